"""Nearly equal coordinates of sides become equal; nothing else changes."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.facade.reading.assembling import snap
from grammarlab.facade.tree import Facade
from tests.facade.strategies import trees
from tests.facade.tilings import corners, tiling

FRAME = np.array([[0.0, 0.0], [10.0, 8.0]])
COORDINATES = st.floats(0.0, 1.0)


@st.composite
def boxes(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Boxes within the frame, some of them almost flat."""
    some = draw(st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES, COORDINATES), max_size=30))
    table = np.array(some).reshape(-1, 4)
    low = np.minimum(table[:, :2], table[:, 2:]) * FRAME[1] * 0.99
    return low, np.minimum(low + np.maximum(np.abs(table[:, 2:] - table[:, :2]), 1e-3) * 0.5, FRAME[1])


@given(boxes(), st.floats(0.0, 0.5))
def test_sides_move_within_the_tolerance_and_no_box_is_lost_or_turned(some, tolerance):
    low, high = some
    snapped = snap(low, high, FRAME, tolerance)
    assert (snapped.low < snapped.high).all()
    for axis in (0, 1):
        lines = snapped.lines[axis]
        assert (np.diff(lines) > 0).all()
        assert (lines[0], lines[-1]) == (0.0, FRAME[1, axis])
        moves = [lines[snapped.low[:, axis]] - low[:, axis], lines[snapped.high[:, axis]] - high[:, axis]]
        assert np.abs(moves).max(initial=0.0) <= min(tolerance, snapped.moved) + 1e-12


@given(trees())
def test_a_tiling_stays_as_it_is_to_the_last_bit(facade: Facade) -> None:
    table, _ = tiling(facade)
    low, high = corners(table)
    frame = np.stack([low.min(axis=0), high.max(axis=0)])
    snapped = snap(low, high, frame, 0.0)
    assert snapped.moved == 0.0
    for axis in (0, 1):
        assert np.array_equal(snapped.lines[axis][snapped.low[:, axis]], low[:, axis])
        assert np.array_equal(snapped.lines[axis][snapped.high[:, axis]], high[:, axis])


def test_windows_that_are_nearly_in_line_come_to_stand_in_line():
    left = np.array([1.0, 1.02, 0.99, 4.0])
    low = np.column_stack([left, [1.0, 3.0, 5.0, 1.01]])
    snapped = snap(low, low + 1.5, FRAME, 0.05)
    assert snapped.low[:, 0].tolist() == [1, 1, 1, 3]
    assert snapped.low[[0, 3], 1].tolist() == [1, 1]
    assert snapped.lines[0][1] == 1.0
    assert np.isclose(snapped.moved, 0.02)


def test_a_sill_thinner_than_the_tolerance_keeps_its_thickness():
    low, high = np.array([[1.0, 1.0], [1.0, 1.04]]), np.array([[2.0, 1.04], [2.0, 3.0]])
    snapped = snap(low, high, FRAME, 0.5)
    assert snapped.lines[1][snapped.high[0, 1]] - snapped.lines[1][snapped.low[0, 1]] == 1.04 - 1.0
    assert snapped.high[0, 1] == snapped.low[1, 1]


def test_many_evenly_spaced_sides_are_parted_in_the_middle():
    low = np.column_stack([np.linspace(0.0, 9.0, 3_000), np.zeros(3_000)])
    snapped = snap(low, low + 0.9, FRAME, 0.05)
    assert snapped.moved <= 0.05
