import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes import measure
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.outlines.setback import REMAINDER, Setback, edge_normals, setback, wing_depths
from tests.geometry.polygons import LOT_L, area, lots, simple

QUICK = settings(max_examples=50, deadline=None)
# Edges in order: left, front, right, back.
LOT = np.array([(0, 0), (0, -12), (30, -12), (30, 0)], float)
STEPS = st.sampled_from([0.0, 0.05, 0.1, 0.2, 0.5])


def signed(meshes):
    return measure.area_vectors(meshes)[:, 1]


@QUICK
@given(simple, st.data())
def test_strips_and_remainder_are_the_whole(ring, data):
    steps = data.draw(st.lists(STEPS, min_size=len(ring), max_size=len(ring)))
    groups = data.draw(st.lists(st.integers(-1, 1), min_size=len(ring), max_size=len(ring)))
    result = setback(lots([ring]), np.array(steps) * math.sqrt(area(ring)), np.array(groups))
    assert signed(result.meshes).sum() == pytest.approx(area(ring), rel=1e-6)
    assert (signed(result.meshes) > -1e-9 * area(ring)).all()


@QUICK
@given(simple, st.data())
def test_only_moved_edges_have_strips_and_they_begin_with_them(ring, data):
    steps = np.array(data.draw(st.lists(STEPS, min_size=len(ring), max_size=len(ring))))
    lot = lots([ring])
    result = setback(lot, steps * math.sqrt(area(ring)))
    strips = result.group != REMAINDER
    leads = set(result.group[strips].tolist())
    # An edge of a step in the outline that its neighbours pass has no strip.
    moved = set(np.flatnonzero(steps > 0.0).tolist())
    assert moved - _edges_of_steps(ring) <= leads <= moved
    steps[[edge for edge in moved if edge not in leads]] = 0.0
    corners = result.meshes.points[result.meshes.corner_points()]
    # A strip that passes an edge that stays may be in several parts: one of them begins with the edge.
    begins = {tuple(corners[at : at + 2].ravel().tolist()) for at in result.meshes.face_offsets[:-1][strips]}
    edges = np.hstack([lot.points, np.roll(lot.points, -1, axis=0)])[steps > 0.0]
    assert {tuple(edge) for edge in edges.tolist()} <= begins


def _edges_of_steps(ring):
    """Edges whose nearest corners before and behind them, or nearest sharp ones, turn to different sides."""
    after = np.roll(ring, -1, axis=0) - ring
    direction = np.arctan2(after[:, 1], after[:, 0])
    turns = np.degrees(np.angle(np.exp(1j * (direction - np.roll(direction, 1)))))
    edges = set(np.flatnonzero(turns * np.roll(turns, -1) < 0.0).tolist())
    sharp = np.flatnonzero((turns > 15.0) | (turns < -45.0))
    for a, b in zip(sharp.tolist(), np.append(sharp[1:], sharp[:1] + len(ring)).tolist(), strict=True):
        if turns[a] * turns[b % len(ring)] < 0.0:
            edges |= {edge % len(ring) for edge in range(a, b)}
    return edges


# A low step between two fronts, upright or leaning by half a metre: (x of its upper corner, distances, remainder).
STEPPED = [
    (10, [0, 0, 4, 4, 0, 0], [(10, 10), (10, 7), (24, 7)]),
    (10, [0, 0, 4, 1.5, 0, 0], [(10, 10), (10, 9.5), (24, 9.5)]),
    (10, [0, 0, 4, 0.9, 0, 0], [(10, 10), (14, 10), (14, 10.1), (24, 10.1)]),
    (10, [0, 1, 4, 4, 0, 0], [(10, 9), (10, 7), (24, 7)]),
    (10, [0, 0.4, 4, 1.5, 0, 0], [(10, 9.6), (10, 9.5), (24, 9.5)]),
    (10, [0, 0.6, 4, 1.5, 0, 0], [(14, 9.4), (14, 9.5), (24, 9.5)]),
    (10, [0, 4, 4, 1.5, 0, 0], [(14, 6), (14, 9.5), (24, 9.5)]),
    (10.5, [0, 0, 4, 4, 0, 0], [(10, 10), (10, 7), (24, 7)]),
    (9.5, [0, 0, 4, 4, 0, 0], [(10, 10), (10, 7), (24, 7)]),
]


