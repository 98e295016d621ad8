import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes import measure
from grammarlab.geometry.meshes.mesh import BORDER, INSIDE, Meshes
from grammarlab.geometry.outlines.offset import offset
from tests.geometry.polygons import LOT_L, area, combs, convex, lots, moved, rectilinear, simple

QUICK = settings(max_examples=50, deadline=None)
SHARES = st.one_of(st.floats(-0.6, -0.001), st.floats(0.001, 0.6))
RECTANGLE = np.array([(0, 0), (30, 0), (30, -12), (0, -12)], float)[::-1]
FRAME = Meshes.single(
    np.array([[0, 0, 0], [0, 0, 9], [9, 0, 9], [9, 0, 0], [3, 0, 3], [6, 0, 3], [6, 0, 6], [3, 0, 6.0]]),
    [(0, 1, 2, 3, 0, 4, 5, 6, 7, 4)],
)


def signed(meshes):
    """Area of each face seen from above, negative when it looks down."""
    return measure.area_vectors(meshes)[:, 1]


def buffered(ring, distance):
    return shapely.Polygon(ring).buffer(distance, join_style="mitre", mitre_limit=1e6)


@QUICK
@given(st.one_of(convex(), rectilinear(), combs(), moved(rectilinear())), SHARES)
def test_the_offset_polygon_is_the_mitred_buffer(ring, share):
    distance = share * math.sqrt(area(ring))
    result = offset(lots([ring]), distance)
    inside = shapely.union_all(_flat(result, INSIDE))
    assert inside.symmetric_difference(buffered(ring, distance)).area <= 1e-6 * area(ring)


def _flat(meshes, tag):
    faces = []
    for face in np.flatnonzero(meshes.tags == tag):
        corners = meshes.points[meshes.corner_points()][meshes.face_offsets[face] : meshes.face_offsets[face + 1]]
        faces.append(shapely.Polygon(np.stack([corners[:, 0], -corners[:, 2]], axis=1)).buffer(0.0))
    return faces


@QUICK
@given(simple, SHARES)
def test_offset_polygons_and_ring_have_the_area_of_the_face(ring, share):
    result = offset(lots([ring]), share * math.sqrt(area(ring)))
    assert signed(result).sum() == pytest.approx(area(ring), rel=1e-6)
    looks_up = signed(result) >= -1e-9 * area(ring)
    assert (looks_up | ((result.tags == BORDER) & (share > 0.0))).all()


@QUICK
@given(simple, SHARES)
def test_inside_and_border_are_the_two_parts_of_all(ring, share):
    lot, distance = lots([ring]), share * math.sqrt(area(ring))
    whole = offset(lot, distance, "all")
    if (whole.tags == INSIDE).any():
        inner = offset(lot, distance, "inside")
        assert signed(inner).tolist() == signed(whole)[whole.tags == INSIDE].tolist()
        assert (inner.tags == INSIDE).all()
    border = offset(lot, distance, "border")
    assert signed(border).tolist() == signed(whole)[whole.tags == BORDER].tolist()


@QUICK
@given(simple, SHARES)
def test_the_ring_has_one_face_an_edge_that_begins_with_it(ring, share):
    lot = lots([ring])
    border = offset(lot, share * math.sqrt(area(ring)), "border")
    corners = border.points[border.corner_points()]
    starts = border.face_offsets[:-1]
    assert border.num_faces == len(ring)
    assert corners[starts].tolist() == lot.points.tolist()
    assert corners[starts + 1].tolist() == np.roll(lot.points, -1, axis=0).tolist()


@QUICK
@given(st.lists(simple, min_size=2, max_size=5), SHARES)
def test_a_face_gives_the_same_bits_alone_and_in_a_batch(rings, share):
    lot = lots([*rings, RECTANGLE])
    together = offset(lot, share)
    for i in range(len(lot)):
        alone = offset(lot.take(np.array([i])), share)
        assert alone.points.tobytes() == together.take(np.array([i])).points.tobytes()


@QUICK
@given(st.floats(0.1, 50.0), st.floats(0.1, 50.0), SHARES)
def test_the_rectangle_formula_agrees_with_the_sweep(width, depth, share):
    # A corner in the middle of an edge keeps the sweep from taking the short cut.
    rectangle = np.array([(0, 0), (width, 0), (width, depth), (0, depth)])
    longer = np.insert(rectangle, 1, (0.5 * width, 0.0), axis=0)
    distance = share * min(width, depth)
    first, second = (signed(offset(lots([ring]), distance, "border")) for ring in (rectangle, longer))
    joined = np.append(second[0] + second[1], second[2:]) if len(second) else second
    assert first == pytest.approx(joined, abs=1e-9 * width * depth)


