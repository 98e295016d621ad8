"""Stars, thumbs, and two models at a time, with mouse, keys and fingers."""

from __future__ import annotations

import json
import re

import pytest
from playwright.sync_api import expect

from tests.browser.driver import Server, settle
from tests.cases import some, takes_turns


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """A server of this module's own, since pairs stay where they are shown."""
    running = Server("toy", tmp_path_factory.mktemp("kinds") / "towers.db").start()
    yield running
    running.kill()


@pytest.fixture
def towers(opened, server):
    page = opened(server.address)
    page.forget()
    yield page
    in_grids(page)


@pytest.fixture
def pairs(towers):
    towers.button("Compare").click()
    expect(asked(towers)).to_contain_text("Pair 1 of 8")
    return towers


def in_grids(towers):
    if towers.button("Compare").get_attribute("aria-pressed") == "true":
        towers.button("Compare").click()
    expect(towers.cell(0)).to_be_visible()


def asked(towers):
    return towers.page.locator(".gl-asked")


def candidates(towers):
    return towers.page.locator(".gl-candidate")


def names(towers):
    return candidates(towers).evaluate_all("buttons => buttons.map(button => button.ariaLabel.split(': ')[1])")


def expect_said(towers, left, alike, right):
    for button, pressed in zip(
        (candidates(towers).first, towers.button("Both alike"), candidates(towers).last),
        (left, alike, right),
        strict=True,
    ):
        expect(button).to_have_attribute("aria-pressed", str(pressed).lower())


def exported(towers, path):
    """Rows of all labels, as a person gets them."""
    with towers.page.expect_download() as download:
        towers.button("Export scores").click()
        towers.page.get_by_role("button", name="JSONL").click()
    download.value.save_as(path)
    return [json.loads(line) for line in path.read_text().splitlines()]


def choose_scale(towers, name):
    towers.button(name).click()
    expect(towers.button(name)).to_have_attribute("aria-pressed", "true")


def test_keys_are_for_the_models_after_a_scale_is_chosen_with_the_mouse(towers):
    towers.cell(1).click()
    choose_scale(towers, "Stars")
    towers.press("4")
    expect(towers.cell(1).locator(".gl-score")).to_have_text("4★")
    choose_scale(towers, "0–100")


@takes_turns
def test_stars_and_thumbs_by_buttons_and_keys_stand_beside_scores(towers, tmp_path):
    towers.cell(0).click()
    towers.press("7")
    choose_scale(towers, "Stars")
    expect(towers.page.get_by_role("slider", name="Score of")).to_be_hidden()
    towers.cell(1).click()
    towers.button("4 of 5 stars").click()
    towers.expect_saved()
    towers.cell(2).click()
    towers.press("1", "5", "0", "9", "h")
    choose_scale(towers, "Thumbs")
    towers.cell(4).click()
    towers.press("1", "0")
    towers.cell(6).click()
    towers.button("thumb up").click()
    towers.expect_saved()
    assert towers.scores()[:8] == ["70", "4★", "1★", "5★", "▲", "▼", "▲", ""]
    assert [label.split(", ")[1] for label in towers.labels()[:8]] == [
        "scored 70",
        "4 of 5 stars",
        "1 of 5 stars",
        "5 of 5 stars",
        "thumb up",
        "thumb down",
        "thumb up",
        "no score",
    ]
    rows = exported(towers, tmp_path / "all.jsonl")
    assert [(row["kind"], row["score"]) for row in rows] == [
        ("score", 70),
        ("stars", 75),
        ("stars", 0),
        ("stars", 100),
        ("thumb", 100),
        ("thumb", 0),
        ("thumb", 100),
    ]
    choose_scale(towers, "0–100")


@takes_turns
def test_a_star_takes_the_place_of_a_score_and_undo_brings_that_back(towers):
    towers.cell(3).click()
    towers.press("6")
    towers.cell(3).click()
    towers.press("t", "2")
    expect(towers.page.locator(".gl-score").nth(3)).to_have_text("2★")
    towers.press("u")
    expect(towers.page.locator(".gl-score").nth(3)).to_have_text("60")
    towers.press("Control+Shift+z")
    expect(towers.page.locator(".gl-score").nth(3)).to_have_text("2★")
    towers.cell(3).click()
    pressed = towers.page.locator(".gl-step.gl-on")
    expect(pressed).to_have_count(2)
    towers.press("t", "Delete", "t")
    towers.expect_saved()
    assert towers.scores()[3] == ""


@takes_turns
def test_the_scale_is_kept_in_this_browser(towers):
    towers.cell(0).click()
    towers.press("t")
    towers.page.reload()
    expect(towers.button("Stars")).to_have_attribute("aria-pressed", "true")
    towers.cell(0).click()
    towers.press("t", "t")
    expect(towers.button("0–100")).to_have_attribute("aria-pressed", "true")