@pytest.mark.parametrize(("x", "steps", "expected"), STEPPED)
def test_what_moves_past_a_step_of_the_outline_ends_at_the_step_as_in_the_runtime(x, steps, expected):
    ring = np.array([(2, 2), (2, 10), (10, 10), (x, 11), (24, 11), (24, 2)], float)
    level = 10 - steps[1]
    result = setback(lots([ring[:, ::-1]]), np.array(steps), np.zeros(6, np.int64))
    rest = result.meshes.take(np.array([0]))
    start, end = rest.face_offsets[np.flatnonzero(result.group == REMAINDER)[0] :][:2]
    corners = rest.points[rest.corner_points()[start:end]]
    outline = {(round(float(-b), 6), round(float(a), 6)) for a, _, b in corners}
    assert outline == {(2, 2), (2, level), *expected, (24, 2)}
    if steps[1] == 0.0:
        first, second = rest.points[rest.corner_points()[:2]]
        assert np.allclose([-first[2], first[0], -second[2], second[0]], [10, 10, x, 11])


STEP = np.array([(2, 2), (10, 2), (10, 10), (11, 10), (11, 24), (2, 24)], float)


def _front(turns, middle=10.0):
    """A lot with a front of three edges that turn by angles in degrees; the first and the last are 10 m long."""
    angles = np.radians(np.cumsum([0, *turns]))
    lengths = np.array([(10.0,), (middle,), (10.0,)])
    front = np.cumsum(lengths * np.stack([np.cos(angles), np.sin(angles)], axis=1), axis=0)
    return np.array([(0, 0), *front, (front[-1, 0], 30), (0, 30)])


def _pieces(ring, steps, groups=None):
    """Group, area and number of corners of each piece."""
    result = setback(lots([ring]), np.array(steps, float), groups if groups is None else np.array(groups))
    corners = np.diff(result.meshes.face_offsets)
    return list(zip(result.group, signed(result.meshes).round(3), corners, strict=True))


TURNED = [
    # Both sides of the step are on one line in the end.
    (STEP, [0, 0.5, 4, 1.5, 0, 0]),
    (STEP, [0, 0.3, 4, 1.3, 0, 0]),
    (_front((0, 10)), [1, 2, 2, 0, 0, 0]),
    (_front((0, -40)), [1, 2, 2, 0, 0, 0]),
]


@pytest.mark.parametrize(("ring", "steps"), TURNED)
def test_which_edges_have_strips_is_the_same_in_every_direction(ring, steps):
    for angle in range(1, 13):
        cos, sin = math.cos(angle), math.sin(angle)
        turned = ring @ np.array([(cos, sin), (-sin, cos)]) + (211.0 * cos, 97.0 * sin)
        assert _pieces(turned, steps) == [
            (group, pytest.approx(size, abs=2e-3), count) for group, size, count in _pieces(ring, steps)
        ]


# Areas of the remainder in CityEngine's runtime.
GENTLE = [
    ((-3, 3), [1, 2, 2, 0, 0, 0], 857.476),
    ((3, -3), [2, 1, 1, 0, 0, 0], 851.78),
    ((-20, 5), [0, 1, 3, 0, 0, 0], 894.63),
    ((5, -20), [3, 1, 0, 0, 0, 0], 848.51),
]


@pytest.mark.parametrize(("turns", "steps", "remainder"), GENTLE)
def test_edges_of_a_gentle_s_have_strips_as_in_the_runtime(turns, steps, remainder):
    *strips, rest = _pieces(_front(turns), steps)
    assert [group for group, _, _ in strips] == np.flatnonzero(steps).tolist()
    assert rest[1] == pytest.approx(remainder, abs=0.01)


CHAMFERED = [
    ((-10, 20), [0, 1, 3, 0, 0, 0], 585.09),
    ((40, -44), [3, 1, 0, 0, 0, 0], 586.92),
]


