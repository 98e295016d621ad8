"""The page beside an editor: a save becomes a picture, a mistake has its line, sliders and dice change the model."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import Page, expect

from grammarlab.pages.watch.watcher import PAGE, Watcher
from tests.browser.accessible import expect_accessible
from tests.browser.in_process import PageThread
from tests.browser.late import deaf
from tests.pages.watch.test_watcher import RULES


def test_a_wall_casts_no_shadow_on_itself(windows: Any, tmp_path: Path):
    """A lit wall of one colour is of one colour in the picture: no stripes of its own shadow."""
    file = tmp_path / "block.cga"
    file.write_text('Lot --> extrude(20) color("#66cc33") Block.')
    thread = PageThread(Watcher(str(file)), PAGE)
    try:
        page = windows(thread.address, size=(1100, 800))
        canvas = page.locator("canvas")
        expect(canvas).to_have_attribute("data-shown", "0 0")
        picture = np.asarray(Image.open(BytesIO(canvas.screenshot())).convert("RGB")).astype(np.float64)
    finally:
        thread.close()
    height, width = picture.shape[:2]
    left = picture[int(0.5 * height) : int(0.65 * height), int(0.33 * width) : int(0.46 * width)]
    assert left.mean(axis=(0, 1)).argmax() == 1  # the wall, not the sky
    assert left.std(axis=(0, 1)).max() < 0.6  # stripes have 2.4


def test_a_save_becomes_a_picture_and_everything_has_a_key(windows: Any, tmp_path: Path):
    file = tmp_path / "house.cga"
    file.write_text("Lot --> extrude(3")
    thread = PageThread(Watcher(str(file)), PAGE)
    try:
        page = windows(thread.address, size=(760, 520))
        canvas = page.locator("canvas")
        status = page.get_by_role("status").filter(has_text="shapes")
        _expect_mistake_alone(page)
        file.write_text(RULES)
        expect(canvas).to_have_attribute("data-version", "1")
        expect(status).to_have_text("8 shapes")
        before = canvas.screenshot()
        # A slider, a menu and a way back.
        slider = page.get_by_role("slider", name="height (m), slider")
        slider.focus()
        slider.press("End")
        expect(page.get_by_label("height (m)", exact=True)).to_have_value("30")
        page.get_by_label("roof", exact=True).select_option("gable")
        page.get_by_role("button", name="height (m): as in the file").click()
        expect(page.get_by_label("height (m)", exact=True)).to_have_value("12")
        page.get_by_label("paint, palette").fill("#336699")
        expect(page.get_by_label("paint", exact=True)).to_have_value("#336699")
        # A mistake is told at its line, and the next save is a picture.
        file.write_text(RULES.replace("extrude(height)", "extrude(heigth)"))
        mistake = page.get_by_role("alert").filter(has_text="line 8, column 17")
        expect(mistake).to_contain_text("Lot --> extrude(heigth)")
        expect_accessible(page)
        file.write_text(RULES.replace("extrude(height)", f"{' ' * 200}extrude(heigth)"))
        _expect_mark_in_view(page)
        file.write_text(RULES.replace("= 12", "= 25"))
        expect(mistake).to_have_count(0)
        expect(status).to_have_text("8 shapes")
        expect(page.get_by_label("height (m)", exact=True)).to_have_value("25")
        # Keys: two models on though nothing is confirmed, the dice, the rule of a part, a step back.
        canvas.focus()
        with deaf(page):
            page.keyboard.press("n")
            page.keyboard.press("n")
        expect(page.get_by_role("spinbutton", name="Model")).to_have_value("2")
        expect(canvas).to_have_attribute("data-shown", "0 2")
        page.keyboard.press("ArrowDown")
        expect(page.get_by_role("region", name="Rule of a part")).to_contain_text("house.cga:")
        _expect_tree_beside(page)
        page.keyboard.press("r")
        expect(page.get_by_role("spinbutton", name="Seed")).not_to_have_value("0")
        page.keyboard.press("Control+z")
        expect(page.get_by_role("spinbutton", name="Seed")).to_have_value("0")
        expect(status).to_have_text("8 shapes")
        assert canvas.screenshot() != before
        _expect_room_on_a_phone(page)
    finally:
        thread.close()


def _expect_tree_beside(page: Page) -> None:
    """The tree is at the part that was chosen, and its rows are chosen with keys."""
    row = page.get_by_role("treeitem", selected=True)
    expect(row).to_contain_text("Wall")
    row.focus()
    page.keyboard.press("ArrowUp")
    expect(row).not_to_contain_text("Wall")


def _expect_mistake_alone(page: Page) -> None:
    """Before the first model there are no parts to choose from."""
    expect(page.get_by_role("alert").filter(has_text="line 1, column 16")).to_have_count(1)
    expect(page.get_by_role("region", name="Tree")).to_have_count(0)
    expect_accessible(page)


def _expect_mark_in_view(page: Page) -> None:
    """A line that is longer than the window is scrolled to the mark below the mistake."""
    expect(page.get_by_role("alert").filter(has_text="line 8, column 217")).to_have_count(1)
    line, mark = (page.locator(f".wa-mistake {name}").bounding_box() for name in ("pre", "i"))
    assert line is not None
    assert mark is not None
    assert line["x"] < mark["x"] < line["x"] + line["width"] - mark["width"]


def _expect_room_on_a_phone(page: Page) -> None:
    page.set_viewport_size({"width": 400, "height": 700})
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    expect_accessible(page)
