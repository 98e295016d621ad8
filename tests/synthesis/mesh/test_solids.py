"""Solids that touch or overlap, beside boxes of whole numbers that are counted cell by cell."""

import numpy as np
import pytest
import trimesh

from grammarlab.synthesis.mesh.solids import united
from grammarlab.synthesis.mesh.surface import Surface, edge_numbers, joined, welded
from tests.cases import some

SIZE = 6


def box(low, high, material: int = 0) -> Surface:
    mesh = trimesh.creation.box(bounds=[low, high])
    faces = np.asarray(mesh.faces, dtype=np.int64)
    return Surface(np.asarray(mesh.vertices, dtype=np.float64), faces, np.full(len(faces), material))


def soup(*boxes: Surface) -> Surface:
    return welded(joined(boxes), 1e-6)


def volume(surface: Surface) -> float:
    return float(trimesh.Trimesh(surface.points, surface.triangles, process=False).volume)


@pytest.mark.parametrize("seed", some(range(20)))
def test_boxes_together_fill_the_cells_that_one_of_them_fills(seed: int) -> None:
    random = np.random.default_rng(seed)
    low = random.integers(0, SIZE - 1, (8, 3))
    high = low + 1 + random.integers(0, SIZE - low - 1, (8, 3))
    cells = np.zeros((SIZE, SIZE, SIZE), dtype=bool)
    for a, b in zip(low, high, strict=True):
        cells[a[0] : b[0], a[1] : b[1], a[2] : b[2]] = True
    found = united(soup(*(box(*each) for each in zip(low, high, strict=True))), 1e-6)
    assert volume(found) == pytest.approx(cells.sum())
    faces = sum(int(np.abs(np.diff(np.pad(cells, 1).astype(int), axis=axis)).sum()) for axis in range(3))
    area = trimesh.Trimesh(found.points, found.triangles, process=False).area
    assert area == pytest.approx(faces)
    assert edge_numbers(found).closed


def test_slabs_side_by_side_have_no_face_between_them() -> None:
    slabs = soup(box([0, 0, 0], [1, 3, 1]), box([1, 0, 0], [2, 2, 1], 1))
    assert not edge_numbers(slabs).watertight
    found = united(slabs, 1e-6)
    assert edge_numbers(found).watertight
    assert set(found.material.tolist()) == {0, 1}
    assert found.points[found.triangles[found.material == 1]][..., 0].min() == pytest.approx(1.0)


def test_inside_out_solids_stay_inside_out() -> None:
    slabs = soup(box([0, 0, 0], [1, 3, 1]), box([1, 0, 0], [2, 2, 1]))
    turned = Surface(slabs.points, slabs.triangles[:, ::-1], slabs.material)
    assert volume(united(turned, 1e-6)) == pytest.approx(-5.0)


def test_open_hollow_and_single_surfaces_stay_as_they_are() -> None:
    cube, room = box([0, 0, 0], [3, 3, 3]), box([1, 1, 1], [2, 2, 2])
    hollow = joined([cube, Surface(room.points, room.triangles[:, ::-1], room.material)])
    open_ = joined([cube, room]).part(np.arange(24) > 0)
    nothing = cube.part(np.zeros(12, dtype=bool))
    for surface in (cube, hollow, open_, nothing):
        assert united(surface, 1e-6) is surface


def test_faces_that_are_there_twice_are_there_once() -> None:
    found = united(soup(box([0, 0, 0], [1, 1, 1]), box([0, 0, 0], [1, 1, 1])), 1e-6)
    assert len(found) == 12


def test_sheets_with_two_sides_stay_beside_solids() -> None:
    points = np.array([[5.0, 0, 0], [6.0, 0, 0], [6.0, 1, 0], [5.0, 1, 0]])
    sheet = Surface(points, np.array([[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]]), np.full(4, 2))
    found = united(soup(box([0, 0, 0], [1, 3, 1]), box([1, 0, 0], [2, 2, 1], 1), sheet), 1e-6)
    assert volume(found) == pytest.approx(5.0)
    assert (found.material == 2).sum() == 4


@pytest.mark.parametrize(("number", "joins"), [(5, True), (200, False)])
def test_a_lattice_whose_union_would_be_huge_stays_as_it_is(number: int, joins: bool) -> None:
    bars = [box([0.1, i, 0.1], [number - 0.1, i + 0.5, 0.6]) for i in range(number)]
    bars += [box([i + 0.05, 0.1, 0], [i + 0.55, number - 0.1, 0.5]) for i in range(number)]
    lattice = soup(*bars)
    assert (united(lattice, 1e-6) is not lattice) == joins
