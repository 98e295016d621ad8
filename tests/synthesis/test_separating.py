"""Solids of cubes that touch in edges: trimesh, which joins equal points, finds them closed once they are apart."""

import numpy as np
import pytest
import trimesh

from grammarlab.synthesis.mesh.surface import Surface, edge_numbers, welded
from grammarlab.synthesis.separating import separated
from tests.cases import some


def cubes(cells: np.ndarray) -> Surface:
    """The faces between full and empty cells."""
    points, triangles = [], []
    full = np.pad(cells, 1)
    for axis in range(3):
        other = [(axis + 1) % 3, (axis + 2) % 3]
        for place in np.argwhere(full != np.roll(full, -1, axis)):
            corner = np.repeat(place[None].astype(float), 4, axis=0)
            corner[:, axis] += 1.0
            corner[[1, 2], other[0]] += 1.0
            corner[[2, 3], other[1]] += 1.0
            first = len(points)
            points += list(corner if full[tuple(place)] else corner[::-1])
            triangles += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return welded(Surface(np.array(points), np.array(triangles), np.zeros(len(triangles), dtype=np.int64)), 1e-6)


def read(surface: Surface) -> trimesh.Trimesh:
    """The mesh as a reader of files has it: points of equal coordinates are one."""
    return trimesh.Trimesh(surface.points, surface.triangles, process=True)


@pytest.mark.parametrize("seed", some(range(12)))
def test_readers_find_two_triangles_at_every_edge(seed: int) -> None:
    cells = np.random.default_rng(seed).random((4, 4, 4)) < 0.5
    surface = cubes(cells)
    assert not read(surface).is_watertight
    found = separated(surface)
    mesh = read(found)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert edge_numbers(found).watertight
    assert mesh.volume == pytest.approx(cells.sum(), abs=0.01)
    assert (found.points == found.points.astype(np.float32)).all()
    # Only points in the middle of edges are new, and none is further from it than a tenth of a millimetre.
    new = found.points[len(surface.points) :]
    assert np.abs(2.0 * new - np.rint(2.0 * new)).max() <= 2e-4


def test_what_is_watertight_stays_as_it_is() -> None:
    surface = cubes(np.ones((2, 1, 1), dtype=bool))
    assert separated(surface) is surface


def test_faces_that_are_there_twice_come_apart() -> None:
    surface = cubes(np.ones((1, 1, 1), dtype=bool))
    twice = Surface(surface.points, np.tile(surface.triangles, (2, 1)), np.tile(surface.material, 2))
    found = separated(twice)
    assert read(found).is_watertight
    assert read(found).volume == pytest.approx(2.0, abs=1e-3)
