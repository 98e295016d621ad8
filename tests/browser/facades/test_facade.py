"""The page that edits a facade: its size, grids, variations, locks, steps back, files."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from grammarlab.facade.editing.grids import grid_of
from grammarlab.facade.file import load_facade, load_locked, save_facade
from grammarlab.facade.sizes.size_wishes import Aspect
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.pages.editor.editor import PAGE, Editor
from grammarlab.runs.sample.shipped import examples_folder
from tests.browser.accessible import expect_accessible
from tests.browser.facades.editing import EditorPage, EditorServer
from tests.browser.in_process import PageThread
from tests.browser.late import deaf
from tests.browser.scoring.test_page import contrast
from tests.browser.scoring.test_touch import Hand
from tests.cases import takes_turns

FACADES = examples_folder() / "facades"
WINDOWS = "french window"
LATE = """
() => document.querySelector('dialog button').dispatchEvent(
  new KeyboardEvent('keydown', { key: 's', ctrlKey: true, bubbles: true }))
"""
"""Ctrl S as it comes before the next frame, when what had the focus before the help is gone."""


@pytest.fixture
def edited(windows: Any, tmp_path: Path) -> Iterator[Callable[..., EditorPage]]:
    """Opens a shipped facade on a page of its own: ``edited("townhouse", color_scheme="dark")``."""
    servers: list[PageThread] = []

    def open_page(name: str = "townhouse", **options: Any) -> EditorPage:
        file = Path(name) if name.endswith(".json") else FACADES / f"{name}.json"
        servers.append(PageThread(Editor(file, tmp_path / "saved.facade.json"), PAGE))
        return EditorPage(windows(servers[-1].address, **options), tmp_path / "saved.facade.json")

    yield open_page
    for server in servers:
        server.close()


@pytest.fixture
def house(edited: Callable[..., EditorPage]) -> EditorPage:
    return edited()


def expect_aligned(facade: Facade, name: str) -> None:
    """The elements of each column begin at one place and are equally wide, and so for rows."""
    grid = grid_of(facade, name)
    for axis, line in ((X, grid.column), (Y, grid.row)):
        for each in np.unique(line):
            nodes = grid.node[line == each]
            assert np.ptp(facade.position[nodes, axis]) <= 1e-6
            assert np.ptp(facade.size[nodes, axis]) <= 1e-6


def test_a_side_that_is_dragged_changes_the_width_at_once_and_keeps_the_grid(house: EditorPage):
    metre = house.metre()
    x, y = house.hold(house.width)
    house.page.mouse.move(x + 2 * metre, y, steps=12)
    # Solved while the mouse is still down.
    expect(house.width).to_have_attribute("aria-valuenow", re.compile(r"13\.(5|6)"))
    expect(house.button("Undo")).to_be_disabled()
    house.page.mouse.up()
    expect(house.button("Undo")).to_be_enabled()
    width, height = house.size()
    assert (width, height) == (pytest.approx(13.6, abs=0.06), 15.2)
    facade = house.save()
    assert facade.width == pytest.approx(width, abs=0.005)
    assert facade.height == pytest.approx(15.2, abs=1e-9)
    expect_aligned(facade, WINDOWS)
    house.press("Control+z")
    house.expect_size(11.6, 15.2)
    assert np.array_equal(house.save().size, load_facade(FACADES / "townhouse.json").size)
    house.press("Control+y")
    house.expect_size(width, height)


def test_the_top_is_dragged_up_and_a_drag_that_is_cancelled_leaves_nothing(house: EditorPage):
    metre = house.metre()
    x, y = house.hold(house.height)
    house.page.mouse.move(x, y - metre, steps=5)
    expect(house.height).to_have_attribute("aria-valuenow", re.compile(r"16\.(1|2)"))
    house.press("Escape")
    house.expect_size(11.6, 15.2)
    house.page.mouse.up()
    expect(house.button("Undo")).to_be_disabled()
    x, y = house.hold(house.height)
    house.page.mouse.move(x, y - metre, steps=5)
    house.page.mouse.up()
    expect(house.button("Undo")).to_be_enabled()
    assert house.size() == (11.6, pytest.approx(16.2, abs=0.06))


@takes_turns
def test_shift_keeps_the_shape_of_the_whole(house: EditorPage):
    metre = house.metre()
    x, y = house.hold(house.width)
    house.page.keyboard.down("Shift")
    house.page.mouse.move(x + metre, y, steps=5)
    house.page.mouse.up()
    house.page.keyboard.up("Shift")
    expect(house.button("Undo")).to_be_enabled()
    width, height = house.size()
    assert width == pytest.approx(12.6, abs=0.06)
    assert height / width == pytest.approx(15.2 / 11.6, abs=0.002)


def test_a_variation_that_is_accepted_is_the_facade_until_it_is_undone(house: EditorPage):
    house.expect_grid(WINDOWS, 3, 4)
    house.tiles.first.click()
    house.expect_grid(WINDOWS, 3, 5)
    facade = house.save()
    expect_aligned(facade, WINDOWS)
    assert grid_of(facade, WINDOWS).num_columns == 5
    house.button("One row less").click()
    expect(house.tiles).to_have_count(2)
    house.tiles.first.click()
    house.expect_grid(WINDOWS, 2, 5)
    house.press("Control+z", "Control+z")
    house.expect_grid(WINDOWS, 3, 4)
    house.expect_size(11.6, 15.2)


def test_a_rectangle_around_windows_makes_a_grid_of_them(house: EditorPage):
    (left, top), (right, bottom) = house.element(8), house.element(5)
    left, right = sorted((left, right))
    metre = house.metre()
    house.page.mouse.move(left - metre, min(top, bottom) - 1.6 * metre)
    house.page.mouse.down()
    house.page.mouse.move(right + metre, max(top, bottom) + 1.6 * metre, steps=6)
    expect(house.page.locator(".fe-lasso")).to_be_visible()
    house.page.mouse.up()
    expect(house.page.locator(".fe-choose[aria-pressed=true]")).to_contain_text(f"{WINDOWS} 2")
    grid = grid_of(house.save(), f"{WINDOWS} 2")
    assert 1 < len(grid.node) < 12
    house.button(f"Rename {WINDOWS} 2").click()
    house.page.get_by_label(f"New name of {WINDOWS} 2").fill("middle")
    house.press("Enter")
    house.expect_grid("middle", grid.num_rows, grid.num_columns)
    house.button("Delete grid middle").click()
    expect(house.page.locator(".fe-choose")).to_have_count(2)


def test_clicks_take_parts_out_of_the_grid_and_put_them_back(house: EditorPage):
    place = house.element(0)
    house.button("Change by clicking").click()
    house.page.mouse.click(*place)
    expect(house.elements).to_have_count(11)
    house.page.mouse.click(*place)
    expect(house.elements).to_have_count(12)
    house.expect_grid(WINDOWS, 3, 4)


@takes_turns
def test_locked_sizes_stay_and_what_contradicts_them_is_said_and_not_done(house: EditorPage):
    house.page.mouse.click(*house.element(0))
    house.button("Lock part width").click()
    locks = house.page.get_by_role("list", name="Locks")
    expect(locks.get_by_role("listitem")).to_have_count(1)
    before = grid_of(load_facade(FACADES / "townhouse.json"), WINDOWS)
    width = house.page.get_by_label("width in metres", exact=True)
    width.fill("14")
    width.press("Enter")
    house.expect_size(14, 15.2)
    facade = house.save()
    was = load_facade(FACADES / "townhouse.json").size[before.node, X]
    assert facade.size[before.node, X] == pytest.approx(was, abs=1e-6)  # what is alike is locked with it
    width.fill("14.5")
    house.press("Control+s")  # what is being typed counts
    house.expect_size(14.5, 15.2)
    expect(house.status).to_have_text("saved")
    assert house.saved().width == pytest.approx(14.5)
    width.fill("14")
    width.press("Enter")
    house.expect_size(14, 15.2)
    width.fill("3")
    width.press("Enter")
    expect(house.complaint).to_contain_text("the facade is 3 m wide")
    expect(house.complaint).to_contain_text("m wide; ")
    house.expect_size(14, 15.2)
    metre = house.metre()
    x, y = house.hold(house.width)
    house.page.mouse.move(x - 11 * metre, y, steps=8)
    expect(house.page.locator(".fe-conflict")).to_contain_text("cannot all be met")
    house.page.mouse.up()
    house.expect_size(14, 15.2)
    expect(house.page.locator(".fe-conflict")).to_be_hidden()
    locks.get_by_role("button", name=re.compile("^Unlock")).click()
    expect(locks).to_be_hidden()


def test_a_place_and_a_range_of_aspects_that_are_typed_are_locked_and_undone(house: EditorPage):
    house.page.mouse.click(*house.element(0))
    place = house.page.get_by_label("part left in metres")
    left = float(place.input_value())
    place.fill(f"{left + 0.2:.2f}")
    place.press("Enter")
    locks = house.page.get_by_role("list", name="Locks").get_by_role("listitem")
    expect(locks).to_have_count(1)
    least, largest = (house.page.get_by_label(f"{end} part width to height") for end in ("Least", "Largest"))
    now = float(largest.input_value())
    assert least.input_value() == largest.input_value()
    largest.fill(f"{0.9 * now:.3f}")
    largest.press("Enter")
    expect(locks).to_have_count(2)
    least.fill(f"{0.8 * now:.3f}")
    least.press("Enter")
    expect(locks.last).to_contain_text("times as wide as high")
    house.save()
    facade, wishes = load_locked(house.file)
    node = grid_of(facade, WINDOWS).node[0]
    assert facade.position[node, X] == pytest.approx(left + 0.2, abs=0.005)
    assert facade.size[node, X] / facade.size[node, Y] == pytest.approx(0.9 * now, abs=1e-3)
    (aspect,) = (wish for wish in wishes if isinstance(wish, Aspect))
    assert (aspect.least, aspect.most) == pytest.approx((0.8 * now, 0.9 * now), abs=1e-3)
    least.fill("0")
    least.press("Enter")
    expect(least).to_have_value(f"{0.8 * now:.2f}")
    for _ in range(3):
        house.button("Undo").click()
    expect(locks).to_have_count(0)
    assert np.array_equal(house.save().size, load_facade(FACADES / "townhouse.json").size)


def test_a_part_that_is_dragged_takes_its_column_along(house: EditorPage):
    grid = grid_of(load_facade(FACADES / "townhouse.json"), WINDOWS)
    nodes = grid.node[grid.column == 1].tolist()
    before = load_facade(FACADES / "townhouse.json").position[nodes, X]
    index = grid.node.tolist().index(nodes[0])
    x, y = house.element(index)
    house.page.mouse.click(x, y)
    expect(house.page.locator(".fe-selected")).to_have_count(1)
    metre = house.metre()
    house.page.mouse.move(x, y)
    house.page.mouse.down()
    house.page.mouse.move(x + 0.25 * metre, y, steps=5)
    house.page.mouse.up()
    expect(house.page.get_by_role("list", name="Locks").get_by_role("listitem")).to_have_count(2)
    facade = house.save()
    assert facade.position[nodes, X] == pytest.approx(before + 0.25, abs=0.05)
    expect_aligned(facade, WINDOWS)


def test_what_is_saved_is_there_after_the_server_was_killed(windows: Any, tmp_path: Path):
    file = tmp_path / "saved.facade.json"
    servers = [EditorServer(FACADES / "townhouse.json", file), EditorServer(file, file)]
    try:
        house = EditorPage(windows(servers[0].start().address), file)
        house.tiles.first.click()
        house.expect_grid(WINDOWS, 3, 5)
        size, facade = house.size(), house.save()
        servers[0].kill()
        expect(house.page.locator(".gl-banner")).to_contain_text("connection")
        again = EditorPage(windows(servers[1].start().address), file)
        again.expect_size(*size)
        again.expect_grid(WINDOWS, 3, 5)
        again.tiles.first.click()
        again.expect_grid(WINDOWS, 3, 6)
        assert len(again.saved()) == len(facade)  # not before it is saved
        assert len(again.save()) > len(facade)
    finally:
        for server in servers:
            server.kill()


def test_the_file_that_was_opened_stays_as_it_is_and_exports_take_new_names(house: EditorPage):
    original = (FACADES / "townhouse.json").read_bytes()
    (house.file.parent / "saved.svg").write_text("mine")
    house.tiles.first.click()
    house.expect_grid(WINDOWS, 3, 5)
    house.save()
    assert (FACADES / "townhouse.json").read_bytes() == original
    for kind, name in (("SVG", "saved-2.svg"), ("PNG", "saved.png"), ("CGA", "saved.cga"), ("GLB", "saved.glb")):
        house.button("Export").click()
        house.page.get_by_role("button", name=re.compile(f"^{kind}")).click()
        expect(house.page.locator(".gl-note").last).to_contain_text(name)
        assert (house.file.parent / name).stat().st_size > 100
    assert (house.file.parent / "saved.svg").read_text() == "mine"


def test_everything_can_be_done_with_keys_alone(house: EditorPage):
    house.press("ArrowRight", "ArrowRight", "Shift+ArrowUp")
    house.expect_size(11.8, 16.2)
    house.press("Control+z")
    house.expect_size(11.8, 15.2)
    house.width.focus()
    house.press("ArrowLeft")
    house.expect_size(11.7, 15.2)
    house.face.focus()
    house.press("ArrowRight", "ArrowUp")
    expect(house.page.locator(".fe-selected")).to_have_count(1)
    with deaf(house.page):
        house.press("w", "w")
    house.press("w")
    expect(house.page.locator(".fe-locked")).to_have_count(1)
    house.press("w")
    expect(house.page.locator(".fe-locked")).to_have_count(0)
    expect(house.page.locator(".fe-old")).to_have_count(0)
    house.press("v", "Enter")
    house.expect_grid(WINDOWS, 3, 5)
    expect(house.page.locator(".fe-old")).to_have_count(0)
    expect(house.tiles.first).to_be_focused()
    house.press("Control+z")
    house.expect_grid(WINDOWS, 3, 4)
    house.face.focus()
    left = house.page.get_by_label("part left in metres")
    place = float(left.input_value())
    with deaf(house.page):
        house.press("Alt+ArrowRight", "Alt+ArrowRight")
    expect(left).to_have_value(f"{place + 0.1:.2f}")
    house.press("?")
    expect(house.page.get_by_role("dialog", name="Keys")).to_be_visible()
    house.press("Escape")
    assert house.save().width == pytest.approx(11.7)


def test_a_key_that_reaches_the_help_after_it_was_closed_has_its_effect(house: EditorPage):
    house.width.focus()
    house.press("ArrowLeft")
    house.expect_size(11.5, 15.2)
    house.page.evaluate(LATE)
    expect(house.status).to_have_text("saved")
    assert house.saved().width == pytest.approx(11.5)


def test_fingers_drag_sides_and_draw_rectangles(edited: Callable[..., EditorPage]):
    house = edited(has_touch=True)
    metre, hand = house.metre(), Hand(house.page)
    x, y = house.middle(house.width)
    hand.put((x, y))
    hand.move(((x, y), (x + 2 * metre, y)))
    hand.lift()
    expect(house.button("Undo")).to_be_enabled()
    assert house.size()[X] == pytest.approx(13.6, abs=0.1)
    x, y = house.element(0)
    house.page.touchscreen.tap(x, y)
    expect(house.page.locator(".fe-selected")).to_have_count(1)
    hand.put((x - metre, y - 2 * metre))
    metre = house.metre()
    hand.move(((x - metre, y - 2 * metre), (x + 5 * metre, y + 2 * metre)))
    hand.lift()
    expect(house.page.locator(".fe-choose[aria-pressed=true]")).to_contain_text(f"{WINDOWS} 2")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_can_be_read_in_both_themes_and_everything_has_a_name(edited: Callable[..., EditorPage], scheme: str):
    house = edited(color_scheme=scheme)
    house.page.mouse.click(*house.element(0))
    for part in (".gl-name", ".gl-hint", ".fe-unit", ".fe-words", ".fe-tile small", ".fe-choose small", ".gl-tab"):
        assert contrast(house.page.locator(part).first) >= 4.5, part
    names = house.page.locator(
        "button, input, [role=slider], [role=application], canvas:not([aria-hidden])"
    ).evaluate_all("all => all.map(each => each.ariaLabel || each.textContent || each.labels?.[0]?.textContent || '')")
    assert all(names), names
    expect_accessible(house.page)


def test_a_narrow_window_shows_the_facade_first(edited: Callable[..., EditorPage]):
    house = edited(size=(420, 760))
    assert house.page.evaluate("document.documentElement.scrollWidth") <= 420
    expect(house.elements.first).to_be_in_viewport()
    house.press("ArrowRight")
    house.expect_size(11.7, 15.2)


def test_names_of_strangers_are_text(edited: Callable[..., EditorPage], tmp_path: Path):
    facade = load_facade(FACADES / "townhouse.json")
    evil = "<img src=x onerror=alert(1)>"
    labels = tuple(evil if label == WINDOWS else label for label in facade.labels)
    grids = tuple(replace(grid, name=evil) if grid.name == WINDOWS else grid for grid in facade.grids)
    save_facade(replace(facade, labels=labels, grids=grids), tmp_path / "evil.json")
    house = edited(str(tmp_path / "evil.json"))
    house.expect_grid(evil, 3, 4)
    house.page.mouse.click(*house.element(0))
    expect(house.page.locator(".fe-label")).to_have_text(evil)
    assert not house.page.locator("img").count()
