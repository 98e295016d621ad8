"""Stretching: which rows keep their size, and that a stretched surface follows the map everywhere."""

import numpy as np
import pytest

from grammarlab.synthesis.mesh.surface import Surface
from grammarlab.synthesis.units import Knots, Stretch, row_knots


@pytest.mark.parametrize("old", range(1, 8))
@pytest.mark.parametrize("new", range(1, 8))
def test_the_lowest_rows_and_the_highest_one_keep_their_size(old: int, new: int) -> None:
    sizes = np.array([4.0, *[3.0] * 5, 2.0])
    lines = [np.concatenate([[0.0], np.cumsum([*sizes[: number - 1], sizes[-1]])]) for number in (old, new)]
    knots = row_knots(*lines)
    assert (np.diff(knots.old) > 0.0).all()
    assert (np.diff(knots.new) > 0.0).all()
    assert (knots.old[[0, -1]] == lines[0][[0, -1]]).all()
    assert (knots.new[[0, -1]] == lines[1][[0, -1]]).all()
    same = np.isclose(np.diff(knots.old), np.diff(knots.new))
    assert same.sum() >= min(old, new, 4) - 1
    if min(old, new) >= 4:
        assert same[[0, 1, -1]].all()


def test_a_slanted_edge_follows_the_map_between_its_ends() -> None:
    points = np.array([[0.0, 0.0, 0.0], [10.0, 10.0, 0.0], [0.0, 10.0, 0.0]])
    triangle = Surface(points, np.array([[0, 1, 2]]), np.zeros(1, dtype=np.int64))
    same = Knots(np.array([0.0, 10.0]), np.array([0.0, 10.0]))
    stretch = Stretch((same, Knots(np.array([0.0, 4.0, 10.0]), np.array([0.0, 4.0, 22.0])), same))
    moved = stretch.moved(triangle)
    a, b, c = moved.points[moved.triangles].swapaxes(0, 1)
    # Below 4 m nothing changes; above it, heights are three times as large.
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0 == pytest.approx(8.0 + 3.0 * 42.0)
    assert stretch.along(1, np.array([-1.0, 2.0, 7.0, 11.0])).tolist() == [-1.0, 2.0, 13.0, 23.0]
