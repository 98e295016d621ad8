"""Each cell of overlapping boxes shows the one in front."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.reading import overlaps
from grammarlab.facade.reading.overlaps import BANDS, FRONT, uncovered

SIDE = 8
LABELS = ("window", "balcony", "molding", "deco", "flag")


@st.composite
def labelled(draw: st.DrawFn) -> tuple[np.ndarray, list[str]]:
    place = st.integers(0, SIDE - 1)
    some = draw(st.lists(st.tuples(place, place, place, place, st.sampled_from(LABELS)), min_size=1, max_size=8))
    boxes = [(min(a, c), min(b, d), max(a, c) + 1, max(b, d) + 1) for a, b, c, d, _ in some]
    return np.array(boxes), [name for *_, name in some]


def in_front(first: int, second: int, boxes: np.ndarray, names: list[str]) -> bool:
    """Whether one of two boxes hides the other: an independent version for two."""

    def within(a: int, b: int) -> bool:
        return bool((boxes[a, :2] >= boxes[b, :2]).all() and (boxes[a, 2:] <= boxes[b, 2:]).all())

    def order(each: int) -> tuple[int, int, int]:
        rank = FRONT.index(names[each] if names[each] in FRONT else "window")
        return rank, int((boxes[each, 2:] - boxes[each, :2]).prod()), each

    if within(first, second) != within(second, first):
        return within(first, second)
    return order(first) < order(second)


@given(labelled())
def test_every_cell_shows_the_box_that_no_other_hides(some):
    boxes, names = some
    pieces = uncovered(boxes, names)
    shown = np.full((SIDE, SIDE), -1)
    for (left, bottom, right, top), source in zip(pieces.boxes.tolist(), pieces.source.tolist(), strict=True):
        assert (shown[left:right, bottom:top] == -1).all()
        shown[left:right, bottom:top] = source
    for x in range(SIDE):
        for y in range(SIDE):
            here = [k for k, (a, b, c, d) in enumerate(boxes.tolist()) if a <= x < c and b <= y < d]
            front = [k for k in here if all(in_front(k, other, boxes, names) for other in here if other != k)]
            assert shown[x, y] == (front[0] if front else -1)


@given(labelled())
def test_what_is_whole_is_all_of_a_box_that_is_no_band(some):
    boxes, names = some
    pieces = uncovered(boxes, names)
    for box, source, whole in zip(pieces.boxes, pieces.source.tolist(), pieces.whole.tolist(), strict=True):
        if whole:
            assert box.tolist() == boxes[source].tolist()
            assert names[source] not in BANDS


def test_a_window_in_a_molding_stays_whole_and_a_balcony_hides_the_foot_of_a_window():
    boxes = np.array([(0, 0, 9, 9), (3, 3, 6, 6), (2, 2, 7, 4)])
    pieces = uncovered(boxes, ["molding", "window", "balcony"])
    assert pieces.boxes[pieces.source == 2].tolist() == [[2, 2, 7, 4]]
    assert pieces.boxes[pieces.source == 1].tolist() == [[3, 4, 6, 6]]


def test_too_many_overlaps_are_refused_before_they_are_all_found(monkeypatch):
    monkeypatch.setattr(overlaps, "MOST_OVERLAPS", 1_000)
    boxes = np.array([(0, 0, k + 1, k + 1) for k in range(100)])
    with pytest.raises(FacadeError, match="More than"):
        uncovered(boxes, ["window"] * 100)
    monkeypatch.setattr(overlaps, "_MOST_CELLS", 50)
    with pytest.raises(FacadeError, match="too many visible pieces"):
        uncovered(boxes[:20], ["window"] * 20)


def test_no_boxes_show_nothing():
    assert len(uncovered(np.zeros((0, 4), dtype=np.int64), []).boxes) == 0