@pytest.mark.parametrize(("turns", "steps", "remainder"), CHAMFERED)
def test_what_moves_past_a_leaning_step_ends_there_if_one_of_its_corners_is_sharp_as_in_the_runtime(
    turns, steps, remainder
):
    assert _pieces(_front(turns, 1.0), steps)[-1][1] == pytest.approx(remainder, abs=0.01)


@pytest.mark.parametrize("edge", range(6))
@pytest.mark.parametrize("steps", [[0, 0, 4, 4, 0, 0], [0, 0.5, 4, 1.5, 0, 0], [0, 0.5, 4, 1.6, 0, 0], [4.0] * 6])
def test_a_corner_in_a_straight_edge_changes_no_areas(steps, edge):
    ring, groups = STEP, np.arange(6)
    parted = np.insert(ring, edge + 1, ring[[edge, (edge + 1) % 6]].mean(axis=0), axis=0)
    result = _pieces(parted, np.insert(steps, edge, steps[edge]), np.insert(groups, edge, edge))
    assert [piece[:2] for piece in result] == [piece[:2] for piece in _pieces(ring, steps, groups)]


@pytest.mark.parametrize("steps", [[math.inf] * 6, [0, 0, math.inf, math.inf, 0, 0], [1, math.inf, 1, 1, 0.5, 1]])
def test_infinite_distances_are_as_very_large_ones(steps):
    assert _pieces(STEP, steps) == _pieces(STEP, np.minimum(steps, 1e9)) == _pieces(STEP, np.minimum(steps, 1e17))


def _oblique(number):
    """A star of 5 to 8 corners of about 30 m, with distances some of which are infinite."""
    randomness = np.random.default_rng(number)
    count = randomness.integers(5, 9)
    angles = 2.0 * math.pi * (np.arange(count) + randomness.uniform(0.0, 0.8, count)) / count
    ring = randomness.uniform(4.0, 18.0, (count, 1)) * np.column_stack([np.cos(angles), np.sin(angles)])
    return ring.round(1), np.where(
        randomness.random(count) < 0.3, math.inf, randomness.choice([0.0, 0.5, 2.0, 4.0], count)
    )


PENTAGON = np.array([(14.8, 10.1), (-0.9, 6), (-7.8, -5.2), (-14.9, -12.2), (-4.2, -6.7)])
HEPTAGON = np.array([(-2, 8), (-18, -9), (-12, -9), (-5, -5), (2, -5), (5, -7), (12, -1)], float)


def test_infinite_distances_beside_others_fill_lots_of_any_angles_as_large_ones_do():
    cases = [(PENTAGON, [4, math.inf, 4, 4, 4]), (HEPTAGON, [4, 2, 4, 4, 4, math.inf, 2]), *map(_oblique, range(60))]
    for ring, steps in cases:
        areas = []
        for longest in (math.inf, 3e5):
            result = setback(lots([ring]), np.minimum(steps, longest))
            areas.append(np.bincount(result.group + 1, signed(result.meshes), len(ring) + 1))
        assert areas[0].sum() == pytest.approx(area(ring), rel=1e-6)
        # In the time that the longest take over 30 m, others move by less than 1 mm, along 30 m of bounds.
        np.testing.assert_allclose(areas[0], areas[1], atol=0.03)


@QUICK
@given(st.lists(st.floats(0.0, 4.0), min_size=4, max_size=4), st.lists(st.integers(-1, 2), min_size=4, max_size=4))
def test_the_rectangle_formula_agrees_with_the_sweep(steps, groups):
    # A corner in the middle of the last edge keeps the sweep from taking the short cut.
    longer = np.append(LOT, [[12.0, 0.0]], axis=0)
    fast = setback(lots([LOT]), np.array(steps), np.array(groups))
    slow = setback(lots([longer]), np.array([*steps, steps[3]]), np.array([*groups, groups[3]]))
    for name in {*groups, REMAINDER}:
        first, second = (signed(result.meshes)[result.group == name] for result in (fast, slow))
        assert first == pytest.approx(second, abs=1e-7)
    assert signed(fast.meshes).sum() == pytest.approx(360.0)


