"""``grammarlab facade open`` in a process of its own, and its page as a person sees it."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.sync_api import FloatRect, Locator, Page, expect

from grammarlab.facade.file import load_facade
from grammarlab.facade.tree import Facade, X, check
from tests.browser.driver import Server


class EditorServer(Server):
    """Edits a file, and saves to another."""

    def __init__(self, file: Path, output: Path) -> None:
        super().__init__(str(file), output)

    def arguments(self) -> list[str]:
        return ["facade", "open", self.grammar, "-o", str(self.session)]


class EditorPage:
    """The page: what one reads on it, and a few things that one does often."""

    def __init__(self, page: Page, file: Path) -> None:
        self.page, self.file = page, file
        self.width = page.get_by_role("slider", name="Width")
        self.height = page.get_by_role("slider", name="Height")
        self.face = page.get_by_role("application")
        self.tiles = page.locator(".fe-tile")
        self.elements = page.locator(".fe-element")
        self.complaint = page.locator(".gl-bad")
        self.status = page.locator(".gl-saved")
        expect(self.tiles.first).to_be_visible()

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def size(self) -> tuple[float, float]:
        """Metres, as the handles say."""
        width, height = (float(each.get_attribute("aria-valuenow") or 0) for each in (self.width, self.height))
        return width, height

    def expect_size(self, width: float, height: float) -> None:
        expect(self.width).to_have_attribute("aria-valuenow", f"{width:.2f}")
        expect(self.height).to_have_attribute("aria-valuenow", f"{height:.2f}")

    def expect_grid(self, name: str, rows: int, columns: int) -> None:
        """Waits until this is the active grid, and so large."""
        label = re.compile(rf"^{re.escape(name)}, {rows} rows, {columns} columns")
        expect(self.page.get_by_role("button", name=label, pressed=True)).to_be_visible()

    def save(self) -> Facade:
        """Saves, and what is in the file then."""
        self.press("Control+s")
        expect(self.status).to_have_text("saved")
        return self.saved()

    def saved(self) -> Facade:
        """What is in the file; a facade, or the test fails."""
        return check(load_facade(self.file))

    def box(self, locator: Locator) -> FloatRect:
        """Where something is on the screen; what lies over the facade is drawn anew now and then."""
        while not (box := locator.bounding_box()):
            expect(locator).to_be_visible()
        return box

    def middle(self, locator: Locator) -> tuple[float, float]:
        box = self.box(locator)
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def element(self, index: int) -> tuple[float, float]:
        """The middle of an element of the active grid on the screen."""
        return self.middle(self.elements.nth(index))

    def hold(self, handle: Locator) -> tuple[float, float]:
        """The mouse on a handle, pressed."""
        place = self.middle(handle)
        self.page.mouse.move(*place)
        self.page.mouse.down()
        return place

    def metre(self) -> float:
        """Pixels of a metre."""
        return self.box(self.page.locator(".fe-measure").first)["width"] / self.size()[X]
