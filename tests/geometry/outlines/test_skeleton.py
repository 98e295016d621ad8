import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.outlines.straight_skeleton import loop_area, merge, sweep
from tests.geometry.polygons import LOT_L, area, combs, convex, moved, rectilinear, simple, stars

QUICK = settings(max_examples=60, deadline=None)


def skeleton(ring):
    result = sweep([ring], [1.0] * len(ring))
    assert result is not None
    return result


def distance_to_edge(ring, edge, places):
    start, end = ring[edge], ring[(edge + 1) % len(ring)]
    along = (end - start) / np.hypot(*(end - start))
    return along[0] * (places[:, 1] - start[1]) - along[1] * (places[:, 0] - start[0])


@QUICK
@given(simple)
def test_every_edge_has_one_face_which_begins_with_it(ring):
    result = skeleton(ring)
    assert len(result.faces) == len(ring)
    for edge, faces in enumerate(result.faces):
        assert len(faces) == 1
        assert faces[0][:2] == (edge, (edge + 1) % len(ring))


@QUICK
@given(simple)
def test_faces_fill_the_polygon_without_overlap(ring):
    result = skeleton(ring)
    areas = [loop_area(result.xy, loop) for faces in result.faces for loop in faces]
    assert min(areas) > 0.0
    assert sum(areas) == pytest.approx(area(ring), rel=1e-9)
    assert all(shapely.Polygon(result.xy[list(loop)]).is_valid for faces in result.faces for loop in faces)


@QUICK
@given(simple)
def test_every_face_rises_evenly_from_its_edge(ring):
    result = skeleton(ring)
    size = np.ptp(ring, axis=0).max()
    for edge, (loop,) in enumerate(result.faces):
        nodes = list(loop)
        # Corners at blunt or sharp angles amplify rounding by the reciprocal of their sine.
        assert distance_to_edge(ring, edge, result.xy[nodes]) == pytest.approx(result.time[nodes], abs=1e-7 * size)


@QUICK
@given(convex())
def test_convex_roofs_are_the_lower_envelope_of_their_slopes(ring):
    result = skeleton(ring)
    for (loop,) in result.faces:
        nodes = list(loop)
        lowest = np.min([distance_to_edge(ring, edge, result.xy[nodes]) for edge in range(len(ring))], axis=0)
        assert result.time[nodes] == pytest.approx(lowest, abs=1e-9)


@QUICK
@given(st.one_of(stars(12), rectilinear(), combs()), st.floats(0.02, 0.4))
def test_what_is_left_at_a_time_is_the_mitred_offset(ring, share):
    distance = share * math.sqrt(area(ring))
    result = sweep([ring], [1.0] * len(ring), distance)
    assert result is not None
    # One large step of GEOS drops small notches, many small ones converge.
    expected = shapely.Polygon(ring)
    for _ in range(150):
        expected = expected.buffer(-distance / 150, join_style="mitre", mitre_limit=1e6)
    left = sum(loop_area(result.xy, loop) for loop in result.rest)
    assert left == pytest.approx(expected.area, abs=1e-6 * area(ring))


@QUICK
@given(simple, st.floats(0.05, 0.9))
def test_a_stopped_sweep_is_the_lower_part_of_the_whole(ring, share):
    whole = skeleton(ring)
    until = share * whole.time.max()
    part = sweep([ring], [1.0] * len(ring), until)
    assert part is not None
    for edge, (full,) in enumerate(whole.faces):
        swept = sum(loop_area(part.xy, loop) for loop in part.faces[edge])
        assert swept == pytest.approx(_area_below(whole, full, until), abs=1e-6 * area(ring))


def _area_below(result, loop, until):
    clipped = []
    for a, b in zip(loop, loop[1:] + loop[:1], strict=True):
        (xa, ya), (xb, yb), ta, tb = result.xy[a], result.xy[b], result.time[a], result.time[b]
        if ta <= until:
            clipped.append((xa, ya))
        if (ta <= until) != (tb <= until):
            share = (until - ta) / (tb - ta)
            clipped.append((xa + share * (xb - xa), ya + share * (yb - ya)))
    return loop_area(np.array(clipped), range(len(clipped)))


