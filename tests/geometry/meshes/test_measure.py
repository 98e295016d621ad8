import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes import measure
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box, cone, cylinder, quad
from tests.geometry.bodies import FRAME, as_triangles, prism, rotations, solids, turned
from tests.geometry.polygons import LOT_L, area, lots, simple

QUICK = settings(max_examples=40, deadline=None)


@QUICK
@given(simple, rotations())
def test_area_of_a_face_is_that_of_its_polygon_in_any_orientation(ring, rotation):
    face = turned(lots([ring]), rotation)
    assert measure.face_areas(face)[0] == pytest.approx(area(ring), rel=1e-9)
    assert measure.face_normals(face)[0] == pytest.approx(rotation[:, 1], abs=1e-9)


@QUICK
@given(solids, rotations())
def test_area_and_volume_of_solids_agree_with_trimesh(solid, rotation):
    solid = turned(solid, rotation)
    other = as_triangles(solid)
    assert measure.areas(solid)[0] == pytest.approx(other.area, rel=1e-9)
    assert measure.volumes(solid)[0] == pytest.approx(other.volume, rel=1e-7)
    assert measure.is_closed(solid)[0] == other.is_watertight


@QUICK
@given(solids)
def test_turning_all_faces_around_negates_the_volume_and_keeps_the_first_edges(solid):
    inside_out = solid.reversed()
    assert measure.volumes(inside_out)[0] == pytest.approx(-measure.volumes(solid)[0])
    first, second = solid.face_offsets[:-1], solid.face_offsets[:-1] + 1
    assert (inside_out.corners[first] == solid.corners[second]).all()
    assert (inside_out.corners[second] == solid.corners[first]).all()


def test_reversed_turns_only_the_chosen_faces():
    turned_over = box().reversed(np.array([True, False, False, False, True, False]))
    flipped = np.einsum("fk,fk->f", measure.face_normals(turned_over), measure.face_normals(box()))
    assert flipped.tolist() == [-1, 1, 1, 1, -1, 1]


@QUICK
@given(st.lists(solids, min_size=1, max_size=4), st.data())
def test_measures_of_a_mesh_are_the_same_alone_and_in_a_batch(batch, data):
    together = Meshes.concatenate(batch)
    chosen = data.draw(st.integers(0, len(batch) - 1))
    for name in ("areas", "volumes", "is_closed", "has_concave_face", "steepest_slope"):
        whole, alone = getattr(measure, name)(together), getattr(measure, name)(batch[chosen])
        assert np.array_equal(np.atleast_2d(whole)[:, chosen], np.atleast_2d(alone)[:, 0])


@QUICK
@given(simple)
def test_a_face_is_convex_exactly_when_it_fills_its_hull(ring):
    import shapely

    polygon = shapely.Polygon(ring)
    filled = polygon.area / polygon.convex_hull.area
    # Dents of rounding size are neither here nor there.
    if filled > 1 - 1e-12 or filled < 1 - 1e-7:
        assert measure.is_convex(lots([ring]))[0] == (filled > 1 - 1e-9)


def test_a_face_that_runs_back_on_itself_is_not_convex():
    spike = np.array([[0, 0, 0], [0, 0, 2], [2, 0, 2], [2, 0, 0], [3, 0, 0], [2, 0, 0.0]])
    assert not measure.is_convex(Meshes.from_polygons(spike, np.array([6])))[0]


@pytest.mark.parametrize("missing", range(6))
def test_a_box_without_one_face_is_open(missing):
    faces = [f for f in range(6) if f != missing]
    corners = box().corners.reshape(6, 4)[faces]
    assert not measure.is_closed(Meshes.single(box().points, corners.tolist()))[0]


def test_a_mesh_without_faces_is_not_closed_and_has_no_extent():
    nothing = Meshes.concatenate([Meshes.single(np.zeros((0, 3)), []), box()])
    assert measure.is_closed(nothing).tolist() == [False, True]
    assert measure.areas(nothing).tolist() == [0.0, 6.0]
    assert measure.volumes(nothing).tolist() == [0.0, pytest.approx(1.0)]
    assert measure.is_rectangular(nothing, 1.0).tolist() == [False, True]
    assert measure.is_planar(nothing, 1.0).tolist() == [False, True]
    assert [column.tolist() for column in measure.steepest_slope(nothing)] == [[0.0, 90.0], [0.0, 180.0]]


def test_an_edge_shape_is_no_closed_mesh():
    edge = Meshes.from_polygons(np.array([[0, 0, 0], [1, 0, 0.0]]), np.array([2]))
    assert not measure.is_closed(edge)[0]


def test_degenerate_faces_have_no_normal():
    line = Meshes.from_polygons(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]]), np.array([3]))
    assert measure.face_normals(line).tolist() == [[0, 0, 0]]


@given(st.floats(-30.0, 30.0), st.floats(0.0, 20.0))
@QUICK
def test_a_sheared_rectangle_is_rectangular_up_to_its_shear_angle(shear, tolerance):
    shift = np.tan(np.radians(shear))
    points = np.array([[0, 0, 0], [shift, 0, 1], [1 + shift, 0, 1], [1, 0, 0.0]])
    if abs(abs(shear) - tolerance) > 1e-6:
        face = Meshes.from_polygons(points, np.array([4]))
        assert measure.is_rectangular(face, tolerance)[0] == (abs(shear) < tolerance)


@given(rotations())
@QUICK
def test_boxes_are_rectangular_without_tolerance_in_any_orientation(rotation):
    assert measure.is_rectangular(turned(box(), rotation), 0.0)[0]


def test_shapes_with_other_faces_are_not_rectangular():
    assert not measure.is_rectangular(Meshes.concatenate([cylinder(), cone(), lots([LOT_L])]), 45.0).any()


def test_a_bent_quad_is_planar_only_within_its_bend():
    bent = np.add(quad().points, [[0, 0, 0], [0, 0, 0], [0, 0.1, 0], [0, 0, 0]])
    face = Meshes.from_polygons(bent, np.array([4]))
    assert [bool(measure.is_planar(face, degrees)[0]) for degrees in (0.25, 10.0)] == [False, True]


@given(st.floats(0.0, 90.0), st.floats(0.0, 359.0))
@QUICK
def test_slope_and_azimuth_of_a_tilted_face(slope, azimuth):
    s, a = np.radians([slope, azimuth])
    normal = np.array([np.sin(s) * np.sin(a), np.cos(s), -np.sin(s) * np.cos(a)])
    across = np.array([np.cos(a), 0.0, np.sin(a)])
    corners = np.array([[1, 0], [0, 1], [-1, 0]]) @ np.array([across, np.cross(normal, across)])
    found = measure.steepest_slope(Meshes.from_polygons(corners, np.array([3])))
    assert found[0][0] == pytest.approx(slope, abs=1e-6)
    if 1e-3 < slope < 90.0 - 1e-3:
        assert (found[1][0] - azimuth + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=1e-5)


def test_a_keyholed_frame_has_the_area_of_its_ring_and_encloses_its_prism():
    assert measure.areas(FRAME)[0] == pytest.approx(72.0)
    assert not measure.is_closed(FRAME)[0]
    assert measure.volumes(prism(LOT_L, 2.0))[0] == pytest.approx(2.0 * area(LOT_L))
