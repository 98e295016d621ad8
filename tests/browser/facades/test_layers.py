"""The page of a design of layers: its canvas, layers, flags, next-best layouts, text, files."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from grammarlab.facade.file import load_facade
from grammarlab.layers.file import load_design
from grammarlab.pages.layers.designer import PAGE, Designer
from tests.browser.accessible import expect_accessible
from tests.browser.driver import Server
from tests.browser.in_process import PageThread
from tests.browser.late import deaf
from tests.browser.scoring.test_page import contrast
from tests.browser.scoring.test_touch import Hand
from tests.cases import some, takes_turns
from tests.layers.samples import RESIDENTIAL


class DesignServer(Server):
    """``grammarlab facade open`` of a design, in a process of its own."""

    def arguments(self) -> list[str]:
        return ["facade", "open", self.grammar, "-o", str(self.session)]


class DesignPage:
    """The page as a person sees it."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.width = page.get_by_role("slider", name="Width")
        self.tiles = page.locator(".fe-tile:visible")
        self.counters = page.get_by_role("status", name="Counters")
        self.text = page.get_by_label("Text of the design")
        self.complaint = page.locator(".gl-bad")
        expect(self.tiles.first).to_be_visible()
        self.settle()

    def settle(self) -> None:
        expect(self.page.locator(".fl-busy")).to_have_count(0)

    def button(self, name: str) -> Any:
        return self.page.get_by_role("button", name=name, exact=True)

    def hold(self) -> tuple[float, float]:
        box = self.width.bounding_box()
        assert box
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        return x, y

    def metre(self) -> float:
        """Pixels."""
        # At once, since another drawing may replace the line at any time.
        width = self.page.evaluate("document.querySelector('.fe-measure').getBoundingClientRect().width")
        assert width
        return width / float(self.width.get_attribute("aria-valuenow") or 0)

    def expect_width(self, width: float) -> None:
        expect(self.width).to_have_attribute("aria-valuenow", f"{width:.2f}")


@pytest.fixture
def opened(windows: Any, tmp_path: Path) -> Iterator[Callable[..., DesignPage]]:
    servers: list[PageThread] = []

    def open_page(text: str = RESIDENTIAL, **options: Any) -> DesignPage:
        (tmp_path / "house.toml").write_text(text, encoding="utf-8")
        servers.append(PageThread(Designer(tmp_path / "house.toml", tmp_path / "mine.toml"), PAGE))
        return DesignPage(windows(servers[-1].address, **options))

    yield open_page
    for server in servers:
        server.close()


@takes_turns
def test_the_layout_follows_the_side_that_is_dragged_and_stays_where_it_cannot(opened: Callable[..., DesignPage]):
    house = opened()
    expect(house.counters).to_have_text("k = 2")
    metre = house.metre()
    x, y = house.hold()
    house.page.mouse.move(x + 3 * metre, y, steps=8)
    expect(house.counters).to_have_text("k = 3")  # while the mouse is still down
    expect(house.button("Undo")).to_be_disabled()
    house.page.mouse.move(x - 5.5 * metre, y, steps=8)
    expect(house.page.locator(".fe-conflict")).to_contain_text("no word fits: Cx")
    house.page.mouse.up()
    expect(house.complaint).to_contain_text("no word fits")
    house.expect_width(6)
    expect(house.counters).to_have_text("k = 2")
    x, y = house.hold()
    house.page.mouse.move(x + metre, y, steps=4)
    house.page.keyboard.press("Escape")
    house.page.mouse.up()
    house.expect_width(6)
    house.page.keyboard.press("Shift+ArrowRight")
    house.expect_width(7)
    expect(house.button("Undo")).to_be_enabled()
    house.page.keyboard.press("Control+z")
    house.expect_width(6)
    house.page.get_by_label("width in metres").fill("9")
    house.page.keyboard.press("Enter")
    house.expect_width(9)
    expect(house.counters).to_have_text("k = 4")  # the best of several, once all are found


