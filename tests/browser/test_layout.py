"""Sizes on every page are a function of the window alone: no frame changes them, and they do not depend on the past."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, Playwright, expect

from grammarlab.matching.library import templates_by_name
from grammarlab.matching.scenes import SceneOptions, rectangles
from grammarlab.pages import corrector as example_server
from grammarlab.pages import matcher
from grammarlab.pages.corrector import Corrector
from grammarlab.pages.editor import editor as editor_server
from grammarlab.pages.editor.editor import Editor
from grammarlab.pages.layers import designer
from grammarlab.pages.scan_desk import ScanDesk
from grammarlab.pages.scoring import serving as scoring_server
from grammarlab.pages.scoring.session import Session
from grammarlab.runs.sample.shipped import examples_folder
from tests.browser.chromium import CHROMIUM
from tests.browser.in_process import Closable, PageThread
from tests.browser.scoring.test_widget import RENDER
from tests.cases import some, takes_turns
from tests.layers.samples import RESIDENTIAL
from tests.synthesis.houses import house

Serve = Callable[[Closable, Any], str]
Windows = Callable[[str], Page]

HEIGHT = 700
WIDTHS = (320, 480, 619, 640, 700, 755, 761, 1000, 1280, 1600)
"""Windows in pixels. From 621 to 760 the panel is below the rest, and the grids stand side by side."""
FRAMES, FEW_FRAMES = 40, 6
"""Frames after a window got its width; some widths of each run are watched for long."""

SAMPLE = """
async (frames) => {
  const frame = () => new Promise(requestAnimationFrame);
  const parts = [...document.querySelectorAll('body, body *')].filter((part) => !part.parentNode.closest('svg'));
  const sizeOf = (part) => {
    const { width, height } = part.getBoundingClientRect();
    const size = part instanceof HTMLElement ? [part.offsetWidth, part.offsetHeight] : [width, height];
    return `${part.tagName} ${[...part.classList].sort().join('.')} ${size.map(Math.round).join(' x ')}`;
  };
  for (let i = 0; i < 4; i += 1) await frame();  // the page notices the size of its window
  const sizes = parts.map(sizeOf);
  const changes = new Set();
  for (let i = 0; i < frames; i += 1) {
    await frame();
    for (const [index, part] of parts.entries())
      if (sizeOf(part) !== sizes[index]) changes.add(`${sizes[index]} is ${sizeOf(part)} later`);
  }
  return { sizes, changes: [...changes].slice(0, 4) };
}
"""


@pytest.fixture(scope="module")
def browser(playwright: Playwright) -> Iterator[Browser]:
    """A browser whose scroll bars take room, as they do on most desktops."""
    chromium = playwright.chromium.launch(
        executable_path=CHROMIUM,
        args=["--no-sandbox", "--disable-gpu", "--no-first-run"],
        ignore_default_args=["--hide-scrollbars"],
    )
    yield chromium
    chromium.close()


@pytest.fixture
def serve() -> Iterator[Serve]:
    with ExitStack() as stack:

        def serve(subject: Closable, page: Any) -> str:
            thread = PageThread(subject, page)
            stack.callback(thread.close)
            return thread.address

        yield serve


@pytest.fixture
def pages(windows: Windows, serve: Serve, tmp_path: Path) -> dict[str, Page]:
    """All pages, each in a window of its own, ready."""
    return scoring_pages(windows, serve, tmp_path) | facade_pages(windows, serve, tmp_path)


def scoring_pages(windows: Windows, serve: Serve, folder: Path) -> dict[str, Page]:
    address, other_address = (
        serve(Session("toy", folder / name, size=200, jobs=0), scoring_server.PAGE) for name in ("a.db", "b.db")
    )
    pages = {name: windows(address) for name in ("scoring", "zoomed", "widget")} | {"pairs": windows(other_address)}
    for page in pages.values():
        expect(page.get_by_role("option").first).to_be_visible()
    for _ in range(2):
        pages["zoomed"].get_by_role("button", name="Zoom in", exact=True).click()
    pages["widget"].evaluate(RENDER)
    expect(pages["widget"].locator("#widget .gl-cell")).to_have_count(32)
    pages["pairs"].keyboard.press("c")
    expect(pages["pairs"].locator(".gl-candidate").first).to_be_visible()
    return pages


def facade_pages(windows: Windows, serve: Serve, folder: Path) -> dict[str, Page]:
    facade = examples_folder() / "facades" / "townhouse.json"
    (folder / "house.toml").write_text(RESIDENTIAL, encoding="utf-8")
    building = house(4, 3, 2, broad=((1, 0),)).write(folder / "house.obj")
    elements = rectangles(SceneOptions(elements=4, kinds=2, noise=0.005, occluded=0.0), 2)
    desk = ScanDesk("scene.json", elements, templates_by_name("rectangle"), folder / "corrections.json")
    pages = {
        "editor": windows(serve(Editor(facade, folder / "saved.facade.json"), editor_server.PAGE)),
        "layers": windows(serve(designer.Designer(folder / "house.toml", folder / "mine.toml"), designer.PAGE)),
        "example": windows(serve(Corrector(building, folder / "example.json"), example_server.PAGE)),
        "scan": windows(serve(matcher.Matcher(desk), matcher.PAGE)),
    }
    expect(pages["editor"].locator(".fe-tile").first).to_be_visible()
    expect(pages["layers"].locator(".fe-tile:visible").first).to_be_visible()
    expect(pages["layers"].locator(".fl-busy")).to_have_count(0)
    expect(pages["example"].locator("image[href^='blob:']")).to_have_count(1)
    expect(pages["scan"].get_by_role("status").filter(has_text="saved in")).to_be_visible()
    return pages


def sampled(pages: dict[str, Page], width: int, frames: int) -> dict[str, dict[str, list[str]]]:
    """Sizes of all parts of each page and their changes, of all pages during the same frames."""
    for page in pages.values():
        page.set_viewport_size({"width": width, "height": HEIGHT})
        page.evaluate(f"(frames) => {{ window.sample = ({SAMPLE})(frames); }}", frames)
    return {name: page.evaluate("window.sample") for name, page in pages.items()}


@takes_turns
def test_sizes_are_a_function_of_the_window_alone(pages: dict[str, Page]) -> None:
    watched = some(WIDTHS)
    upwards = {width: sampled(pages, width, FRAMES if width in watched else FEW_FRAMES) for width in WIDTHS}
    changes = {
        (name, width): sample["changes"]
        for width, samples in upwards.items()
        for name, sample in samples.items()
        if sample["changes"]
    }
    assert changes == {}
    for width in reversed(WIDTHS):
        for name, sample in sampled(pages, width, 1).items():
            assert sample["sizes"] == upwards[width][name]["sizes"], f"{name}, {width} pixels, after a wider window"
