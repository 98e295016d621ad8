"""The dialog that says what the keys do."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect

from tests.browser.scoring.test_page import contrast

HELD = "() => document.activeElement.closest('dialog')?.ariaLabel"


def keys(page: Page):
    return page.get_by_role("dialog", name="Keys")


def type_like(page: Page, code: str) -> None:
    """A question mark from the key at this place of a keyboard, with Shift held."""
    client = page.context.new_cdp_session(page)
    for kind in ("keyDown", "keyUp"):
        event = {"type": kind, "key": "?", "code": code, "modifiers": 8, "text": "?" if kind == "keyDown" else ""}
        client.send("Input.dispatchKeyEvent", event)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_question_mark_shows_keys_that_can_be_read_on_a_page_that_nobody_has_clicked(opened, server, scheme):
    page = opened(server.address, color_scheme=scheme).page
    page.keyboard.press("?")
    expect(keys(page)).to_be_visible()
    for key, says in (("H", "score 100"), ("?", "show or hide these keys"), ("Enter", "in 3D")):
        expect(keys(page).get_by_text(key, exact=True)).to_be_visible()
        expect(keys(page)).to_contain_text(says)
    for part in ("h2", "dt", "dd"):
        assert contrast(keys(page).locator(part).first) >= 4.5
    page.keyboard.press("Escape")
    expect(keys(page)).to_be_hidden()


@pytest.mark.parametrize("code", ["Slash", "Minus", "KeyM"])
def test_the_question_mark_may_lie_anywhere(towers, code):
    """As on an American, a German and a French keyboard."""
    towers.cell(3).click()
    type_like(towers.page, code)
    expect(keys(towers.page)).to_be_visible()
    type_like(towers.page, code)
    expect(keys(towers.page)).to_be_hidden()
    expect(towers.cell(3)).to_be_focused()


def test_the_focus_stays_in_the_dialog_and_comes_back(towers):
    towers.cell(2).click()
    towers.press("?")
    for key in ("Tab", "Tab", "Shift+Tab", "Shift+Tab", "Shift+Tab"):
        assert towers.page.evaluate(HELD) == "Keys"
        towers.press(key)
    assert towers.page.evaluate(HELD) == "Keys"
    towers.press("7", "u", "ArrowRight", "Escape")
    expect(keys(towers.page)).to_be_hidden()
    expect(towers.cell(2)).to_be_focused()
    assert set(towers.scores()) == {""}
    towers.expect_chosen([2])


def test_a_click_shows_and_hides_the_keys(towers):
    towers.button("Keys").click()
    expect(keys(towers.page)).to_be_visible()
    keys(towers.page).get_by_role("button", name="Close").click()
    expect(keys(towers.page)).to_be_hidden()
    expect(towers.button("Keys")).to_be_focused()


def test_a_question_mark_that_is_typed_is_text(towers):
    towers.button("Sort").click()
    search = towers.page.get_by_role("searchbox")
    search.fill("")
    search.press("?")
    expect(search).to_have_value("?")
    expect(keys(towers.page)).to_be_hidden()
    towers.press("Escape", "Escape")


def test_the_keys_are_shown_above_the_large_view_which_stays(towers):
    towers.cell(0).click()
    towers.press("Enter")
    look = towers.page.get_by_role("dialog", name="Model in 3D")
    expect(look).to_be_visible()
    towers.press("?")
    expect(keys(towers.page)).to_be_visible()
    towers.press("Escape")
    expect(keys(towers.page)).to_be_hidden()
    expect(look).to_be_visible()
    towers.press("Escape")
    expect(look).to_be_hidden()


def test_all_keys_are_seen_in_a_small_window(opened, server):
    page = opened(server.address, size=(390, 300)).page
    page.keyboard.press("?")
    expect(keys(page)).to_be_visible()
    last = keys(page).locator("dd").last
    last.scroll_into_view_if_needed()
    expect(last).to_be_in_viewport()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