@takes_turns
def test_pairs_are_answered_by_keys_and_corrected(pairs, tmp_path):
    first = names(pairs)
    assert len(set(first)) == 2
    pairs.press("ArrowLeft")
    expect(asked(pairs)).to_contain_text("Pair 2 of 8")
    pairs.press("ArrowDown", "ArrowRight")
    pairs.expect_saved()
    expect(asked(pairs)).to_contain_text("Pair 4 of 8")
    pairs.press("ArrowUp")
    expect_said(pairs, left=False, alike=False, right=True)
    pairs.press("ArrowUp")
    expect_said(pairs, left=False, alike=True, right=False)
    pairs.press("ArrowUp")
    assert names(pairs) == first
    expect_said(pairs, left=True, alike=False, right=False)
    pairs.press("ArrowRight", "ArrowUp")
    expect_said(pairs, left=False, alike=False, right=True)
    pairs.expect_saved()
    rows = exported(pairs, tmp_path / "pairs.jsonl")
    assert [row["kind"] for row in rows] == ["rather", "tie", "rather"]
    numbers = [int(name.split()[1]) for name in first]
    assert [rows[0]["model"], json.loads(rows[0]["other"])["model"]] == numbers[::-1]
    pairs.press("u")
    expect_said(pairs, left=True, alike=False, right=False)
    pairs.press("Delete")
    expect_said(pairs, left=False, alike=False, right=False)
    pairs.press("n", "Delete", "n", "Delete")
    pairs.expect_saved()
    expect(pairs.page.locator(".gl-hint").first).to_contain_text("Score some models")


@takes_turns
def test_a_click_or_a_finger_on_a_model_prefers_it(opened, server):
    towers = opened(server.address, has_touch=True, size=(390, 800))
    towers.button("Compare").tap()
    expect(asked(towers)).to_contain_text("Pair 1 of 8")
    assert towers.page.evaluate("document.documentElement.scrollWidth") <= 390
    left, right = (candidates(towers).nth(side).bounding_box() for side in range(2))
    assert left["x"] + left["width"] <= right["x"]
    candidates(towers).last.tap()
    expect(asked(towers)).to_contain_text("Pair 2 of 8")
    candidates(towers).first.click()
    towers.button("Both alike").tap()
    towers.expect_saved()
    for said in ((False, True, False), (True, False, False), (False, False, True)):
        towers.button("Pair before").tap()
        expect_said(towers, *said)
        towers.button("No answer").tap()
    towers.expect_saved()
    in_grids(towers)


def test_what_was_said_of_pairs_is_there_after_opening_the_page_again(pairs):
    before = names(pairs)
    pairs.press("ArrowRight")
    pairs.expect_saved()
    pairs.page.reload()
    expect(asked(pairs)).to_contain_text("Pair 2 of 8")
    pairs.button("Pair before").click()
    assert names(pairs) == before
    expect_said(pairs, left=False, alike=False, right=True)
    pairs.button("No answer").click()
    pairs.expect_saved()


def test_pairs_and_grids_by_a_key_and_both_models_in_3d(towers):
    towers.cell(0).click()
    towers.press("c")
    expect(asked(towers)).to_be_visible()
    expect(towers.page.locator(".gl-stage")).to_be_hidden()
    expect(towers.page.locator(".gl-compare")).to_be_focused()
    shown = names(towers)
    towers.press("Enter")
    title = towers.page.locator(".gl-look-title")
    expect(title).to_contain_text(shown[0])
    towers.press("ArrowRight")
    expect(title).to_contain_text(shown[1])
    towers.press("ArrowRight")
    expect(title).to_contain_text(shown[1])
    towers.press("Escape")
    expect(towers.page.locator(".gl-compare")).to_be_focused()
    towers.press("c")
    expect(towers.page.locator(".gl-cell:focus")).to_have_count(1)


@takes_turns
def test_other_pairs_come_when_all_are_answered_and_are_learned_from_behind_the_person(pairs):
    before = set()
    for _ in range(8):
        before |= {tuple(names(pairs))}
        pairs.press("ArrowLeft")
    expect(asked(pairs)).to_contain_text("Pair 1 of 8. Which")
    pairs.expect_saved()
    # Either says that they are known; which one depends on how much the updates between them have changed.
    known = re.compile("8 comparisons; (the predictions know them all|the last updates changed little)")
    expect(pairs.page.locator(".gl-hint").first).to_contain_text(known)
    after = set()
    for _ in range(8):
        after |= {tuple(names(pairs))}
        pairs.press("n")
    assert len(after) == 8
    assert not {frozenset(pair) for pair in before} & {frozenset(pair) for pair in after}
    for _ in range(8):
        pairs.press("u")
    expect(pairs.page.locator(".gl-hint").first).to_contain_text("Score some models")


@pytest.mark.parametrize("scheme", some(["light", "dark"]))
def test_two_models_are_read_and_told_apart_in_both_themes(opened, server, scheme):
    towers = opened(server.address, color_scheme=scheme)
    towers.button("Compare").click()
    expect(towers.page.locator(".gl-candidate[aria-busy=false]")).to_have_count(2)
    settle(towers.page)
    colours = asked(towers).evaluate(
        "text => [getComputedStyle(text).color, getComputedStyle(text.parentElement).backgroundColor]"
    )
    assert colours[0] != colours[1]
    in_grids(towers)
