"""Fingers on the grids, and pinching on a touchpad."""

from __future__ import annotations

import math

import pytest
from playwright.sync_api import expect

from tests.cases import some, takes_turns


class Hand:
    """Fingers on a touch screen."""

    def __init__(self, page):
        self._client = page.context.new_cdp_session(page)

    def put(self, *points):
        self._send("touchStart", points)

    def move(self, *paths, steps=10):
        """Each finger from one point to another."""
        for step in range(1, steps + 1):
            part = step / steps
            self._send("touchMove", [[a + part * (b - a) for a, b in zip(*path, strict=True)] for path in paths])

    def lift(self, *left):
        """All fingers but those left."""
        self._send("touchEnd", left)

    def _send(self, kind, points):
        fingers = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
        self._client.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})


@pytest.fixture
def touched(opened, server):
    """The page on a touch screen."""
    page = opened(server.address, has_touch=True)
    page.forget()
    return page


def middle(locator):
    box = locator.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def pinch(page, x, y, before, after, steps=10):
    """Two fingers around a point, some pixels apart."""
    hand = Hand(page.page)
    a, b = (x - before / 2, y), (x + before / 2, y)
    hand.put(a)
    hand.put(a, b)
    hand.move((a, (x - after / 2, y)), (b, (x + after / 2, y)), steps=steps)
    hand.lift()


@pytest.mark.parametrize("steps", some([2, 15, 40]))
def test_two_fingers_zoom_what_is_between_them(touched, steps):
    tile = touched.cell(5)
    before = tile.bounding_box()
    x, y = middle(tile)
    pinch(touched, x, y, 100, 250, steps)
    after = tile.bounding_box()
    assert after["width"] / before["width"] == pytest.approx(2.5, rel=0.03)
    assert middle(tile) == pytest.approx((x, y), abs=6)
    touched.expect_chosen([])
    pinch(touched, x, y, 250, 100, steps)
    assert tile.bounding_box()["width"] == pytest.approx(before["width"], rel=0.05)
    assert touched.page.evaluate("visualViewport.scale") == 1


@pytest.fixture
def zoomed(touched):
    """The models are larger than their room; a tile that lies in its middle."""
    for _ in range(4):
        touched.button("Zoom in").click()
    x, y = middle(touched.page.locator(".gl-stage"))
    centres = [middle(touched.cell(position)) for position in range(touched.cells.count())]
    return touched.cell(min(range(len(centres)), key=lambda position: math.dist(centres[position], (x, y))))


def test_fingers_that_wander_together_while_they_pinch_take_the_models_along(touched, zoomed):
    x, y = middle(zoomed)
    before = zoomed.bounding_box()
    hand = Hand(touched.page)
    hand.put((x - 50, y), (x + 50, y))
    hand.move(((x - 50, y), (x - 100, y - 60)), ((x + 50, y), (x + 60, y - 60)))
    hand.lift()
    assert zoomed.bounding_box()["width"] / before["width"] == pytest.approx(1.6, rel=0.03)
    assert middle(zoomed) == pytest.approx((x - 20, y - 60), abs=8)


@takes_turns
def test_a_finger_scrolls_and_a_second_one_then_zooms(touched, zoomed):
    x, y = middle(zoomed)
    hand = Hand(touched.page)
    hand.put((x, y))
    hand.move(((x, y), (x, y - 80)), steps=8)
    # A finger that rests before it is lifted does not throw what it moved.
    expect_still(zoomed)
    hand.lift()
    expect_still(zoomed)
    assert -82 < middle(zoomed)[1] - y < -50
    touched.expect_chosen([])
    before = zoomed.bounding_box()
    x, y = middle(zoomed)
    hand.put((x, y))
    hand.move(((x, y), (x, y + 40)), steps=8)
    hand.put((x, y + 40), (x + 100, y + 40))
    hand.move(((x, y + 40), (x - 100, y + 40)), ((x + 100, y + 40), (x + 100, y + 40)))
    hand.lift()
    assert zoomed.bounding_box()["width"] / before["width"] == pytest.approx(2, rel=0.05)


def expect_still(locator):
    """Waits until it moves no more."""
    before = None
    while (now := locator.bounding_box()) != before:
        before = now
        locator.page.wait_for_timeout(100)


def test_taps_select_one_after_the_other_also_after_a_pinch(touched):
    pinch(touched, *middle(touched.cell(5)), 100, 130)
    for position in (5, 4):
        touched.page.touchscreen.tap(*middle(touched.cell(position)))
    touched.expect_chosen([4, 5])
    touched.page.touchscreen.tap(*middle(touched.cell(5)))
    touched.expect_chosen([4])


def test_after_a_score_a_finger_chooses_the_next_model_alone(touched):
    for position, score in ((0, "90"), (1, "0"), (2, "50")):
        touched.page.touchscreen.tap(*middle(touched.cell(position)))
        touched.expect_chosen([position])
        touched.button(score).tap()
        touched.expect_saved()
    assert touched.scores()[:3] == ["90", "0", "50"]
    for position in (0, 2):
        touched.page.touchscreen.tap(*middle(touched.cell(position)))
    touched.expect_chosen([0, 2])


def test_a_score_that_is_taken_back_ends_no_choice_of_fingers(touched):
    touched.page.touchscreen.tap(*middle(touched.cell(0)))
    touched.button("90").tap()
    touched.expect_saved()
    for position in (1, 2):
        touched.page.touchscreen.tap(*middle(touched.cell(position)))
    touched.page.locator(".gl-recent li .gl-quiet").first.tap()
    touched.expect_saved()
    assert touched.scores()[0] == ""
    touched.page.touchscreen.tap(*middle(touched.cell(3)))
    touched.expect_chosen([1, 2, 3])


def test_pinching_on_a_touchpad_zooms_as_far_as_the_fingers_go(towers):
    tile = towers.cell(5)
    x, y = middle(tile)
    before = tile.bounding_box()
    client = towers.page.context.new_cdp_session(towers.page)
    gesture = {"x": x, "y": y, "scaleFactor": 2, "relativeSpeed": 400, "gestureSourceType": "mouse"}
    client.send("Input.synthesizePinchGesture", gesture)
    expect_still(tile)
    expect(tile).to_be_in_viewport()
    assert tile.bounding_box()["width"] / before["width"] == pytest.approx(2, rel=0.1)
    assert towers.page.evaluate("visualViewport.scale") == 1


def test_a_swipe_beside_the_large_picture_shows_the_next_model_and_one_on_it_turns_the_model(touched):
    touched.page.touchscreen.tap(*middle(touched.cell(1)))
    touched.button("3D view").tap()
    large = touched.page.get_by_role("dialog", name="Model in 3D")
    title, canvas = large.get_by_role("heading"), large.locator("canvas")
    names = [label.split(",")[0] for label in touched.labels()]
    expect(title).to_contain_text(names[1])
    hand = Hand(touched.page)
    for where, by, shown in ((title, (-60, 5), 2), (title, (60, 5), 1), (title, (-40, 0), 1), (canvas, (-120, 0), 1)):
        x, y = middle(where)
        hand.put((x, y))
        hand.move(((x, y), (x + by[0], y + by[1])))
        hand.lift()
        expect(title).to_contain_text(names[shown])
    x, y = middle(large.get_by_text("Click a part of the model"))
    hand.put((x, y))
    hand.move(((x, y), (x - 80, y)))
    hand.lift()
    expect(title).to_contain_text(names[2])
    large.get_by_role("button", name="Close").tap()
    touched.expect_chosen([2])