def test_neighbouring_strips_of_a_group_are_one_piece():
    # As CityEngine gives it: one U of eight corners, and the remainder.
    result = setback(lots([LOT]), np.array([4.0, 0.0, 4.0, 4.0]), np.zeros(4, int))
    assert result.group.tolist() == [0, REMAINDER]
    assert np.diff(result.meshes.face_offsets).tolist() == [8, 4]
    assert signed(result.meshes) == pytest.approx([184.0, 176.0])


def test_strips_that_do_not_touch_are_two_pieces():
    result = setback(lots([LOT]), np.array([4.0, 0.0, 4.0, 0.0]), np.zeros(4, int))
    assert result.group.tolist() == [0, 0, REMAINDER]
    assert signed(result.meshes) == pytest.approx([48.0, 48.0, 264.0])


def test_a_strip_all_around_has_a_keyhole():
    result = setback(lots([LOT, LOT_L]), np.full(10, 2.0), np.zeros(10, int))
    assert np.diff(result.meshes.mesh_faces).tolist() == [2, 2]
    assert np.diff(result.meshes.face_offsets).tolist() == [10, 4, 14, 6]
    assert signed(result.meshes) == pytest.approx([152.0, 208.0, 176.0, 316.0])


def test_strips_that_meet_leave_no_remainder():
    result = setback(lots([LOT]), np.array([3.0, 9.0, 4.0, 4.0]), np.zeros(4, int))
    assert result.group.tolist() == [0]
    assert signed(result.meshes) == pytest.approx([360.0])


def test_no_distance_leaves_the_whole_as_remainder():
    lot = lots([LOT, LOT_L])
    for result in (setback(lot, np.zeros(10)), setback(lot, np.ones(10), np.full(10, REMAINDER))):
        assert result.group.tolist() == [REMAINDER, REMAINDER]
        assert result.meshes.points.tolist() == lot.points.tolist()


@pytest.mark.parametrize(
    ("turn", "moved", "end"),
    [  # where the strip ends, from the corner in metres, as in the runtime
        (-60.0, 0, (-1.155, 2.0)),
        (-45.1, 0, (-1.993, 2.0)),
        (-44.9, 0, (0.826, 2.0)),
        (-32.0, 0, (0.573, 2.0)),
        (-32.0, 1, (0.573, 2.0)),
        (-46.0, 1, (2.780, 0.0)),
        (2.0, 0, (-0.035, 2.0)),
        (14.9, 0, (-0.261, 2.0)),
        (16.0, 0, (6.975, 2.0)),
        (20.0, 1, (-5.848, 0.0)),
        (60.0, 0, (1.155, 2.0)),
    ],
)
def test_a_strip_ends_on_the_line_of_an_edge_that_stays_or_on_the_bisector_of_a_blunt_corner(turn, moved, end):
    corner, angle = np.array([10.0, 0.0]), math.radians(turn)
    bend = corner + 10.0 * np.array([math.cos(angle), math.sin(angle)])
    last = [(10.0, 30.0)] if turn > 0.0 else [(35.0, bend[1] - 2.0), (35.0, 20.0)]
    ring = np.array([(0.0, 0.0), corner, bend, *last, (0.0, 30.0)])
    distances = np.zeros(len(ring))
    distances[moved] = 2.0
    result = setback(lots([ring]), distances)
    rest = np.flatnonzero(result.group == REMAINDER)
    points = result.meshes.points[result.meshes.corner_points()[result.meshes.face_offsets[rest[0]] :]][:, [0, 2]]
    expected = np.array([corner[0] + end[0], -end[1]])
    assert np.abs(points - expected).max(axis=1).min() < 2e-3


def test_what_has_swept_past_a_reflex_corner_is_taken_along_by_the_edge_that_comes_up_to_it():
    # The foot of a T in steps of 3, 0 and 4 m: the right side sweeps all behind it, as in the runtime.
    ring = np.array([(0, 0), (3, 0), (3, 1.5), (3, 9), (-10, 9), (-10, 1.5), (0, 1.5)], float)
    result = setback(lots([ring]), np.array([3.0, 4, 4, 0, 0, 0, 0]), np.zeros(7, int))
    rest = result.meshes.points[result.meshes.corner_points()[result.meshes.face_offsets[-2] :]][:, [0, 2]]
    assert sorted(np.round(rest, 9).tolist()) == [[-10.0, -9.0], [-10.0, -1.5], [-1.0, -9.0], [-1.0, -1.5]]


