"""Boxes with gaps become tilings that straight cuts divide, and wall never prevents a cut."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.reading.cutting import MOST_LEVELS
from grammarlab.facade.reading.filling import WALL, PinwheelError, fill
from grammarlab.facade.reading.overlaps import VisiblePieces
from tests.facade.tilings import Box, guillotine

SIDE = 6
FRAME = (0, 0, SIDE, SIDE)
WINDMILL = [(0, 0, 4, 1), (5, 0, 6, 4), (2, 5, 6, 6), (0, 2, 1, 6)]


def pieces_of(boxes: list[Box], whole: list[bool] | None = None) -> VisiblePieces:
    table = np.array(boxes, dtype=np.int64).reshape(-1, 4)
    return VisiblePieces(
        table, np.arange(len(table)), np.array([True] * len(table) if whole is None else whole, dtype=bool)
    )


@st.composite
def apart(draw: st.DrawFn) -> list[Box]:
    """Boxes that do not overlap."""
    boxes: list[Box] = []
    place = st.integers(0, SIDE - 1)
    for a, b, c, d in draw(st.lists(st.tuples(place, place, place, place), max_size=12)):
        box = min(a, c), min(b, d), max(a, c) + 1, max(b, d) + 1
        if all(box[2] <= o[0] or o[2] <= box[0] or box[3] <= o[1] or o[3] <= box[1] for o in boxes):
            boxes.append(box)
    return boxes


def check_tiles(tiles: np.ndarray, source: np.ndarray, boxes: list[Box]) -> None:
    """Each cell is covered once, and has the box at its place as its source."""
    shown = np.full((SIDE, SIDE), -2)
    for (left, bottom, right, top), each in zip(tiles.tolist(), source.tolist(), strict=True):
        assert (shown[left:right, bottom:top] == -2).all()
        shown[left:right, bottom:top] = each
    expected = np.full((SIDE, SIDE), WALL)
    for place, (left, bottom, right, top) in enumerate(boxes):
        expected[left:right, bottom:top] = place
    assert np.array_equal(shown, expected)
    assert guillotine([tuple(tile) for tile in tiles.tolist()])


@given(apart())
def test_whole_boxes_are_kept_or_refused_as_by_brute_force(boxes):
    if guillotine(boxes):
        tiles, source = fill(pieces_of(boxes), FRAME)
        check_tiles(tiles, source, boxes)
        assert np.bincount(source[source != WALL], minlength=len(boxes)).tolist() == [1] * len(boxes)
    else:
        with pytest.raises(PinwheelError) as told:
            fill(pieces_of(boxes), FRAME)
        named = [boxes[each] for each in told.value.sources]
        assert not guillotine(named)


@given(apart(), st.data())
def test_what_may_be_cut_never_stands_in_the_way(boxes, data):
    whole = data.draw(st.lists(st.booleans(), min_size=len(boxes), max_size=len(boxes)))
    assume(guillotine([box for box, one in zip(boxes, whole, strict=True) if one]))
    check_tiles(*fill(pieces_of(boxes, whole), FRAME), boxes)


@given(apart())
def test_where_boxes_may_be_split_everything_is_tiled(boxes):
    check_tiles(*fill(pieces_of(boxes), FRAME, split=True), boxes)


def test_a_windmill_is_named_and_one_of_its_boxes_split_when_asked():
    with pytest.raises(PinwheelError) as told:
        fill(pieces_of([*WINDMILL]), FRAME)
    assert told.value.sources.tolist() == [0, 1, 2, 3]
    tiles, source = fill(pieces_of(WINDMILL), FRAME, split=True)
    check_tiles(tiles, source, WINDMILL)
    assert sorted(np.bincount(source[source != WALL]).tolist()) == [1, 1, 1, 2]


def test_a_wall_without_boxes_is_one_rectangle():
    tiles, source = fill(pieces_of([]), FRAME)
    assert (tiles.tolist(), source.tolist()) == ([list(FRAME)], [WALL])


def test_cuts_within_cuts_end():
    count = MOST_LEVELS + 4
    boxes = [(k, k, k + 1, count) if k % 2 else (k, k, count, k + 1) for k in range(count)]
    with pytest.raises(FacadeError, match="levels of cuts"):
        fill(pieces_of(boxes), (0, 0, count, count))
