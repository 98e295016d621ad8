import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes.measure import face_areas, face_normals
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.triangulate import triangulate
from tests.geometry.bodies import FRAME, rotations, solids, turned
from tests.geometry.polygons import convex, lots, moved, simple

QUICK = settings(max_examples=40, deadline=None)


def triangle_vectors(meshes):
    triangles, face = triangulate(meshes)
    a, b, c = (meshes.points[triangles[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a), face


@QUICK
@given(st.lists(st.one_of(simple, moved(simple)), min_size=1, max_size=4), rotations())
def test_triangles_cover_their_faces_once_and_look_the_same_way(rings, rotation):
    faces = turned(lots(rings), rotation)
    vectors, face = triangle_vectors(faces)
    sizes = np.linalg.norm(vectors, axis=1)
    assert np.bincount(face, sizes, faces.num_faces) == pytest.approx(face_areas(faces), rel=1e-6)
    agreement = np.einsum("tk,tk->t", vectors, face_normals(faces)[face])
    assert (agreement >= -1e-9 * face_areas(faces)[face]).all()


@QUICK
@given(convex(), rotations())
def test_convex_faces_become_fans(ring, rotation):
    triangles, face = triangulate(turned(lots([ring]), rotation))
    assert triangles.tolist() == [[0, k, k + 1] for k in range(1, len(ring) - 1)]
    assert face.tolist() == [0] * (len(ring) - 2)


@pytest.mark.parametrize("start", range(4))
def test_a_dart_is_split_at_its_reflex_corner(start):
    dart = np.roll(np.array([[0, 0, 0], [1, 0, 3], [2, 0, 0], [1, 0, 1.0]]), start, axis=0)
    vectors, _ = triangle_vectors(Meshes.from_polygons(dart, np.array([4])))
    assert (vectors[:, 1] > 0.5).all()


def test_a_face_with_a_hole_is_covered_without_the_hole():
    vectors, _ = triangle_vectors(FRAME)
    assert (vectors[:, 1] >= 0.0).all()
    assert vectors[:, 1].sum() == pytest.approx(72.0)


@QUICK
@given(st.lists(solids, min_size=1, max_size=4))
def test_triangles_come_face_by_face(batch):
    meshes = Meshes.concatenate(batch)
    triangles, face = triangulate(meshes)
    assert (np.diff(face) >= 0).all()
    assert np.array_equal(meshes.mesh_of_point()[triangles[:, 0]], meshes.mesh_of_face()[face])


def test_edges_and_points_have_no_triangles_and_faces_without_area_some():
    points = np.zeros((3 + 4, 3))
    points[3:, 0] = [0.0, 1.0, 3.0, 2.0]
    triangles, face = triangulate(Meshes.from_polygons(points, np.array([2, 1, 4])))
    assert face.tolist() == [2, 2]
    assert triangles.shape == (2, 3)
    assert triangulate(Meshes.single(np.zeros((0, 3)), []))[0].shape == (0, 3)
