"""Stretching: which rows and elements keep their size, and that a stretched surface follows the map everywhere."""

import numpy as np
import pytest

from grammarlab.facade.lattice import Lattice
from grammarlab.synthesis.analysis.example import Region
from grammarlab.synthesis.label_grid import LabelGrid
from grammarlab.synthesis.mesh.surface import Surface
from grammarlab.synthesis.units import Knots, Stretch, cell_knots, row_knots


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


def region(boxes: list[tuple[float, float, float, float]], width: float, height: float) -> Region:
    """A wall of one cell with its lower left corner at (1, 2), metres."""
    lattices = [
        Lattice(np.array([start, start + size]), 0.0, False, np.zeros(len(boxes), dtype=np.int64))
        for start, size in ((1.0, width), (2.0, height))
    ]
    return Region(
        name="front",
        side=0,
        columns=lattices[0],
        rows=lattices[1],
        grid=LabelGrid.from_labels(np.zeros((1, 1), dtype=np.int64), ["window"]),
        plane=0.0,
        back=-1.0,
        front=1.0,
        elements=np.zeros((len(boxes), 4)),
        whole=np.array(boxes).reshape(-1, 4),
        wall=np.array([[1.0, 2.0], [1.0 + width, 2.0 + height]]),
        noise=0.0,
    )


@pytest.mark.parametrize("size", [(3.0, 3.0), (2.5, 3.0), (3.0, 2.6), (7.3, 4.1)])
def test_elements_keep_their_size_in_another_cell_and_walls_share_the_change(size: tuple[float, float]) -> None:
    unit = region([(1.3, 2.5, 2.3, 4.5), (2.6, 3.0, 3.4, 4.0)], 3.0, 3.0)
    low = np.array([10.0, 20.0])
    x, y = cell_knots(unit, 0, 0, low, low + size)
    assert x.new[[0, -1]].tolist() == [10.0, 10.0 + size[0]]
    assert y.new[[0, -1]].tolist() == [20.0, 20.0 + size[1]]
    lines = np.array([1.0, 1.3, 2.3, 2.6, 3.4, 4.0])
    sizes = np.diff(np.interp(lines, x.old, x.new))
    assert sizes[[1, 3]] == pytest.approx([1.0, 0.8])
    assert sizes[[0, 2, 4]] == pytest.approx(np.array([0.3, 0.3, 0.6]) * (size[0] - 1.8) / 1.2)
    assert np.diff(np.interp([2.5, 4.5], y.old, y.new)) == pytest.approx(2.0)


@pytest.mark.parametrize(("boxes", "width"), [([], 2.0), ([(1.3, 2.5, 3.7, 4.5)], 2.5), ([(0.9, 2.0, 4.1, 5.0)], 4.0)])
def test_a_cell_without_elements_or_without_room_is_scaled(
    boxes: list[tuple[float, float, float, float]], width: float
) -> None:
    x, _ = cell_knots(region(boxes, 3.0, 3.0), 0, 0, np.zeros(2), np.array([width, 3.0]))
    assert x.old.tolist() == [1.0, 4.0]
    assert x.new.tolist() == [0.0, width]
