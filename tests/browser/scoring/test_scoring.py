"""Selecting models and giving scores, with mouse and keys."""

from __future__ import annotations

from playwright.sync_api import expect

from tests.cases import takes_turns


def box(locator):
    found = locator.bounding_box()
    assert found
    return found


def middle(locator):
    found = box(locator)
    return found["x"] + found["width"] / 2, found["y"] + found["height"] / 2


def test_two_grids_of_sixteen_models_appear_with_their_pictures(towers):
    towers.expect_pictures()
    assert towers.cells.count() == 32
    assert towers.page.get_by_role("listbox").count() == 2


def test_a_click_selects_shift_a_range_and_ctrl_toggles(towers):
    towers.cell(2).click()
    towers.expect_chosen([2])
    towers.cell(5).click(modifiers=["Shift"])
    towers.expect_chosen([2, 3, 4, 5])
    towers.cell(3).click(modifiers=["Control"])
    towers.expect_chosen([2, 4, 5])
    towers.cell(20).click(modifiers=["Control"])
    towers.expect_chosen([2, 4, 5, 20])
    towers.cell(22).click(modifiers=["Control", "Shift"])
    towers.expect_chosen([2, 4, 5, 20, 21, 22])


def test_all_are_selected_and_none(towers):
    towers.cell(0).click()
    towers.press("Control+a")
    towers.expect_chosen(list(range(32)))
    towers.press("Escape")
    towers.expect_chosen([])


def test_a_click_beside_the_models_selects_none(towers):
    towers.cell(0).click()
    stage = box(towers.page.locator(".gl-stage"))
    towers.page.mouse.click(stage["x"] + 5, stage["y"] + 5)
    towers.expect_chosen([])


def test_a_rubber_band_selects_what_it_touches_and_shift_adds(towers):
    mouse = towers.page.mouse
    (left, top), (right, bottom) = middle(towers.cell(0)), middle(towers.cell(3))
    mouse.move(left, top)
    mouse.down()
    mouse.move(right, bottom, steps=4)
    expect(towers.page.locator(".gl-band")).to_be_visible()
    mouse.up()
    expect(towers.page.locator(".gl-band")).to_be_hidden()
    towers.expect_chosen([0, 1, 2, 3])
    towers.page.keyboard.down("Shift")
    mouse.move(*middle(towers.cell(16)))
    mouse.down()
    x, y = middle(towers.cell(17))
    mouse.move(x, y, steps=4)
    mouse.up()
    towers.page.keyboard.up("Shift")
    towers.expect_chosen([0, 1, 2, 3, 16, 17])


def test_one_score_goes_to_the_whole_selection(towers):
    towers.cell(4).click()
    towers.cell(7).click(modifiers=["Shift"])
    towers.press("8")
    towers.expect_saved()
    assert towers.scores()[4:8] == ["80"] * 4
    assert towers.scores().count("") == 28


def test_keys_steps_slider_and_typing_give_scores(towers):
    for position, act, score in (
        (0, lambda: towers.press("0"), "0"),
        (1, lambda: towers.press("9"), "90"),
        (2, lambda: towers.press("h"), "100"),
        (3, lambda: towers.button("40").click(), "40"),
        (4, lambda: towers.page.get_by_role("slider", name="Score of").fill("33"), "33"),
        (5, lambda: (towers.press("s"), towers.page.keyboard.type("72.5"), towers.press("Enter")), "72.5"),
    ):
        towers.cell(position).click()
        act()
        towers.expect_saved()
        assert towers.scores()[position] == score
    assert towers.scores()[:6] == ["0", "90", "100", "40", "33", "72.5"]


def test_a_score_out_of_range_is_not_taken(towers):
    towers.cell(0).click()
    towers.press("s")
    towers.page.keyboard.type("101")
    towers.press("Enter")
    assert towers.page.get_by_label("Score of the selected models, 0 to 100").evaluate("field => !field.validity.valid")
    assert towers.scores()[0] == ""


@takes_turns
def test_a_key_hands_on_to_the_next_model_unless_switched_off(towers):
    towers.cell(0).click()
    towers.press("1", "2", "3")
    towers.expect_saved()
    assert towers.scores()[:4] == ["10", "20", "30", ""]
    towers.expect_chosen([3])
    towers.page.get_by_label("after a key, go on to the next model").uncheck()
    towers.cell(3).click()
    towers.press("4", "5")
    towers.expect_saved()
    assert towers.scores()[:5] == ["10", "20", "30", "50", ""]
    towers.page.get_by_label("after a key, go on to the next model").check()


def test_delete_takes_a_score_away(towers):
    towers.cell(0).click()
    towers.press("5", "ArrowLeft", "Delete")
    towers.expect_saved()
    assert towers.scores()[0] == ""


def test_undo_and_redo_by_keys_and_buttons(towers):
    towers.cell(0).click()
    towers.press("3")
    towers.cell(0).click()
    towers.press("6")
    towers.expect_saved()
    first = towers.page.locator(".gl-score").first
    expect(first).to_have_text("60")
    towers.press("u")
    expect(first).to_have_text("30")
    towers.press("Control+z")
    expect(first).to_have_text("")
    towers.press("Control+Shift+z")
    expect(first).to_have_text("30")
    towers.button("Redo").click()
    expect(first).to_have_text("60")
    expect(towers.button("Redo")).to_be_disabled()
    towers.button("Undo").click()
    expect(first).to_have_text("30")


def test_nothing_left_to_redo_is_no_mistake(towers):
    towers.press("Control+y")
    expect(towers.page.get_by_text("there is nothing to redo")).to_be_visible()
    expect(towers.page.locator(".gl-note.gl-bad:not(.gl-warnings)")).to_have_count(0)


def test_arrows_move_within_a_grid_and_over_to_the_next(towers):
    """Each grid has two columns, so that its pictures are large enough to judge."""
    towers.cell(0).click()
    for keys, position in (
        (["ArrowRight"], 1),
        (["ArrowDown"], 3),
        (["ArrowLeft"], 2),
        (["ArrowUp"], 0),
        (["ArrowUp"], 0),
        (["ArrowRight"] * 2, 16),
        (["ArrowDown"], 18),
        (["ArrowLeft"], 3),
        (["End"], 15),
        (["ArrowRight"], 30),
        (["Home"], 16),
    ):
        towers.press(*keys)
        towers.expect_chosen([position])
        expect(towers.cell(position)).to_be_focused()


def test_keys_select_ranges_and_single_models(towers):
    towers.cell(2).click()
    towers.press("Shift+ArrowRight", "Shift+ArrowDown")
    towers.expect_chosen([2, 3, 4, 5])
    towers.cell(0).click()
    towers.press("Control+ArrowRight", "Control+ArrowDown", " ")
    towers.expect_chosen([0, 3])
    towers.press(" ")
    towers.expect_chosen([0])


def test_scores_are_there_after_opening_the_page_again(towers):
    towers.cell(9).click()
    towers.press("7")
    towers.expect_saved()
    towers.page.reload()
    expect(towers.page.locator(".gl-score").nth(9)).to_have_text("70")


def test_many_scores_given_quickly_are_all_kept(towers):
    """Five rounds over all models but the last, each with other scores; nobody waits for an answer."""
    for turn in range(5):
        towers.cell(0).click()
        for position in range(31):
            towers.press(str((position + turn) % 10))
    towers.expect_saved()
    towers.page.reload()
    expect(towers.cell(31)).to_be_visible()
    assert towers.scores() == [*(str(10 * ((position + 4) % 10)) for position in range(31)), ""]
