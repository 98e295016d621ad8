"""What stands beside the grids: models that were scored, the preview, the size of pictures, the score on a phone."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from tests.browser.driver import ScoringPage
from tests.cases import takes_turns
from tests.waiting import wait_until


@takes_turns
def test_scores_are_taken_away_one_by_one_and_pictures_grow_and_turn(towers: ScoringPage):
    page = towers.page
    scored = page.get_by_role("list", name="Scored models").get_by_role("listitem")
    expect(scored).to_have_count(0)
    towers.cell(0).click()
    towers.press("7", "2", "9")
    towers.expect_saved()
    models = towers.models()
    expect(scored.locator(".gl-score")).to_have_text(["90", "20", "70"])
    # The one in the middle goes, with its score in the grid, and no other; a step back brings it.
    scored.nth(1).get_by_role("button", name="Remove the score").click()
    expect(scored.locator(".gl-score")).to_have_text(["90", "70"])
    towers.expect_saved()
    assert towers.scores()[:4] == ["70", "", "90", ""]
    assert towers.models() == models
    towers.button("Undo").click()
    expect(scored).to_have_count(3)
    # The wheel on the slider, the slider and the keys change one size.
    slider = page.get_by_role("slider", name="Size of pictures")
    size = towers.cell(0).evaluate("cell => cell.offsetWidth")
    slider.hover()
    page.mouse.wheel(0, -100)
    expect(slider).to_have_attribute("aria-valuetext", "112 %")
    assert towers.cell(0).evaluate("cell => cell.offsetWidth") == pytest.approx(1.12 * size, abs=2)
    slider.focus()
    slider.press("End")
    expect(slider).to_have_attribute("aria-valuetext", "1000 %")
    towers.button("Show all").click()
    expect(slider).to_have_attribute("aria-valuetext", "100 %")
    # A preview turns on the other side of the grids, and goes with the mouse.
    page.get_by_role("button", name="Show the model below the mouse").click()
    preview = page.locator(".gl-preview")
    page.emulate_media(reduced_motion="no-preference")
    towers.cell(0).hover()
    expect(preview).to_be_visible()
    box, tile = preview.bounding_box(), towers.cell(0).bounding_box()
    assert box
    assert tile
    assert box["x"] > tile["x"] + tile["width"]
    assert box["width"] > 300
    before = preview.screenshot()
    wait_until(lambda: preview.screenshot() != before)
    page.emulate_media(reduced_motion="reduce")
    page.mouse.move(2, 2)
    expect(preview).to_be_hidden()


def test_a_phone_scores_at_its_lower_edge_below_the_models(towers: ScoringPage):
    page = towers.page
    page.set_viewport_size({"width": 400, "height": 760})
    bar = page.get_by_role("region", name="Score", exact=True)
    edge = bar.bounding_box()
    assert edge
    assert edge["y"] + edge["height"] == pytest.approx(760, abs=1)
    assert edge["height"] < 180
    towers.cell(1).click()
    bar.get_by_role("button", name="30", exact=True).click()
    expect(towers.cell(1).locator(".gl-score")).to_have_text("30")
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
