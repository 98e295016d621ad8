"""No score is lost: the connection goes, the server is killed, two windows are open."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from tests.browser.driver import Server
from tests.cases import takes_turns


@pytest.fixture
def mortal(tmp_path):
    """A server that a test may kill."""
    running = Server("toy", tmp_path / "towers.db").start()
    yield running
    running.kill()


def test_scores_given_while_the_server_is_gone_are_sent_when_it_is_back(opened, mortal):
    towers = opened(mortal.address)
    towers.cell(0).click()
    towers.press("1")
    towers.expect_saved()
    mortal.kill()
    banner = towers.page.get_by_role("alert").filter(has_text="connection to Python is lost")
    expect(banner).to_be_visible()
    towers.press("2", "3")
    expect(towers.saved).to_have_text("2 not saved yet")
    expect(banner).to_contain_text("2 scores are not saved yet")
    expect(towers.page.locator(".gl-unsaved")).to_have_count(2)
    assert towers.scores()[:4] == ["10", "20", "30", ""]
    mortal.start(mortal.port)
    towers.expect_saved()
    expect(banner).to_be_hidden()
    towers.page.reload()
    expect(towers.page.locator(".gl-score").nth(2)).to_have_text("30")
    assert towers.scores()[:4] == ["10", "20", "30", ""]


def test_a_page_with_unsaved_scores_asks_before_it_is_left(opened, mortal):
    towers = opened(mortal.address)
    towers.cell(0).click()
    mortal.kill()
    towers.press("4")
    expect(towers.saved).to_have_text("1 not saved yet")
    with towers.page.expect_event("dialog") as asked:
        towers.page.close(run_before_unload=True)
    assert asked.value.type == "beforeunload"
    asked.value.accept()


@takes_turns
def test_two_windows_agree(opened, server):
    first, second = opened(server.address), opened(server.address)
    first.cell(3).click()
    first.press("8")
    first.expect_saved()
    expect(second.page.locator(".gl-score").nth(3)).to_have_text("80")
    second.button("Undo").click()
    expect(first.page.locator(".gl-score").nth(3)).to_have_text("")


def test_a_page_without_the_token_is_not_served(browser, server):
    context = browser.new_context()
    answer = context.request.get(server.address.replace("token=", "token=x"))
    assert answer.status == 403
    context.close()