@takes_turns
def test_layers_masks_flags_and_layouts_are_chosen_and_exported(opened: Callable[..., DesignPage], tmp_path: Path):
    house = opened()
    house.page.get_by_role("checkbox", name="door").uncheck()
    expect(house.page.locator(".fl-off")).to_have_count(1)
    house.button("Show Q of columns").click()
    expect(house.button("Hide Q of columns")).to_be_focused()
    flag = house.page.get_by_role("button", name=re.compile("^B: attached"))
    with deaf(house.page):
        flag.dblclick()
    flag.click()
    expect(flag).to_have_attribute("aria-pressed", "true")
    house.settle()
    house.tiles.nth(1).click()
    expect(house.tiles.nth(1)).to_have_attribute("aria-pressed", "true")
    house.page.keyboard.press("Control+s")
    expect(house.page.locator(".gl-saved")).to_have_text("saved")
    design = load_design(tmp_path / "mine.toml")
    assert (design.layers[1].on, design.layers[2].masks[1], design.symbols["B"].attached) == (False, None, True)
    for kind, name in (("JSON", "mine.facade.json"), ("GLB", "mine.glb"), ("SVG", "mine.svg"), ("CGA", "mine.cga")):
        house.button("Export").click()
        house.page.get_by_role("button", name=re.compile(f"^{kind}")).click()
        expect(house.page.locator(".gl-note").last).to_contain_text(name)
        assert (tmp_path / name).stat().st_size > 100
    assert "door" not in load_facade(tmp_path / "mine.facade.json").labels


@takes_turns
def test_the_text_is_edited_with_its_mistakes_beside_it_and_outlives_the_server(windows: Any, tmp_path: Path):
    (tmp_path / "house.toml").write_text(RESIDENTIAL, encoding="utf-8")
    server = DesignServer(str(tmp_path / "house.toml"), tmp_path / "mine.toml")
    try:
        house = DesignPage(windows(server.start().address))
        house.page.keyboard.press("t")
        expect(house.text).to_be_focused()
        house.text.fill(RESIDENTIAL.replace("A(BA)^k", "A(BX)^k"))
        mistake = house.page.locator(".fl-mistake")
        expect(mistake).to_contain_text("unknown symbol 'X'")
        expect(mistake).to_contain_text("line 19, column 10")
        house.page.keyboard.press("Control+s")
        expect(house.complaint).to_contain_text("Correct the text")
        assert not (tmp_path / "mine.toml").exists()
        mistake.click()
        assert house.text.evaluate("it => it.value.slice(it.selectionStart, it.selectionEnd)") == "X"
        house.page.keyboard.type("A")
        expect(mistake).to_have_count(0)
        house.text.fill(RESIDENTIAL.replace("B = { size = 1.6 }", "B = { size = 0.9 }"))
        house.page.keyboard.press("Control+s")  # what is being typed counts
        expect(house.page.locator(".gl-saved")).to_have_text("saved")
        server.kill()
        expect(house.page.locator(".gl-banner")).to_contain_text("connection")
        assert load_design(tmp_path / "mine.toml").symbols["B"].size == 0.9
    finally:
        server.kill()


@pytest.mark.parametrize("scheme", some(["light", "dark"]))
def test_fingers_small_windows_and_both_themes(opened: Callable[..., DesignPage], scheme: str):
    evil = "<img src=x onerror=alert(1)>"
    text = RESIDENTIAL.replace('name = "door"', f'name = "{evil}"').replace("Residential house", evil)
    house = opened(text, color_scheme=scheme, size=(420, 760), has_touch=True)
    assert house.page.evaluate("document.documentElement.scrollWidth") <= 420
    expect(house.page.locator(".gl-name")).to_have_text(evil)
    assert not house.page.locator("img").count()
    hand, metre, box = Hand(house.page), house.metre(), house.width.bounding_box()
    assert box
    x, y = box["x"] + 14, box["y"] + 14
    hand.put((x, y))
    hand.move(((x, y), (x + metre, y)))
    hand.lift()
    expect(house.button("Undo")).to_be_enabled()
    assert float(house.width.get_attribute("aria-valuenow") or 0) == pytest.approx(7.0, abs=0.2)
    expect_accessible(house.page)
    for part in (
        ".gl-name",
        ".gl-hint",
        ".fe-words",
        ".fe-tile small",
        ".fl-size small",
        ".fl-pattern",
        ".fl-chip[aria-pressed=false]",
    ):
        assert contrast(house.page.locator(part).first) >= 4.5, part
    names = house.page.locator("button, input, textarea, [role=slider]").evaluate_all(
        "all => all.map(each => each.ariaLabel || each.textContent || each.labels?.[0]?.textContent || '')"
    )
    assert all(names), names
