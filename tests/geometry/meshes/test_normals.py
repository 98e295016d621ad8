"""Corner normals of boxes, cylinders and spheres, which can be worked out, and faces turned back after a shuffle."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.geometry.meshes.edges import joined
from grammarlab.geometry.meshes.measure import face_normals
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.normals import corner_normals, turned_faces
from grammarlab.geometry.meshes.primitives import box, builtin_asset

SHEET = Meshes.single(
    np.array([[x, 0.1 * x * x, z] for x in (0.0, 1.0, 2.0) for z in (0.0, 1.0)]), [[0, 1, 3, 2], [2, 3, 5, 4]]
)


def test_soft_normals_of_a_cube_point_out_of_its_corners():
    cube = box()
    middle = cube.points[cube.corner_points()] - 0.5
    assert corner_normals(cube, 180.0) == pytest.approx(middle / np.sqrt(0.75))
    for angle in (0.0, 89.0, 90.0):
        assert corner_normals(cube, angle) == pytest.approx(face_normals(cube)[cube.face_of_corner()])
    assert corner_normals(cube, 91.0) == pytest.approx(middle / np.sqrt(0.75))


@pytest.mark.parametrize("name", ["builtin:cylinder", "builtin:sphere", "builtin:cone"])
def test_normals_of_round_solids_follow_their_shape_and_hard_ones_their_faces(name):
    mesh = builtin_asset(name)
    flat = face_normals(mesh)[mesh.face_of_corner()]
    assert corner_normals(mesh, 0.0) == pytest.approx(flat)
    for angle in (30.0, 60.0, 180.0):
        normals = corner_normals(mesh, angle)
        assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
        turn = np.einsum("ij,ij->i", normals, flat)
        assert turn.min() > 0.0
    if name == "builtin:cylinder":
        lateral = np.abs(flat[:, 1]) < 0.5
        across = mesh.points[mesh.corner_points()] - 0.5
        across[:, 1] = 0.0
        expected = across / np.linalg.norm(across, axis=1, keepdims=True)
        assert corner_normals(mesh, 30.0)[lateral] == pytest.approx(expected[lateral])
        assert corner_normals(mesh, 30.0)[~lateral] == pytest.approx(flat[~lateral])


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("mesh", [box(), SHEET, builtin_asset("builtin:cone"), Meshes.united([box(), SHEET, box()])])
def test_faces_that_were_turned_over_are_turned_back(mesh, seed):
    flags = np.random.default_rng(seed).random(mesh.num_faces) < 0.5
    assert (turned_faces(mesh.reversed(flags)) == flags).all()
    assert (turned_faces(mesh.reversed()) == True).all()  # noqa: E712  # the array, not one value


def test_points_that_are_not_shared_have_hard_edges():
    apart = Meshes.from_polygons(box().points[box().corner_points()], np.full(6, 4), np.array([6]))
    flat = face_normals(apart)[apart.face_of_corner()]
    assert corner_normals(apart, 180.0) == pytest.approx(flat)
    assert np.abs(corner_normals(joined(apart), 180.0)) == pytest.approx(np.full((24, 3), np.sqrt(1 / 3)))
