"""Values at corners follow the surface: they are what the place says, after any cut, turn or division."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.geometry.components import face_sets, faces, joined, unaligned
from grammarlab.geometry.meshes.clip import slabs
from grammarlab.geometry.meshes.corner_data import CornerData, join_data
from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box, cylinder
from tests.cases import bulk

TO_UV = np.array([[2.0, -1.0], [0.5, 3.0], [-1.5, 0.25]])
STAR = Meshes.single(
    np.array([[0, 0, 0], [4, 0, 0], [4, 3, 0], [3, 3, 0], [3, 1, 0], [2, 1, 0], [2, 3, 0], [0, 3, 0.0]]),
    [list(range(8))],
)
"""A wall with a notch: cuts divide it."""


def dressed(meshes):
    """Meshes with normals that are the places of corners, coordinates that are linear there, and numbered faces."""
    places = meshes.points[meshes.corner_points()]
    data = CornerData.of_sets([places @ TO_UV, places[:, :2]], meshes.num_faces, places, np.arange(meshes.num_faces))
    return meshes.with_data(data)


def data_of(meshes):
    assert meshes.data is not None
    return meshes.data


def assert_fits(meshes, places=None):
    """The coordinates of all corners are those of their places."""
    places = meshes.points if places is None else places
    at_corners = places[meshes.corner_points()]
    np.testing.assert_allclose(data_of(meshes).coordinates(0), at_corners @ TO_UV, atol=1e-9)
    np.testing.assert_allclose(data_of(meshes).coordinates(1), at_corners[:, :2], atol=1e-9)
    return at_corners


@bulk(40)
@given(st.sampled_from([box(), cylinder(7), STAR]), st.integers(0, 2), st.floats(0.05, 0.95), st.floats(0.05, 0.95))
def test_cuts_interpolate_along_edges(mesh, axis, first, second):
    low, high = sorted((first, second))
    size = mesh.points.max(axis=0)[axis]
    cut = slabs(dressed(mesh), np.array([0, 0]), axis, np.array([low, 0.0]) * size, np.array([high, low]) * size)
    known = ~np.isnan(data_of(cut).coordinates(0)[:, 0])
    places = cut.points[cut.corner_points()][known]
    np.testing.assert_allclose(data_of(cut).coordinates(0)[known], places @ TO_UV, atol=1e-9)
    np.testing.assert_allclose(data_of(cut).normals[known], places, atol=1e-9)
    # What has no values closes a cut: it lies across the axis.
    face = cut.face_of_corner()
    for cap in np.unique(face[~known]).tolist():
        assert np.ptp(cut.points[cut.corner_points()[face == cap]][:, axis]) < 1e-12
    assert set(data_of(cut).slots.tolist()) <= set(range(mesh.num_faces))


def test_faces_alone_and_joined_keep_their_values_and_turn_their_normals():
    mesh = dressed(cylinder(5))
    alone = faces(mesh)
    for parts in (alone, face_sets(mesh, np.arange(mesh.num_faces), np.array([3, mesh.num_faces - 3]))):
        of_point = parts.shapes.mesh_of_point()
        places = parts.origin[of_point] + np.einsum("pij,pj->pi", parts.rotation[of_point], parts.shapes.points)
        at_corners = assert_fits(parts.shapes, places)
        turned = np.einsum("cij,cj->ci", parts.rotation[parts.shapes.mesh_of_corner()], data_of(parts.shapes).normals)
        np.testing.assert_allclose(turned, at_corners, atol=1e-9)
        np.testing.assert_allclose(data_of(unaligned(parts).shapes).normals, at_corners, atol=1e-9)
    merged = joined(alone, np.array([mesh.num_faces]))
    places = merged.origin[0] + merged.shapes.points @ merged.rotation[0].T
    at_corners = assert_fits(merged.shapes, places)
    np.testing.assert_allclose(data_of(merged.shapes).normals @ merged.rotation[0].T, at_corners, atol=1e-9)


def test_a_reversed_face_keeps_its_values_and_turns_its_normals_over():
    mesh = dressed(box())
    turned = mesh.reversed(np.arange(6) % 2 == 0)
    at_corners = assert_fits(turned)
    side = np.where(turned.face_of_corner() % 2 == 0, -1.0, 1.0)[:, None]
    np.testing.assert_array_equal(data_of(turned).normals, side * at_corners)


def test_stretched_normals_stay_at_right_angles_to_the_surface():
    sphere = np.random.default_rng(1).normal(size=(20, 3))
    mesh = Meshes.from_polygons(np.repeat(sphere, 3, axis=0), np.full(20, 3))
    mesh = mesh.with_data(CornerData.of_sets([mesh.points[:, :2]], 20, mesh.points))
    size = np.array([[2.0, 0.5, 3.0]]).repeat(20, axis=0)
    tangent = np.cross(mesh.points, [1.0, 2.0, 3.0])
    stretched = mesh.with_points(mesh.points * size[0], stretch=size)
    assert np.abs((data_of(stretched).normals * tangent * size[0]).sum(axis=1)).max() < 1e-12


def test_extruded_faces_keep_their_coordinates_above_and_below():
    solid = extrude(dressed(STAR), np.array([2.0]))
    level = solid.points.copy()
    level[:, 2] = 0.0
    known = ~np.isnan(data_of(solid).coordinates(0)[:, 0])
    assert np.count_nonzero(known) == 16
    np.testing.assert_allclose(
        data_of(solid).coordinates(0)[known], level[solid.corner_points()][known] @ TO_UV, atol=1e-12
    )


def test_taken_and_joined_batches_have_the_values_of_their_meshes():
    one, plain, other = dressed(box()), cylinder(4), dressed(STAR)
    both = Meshes.concatenate([one, plain, other])
    again = both.take(np.array([2, 0, 2]))
    np.testing.assert_array_equal(
        data_of(again).values, np.concatenate([data_of(other).values, data_of(one).values, data_of(other).values])
    )
    assert np.isnan(data_of(both.take(np.array([1]))).values).all()
    assert join_data([(None, 3, 1)]) is None
    assert data_of(both.take(np.array([1]))).coordinates(7).shape == (len(plain.corners), 2)


@pytest.mark.parametrize("num_sets", [1, 3])
def test_sets_of_different_numbers_are_filled_up(num_sets):
    data = CornerData.of_sets([np.ones((3, 2))] * num_sets, 1)
    both = join_data([(data, 3, 1), (CornerData.of_sets([np.zeros((4, 2))] * 2, 1), 4, 1)])
    assert both is not None
    assert both.num_sets == max(num_sets, 2)
    assert np.isnan(both.values).any()
