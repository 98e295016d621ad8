"""What a person does means what the page shows, however late it hears of what happened meanwhile."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from tests.browser.driver import Server
from tests.browser.late import deaf
from tests.cases import takes_turns


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """A server of this module's own, since its factors stay."""
    running = Server("toy", tmp_path_factory.mktemp("delays") / "towers.db").start()
    yield running
    running.kill()


@pytest.fixture
def towers(opened, server):
    """The page with two factors, of which the first is active."""
    page = opened(server.address)
    while (count := page.page.locator(".gl-tab").count()) > 1:
        page.button("Rename or delete this factor").click()
        page.page.locator(".gl-danger").click()
        expect(page.page.locator(".gl-tab")).not_to_have_count(count)
    page.forget()
    edit(page, rename="overall")
    page.button("New factor").click()
    page.page.keyboard.type("roof")
    page.press("Enter")
    expect_active(page, "roof")
    tab(page, "overall").click()
    expect_active(page, "overall")
    return page


def tab(page, name):
    return page.page.locator(".gl-tab").filter(has_text=name)


def expect_active(page, name):
    expect(tab(page, name)).to_have_attribute("aria-pressed", "true")


def edit(page, rename):
    page.button("Rename or delete this factor").click()
    page.page.get_by_label("Name of the factor").fill(rename)
    page.press("Enter")
    expect(tab(page, rename)).to_be_visible()


def names(page):
    return page.page.locator(".gl-tab span").all_text_contents()


def score_of_first(page, factor):
    tab(page, factor).click()
    expect_active(page, factor)
    return page.scores()[0]


@takes_turns
def test_a_score_goes_to_the_factor_that_was_seen_while_another_becomes_active(towers):
    towers.cell(0).click()
    with deaf(towers.page):
        tab(towers, "roof").click()
        expect_active(towers, "overall")
        towers.cell(0).click()
        towers.press("7")
    expect_active(towers, "roof")
    towers.expect_saved()
    assert towers.scores()[0] == ""
    assert score_of_first(towers, "overall") == "70"


@takes_turns
def test_presses_count_from_the_press_before_though_it_is_not_confirmed(towers):
    with deaf(towers.page):
        tab(towers, "roof").click()
        tab(towers, "overall").click()
        towers.press("c", "c")
        towers.cell(0).click()
        towers.press("7")
    towers.expect_saved()  # so all states before are there
    expect_active(towers, "overall")
    expect(towers.cell(0)).to_be_visible()


@takes_turns
def test_a_score_goes_to_the_factor_that_was_seen_though_it_is_called_otherwise_by_now(towers, opened, server):
    other = opened(server.address)
    with deaf(towers.page):
        edit(other, rename="style")
        edit(other, rename="overall two")
        towers.cell(0).click()
        towers.press("6")
    towers.expect_saved()
    assert names(towers)[:2] == ["overall two", "roof"]
    assert score_of_first(towers, "roof") == ""
    assert score_of_first(towers, "overall two") == "60"


@takes_turns
def test_a_score_for_a_factor_that_was_deleted_is_refused_in_words(towers, opened, server):
    other = opened(server.address)
    with deaf(towers.page):
        other.button("Rename or delete this factor").click()
        other.page.get_by_role("button", name="Delete “overall”").click()
        expect(tab(other, "overall")).to_have_count(0)
        towers.cell(0).click()
        towers.press("6")
    complaint = towers.page.get_by_role("alert").filter(has_text="Not saved")
    expect(complaint).to_contain_text("has been deleted; Undo brings it")
    assert towers.scores()[0] == ""
    other.button("Undo").click()
    expect(tab(towers, "overall")).to_be_visible()


@pytest.mark.parametrize("act", ["rename", "delete"])
@takes_turns
def test_a_menu_stays_about_the_factor_that_it_names_while_another_becomes_active(towers, act):
    with deaf(towers.page):
        tab(towers, "roof").click()
        towers.button("Rename or delete this factor").click()
        expect(towers.page.get_by_role("button", name="Delete “overall”")).to_be_visible()
    expect_active(towers, "roof")
    expect(towers.page.get_by_text("Factor “overall”")).to_be_visible()
    if act == "rename":
        towers.page.get_by_label("Name of the factor").fill("shape")
        towers.press("Enter")
        expect(tab(towers, "shape")).to_be_visible()
        assert names(towers)[:2] == ["shape", "roof"]
        return
    towers.page.get_by_role("button", name="Delete “overall”").click()
    expect(tab(towers, "overall")).to_have_count(0)
    assert names(towers) == ["roof"]
    towers.button("Undo").click()
    expect(tab(towers, "overall")).to_be_visible()


def test_a_tab_is_the_factor_that_it_shows_though_another_has_its_name_by_now(towers, opened, server):
    other = opened(server.address)
    with deaf(towers.page):
        tab(other, "roof").click()
        expect_active(other, "roof")
        edit(other, rename="door")
        other.button("New factor").click()
        other.page.keyboard.type("roof")
        other.press("Enter")
        expect_active(other, "roof")
        tab(towers, "roof").click()
    expect_active(towers, "door")
