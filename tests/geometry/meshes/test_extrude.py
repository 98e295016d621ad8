import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes.extrude import extrude, extrude_along_vertex_normals, extrude_to_level
from grammarlab.geometry.meshes.measure import (
    area_vectors,
    areas,
    corner_edges,
    face_areas,
    face_normals,
    is_closed,
    num_faces,
    volumes,
)
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box, disk, quad, sphere
from tests.geometry.bodies import FRAME, rotations, turned
from tests.geometry.polygons import area, lots, simple

QUICK = settings(max_examples=40, deadline=None)
heights = st.one_of(st.floats(0.01, 5.0), st.floats(-5.0, -0.01))
UP = np.array([[0.0, 1.0, 0.0]])

TILES = Meshes.single(
    np.array([[x, 0.0, z] for z in (2.0, 1.0, 0.0) for x in (0.0, 1.0, 2.0)]),
    [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)],
)
"""Four unit squares that form a larger one."""


@QUICK
@given(simple, heights, rotations())
def test_a_prism_is_closed_looks_outwards_and_has_area_times_height(ring, height, rotation):
    face = turned(lots([ring]), rotation)
    solid = extrude(face, np.array([height]))
    assert is_closed(solid)[0]
    assert volumes(solid)[0] == pytest.approx(area(ring) * abs(height), rel=1e-6)
    perimeter = np.linalg.norm(corner_edges(face), axis=1).sum()
    assert areas(solid)[0] == pytest.approx(2 * area(ring) + perimeter * abs(height), rel=1e-6)


@QUICK
@given(simple, heights)
def test_faces_are_the_bottom_the_top_then_the_walls_in_edge_order(ring, height):
    face = lots([ring])
    solid = extrude(face, np.array([height]))
    count = len(ring)
    assert solid.num_faces == count + 2
    edges = corner_edges(face)
    first_edges = corner_edges(solid)[solid.face_offsets[:-1]]
    # A wall below the ground is seen from the other side, so its first edge runs the other way.
    assert first_edges[2:] == pytest.approx(np.sign(height) * edges)
    assert face_areas(solid)[2:] == pytest.approx(np.linalg.norm(edges, axis=1) * abs(height))
    assert area_vectors(solid)[:2, 1] == pytest.approx(np.sign(height) * np.array([-area(ring), area(ring)]), rel=1e-6)
    # Turned over, a face begins with the same edge.
    turns = np.array([-1.0, 1.0]) * np.sign(height)
    assert first_edges[:2] == pytest.approx(turns[:, None] * edges[0])


def test_an_extruded_rectangle_is_the_box_but_for_the_first_edge_of_its_bottom():
    prism = extrude(quad(), np.ones(1))
    assert np.array_equal(prism.points, box().points)
    assert np.array_equal(prism.corners[4:], box().corners[4:])
    # The bottom of the box begins at the origin of its scope.
    assert np.array_equal(prism.corners[[2, 3, 0, 1]], box().corners[:4])


def test_height_zero_leaves_a_mesh_as_it_is():
    both = extrude(Meshes.concatenate([quad(), quad(), disk(5)]), np.array([0.0, 2.0, 0.0]))
    assert num_faces(both).tolist() == [1, 6, 1]
    assert np.array_equal(both.take(np.array([0])).points, quad().points)


def test_neighbours_in_one_plane_get_no_wall_between_them():
    solid = extrude(TILES, np.array([3.0]))
    assert solid.num_faces == 8 + 4 + 4
    assert is_closed(solid)[0]
    assert volumes(solid)[0] == pytest.approx(12.0)


def test_faces_of_a_bent_mesh_are_extruded_one_by_one_along_their_normals():
    solid = extrude(box(), np.array([0.5]))
    assert solid.num_faces == 6 * 6
    assert is_closed(solid)[0]
    assert volumes(solid)[0] == pytest.approx(6 * 0.5)


@QUICK
@given(heights)
def test_a_bent_mesh_extruded_along_the_world_is_one_solid(height):
    roof = Meshes.single(
        np.array([[0, 0, 2], [2, 0, 2], [2, 1, 1], [0, 1, 1], [2, 0, 0], [0, 0, 0.0]]), [(0, 1, 2, 3), (3, 2, 4, 5)]
    )
    solid = extrude(roof, np.array([height]), UP)
    assert is_closed(solid)[0]
    assert volumes(solid)[0] == pytest.approx(4.0 * abs(height))
    assert solid.num_faces == 2 * 2 + 6


def test_a_face_with_a_hole_becomes_a_closed_tube():
    solid = extrude(FRAME, np.array([2.0]))
    assert is_closed(solid)[0]
    assert solid.num_faces == 8 + 2
    assert volumes(solid)[0] == pytest.approx(144.0)


@QUICK
@given(st.integers(4, 12), heights)
def test_along_vertex_normals_a_ball_stays_a_ball(sides, height):
    ball = sphere(sides, sides)
    thick = extrude_along_vertex_normals(ball, np.array([height * 0.01]))
    assert thick.num_faces == 2 * ball.num_faces
    assert is_closed(thick)[0]
    assert volumes(thick)[0] > 0.0


def test_along_vertex_normals_a_flat_mesh_is_a_prism():
    assert volumes(extrude_along_vertex_normals(TILES, np.array([-3.0])))[0] == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("height", "level", "volume"), [(3.0, 3.0, 10.0), (0.5, 1.0, 2.0), (0.0, 1.0, 2.0), (-3.0, -2.0, 10.0)]
)
def test_a_flat_top_counts_from_the_lowest_or_highest_vertex(height, level, volume):
    tilted = quad().points * [2.0, 1.0, 2.0] + [[0, 0, 0], [0, 1, 0], [0, 1, 0], [0, 0, 0]]
    solid = extrude_to_level(Meshes.from_polygons(tilted, np.array([4])), np.array([height]), UP)
    assert is_closed(solid)[0]
    flat = np.abs(face_normals(solid)[:, 1]) == 1.0
    assert np.count_nonzero(flat) == 1
    assert np.count_nonzero(solid.points[:, 1] == level) == 4
    assert (face_areas(solid) > 0.0).all()
    assert volumes(solid)[0] == pytest.approx(volume)


def test_a_level_face_rises_by_its_height():
    solid = extrude_to_level(Meshes.concatenate([quad(), disk(6)]), np.array([2.0, 0.0]), np.repeat(UP, 2, axis=0))
    assert volumes(solid)[0] == pytest.approx(2.0)
    assert num_faces(solid).tolist() == [6, 1]


@QUICK
@given(st.lists(st.tuples(simple, heights), min_size=1, max_size=4), st.data())
def test_a_batch_equals_its_members(lots_and_heights, data):
    rings, tall = zip(*lots_and_heights, strict=True)
    together = extrude(lots(rings), np.array(tall))
    k = data.draw(st.integers(0, len(rings) - 1))
    alone = extrude(lots([rings[k]]), np.array([tall[k]]))
    assert np.array_equal(together.take(np.array([k])).points, alone.points)
    assert np.array_equal(together.take(np.array([k])).corners, alone.corners)
