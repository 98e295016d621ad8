"""The page that corrects an example: labels, lines, walls, steps back, its file, and a building that is tried."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import FloatRect, Locator, Page, expect

from grammarlab.pages.corrector import PAGE, Corrector
from grammarlab.synthesis.analysis.correction import corrected
from grammarlab.synthesis.analysis.example import analyse
from grammarlab.synthesis.mesh.building_files import read_mesh
from tests.browser.accessible import expect_accessible
from tests.browser.in_process import PageThread
from tests.cases import takes_turns
from tests.synthesis.houses import house
from tests.waiting import wait_until


@pytest.fixture
def building(tmp_path: Path) -> Path:
    return house(4, 3, 2, broad=((1, 0),)).write(tmp_path / "house.obj")


@pytest.fixture
def opened(windows: Any, building: Path, tmp_path: Path) -> Iterator[Callable[[], Page]]:
    servers: list[PageThread] = []

    def open_page() -> Page:
        servers.append(PageThread(Corrector(building, tmp_path / "example.json"), PAGE))
        return windows(servers[-1].address)

    yield open_page
    for server in servers:
        server.close()


def press(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def walls(tmp_path: Path) -> dict[str, Any]:
    return {wall["name"]: wall for wall in json.loads((tmp_path / "example.json").read_text())["walls"]}


@takes_turns
def test_labels_are_corrected_saved_and_gone_on_with(
    opened: Callable[[], Page], building: Path, tmp_path: Path
) -> None:
    page = opened()
    cells = page.locator(".ex-cell")
    expect(cells).to_have_count(12)
    expect(page.locator("image[href^='blob:']")).to_have_count(1)
    # Two units of the top row get a name of their own; another label is merged away, and that is undone and redone.
    page.get_by_role("button", name="window, row 3, column 1").click()
    page.get_by_role("button", name="window, row 3, column 2").click(modifiers=["Shift"])
    page.get_by_label("Label of the chosen units").fill("<b>attic</b>")
    press(page, "Relabel")
    expect(page.locator("[aria-label^='<b>attic</b>, row 3']")).to_have_count(2)
    page.get_by_label("Merge window-2 into").select_option("window")
    expect(page.locator("[aria-label^='window-2']")).to_have_count(0)
    press(page, "Undo")
    expect(page.locator("[aria-label^='window-2']")).to_have_count(1)
    press(page, "Redo")
    expect(page.locator(".ex-saved")).to_have_text("not saved")
    press(page, "Save")
    expect(page.locator(".ex-saved")).to_contain_text("example.json")
    found = walls(tmp_path)
    assert found["front"]["labels"][2][:2] == ["<b>attic</b>"] * 2
    example = corrected(analyse(read_mesh(building)), tmp_path / "example.json")
    assert example.main.grid.labels.shape == (3, 4)
    # Who opens it again goes on there.
    again = opened()
    expect(again.locator("[aria-label^='<b>attic</b>, row 3']")).to_have_count(2)
    expect(again.locator(".ex-saved")).to_contain_text("saved to")


@takes_turns
def test_a_building_is_tried_and_mistakes_are_said(opened: Callable[[], Page]) -> None:
    page = opened()
    expect(page.locator(".ex-cell")).to_have_count(12)
    page.get_by_role("spinbutton", name="Rows").fill("2")
    page.get_by_role("spinbutton", name="Columns").fill("5")
    press(page, "Synthesize")
    expect(page.get_by_label("Result", exact=True)).to_contain_text("2 × 5 units")
    expect(page.get_by_label("Result", exact=True)).to_contain_text("closed")
    assert page.locator(".ex-result").evaluate("image => image.decode().then(() => image.naturalWidth)") > 500
    expect_accessible(page)
    page.get_by_role("button", name="window, row 2, column 2").click()
    page.get_by_label("Label of the chosen units").fill("  ")
    press(page, "Relabel")
    expect(page.locator("p.ex-bad")).to_contain_text("expected a name")
    names = page.locator("button, input, select, [role=slider]").evaluate_all(
        "all => all.map(each => each.ariaLabel || each.textContent || '')"
    )
    assert all(names)


def place(shown: Locator) -> FloatRect:
    """Where something is; not while it is being drawn anew."""
    found: list[FloatRect | None] = []
    wait_until(lambda: found.append(shown.bounding_box()) or found[-1] is not None)
    assert found[-1]
    return found[-1]


def test_lines_are_dragged_and_walls_left_out(opened: Callable[[], Page], tmp_path: Path) -> None:
    page = opened()
    cells = page.locator(".ex-cell")
    expect(cells).to_have_count(12)
    # The left border goes half a metre out by the mouse, and back a little by a key.
    line = page.get_by_role("slider", name="Line 0 of columns")
    before = float(line.get_attribute("aria-valuenow") or 0)
    stage, grip = place(page.locator(".ex-stage image")), place(line)
    x, y = grip["x"] + grip["width"] / 2, grip["y"] + grip["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 0.5 * stage["width"] / 14.0, y, steps=4)
    page.mouse.up()
    expect(page.locator(".ex-note", has_text="A line between columns")).to_be_visible()
    page.keyboard.press("ArrowRight")
    expect(line).not_to_have_attribute("aria-valuenow", f"{before:.2f}")
    # A row is split and the line taken away again; a wall is left out; the main one cannot be.
    page.get_by_role("button", name="window, row 2, column 3").click()
    press(page, "Split row")
    expect(cells).to_have_count(16)
    page.get_by_role("slider", name="Line 2 of rows").focus()
    # A second click comes before the answer, when lines have other numbers.
    page.get_by_role("button", name="Remove line").evaluate("button => { button.click(); button.click(); }")
    expect(cells).to_have_count(12)
    expect(page.get_by_role("button", name="Exclude this wall")).to_be_disabled()
    page.get_by_role("tab", name="left").click()
    press(page, "Exclude this wall")
    expect(page.get_by_role("tab", name="left")).to_contain_text("excluded")
    press(page, "Save")
    expect(page.locator(".ex-saved")).to_contain_text("example.json")
    found = walls(tmp_path)
    assert set(found) == {"front", "right", "back"}
    assert found["front"]["columns"][0] == pytest.approx(before - 0.45, abs=0.06)
