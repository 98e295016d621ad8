"""Tilings become trees, and only those that straight cuts divide."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.reading.cutting import MOST_LEVELS, cut, pinwheel
from grammarlab.facade.tree import LEAF, Facade, Y
from tests.facade.strategies import trees
from tests.facade.tilings import corners, divides, grid_tilings, guillotine, tiling

REFINED = [(0, 0, 1, 1), (1, 0, 2, 1), (2, 0, 3, 2), (1, 2, 3, 3), (0, 1, 1, 3), (1, 1, 2, 2)]
PINWHEEL = [(0, 0, 2, 1), (2, 0, 3, 2), (1, 2, 3, 3), (0, 1, 1, 3), (1, 1, 2, 2)]


@given(trees(), st.randoms(use_true_random=False))
def test_the_leaves_of_a_tree_give_back_the_tree(facade: Facade, randomness) -> None:
    boxes, names = tiling(facade)
    order = list(range(len(boxes)))
    randomness.shuffle(order)
    again, box = cut(*corners(boxes[order]), [names[each] for each in order])
    assert again.parent.tolist() == facade.parent.tolist()
    assert again.axis.tolist() == facade.axis.tolist()
    assert [again.name_of(node) for node in again.leaves] == names
    assert [order[each] for each in box[again.leaves]] == list(range(len(boxes)))
    np.testing.assert_allclose(again.position, facade.position, atol=1e-5)


@pytest.mark.parametrize("side", [3, 4])
def test_what_is_cut_and_what_is_not_is_as_by_brute_force(side):
    refused = 0
    for boxes in grid_tilings(side, most=6):
        table = np.array(boxes, dtype=np.float64)
        if guillotine(boxes):
            facade, box = cut(*corners(table), [str(each) for each in range(len(boxes))])
            assert np.array_equal(facade.position[box >= 0], table[box[box >= 0], :2])
            assert np.array_equal(facade.size[box >= 0], table[box[box >= 0], 2:] - table[box[box >= 0], :2])
            continue
        refused += 1
        with pytest.raises(FacadeError, match="form a pinwheel"):
            cut(*corners(table), [""] * len(boxes))
        found = [boxes[each] for each in pinwheel(np.array(boxes))]
        assert 5 <= len(found) <= len(boxes)
        assert not any(divides(found, axis, line) for axis in (0, 1) for line in range(side))
    assert refused >= 2


def test_the_refined_pinwheel_is_cut_and_the_pinwheel_is_named():
    facade, _ = cut(*corners(np.array(REFINED, dtype=np.float64)), list("abcdef"))
    assert len(facade.leaves) == 6
    around = [*PINWHEEL, (3, 0, 5, 3), (0, 3, 5, 4)]
    with pytest.raises(FacadeError) as told:
        cut(*corners(np.array(around, dtype=np.float64)), list("abcdefg"))
    assert "these 5 rectangles" in str(told.value)
    assert "a 0 at (0, 0) to (2, 1)" in str(told.value)
    assert "f 5" not in str(told.value)


def test_floors_come_before_columns_where_both_are_possible():
    boxes = np.array([(x, y, x + 1, y + 1) for x in range(2) for y in range(2)], dtype=np.float64)
    facade, _ = cut(*corners(boxes), ["00", "01", "10", "11"])
    assert facade.axis[0] == Y
    assert [facade.name_of(node) for node in facade.leaves] == ["00", "10", "01", "11"]


def test_one_rectangle_is_a_leaf_wherever_it_lies():
    facade, box = cut(np.array([[5e6, 4e5]]), np.array([[5e6 + 1, 4e5 + 2]]), ["wall"])
    assert facade.axis.tolist() == [LEAF]
    assert (facade.position.tolist(), facade.size.tolist(), box.tolist()) == ([[0, 0]], [[1, 2]], [0])


@pytest.mark.parametrize(
    ("boxes", "says"),
    [
        ([], "found none"),
        ([(0, 0, 1, 1), (2, 0, 3, 1)], "leave gaps: they cover 2 of 3"),
        ([(0, 0, 2, 1), (1, 0, 3, 1)], "overlap: they cover 4 of 3"),
    ],
)
def test_what_is_no_tiling_is_refused(boxes, says):
    table = np.array(boxes, dtype=np.float64).reshape(-1, 4)
    with pytest.raises(FacadeError, match=says):
        cut(*corners(table), [""] * len(boxes))


def test_ten_thousand_rectangles_are_cut_and_a_bottomless_tree_is_not():
    lines = np.cumsum(np.random.default_rng(0).uniform(0.1, 1.0, 101))
    boxes = np.array([(lines[i], lines[j], lines[i + 1], lines[j + 1]) for i in range(100) for j in range(100)])
    facade, _ = cut(*corners(boxes), ["window"] * len(boxes))
    assert len(facade) == 10_101
    with pytest.raises(FacadeError, match="levels of cuts"):
        cut(*corners(np.array(_peeled(MOST_LEVELS + 2), dtype=np.float64)), [""] * (MOST_LEVELS + 3))


def _peeled(count: int) -> list[tuple[int, int, int, int]]:
    """A strip at the left, one at the bottom of the rest, and so on."""
    left = bottom = 0
    boxes = []
    for place in range(count):
        if place % 2:
            boxes.append((left, bottom, count, bottom + 1))
            bottom += 1
        else:
            boxes.append((left, bottom, left + 1, count))
            left += 1
    return [*boxes, (left, bottom, count, count)]
