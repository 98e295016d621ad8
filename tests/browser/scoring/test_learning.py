"""What a person sees who has scored models and updated: predictions, new models, orders, the grammar."""

from __future__ import annotations

import math
import re

import pytest
from playwright.sync_api import expect

from tests.browser.accessible import expect_accessible
from tests.browser.driver import ScoringPage, Server
from tests.cases import takes_turns
from tests.waiting import wait_until


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """A server of this module's own, since what was learned stays."""
    running = Server("toy", tmp_path_factory.mktemp("learning") / "towers.db").start()
    yield running
    running.kill()


@pytest.fixture(scope="module")
def story(browser, server):
    """32 models were scored and learned from, once for all tests here."""
    context = browser.new_context()
    towers = ScoringPage(context.new_page())
    towers.page.goto(server.address)
    towers.cell(0).click()
    towers.press(*(str((3 * position) % 10) for position in range(32)))
    towers.expect_saved()
    towers.update()
    context.close()
    return server


@pytest.fixture
def learned(story, opened):
    """The page of a session that has learned."""
    return opened(story.address)


def predicted(towers):
    return towers.look("cells => cells.map(cell => Number(cell.ariaLabel.match(/predicted (-?\\d+)/)?.[1]))")


def uncertain(towers):
    return towers.look("cells => cells.map(cell => Number(cell.ariaLabel.match(/± (\\d+)/)?.[1]))")


def show_new(towers, way):
    before = towers.models()
    towers.page.get_by_role("button", name="by ").click()
    towers.page.get_by_role("radio", name=way).first.click()
    wait_until(lambda: towers.models() != before)


def sort(towers, order):
    towers.page.get_by_role("button", name="Sort").click()
    towers.page.get_by_role("button", name=order).click()


def test_what_was_learned_shows_new_models_with_bars_a_chart_and_reasons(learned):
    assert learned.scores() == [""] * 32
    pictures = learned.page.get_by_role("img", name="models that are next in line")
    expect(pictures.locator(".gl-picture").first).to_have_css("background-image", re.compile("blob:"))
    assert not any(math.isnan(value) for value in (*predicted(learned), *uncertain(learned)))
    assert learned.page.locator(".gl-dot").count() >= 1
    expect(learned.page.locator(".gl-chart figcaption")).to_contain_text("changed what is learned by")
    fill = learned.page.locator(".gl-bar.gl-predicted i").first
    expect(fill).not_to_have_css("transform", "matrix(0, 0, 0, 1, 0, 0)")
    expect_accessible(learned.page)


def test_nobody_who_has_shown_no_pattern_is_told_to_stop(learned):
    for _ in range(2):  # Nothing is new, so what is learned does not change.
        learned.update()
    hint = learned.page.locator(".gl-hint")
    expect(hint).to_contain_text("the predictions know them all")
    expect(learned.page.locator(".gl-words")).to_contain_text("No pattern yet")
    expect(learned.page.locator(".gl-chart figcaption")).to_contain_text("changed what is learned by less than 0.1 %")


@takes_turns
def test_models_come_in_all_ways(learned):
    for name in ("by ", "Sort", "Grid"):
        learned.page.get_by_role("button", name=name).click()
        expect(learned.page.locator(".gl-menu:popover-open")).to_be_visible()
        expect_accessible(learned.page)
        if name == "by ":
            assert learned.page.get_by_role("radio").count() == 8
        learned.press("Escape")
    for way, titles in (
        ("unscored", 1),
        ("different", 1),
        ("uncertain", 1),
        ("surprising", 1),
        ("scored all", 1),
        ("as learned", 2),
        ("default", 2),
    ):
        show_new(learned, way)
        expect(learned.page.get_by_role("button", name="by ")).to_contain_text(way.removesuffix(" all"))
        headings = learned.page.locator(".gl-title")
        assert headings.count() >= titles, way
    assert len(set(learned.models())) == len(learned.models())


@takes_turns
def test_scrolling_on_shows_what_is_in_line_below_and_the_last_score_asks_for_others(learned):
    before = learned.models()
    learned.page.locator(".gl-stage").hover()
    # Once, to the end: what is turned again when more has come asks for still more.
    learned.page.mouse.wheel(0, 100_000)
    wait_until(lambda: learned.cells.count() > 32)
    after = learned.models()
    assert set(before) < set(after)
    assert len(set(after)) == len(after)
    # Later than what counts as scrolled to, so that the click on the last one asks for no more below it.
    learned.page.wait_for_timeout(1600)
    # All at once, then the last one by a key: nothing is left to score, so that others come.
    learned.cell(0).click()
    learned.press("Control+a", "5", "Escape")
    learned.cell(len(after) - 1).click()
    learned.press("5")
    learned.expect_chosen([0])
    expect(learned.cell(0)).to_be_focused()
    expect(learned.cell(0)).to_be_in_viewport()
    assert not set(learned.models()) & set(after)
    learned.press("u", "u")
    learned.expect_saved()


@takes_turns
def test_already_ranked_shows_scored_models_with_their_scores(learned):
    show_new(learned, "surprising")
    expect(learned.page.locator(".gl-cell .gl-score:not(:empty)")).to_have_count(32)
    show_new(learned, "default")


@takes_turns
def test_models_are_sorted_by_what_is_predicted(learned):
    shown = sorted(learned.models())
    sort(learned, "Predicted score highest first")
    _expect_falling(learned, predicted)
    sort(learned, "Uncertainty least known first")
    _expect_falling(learned, uncertain)
    before = learned.models()
    sort(learned, "Random")
    wait_until(lambda: learned.models() != before)
    assert sorted(learned.models()) == shown


def test_models_are_sorted_by_similarity_to_the_selected(learned):
    before, values = learned.models(), predicted(learned)
    learned.cell(6).click()
    sort(learned, "Similarity to the 1 selected")
    wait_until(lambda: learned.models() != before)
    learned.expect_chosen([learned.models().index(before[6])])
    # What the kernel cannot tell apart from the selected has its prediction, too.
    assert predicted(learned)[0] == values[6]


def test_models_are_sorted_by_a_feature_found_by_name(learned):
    learned.page.get_by_role("button", name="Sort").click()
    learned.page.get_by_role("searchbox").fill("mesh")
    found = learned.page.get_by_role("group", name="Features found").get_by_role("button")
    expect(found.first).to_contain_text("MESH")
    found.first.click()
    expect(learned.page.get_by_role("searchbox")).to_be_hidden()


def test_a_grammar_is_learned_and_its_samples_are_drawn(learned):
    with learned.page.expect_download() as download:
        learned.button("Learn grammar").click()
    assert download.value.suggested_filename.endswith(".cga")
    assert "-->" in download.value.path().read_text()
    expect(learned.page.locator(".gl-outcome")).to_contain_text("rules became")
    expect(learned.page.get_by_role("link", name="Save ")).to_be_in_viewport()
    learned.button("Check sheet").click()
    sheet = learned.page.get_by_role("img", name="samples of the learned grammar")
    expect(sheet).to_be_in_viewport(ratio=0.9)
    assert sheet.evaluate("image => image.naturalWidth") > 200
    expect_accessible(learned.page)


def _expect_falling(towers, values):
    wait_until(lambda: all(_is_falling(values(towers)[part : part + 16]) for part in (0, 16)))


def _is_falling(values):
    return values == sorted(values, reverse=True)