def wings(meshes: Meshes, **depths: np.ndarray | float) -> Setback:
    """Wings along some sides as group 0, the rest as `REMAINDER`."""
    distances = wing_depths(meshes, depths)
    return setback(meshes, distances, np.zeros(len(distances), dtype=np.int64))


def test_shapes_l_u_o_have_wings_at_their_sides():
    for depths, area_of_wings in (
        ({"front": 3.0, "left": 4.0}, 126.0),
        ({"front": 3.0, "right": 2.0, "left": 4.0}, 144.0),
        ({"front": 3.0, "right": 2.0, "back": 1.0, "left": 4.0}, 168.0),
    ):
        result = wings(lots([LOT]), **depths)
        assert result.group.tolist() == [0, REMAINDER]
        assert signed(result.meshes) == pytest.approx([area_of_wings, 360.0 - area_of_wings])


@QUICK
@given(simple, st.lists(st.floats(0.0, 0.5), min_size=4, max_size=4))
def test_shape_and_remainder_are_the_whole(ring, depths):
    front, right, back, left = np.array(depths) * math.sqrt(area(ring))
    result = wings(lots([ring]), front=front, right=right, back=back, left=left)
    assert signed(result.meshes).sum() == pytest.approx(area(ring), rel=1e-6)


def test_depths_may_differ_from_mesh_to_mesh():
    result = wings(lots([LOT, LOT]), front=np.array([3.0, 0.0]), left=np.array([0.0, 4.0]))
    assert signed(result.meshes) == pytest.approx([90.0, 270.0, 48.0, 312.0])


def test_edge_normals_point_out_of_the_face():
    assert edge_normals(lots([LOT])) == pytest.approx(np.array([[-1, 0, 0], [0, 0, 1], [1, 0, 0], [0, 0, -1]]))


def test_strips_run_around_holes_too():
    points = np.array([[0, 0, 0], [0, 0, 9], [9, 0, 9], [9, 0, 0], [3, 0, 3], [6, 0, 3], [6, 0, 6], [3, 0, 6.0]])
    frame = Meshes.single(points, [(0, 1, 2, 3, 0, 4, 5, 6, 7, 4)])
    result = setback(frame, np.ones(10), np.zeros(10, int))
    assert result.group.tolist() == [0, 0, REMAINDER]
    assert signed(result.meshes) == pytest.approx([32.0, 16.0, 24.0])


def test_faces_that_are_no_simple_polygons_are_their_own_remainder():
    bow_tie = np.array([(0, 0), (4, 3), (4, 0), (0, 1)], float)
    line = np.array([(0, 0), (1, 0), (2, 0)], float)
    result = setback(lots([bow_tie, line]), np.ones(7))
    assert result.group.tolist() == [REMAINDER, REMAINDER]
    assert result.meshes.points.tolist() == lots([bow_tie, line]).points.tolist()


def test_negative_distances_and_nan_leave_edges_where_they_are():
    result = setback(lots([LOT]), np.array([-1.0, np.nan, 0.0, 0.0]))
    assert result.group.tolist() == [REMAINDER]


def test_no_meshes_give_no_pieces():
    nothing = lots([LOT]).take(np.zeros(0, int))
    result = setback(nothing, np.zeros(0))
    assert (len(result.meshes), len(result.group)) == (0, 0)


def test_a_reflex_corner_beside_an_edge_that_stays_is_a_corner_of_the_remainder():
    outline = np.array([[0, 0, 0], [0, 0, 12], [8, 0, 12], [8, 0, 22], [26, 0, 22], [26, 0, 0.0]])
    lot = Meshes.from_polygons(outline, np.array([6]))
    remainder = setback(lot, np.array([0.0, 3, 0, 3, 0, 0])).meshes
    lengths = np.linalg.norm(measure.corner_edges(remainder), axis=1)[remainder.face_offsets[-2] :]
    assert lengths == pytest.approx([9, 8, 3, 7, 18, 19, 26])  # from the runtime
