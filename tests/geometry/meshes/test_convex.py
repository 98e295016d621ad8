"""Divided faces are convex, have the surface of the mesh, and are those that the runtime of CityEngine makes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.geometry.meshes.convex import MOST_CORNERS, convexified
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.edges import is_closed_surface
from grammarlab.geometry.meshes.measure import areas, face_areas, has_concave_face, volumes
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.language.grammar import Grammar
from tests.derivation.operations.leaves import L_SHAPE, sampled, world_meshes

U_SHAPE = [(0, 0), (0, 25), (8, 25), (8, 10), (20, 10), (20, 25), (30, 25), (30, 0)]
T_SHAPE = [(0, 10), (0, 14), (20, 14), (20, 10), (12, 10), (12, 0), (7, 0), (7, 10)]
CHEVRON = [(0, 0), (4, 6), (0, 12), (10, 6)]


def face_of(outline: Sequence[tuple[float, float]]) -> Meshes:
    points = np.array([(x, 0.0, z) for x, z in outline])
    return Meshes.from_polygons(points, np.array([len(points)]))


def spiky(corners: int, seed: int) -> Meshes:
    """A star-shaped outline with random radii, counter-clockwise seen from above."""
    radius = np.random.default_rng(seed).uniform(2.0, 10.0, corners)
    angle = -2.0 * np.pi * np.arange(corners) / corners
    return face_of(list(zip((radius * np.cos(angle)).tolist(), (radius * np.sin(angle)).tolist(), strict=True)))


@pytest.mark.parametrize(
    ("outline", "longest", "sizes"),
    [  # from the runtime
        (U_SHAPE, np.inf, [4, 4, 6]),
        (U_SHAPE, 9.0, [4, 7]),
        (U_SHAPE, 7.0, [8]),
        (T_SHAPE, np.inf, [4, 4, 6]),
        (CHEVRON, np.inf, [3, 4]),
        (CHEVRON, 3.0, [4]),
    ],
)
def test_faces_are_those_of_the_runtime(outline: list[tuple[float, float]], longest: float, sizes: list[int]) -> None:
    assert sorted(np.diff(convexified(face_of(outline), longest).face_offsets).tolist()) == sizes


@pytest.mark.parametrize("seed", range(6))
def test_parts_of_any_outline_are_convex_and_fill_it(seed: int) -> None:
    face = spiky(7 + 4 * seed, seed)
    parts = convexified(face)
    assert not has_concave_face(parts)[0]
    assert face_areas(parts).min() > 0.0
    assert areas(parts) == pytest.approx(areas(face))


def test_shorter_cuts_are_all_that_a_limit_leaves() -> None:
    face = spiky(24, 3)
    counts = [convexified(face, limit).num_faces for limit in (0.0, 1.0, 3.0, 9.0, np.inf)]
    assert counts == sorted(counts)
    assert counts[0] == 1


def test_a_solid_stays_closed_and_its_walls_get_the_ends_of_cuts() -> None:
    mesh = world_meshes(sampled("Lot --> extrude(3) convexify(13) A.", L_SHAPE))
    assert sorted(np.diff(mesh.face_offsets).tolist()) == [4] * 7 + [5] * 2 + [6]
    assert is_closed_surface(mesh)[0]
    assert volumes(mesh) == pytest.approx([3.0 * 492.0])


def test_texture_coordinates_continue_across_cuts() -> None:
    face = face_of(U_SHAPE)
    parts = convexified(face.with_data(CornerData.of_sets([face.points[:, [0, 2]] * 2.0 + 1.0], 1)))
    assert parts.data is not None
    assert np.allclose(parts.data.coordinates(0), parts.points[parts.corners][:, [0, 2]] * 2.0 + 1.0)


def test_a_face_with_a_hole_is_divided_too() -> None:
    mesh = world_meshes(sampled("Lot --> shapeO(3, 3, 3, 3) { shape : convexify() A. }"))
    assert mesh.num_faces > 2
    assert not has_concave_face(mesh)[0]
    assert areas(mesh) == pytest.approx([600.0 - 24.0 * 14.0])


def test_a_face_of_too_many_corners_stays_with_a_warning() -> None:
    outline = spiky(MOST_CORNERS + 1, 2)
    assert convexified(outline).num_faces == 1
    forest = derive(Grammar.parse("Lot --> convexify() A."), 1, 1, footprint=outline.points)
    assert len(forest.leaves) == 1
    assert "at most 500 corners" in forest.warnings[0].message
