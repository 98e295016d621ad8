"""Pictures of the pages in a browser: `python -m docs.gen.screens [NAME ...]`; without a name, all of them."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from playwright.sync_api import Page, expect, sync_playwright

from tests.browser.chromium import ARGUMENTS, CHROMIUM
from tests.browser.driver import ScoringPage, Server, settle
from tests.browser.facades.editing import EditorPage

IMAGES = Path(__file__).parents[1] / "images"
FACADES = "grammars/facades"
MILLISECONDS = 120_000
REST = 6_000
"""Milliseconds without a new picture after which all are there."""


@dataclass(frozen=True, slots=True)
class Screen:
    """A page and the actions on it before its picture is taken."""

    command: tuple[str, ...]
    """Arguments of grammarlab; `OUT` is replaced by a new file."""
    do: Callable[[Page], None]
    size: tuple[int, int] = (1280, 800)


class CommandServer(Server):
    """Any command that serves a page, with its own pictures."""

    module = "grammarlab"

    def __init__(self, command: tuple[str, ...], output: Path) -> None:
        super().__init__(command[0], output)
        self.command = command

    def arguments(self) -> list[str]:
        """As `Server.arguments`."""
        return [str(self.session) if each == "OUT" else each for each in self.command]


def new_models(page: Page) -> None:
    """The scoring page after it has opened, with all its pictures."""
    scoring = ScoringPage(page)
    expect(scoring.cell(0)).to_be_visible()
    scoring.expect_pictures()
    # Quick pictures come first, and good ones take their places.
    before, now = None, pictures_of(page)
    while now != before:
        page.wait_for_timeout(REST)
        before, now = now, pictures_of(page)


def pictures_of(page: Page) -> list[str]:
    """The pictures of all models of a scoring page, as texts that differ."""
    styles = "pictures => pictures.map(({ style }) => style.backgroundImage + style.backgroundPosition)"
    return page.locator(".gl-cell .gl-picture").evaluate_all(styles)


def one_column_more(page: Page) -> None:
    """The arcade with one column more and the width of a window locked."""
    editor = EditorPage(page, Path())
    editor.button("One column more").click()
    before = editor.elements.count()
    editor.tiles.nth(1).click()
    expect(editor.elements).not_to_have_count(before)
    page.mouse.click(*editor.element(2))
    editor.button("Lock part width").click()
    expect(page.get_by_role("list", name="Locks").get_by_role("listitem")).to_have_count(1)
    expect(page.get_by_text("Computing variations")).to_be_hidden()


def next_best(page: Page) -> None:
    """The apartment house with its next-best layouts."""
    expect(page.locator(".fe-tile:visible").first).to_be_visible()
    expect(page.locator(".fl-busy")).to_have_count(0)


def a_building(page: Page) -> None:
    """The quarter from above, with the building in the middle of the picture."""
    expect(page.locator(".ct-progress")).to_be_empty()
    page.locator("canvas").click()
    expect(page.locator(".ct-rules li")).not_to_have_count(0)


SCREENS = {
    "scoring.jpg": Screen(("score", "building", "--session", "OUT", "--seed", "5"), new_models, (1360, 860)),
    "scoring_trees.jpg": Screen(("score", "oak", "--session", "OUT", "--seed", "5"), new_models, (1360, 860)),
    "facade_page.jpg": Screen(("facade", "open", f"{FACADES}/arcade.json", "-o", "OUT"), one_column_more, (1360, 860)),
    # After `make quarter`.
    "city_page.jpg": Screen(("city", "open", "out/quarter/city"), a_building, (1360, 860)),
    "layers_page.png": Screen(("facade", "open", f"{FACADES}/apartment.toml", "-o", "OUT"), next_best),
}


def main(names: list[str]) -> None:
    """Take the pictures of these names."""
    if unknown := set(names) - set(SCREENS):
        raise SystemExit(f"unknown picture {min(unknown)!r}: expected one of {', '.join(SCREENS)}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        for name in names or SCREENS:
            take(browser.new_page, name)
        browser.close()


def take(open_page: Callable[..., Page], name: str) -> None:
    """Take one picture."""
    screen = SCREENS[name]
    with tempfile.TemporaryDirectory() as folder:
        server = CommandServer(screen.command, Path(folder) / f"made{_ending(screen)}")
        try:
            page = open_page(viewport={"width": screen.size[0], "height": screen.size[1]})
            page.set_default_timeout(MILLISECONDS)
            page.goto(server.start().address)
            screen.do(page)
            page.wait_for_load_state("networkidle")
            settle(page)
            page.screenshot(path=IMAGES / name)
            page.close()
        finally:
            server.kill()


def _ending(screen: Screen) -> str:
    return ".db" if screen.command[0] == "score" else Path(screen.command[2]).suffix


if __name__ == "__main__":
    expect.set_options(timeout=MILLISECONDS)
    main(sys.argv[1:])
