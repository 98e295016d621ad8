"""What is shown: grids, zoom and pan, other models, the 3D view."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

from grammarlab.learning.designs.addresses import Address
from grammarlab.runs.sample.trace import as_values, trace_model
from tests.browser.accessible import expect_accessible
from tests.browser.driver import Server
from tests.browser.late import deaf
from tests.cases import some, takes_turns
from tests.waiting import wait_until


def tile_width(towers):
    return towers.cell(0).bounding_box()["width"]


def test_buttons_zoom_in_and_out_and_show_all_again(towers):
    before = tile_width(towers)
    towers.button("Zoom in").click()
    towers.button("Zoom in").click()
    assert tile_width(towers) > 1.4 * before
    towers.button("Zoom out").click()
    assert before < tile_width(towers) < 1.4 * before
    towers.button("Show all").click()
    assert tile_width(towers) == before


@pytest.mark.parametrize(("size", "least"), some([((1440, 900), 200), ((1100, 800), 150), ((400, 800), 150)]))
@takes_turns
def test_pictures_are_large_enough_to_judge_and_none_is_cut_at_a_side(opened, server, size, least):
    shown = opened(server.address, size=size)
    boxes = [shown.cell(position).bounding_box() for position in range(shown.cells.count())]
    stage = shown.page.locator(".gl-stage").bounding_box()
    assert min(box["width"] for box in boxes) >= least
    assert min(box["x"] for box in boxes) >= stage["x"]
    assert max(box["x"] + box["width"] for box in boxes) <= stage["x"] + stage["width"]


ASKED_FOR = """
window.good = [];
const { send } = WebSocket.prototype;
WebSocket.prototype.send = function (data) {
  const { command, good: models } = typeof data === "string" ? JSON.parse(data) : {};
  if (command === "pictures") good.push(...models);
  send.call(this, data);
};
"""
"""Script that remembers of which models good pictures were asked for."""


def test_pictures_are_good_where_somebody_looks_and_quick_elsewhere(opened, server):
    shown = opened(server.address, size=(1100, 600), script=ASKED_FOR)
    models = shown.models()
    first, last = models[:2], models[14:16]
    wait_until(lambda: set(first) <= set(shown.page.evaluate("good")))
    shown.expect_pictures()
    assert not {*last} & set(shown.page.evaluate("good"))
    shown.cell(15).scroll_into_view_if_needed()
    wait_until(lambda: set(last) <= set(shown.page.evaluate("good")))


@takes_turns
def test_the_wheel_with_ctrl_zooms_where_the_mouse_is(towers):
    tile = towers.cell(21)
    before = tile.bounding_box()
    x, y = before["x"] + before["width"] / 2, before["y"] + before["height"] / 2
    towers.page.mouse.move(x, y)
    towers.page.keyboard.down("Control")
    for _ in range(5):
        towers.page.mouse.wheel(0, -120)
    towers.page.keyboard.up("Control")
    expect(tile).to_be_in_viewport()
    after = tile.bounding_box()
    assert after["width"] > 2 * before["width"]
    assert after["x"] < x < after["x"] + after["width"]
    assert after["y"] < y < after["y"] + after["height"]


@pytest.mark.parametrize("with_tool", [True, False])
def test_dragging_pans_with_the_hand_or_with_ctrl(towers, with_tool):
    for _ in range(5):
        towers.button("Zoom in").click()
    before = towers.cell(21).bounding_box()
    if with_tool:
        towers.button("Drag to pan").click()
    else:
        towers.page.keyboard.down("Control")
    mouse = towers.page.mouse
    mouse.move(500, 500)
    mouse.down()
    mouse.move(450, 420, steps=3)
    mouse.up()
    towers.page.keyboard.up("Control")
    after = towers.cell(21).bounding_box()
    assert (after["x"] - before["x"], after["y"] - before["y"]) == (-50, -80)
    towers.expect_chosen([])


def test_bars_can_be_switched_off(towers):
    bars = towers.page.locator(".gl-bars").first
    expect(bars).to_be_visible()
    towers.button("Bars of predicted score and uncertainty").click()
    expect(bars).to_be_hidden()
    towers.page.reload()
    expect(towers.cell(0)).to_be_visible()
    expect(bars).to_be_hidden()


@takes_turns
def test_grids_grow_to_ten_by_ten_and_all_pictures_come(towers):
    def lay(name, count):
        towers.page.get_by_role("button", name="Grid").click()
        towers.page.get_by_role("radio", name=name).click()
        expect(towers.cells).to_have_count(count)

    lay("10 × 10 to check", 100)
    towers.expect_pictures()
    assert tile_width(towers) >= 40
    towers.page.get_by_role("button", name="Grid").click()
    for name, value in (("grids", "2"), ("rows", "3"), ("columns", "5")):
        towers.page.get_by_role("spinbutton", name=name).fill(value)
    towers.press("Enter")
    expect(towers.cells).to_have_count(30)
    first, sixth = towers.cell(0).bounding_box(), towers.cell(5).bounding_box()
    assert first["x"] == sixth["x"]
    assert first["y"] < sixth["y"]
    lay("2 of 4 × 4", 32)


@takes_turns
def test_a_double_click_shows_the_model_in_3d(towers):
    towers.cell(3).dblclick()
    dialog = towers.page.get_by_role("dialog")
    expect(dialog).to_be_visible()
    assert colours(shown(towers)) > 20
    before = shown(towers)
    mouse = towers.page.mouse
    mouse.move(600, 400)
    mouse.down()
    mouse.move(760, 420, steps=4)
    mouse.up()
    expect_other_picture(towers, before)
    towers.press("Escape")
    expect(dialog).to_be_hidden()
    expect(towers.cell(3)).to_be_focused()


@takes_turns
def test_the_3d_view_is_used_by_keys_alone(towers):
    towers.cell(4).focus()
    towers.press("Enter")
    dialog = towers.page.get_by_role("dialog")
    before = shown(towers)
    towers.press("ArrowRight", "6")
    expect_other_picture(towers, before)
    expect(dialog.get_by_role("heading")).to_contain_text("scored 60")
    before = shown(towers)
    for key in ("Shift+ArrowRight", "Shift+ArrowUp", "+"):
        towers.press(key)
        expect_other_picture(towers, before)
        towers.press("=")
        expect_picture(towers, before)
    towers.press("Escape")
    towers.expect_saved()
    expect(towers.cell(5)).to_be_focused()
    assert towers.scores()[4:6] == ["", "60"]


@takes_turns
def test_a_click_into_the_3d_view_shows_the_rule_of_the_part_there(towers):
    look_at(towers, 4)
    before = shown(towers)
    middle = centre(towers)
    towers.page.mouse.click(*middle)
    expect(rule(towers)).to_contain_text("toy.cga:")
    text = rule(towers).inner_text()
    expect_other_picture(towers, before)
    rows = as_values(trace_model("toy", *address(towers, 4)))["nodes"]
    way = towers.page.locator(".gl-path li").all_inner_texts()
    assert [step.split()[0] for step in way[:2]] == ["Start", "MASS"]
    made = {f"{row['symbol']} toy.cga:{place(row)} part" for row in rows if row["sizes"]}
    assert any(text.startswith(part) for part in made)
    towers.page.mouse.move(*middle)
    towers.page.mouse.down()
    towers.page.mouse.move(middle[0] + 60, middle[1], steps=4)
    towers.page.mouse.up()
    towers.button("Whole model").click()
    assert rule(towers).inner_text() == text  # to drag is not to click
    marked = shown(towers)
    towers.page.mouse.click(middle[0] - 450, middle[1])
    expect(rule(towers)).to_contain_text("Click a part")
    expect_other_picture(towers, marked)


@takes_turns
def test_the_rules_of_all_parts_are_reached_by_keys_and_by_buttons(towers):
    look_at(towers, 4)
    before = shown(towers)
    with deaf(towers.page):
        towers.press("ArrowDown", "ArrowDown")
    expect(rule(towers)).to_contain_text("part 2 of 2")
    expect_other_picture(towers, before)
    towers.button("Next part").press("Enter")
    expect(rule(towers)).to_contain_text("part 1 of 2")
    towers.button("Previous part").click()
    expect(rule(towers)).to_contain_text("part 2 of 2")
    towers.press("ArrowRight")
    expect(rule(towers)).to_contain_text("Click a part")
    towers.press("Escape")


@takes_turns
def test_a_finger_asks_for_the_rule_of_a_part(opened, server):
    touched = opened(server.address, has_touch=True, color_scheme="dark", size=(420, 760))
    look_at(touched, 0)
    shown(touched)
    touched.page.touchscreen.tap(*centre(touched))
    expect(rule(touched)).to_contain_text("toy.cga:")


def look_at(towers, position):
    towers.cell(position).focus()
    towers.press("Enter")


def rule(towers):
    return towers.page.locator(".gl-rule-text")


def centre(towers):
    box = towers.page.locator(".gl-room").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def address(towers, position):
    """Model and seed."""
    _, seed, model = Address.parse(towers.models()[position])[:3]
    return model, seed


def place(row):
    found = row["rule_at"] or row["made_at"]
    return f"{found['line']}:{found['column']}"


def shown(towers):
    """The picture in the 3D view, once it is there."""
    expect(towers.page.locator(".gl-look-note")).to_have_text("")
    return towers.page.locator(".gl-room").screenshot()


def expect_picture(towers, expected):
    for _ in range(100):
        if shown(towers) == expected:
            return
    pytest.fail("the 3D view does not show the whole model again")


def colours(picture):
    pixels = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")) // 16
    return len(np.unique(pixels.reshape(-1, 3), axis=0))


def expect_other_picture(towers, before):
    for _ in range(100):
        if shown(towers) != before:
            return
    pytest.fail("the 3D view shows the same as before")


@takes_turns
def test_meshes_that_are_not_there_are_told_once_and_again_when_the_page_is_loaded_again(opened, tmp_path):
    rules = tmp_path / "house.cga"
    rules.write_text('Lot --> i("oak.obj") A i("pine.obj") B')
    running = Server(str(rules), tmp_path / "houses.db").start()
    try:
        houses = opened(running.address)
        note = houses.page.locator(".gl-warnings")
        houses.expect_pictures()
        for name in ("oak", "pine"):
            expect(note.get_by_text(f'there is no asset "{name}.obj"')).to_have_count(1)
        expect(note.locator("summary")).to_have_text("1 more warning")
        houses.button("Dismiss").click()
        houses.cell(0).click()
        houses.press("5")
        houses.expect_saved()
        expect(note).to_be_hidden()
        houses.page.reload()
        expect(note).to_be_visible()
    finally:
        running.kill()


WARNED = """
window.WebSocket = class extends WebSocket {
  set onmessage(listener) {
    let last;
    super.onmessage = (event) => {
      if (typeof event.data === "string" && JSON.parse(event.data).event === "state") last = JSON.parse(event.data);
      listener(event);
    };
    window.warn = (warnings) => {
      last.state.warnings = warnings;
      listener({ data: JSON.stringify(last) });
    };
  }
};
"""
"""Script of a window: ``warn([...])`` lets the server say its last state with these warnings."""


def test_all_warnings_can_be_read_and_each_is_read_out_once(opened, server):
    page = opened(server.address, script=WARNED).page
    warn = "warnings => window.warn(warnings)"
    note = page.locator(".gl-warnings")
    newest, others = note.locator(".gl-newest"), note.locator("li")
    expect(note).to_be_hidden()
    page.evaluate(warn, ["w1"])
    expect(newest).to_have_text("w1")
    expect(note.locator("summary")).to_be_hidden()

    page.evaluate(
        """() => {
          window.spoken = [];
          const alert = document.querySelector(".gl-warnings [role=alert]");
          const added = ({ addedNodes }) => [...addedNodes].map((each) => each.textContent);
          new MutationObserver((changes) => spoken.push(...changes.flatMap(added))).observe(alert, { childList: true });
        }"""
    )
    names = [f"w{number}" for number in range(1, 21)]
    page.evaluate(warn, names[:3])
    expect(newest).to_have_text("w3")
    expect(note.locator("summary")).to_have_text("2 more warnings")
    note.locator("summary").press("Enter")
    expect(others).to_have_text(["w2", "w1"])
    # Batches within a second are all read out, each alone: none replaces one that may not have been read yet.
    expect(note.get_by_role("alert")).to_have_attribute("aria-atomic", "false")
    page.evaluate("names => { for (let number = 3; number < 21; number++) warn(names.slice(0, number)); }", names)
    expect(note.get_by_role("alert").get_by_text("w4", exact=True)).to_be_attached()
    expect(note.get_by_role("alert").get_by_text("w19", exact=True)).to_be_attached()
    page.evaluate(warn, names)
    expect(newest).to_have_text("w20")
    expect(others).to_have_text(names[-2::-1])
    expect(others.last).to_be_visible()  # it stays open
    expect(note.locator("summary")).to_be_focused()
    others.last.scroll_into_view_if_needed()
    expect(others.last).to_be_in_viewport()
    assert page.evaluate("spoken") == names[1:]
    expect(note.get_by_role("alert")).to_have_text("")  # or it would be there twice
    expect_accessible(page)

    note.get_by_role("button", name="Dismiss").press("Enter")
    expect(note).to_be_hidden()
    assert page.evaluate("document.activeElement.closest('.gl-display, .gl-left') !== null")
    page.evaluate(warn, names)
    expect(note).to_be_hidden()
    page.evaluate(warn, [*names, "w21"])
    expect(newest).to_have_text("w21")
    expect(others).to_have_count(0)


def test_dismissing_a_note_with_the_keyboard_loses_no_focus(opened, server):
    towers = opened(server.address)
    towers.page.evaluate(
        """() => {
          const { send } = WebSocket.prototype;
          let asked = 0;
          WebSocket.prototype.send = function (data) {
            send.call(this, typeof data === "string" ? data.replace('"more"', () => `"nothing${(asked += 1)}"`) : data);
          };
        }"""
    )
    dismiss = towers.page.locator(".gl-corner .gl-note:visible > button")
    for count in (1, 2):
        towers.button("More models").click()
        expect(dismiss).to_have_count(count)
    dismiss.first.focus()
    towers.press("Enter")
    expect(dismiss).to_have_count(1)
    expect(dismiss).to_be_focused()
    towers.press("Enter")
    expect(dismiss).to_have_count(0)
    expect(towers.button("More models")).to_be_focused()

    towers.button("More models").click()
    expect(dismiss).to_have_count(1)
    dismiss.focus()
    towers.page.evaluate(
        "[...document.querySelectorAll('button')].find(each => each.innerText === 'More models').remove()"
    )
    towers.press("Enter")
    expect(dismiss).to_have_count(0)
    assert towers.page.evaluate("document.activeElement.matches('button:enabled')")


def test_more_models_can_be_asked_for_again_after_a_request_that_failed(towers):
    towers.page.evaluate(
        """() => {
          const { send } = WebSocket.prototype;
          WebSocket.prototype.send = function (data) {
            WebSocket.prototype.send = send;
            send.call(this, data.replace('"more"', '"nothing"'));
          };
        }"""
    )
    more = towers.button("More models")
    count = towers.cells.count()
    more.click()
    expect(towers.page.get_by_text("nothing")).to_be_visible()
    more.click()
    expect(towers.cells).not_to_have_count(count)