def test_ring_and_inside_of_an_l_have_the_known_areas():
    result = offset(lots([LOT_L]), -1.0)
    assert result.tags.tolist() == [BORDER] * 6 + [INSIDE]
    assert signed(result) == pytest.approx([11, 8, 10, 17, 21, 25, 400])


def test_the_inside_begins_where_the_face_begins():
    result = offset(lots([LOT_L, RECTANGLE]), -1.0, "inside")
    first = result.points[result.mesh_points[:-1]]
    assert first == pytest.approx(np.array([[1, 0, 1], [1, 0, 11]]))


def test_too_large_an_offset_keeps_the_face_or_only_the_ring():
    lot = lots([LOT_L, RECTANGLE])
    assert signed(offset(lot, -9.5, "inside")).tolist() == pytest.approx([492.0, 360.0])
    assert (offset(lot, -9.5, "all").tags == BORDER).all()
    assert measure.areas(offset(lot, -9.5, "border")) == pytest.approx([492.0, 360.0])


def test_no_distance_leaves_the_face_and_no_ring():
    lot = lots([LOT_L])
    assert signed(offset(lot, 0.0)).tolist() == [492.0]
    assert offset(lot, 0.0, "border").num_faces == 0
    assert len(offset(lot, 0.0, "border")) == 1


def test_a_split_offset_gives_several_polygons():
    dumbbell = np.array(
        [(0, 0), (4, 0), (4, 1.5), (6, 1.5), (6, 0), (10, 0), (10, 4), (6, 4), (6, 2.5), (4, 2.5), (4, 4), (0, 4)]
    )
    result = offset(lots([dumbbell]), -1.0, "inside")
    assert signed(result) == pytest.approx([4.0, 4.0])


def test_a_grown_horseshoe_gets_a_hole_by_keyhole():
    corners = np.array(
        [(0, 0), (4.5, 0), (4.5, 3), (3, 3), (3, 7), (7, 7), (7, 3), (5.5, 3), (5.5, 0), (10, 0), (10, 10), (0, 10)]
    )
    result = offset(lots([corners]), 1.0, "inside")
    assert signed(result) == pytest.approx([buffered(corners, 1.0).area])
    assert result.num_faces == 1
    assert len(result.corners) > len(set(result.corners.tolist()))


def test_holes_shrink_when_a_face_grows_and_grow_when_it_shrinks():
    assert signed(offset(FRAME, 0.5, "inside")) == pytest.approx([100.0 - 4.0])
    assert signed(offset(FRAME, -0.5, "inside")) == pytest.approx([64.0 - 16.0])
    assert signed(offset(FRAME, 2.0, "inside")) == pytest.approx([169.0])
    for distance in (0.5, -0.5, -2.0):
        assert signed(offset(FRAME, distance)).sum() == pytest.approx(72.0)
        assert offset(FRAME, distance, "border").num_faces == 8


def test_every_face_of_a_mesh_is_offset_on_its_own():
    lot = lots([LOT_L, RECTANGLE])
    both = Meshes(lot.points, np.arange(10), lot.face_offsets, np.array([0, 2]), np.array([0, 10]), lot.tags)
    result = offset(both, -1.0)
    assert result.mesh_faces.tolist() == [0, 12]
    assert measure.areas(result) == pytest.approx([492.0 + 360.0])


def test_distances_may_differ_from_mesh_to_mesh():
    result = offset(lots([RECTANGLE, RECTANGLE, RECTANGLE]), np.array([-1.0, 0.0, 1.0]), "inside")
    assert signed(result) == pytest.approx([280.0, 360.0, 448.0])


@pytest.mark.parametrize("distance", [-0.25, 0.25])
def test_faces_that_are_no_simple_polygons_stay_as_they_are(distance):
    bow_tie = np.array([(0, 0), (4, 3), (4, 0), (0, 1)], float)
    line = np.array([(0, 0), (1, 0), (2, 0)], float)
    lot = lots([bow_tie, line])
    for keep in ("all", "inside"):
        result = offset(lot, distance, keep)
        assert result.points.tolist() == lot.points.tolist()
        assert result.tags.tolist() == [INSIDE, INSIDE]
    assert offset(lot, distance, "border").num_faces == 0


def test_no_meshes_give_no_meshes():
    nothing = lots([LOT_L]).take(np.zeros(0, int))
    assert len(offset(nothing, -1.0)) == 0
