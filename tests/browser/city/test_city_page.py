"""The page of a city: seen from above and from the street, changed by mouse, keys and touch."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

from grammarlab.city.parcel_addresses import EXCLUDED, read_pins
from grammarlab.pages.city.city_viewer import CityViewer, page_of
from grammarlab.runs.city.parcel_reading import read_parcel_table
from tests.browser.accessible import expect_accessible
from tests.browser.in_process import PageThread
from tests.browser.late import FROM_THE_FIRST_STATE, deaf
from tests.browser.scoring.test_page import contrast
from tests.cases import some, takes_turns
from tests.pages.city.small_city import write_city
from tests.pages.city.test_city_viewer import REBUILD

SMALL = (800, 560)
"""Pixels of windows: without a graphics card every pixel takes time."""
PHONE = {"size": (390, 844), "has_touch": True, "is_mobile": True}


@pytest.fixture
def opened(windows: Any, tmp_path: Path) -> Iterator[Callable[..., Page]]:
    """Opens the small city in a window: ``opened(color_scheme="dark")``."""
    write_city(tmp_path / "city")
    thread = PageThread(CityViewer(tmp_path / "city", rebuild=REBUILD), page_of(tmp_path / "city"))

    pages: list[Page] = []

    def open_page(**options: Any) -> Page:
        page = windows(thread.address, **{"size": SMALL, **options})
        pages.append(page)
        expect(page.locator("canvas")).to_be_visible()
        loaded(page)
        return page

    yield open_page
    # First, since tiles may be loading.
    for page in pages:
        page.close()
    thread.close()


def loaded(page: Page) -> None:
    """Waits until nothing is being built or loaded."""
    expect(page.locator(".ct-progress")).to_be_empty()
    expect(page.locator(".gl-saved[data-state=saving]")).to_have_count(0)


def name(page: Page) -> Locator:
    return page.locator(".ct-name")


def fact(page: Page, wanted: str) -> Locator:
    return page.locator(f".ct-facts dt:text-is('{wanted}') + dd")


def middle(page: Page) -> tuple[float, float]:
    box = page.locator("canvas").bounding_box()
    assert box
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


@takes_turns
def test_a_building_is_chosen_changed_and_scored(opened: Callable[..., Page], tmp_path: Path) -> None:
    # By keys, before the parcels are there: the next building but one; then the same building by a click on it.
    page = opened(script=FROM_THE_FIRST_STATE)
    first, second = read_parcel_table(tmp_path / "city" / "parcels.parquet").id[:2]
    page.locator("canvas").focus()
    page.keyboard.press("n")
    page.keyboard.press("n")
    page.evaluate("hear()")
    expect(name(page)).to_have_text(second)
    expect(fact(page, "zone")).to_have_text("homes")
    page.wait_for_timeout(800)  # the flight to the building
    page.keyboard.press("Escape")
    expect(name(page)).to_have_text("No building selected")
    page.mouse.click(*middle(page))
    expect(name(page)).to_have_text(second)
    # Another building stands there, and the step can be undone.
    model = fact(page, "model").text_content() or ""
    page.keyboard.press("r")
    expect(fact(page, "model")).not_to_have_text(model)
    assert read_pins(tmp_path / "pins.csv").get(second).reroll == 1
    loaded(page)
    page.keyboard.press("Control+z")
    expect(fact(page, "model")).to_have_text(model)
    loaded(page)
    # Scores by keys and by number are those of the zone's session, and of the building that was selected last.
    page.keyboard.press("b")
    expect(name(page)).to_have_text(first)
    with deaf(page):
        page.keyboard.press("n")
        page.keyboard.press("4")
    expect(name(page)).to_have_text(second)
    expect(page.locator(".gl-step.gl-on")).to_have_count(4)
    number = page.get_by_label("Score of this building, 0 to 100")
    expect(number).to_have_value("75")
    number.fill("90")
    number.press("Enter")
    expect(page.get_by_role("status").filter(has_text="scored 90")).to_be_visible()
    expect(page.locator(".ct-zones li").first).to_contain_text("1 scored")
    expect(page.get_by_role("button", name="Learn homes")).to_be_enabled()
    # An excluded parcel stays selected, so that it can be included again.
    page.get_by_role("button", name="Exclude", exact=True).click()
    expect(page.get_by_role("button", name="Include", exact=True)).to_be_enabled()
    assert read_pins(tmp_path / "pins.csv").get(second).zone == EXCLUDED
    expect(page.get_by_text("22 buildings, 1 excluded, 1 small")).to_be_visible()
    loaded(page)


@takes_turns
def test_parcels_are_found_and_walked_to(opened: Callable[..., Page]) -> None:
    page = opened()
    find = page.get_by_role("searchbox", name="Find a parcel by its id")
    find.fill("P-999")
    find.press("Enter")
    assert find.evaluate("field => field.validationMessage") == "There is no parcel with this id."
    find.fill("P-010")
    find.press("Enter")
    expect(name(page)).to_have_text("P-010")
    # In front of the building, on the street; a second V leads back.
    page.locator("canvas").focus()
    page.keyboard.press("v")
    expect(page.get_by_role("group", name="Walk")).to_be_visible()
    before = page.locator("canvas").screenshot()
    page.keyboard.down("ArrowLeft")
    page.wait_for_timeout(300)
    page.keyboard.up("ArrowLeft")
    assert page.locator("canvas").screenshot() != before
    page.keyboard.press("v")
    expect(page.get_by_role("group", name="Walk")).to_be_hidden()
    # What is not labelled cannot be found without eyes.
    names = page.locator("button, input, canvas").evaluate_all(
        "all => all.map(each => each.ariaLabel || each.textContent || '')"
    )
    assert all(names)
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Keys")).to_be_visible()


@pytest.mark.parametrize("scheme", some(["light", "dark"]))
@takes_turns
def test_a_phone_shows_all_and_words_stand_out(opened: Callable[..., Page], scheme: str, tmp_path: Path) -> None:
    first, second = read_parcel_table(tmp_path / "city" / "parcels.parquet").id[:2]
    page = opened(color_scheme=scheme, **PHONE)
    page.get_by_role("button", name="Next building").tap()
    expect(name(page)).to_have_text(first)
    page.wait_for_timeout(800)  # the flight to the building
    page.get_by_role("button", name="Next building").tap()
    expect(name(page)).to_have_text(second)
    page.wait_for_timeout(800)
    page.touchscreen.tap(*middle(page))
    page.wait_for_timeout(300)
    expect(name(page)).to_have_text(second)
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390
    expect_accessible(page)
    for selector in (".ct-facts dt", ".ct-facts dd", ".ct-zone small", ".gl-name"):
        assert contrast(page.locator(selector).first) >= 4.5
    page.get_by_role("button", name="Walk", exact=True).tap()
    expect(page.get_by_role("button", name="Walk ahead")).to_be_visible()
