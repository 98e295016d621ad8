"""Points on surfaces, against what is obvious and against trimesh."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import sphere
from grammarlab.geometry.meshes.surface_points import nearest_on, points_on
from grammarlab.geometry.meshes.triangulate import triangulate

DRAWS = np.random.default_rng(1).random((400, 3))


def as_trimesh(meshes: Meshes) -> trimesh.Trimesh:
    return trimesh.Trimesh(meshes.points, triangulate(meshes)[0], process=False)


@pytest.fixture
def ball() -> Meshes:
    return sphere(12, 8)


def test_points_lie_on_the_faces_that_are_named(ball):
    points, face = points_on(ball, np.zeros(400, np.int64), DRAWS)
    _, distance, _ = trimesh.proximity.closest_point_naive(as_trimesh(ball), points)
    assert np.abs(distance).max() < 1e-9
    corners = [ball.points[ball.corners[ball.face_offsets[f] : ball.face_offsets[f + 1]]] for f in face]
    for point, polygon in zip(points, corners, strict=True):
        assert (point >= polygon.min(axis=0) - 1e-9).all()
        assert (point <= polygon.max(axis=0) + 1e-9).all()


def test_closest_points_are_those_of_trimesh(ball):
    there = 3.0 * DRAWS - 1.0
    found, _ = nearest_on(ball, np.zeros(400, np.int64), there)
    _, distance, _ = trimesh.proximity.closest_point_naive(as_trimesh(ball), there)
    assert np.allclose(np.linalg.norm(found - there, axis=1), distance)


def test_points_do_not_depend_on_the_other_meshes(ball):
    square = Meshes.from_polygons(np.array([[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0.0]]), np.array([4]))
    both = Meshes.concatenate([square, ball, square])
    mesh = np.repeat([0, 1, 2], [100, 200, 100])
    for _, face in (points_on(both, mesh, DRAWS), nearest_on(both, mesh, DRAWS)):
        assert set(face[:100].tolist()) == {0}
        assert set(face[300:].tolist()) == {both.num_faces - 1}
    alone, _ = points_on(ball, np.zeros(200, np.int64), DRAWS[100:300])
    assert np.array_equal(points_on(both, mesh, DRAWS)[0][100:300], alone)
    closest, _ = nearest_on(ball, np.zeros(200, np.int64), DRAWS[100:300])
    assert np.array_equal(nearest_on(both, mesh, DRAWS)[0][100:300], closest)


def test_no_points_are_no_trouble(ball):
    points, face = points_on(ball, np.zeros(0, np.int64), np.zeros((0, 3)))
    assert (points.shape, face.shape) == ((0, 3), (0,))