@QUICK
@given(st.one_of(stars(), rectilinear(), moved(rectilinear())), st.data())
def test_edges_at_their_own_speeds_fill_the_polygon_too(ring, data):
    steps = st.lists(st.sampled_from([0.0, 0.1, 0.2, 0.25]), min_size=len(ring), max_size=len(ring))
    speeds = [step * math.sqrt(area(ring)) for step in data.draw(steps)]
    result = sweep([ring], speeds, 1.0, bisector_cuts=True)
    assert result is not None
    swept = [loop_area(result.xy, loop) for faces in result.faces for loop in faces]
    left = [loop_area(result.xy, loop) for loop in result.rest]
    assert sum(swept) + sum(left) == pytest.approx(area(ring), rel=1e-6)
    assert min(swept, default=0.0) >= -1e-9 * area(ring)


def test_an_l_has_the_skeleton_known_from_paper():
    result = skeleton(LOT_L)
    nodes = np.column_stack([result.xy, result.time])[6:]
    expected = [(6.0, -6.0, 6.0), (14.0, -6.0, 6.0), (17.0, -13.0, 9.0), (17.0, -9.0, 9.0)]
    assert nodes[np.lexsort(nodes.T[::-1])] == pytest.approx(np.array(expected))


def test_a_square_has_one_tip():
    result = skeleton(np.array([(0, 0), (2, 0), (2, 2), (0, 2)], float))
    assert result.xy[4:].tolist() == [[1.0, 1.0]]
    assert [len(loop) for (loop,) in result.faces] == [3, 3, 3, 3]


def test_a_frame_is_swept_from_outline_and_hole():
    outline = np.array([(0, 0), (10, 0), (10, 10), (0, 10)], float)
    hole = np.array([(4, 4), (4, 6), (6, 6), (6, 4)], float)
    result = sweep([outline, hole], [1.0] * 8)
    assert result is not None
    assert result.time.max() == 2.0
    areas = [loop_area(result.xy, loop) for (loop,) in result.faces]
    assert areas == pytest.approx([16.0] * 4 + [8.0] * 4)


def test_straight_corners_split_the_face_of_their_edge():
    ring = np.array([(0, 0), (2, 0), (4, 0), (4, 2), (0, 2)], float)
    result = skeleton(ring)
    assert [loop_area(result.xy, loop) for (loop,) in result.faces] == pytest.approx([1.5, 1.5, 1.0, 3.0, 1.0])


def test_the_same_polygon_gives_the_same_bits():
    ring = LOT_L * 1.1 + 0.3
    first, second = skeleton(ring), skeleton(ring.copy())
    assert first.faces == second.faces
    assert first.xy.tobytes() == second.xy.tobytes()


@pytest.mark.parametrize(
    "ring",
    [
        [(0, 0), (1, 0)],
        [(0, 0), (1, 0), (2, 0)],
        [(1, 1), (1, 1), (1, 1), (1, 1)],
        [(0, 0), (2, 2), (2, 0), (0, 2)],
        [(0, 0), (4, 3), (4, 0), (0, 1)],
        [(0, 0), (math.nan, 0), (1, 1)],
        [(0, 0), (math.inf, 0), (1, 1)],
    ],
    ids=["two corners", "no area", "one place", "bow tie", "lopsided bow tie", "not a number", "infinite"],
)
def test_what_is_no_simple_polygon_has_no_skeleton(ring):
    assert sweep([np.array(ring, float)], [1.0] * len(ring)) is None


def test_merging_neighbours_drops_the_edge_between_them():
    assert merge([(0, 1, 2, 3), (1, 4, 5, 2)]) == [(0, 1, 4, 5, 2, 3)]


def test_merging_a_ring_leaves_its_hole():
    strips = [(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
    assert sorted(len(loop) for loop in merge(strips)) == [4, 4]
