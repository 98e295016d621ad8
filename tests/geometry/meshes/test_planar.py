import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes import measure
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.planar import lay_flat, rectangle_sizes, regroup, signed_areas
from tests.geometry.polygons import LOT_L, area, lots, simple

QUICK = settings(max_examples=40, deadline=None)
DIRECTIONS = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6)


def somewhere(meshes, numbers):
    """The meshes turned and moved in space."""
    basis = np.linalg.qr(np.array([*numbers, 0.3, 0.9, 0.2]).reshape(3, 3) + 2.0 * np.eye(3))[0]
    basis[:, 0] *= np.sign(np.linalg.det(basis))
    return meshes.with_points(meshes.points @ basis.T + 3.0)


@QUICK
@given(st.lists(simple, min_size=1, max_size=4), DIRECTIONS)
def test_laying_flat_and_lifting_gives_the_corners_back(rings, numbers):
    meshes = somewhere(lots(rings), numbers)
    polygons = lay_flat(meshes)
    faces = polygons.face_of_corner()
    lifted = polygons.lift(faces, polygons.xy[:, None], np.zeros((len(faces), 1)))[:, 0]
    size = max(float(np.ptp(ring, axis=0).max()) for ring in rings)
    assert lifted == pytest.approx(polygons.points, abs=1e-9 * (size + 1.0))


@QUICK
@given(st.lists(simple, min_size=1, max_size=4), DIRECTIONS)
def test_flat_polygons_keep_their_areas_and_run_counter_clockwise(rings, numbers):
    polygons = lay_flat(somewhere(lots(rings), numbers))
    assert signed_areas(polygons) == pytest.approx([area(ring) for ring in rings], rel=1e-6)


@QUICK
@given(st.lists(simple, min_size=2, max_size=4), DIRECTIONS)
def test_a_polygon_lies_the_same_alone_and_in_a_batch(rings, numbers):
    meshes = somewhere(lots(rings), numbers)
    together = lay_flat(meshes)
    for i in range(len(rings)):
        alone = lay_flat(meshes.take(np.array([i])))
        assert alone.xy.tobytes() == together.xy[together.offsets[i] : together.offsets[i + 1]].tobytes()


def test_frames_start_at_the_first_corner_along_the_first_edge():
    polygons = lay_flat(lots([LOT_L]))
    assert polygons.xy[:2].tolist() == [[0.0, 0.0], [12.0, 0.0]]
    assert polygons.axes[0, 2].tolist() == [0.0, 1.0, 0.0]


def test_rectangles_are_found_with_the_lengths_of_their_edges():
    rectangle = np.array([(1, 1), (4, 1), (4, 3), (1, 3)], float)
    skewed = rectangle + np.array([(0, 0), (0, 0), (0.1, 0), (0.1, 0)])
    kite = np.array([(0, 0), (2, -1), (4, 0), (2, 3)], float)
    found, sizes = rectangle_sizes(lay_flat(lots([rectangle, skewed, kite, LOT_L])))
    assert found.tolist() == [True, False, False, False]
    assert sizes.tolist() == [[3.0, 2.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]


def test_faces_without_area_get_frames_without_nan():
    points = np.array([[0, 0, 0], [1, 1, 1], [2, 2, 2], [5, 5, 5], [5, 5, 5], [5, 5, 5.0]])
    polygons = lay_flat(Meshes.from_polygons(points, np.array([3, 3])))
    assert np.isfinite(polygons.xy).all()
    identity = polygons.axes @ np.swapaxes(polygons.axes, 1, 2)
    assert identity == pytest.approx(np.stack([np.eye(3)] * 2))


def test_regrouping_joins_meshes_without_moving_a_face():
    meshes = lots([LOT_L, LOT_L + 50.0, LOT_L + 90.0])
    joined = regroup(meshes, np.array([0, 2, 2, 3]))
    assert np.diff(joined.mesh_faces).tolist() == [2, 0, 1]
    assert joined.points[joined.corner_points()].tolist() == meshes.points[meshes.corner_points()].tolist()
    assert measure.areas(joined).tolist() == [984.0, 0.0, 492.0]
