import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import DerivationError
from grammarlab.geometry.meshes import measure
from grammarlab.geometry.meshes.edges import edges
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.outlines.roofs import roof_gable, roof_hip, roof_pyramid, roof_ridge, roof_shed
from tests.cases import bulk
from tests.geometry.polygons import LOT_L, area, combs, convex, lots, rectilinear, simple, stars

QUICK = bulk(40)
# Edges in order: left 12 m, front 30 m, right, back.
LOT = np.array([(0, 0), (0, -12), (30, -12), (30, 0)], float)
FRAME = Meshes.single(
    np.array([[0, 0, 0], [0, 0, 9], [9, 0, 9], [9, 0, 0], [3, 0, 3], [6, 0, 3], [6, 0, 6], [3, 0, 6.0]]),
    [(0, 1, 2, 3, 0, 4, 5, 6, 7, 4)],
)
FORMS = {
    "hip": lambda lot: roof_hip(lot, 40.0),
    "hip with overhang": lambda lot: roof_hip(lot, 40.0, overhang=0.1),
    "hip, even": lambda lot: roof_hip(lot, 40.0, even=True),
    "gable": lambda lot: roof_gable(lot, 40.0),
    "gable with overhangs": lambda lot: roof_gable(lot, 40.0, overhang_x=0.1, overhang_y=0.2),
    "gable with eaves": lambda lot: roof_gable(lot, 40.0, overhang_x=0.1),
    "gable with verges": lambda lot: roof_gable(lot, 40.0, overhang_y=0.1),
    "gable, even": lambda lot: roof_gable(lot, 40.0, even=True),
    "gable over an edge": lambda lot: roof_gable(lot, 40.0, index=1),
    "shed": lambda lot: roof_shed(lot, 40.0),
    "falling shed": lambda lot: roof_shed(lot, -40.0, index=1),
    "ridge": lambda lot: roof_ridge(lot, 40.0),
}
OVERHANGS = st.sampled_from([0.0, 0.1, 0.5])
UNDERSIDE = -0.99
every_form = pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
CLOSED = {name: form for name, form in FORMS.items() if "with" not in name}
every_closed_form = pytest.mark.parametrize("form", CLOSED.values(), ids=CLOSED)


def underside_area(meshes):
    vectors = measure.area_vectors(meshes)
    lengths = np.linalg.norm(vectors, axis=1)
    return -vectors[(vectors[:, 1] <= UNDERSIDE * lengths) & (lengths > 0.0), 1].sum()


def face_points(meshes, face):
    return meshes.points[meshes.corner_points()][meshes.face_offsets[face] : meshes.face_offsets[face + 1]]


@every_closed_form
@bulk(25)
@given(ring=simple)
def test_roofs_are_closed_solids_over_the_whole_face(form, ring):
    roof = form(lots([ring]))
    size = math.sqrt(area(ring))
    assert measure.is_closed(roof).all()
    assert np.isfinite(roof.points).all()
    assert measure.volumes(roof)[0] > 1e-4 * size**3
    looks_up = measure.area_vectors(roof)[:, 1]
    assert looks_up.sum() == pytest.approx(0.0, abs=1e-6 * size**2)
    assert underside_area(roof) == pytest.approx(area(ring), rel=1e-6)


@every_closed_form
@bulk(25)
@given(ring=st.one_of(stars(), rectilinear(), combs()))
def test_exactly_two_faces_meet_at_every_edge_of_a_roof(form, ring):
    assert (edges(form(lots([ring]))).num_faces == 2).all()


@every_closed_form
def test_roofs_over_faces_with_holes_are_closed_solids(form):
    roof = form(FRAME)
    assert measure.is_closed(roof).all()
    assert measure.volumes(roof)[0] > 10.0
    assert underside_area(roof) >= 72.0 - 1e-9


@every_form
def test_a_roof_has_the_same_bits_alone_and_in_a_batch(form):
    lot = lots([LOT, LOT_L, LOT * 1.7, LOT[:, ::-1] * [-1, 1], LOT_L * 0.3, LOT])
    together = form(lot)
    for i in range(len(lot)):
        alone, taken = form(lot.take(np.array([i]))), together.take(np.array([i]))
        assert alone.points.tobytes() == taken.points.tobytes()
        assert alone.corners.tolist() == taken.corners.tolist()


@every_form
@pytest.mark.parametrize(
    "ring",
    [[(0, 0), (4, 3), (4, 0), (0, 1)], [(0, 0), (1, 0), (2, 0)], [(1, 1), (1, 1), (1, 1)]],
    ids=["bow tie", "line", "point"],
)
def test_degenerate_faces_give_finite_roofs(form, ring):
    roof = form(lots([np.array(ring, float)]))
    assert np.isfinite(roof.points).all()
    assert len(roof) == 1


@QUICK
@given(simple, st.floats(5.0, 75.0))
def test_hip_slopes_have_the_angle_and_begin_with_their_edges(ring, angle):
    lot = lots([ring])
    roof = roof_hip(lot, angle)
    heights = measure.face_normals(roof)[1:, 1]
    assert np.degrees(np.arccos(heights)) == pytest.approx(np.full(len(heights), angle), abs=1e-3)
    corners = lot.points.tolist()
    edge_of = {(*corners[edge], *corners[(edge + 1) % len(ring)]): edge for edge in range(len(ring))}
    slopes = []
    for face in range(1, roof.num_faces):
        points = face_points(roof, face).tolist()
        pairs = [(*a, *b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
        slopes.append([edge_of[pair] for pair in pairs if pair in edge_of])
        assert pairs[0] in edge_of
    assert sorted(edge for slope in slopes for edge in slope) == list(range(len(ring)))
    assert [slope[0] for slope in slopes] == sorted(min(slope) for slope in slopes)
    for first, *others in slopes:
        away = ring[others] - ring[first]
        along = ring[(first + 1) % len(ring)] - ring[first]
        assert np.allclose(away[:, 0] * along[1], away[:, 1] * along[0], atol=1e-3)
    assert face_points(roof, 0)[:2].tolist() == lot.points[[1, 0]].tolist()


# Square metres of the slopes of roofs of 5 m that another CGA runtime has measured, in its order.
WINGS = {
    "one wing": (
        [(0, 0), (0, 10), (10, 10), (10, 24), (19, 24), (19, 10), (33, 10), (33, 0)],
        [35.355, 169.352, 89.095, 28.638, 89.095, 35.355, 197.990],
    ),
    "a wing that rises above the ridge": (
        [(0, 0), (0, 10), (10, 10), (10, 24), (24, 24), (24, 10), (33, 10), (33, 0)],
        [30.723, 61.445, 115.517, 60.216, 115.517, 55.301, 30.723, 176.962],
    ),
    "two wings": (
        [(0, 0), (0, 8), (8, 8), (8, 20), (14, 20), (14, 8), (20, 8), (20, 20), (26, 20), (26, 8), (36, 8), (36, 0)],
        [25.612, 176.086, 57.628, 14.407, 57.628, 57.628, 14.407, 57.628, 25.612, 204.900],
    ),
    "a small and a large wing": (
        [(0, 0), (0, 8), (8, 8), (8, 20), (14, 20), (14, 8), (20, 8), (20, 26), (32, 26), (32, 8), (40, 8), (40, 0)],
        [20.827, 92.421, 46.861, 11.715, 46.861, 135.378, 46.861, 135.378, 41.655, 20.827, 192.653],
    ),
}


@pytest.mark.parametrize(("corners", "areas"), WINGS.values(), ids=WINGS)
def test_slopes_on_one_line_that_meet_above_a_wing_are_one(corners, areas):
    roof = roof_hip(lots([np.array(corners, float)[:, ::-1]]), 5.0, by="height")
    assert measure.face_areas(roof)[1:] == pytest.approx(areas, abs=0.001)


@QUICK
@given(simple, st.floats(5.0, 75.0))
def test_hip_slopes_have_the_area_of_the_face_over_the_cosine(ring, angle):
    roof = roof_hip(lots([ring]), angle)
    slopes = measure.face_areas(roof)[1:].sum()
    assert slopes * math.cos(math.radians(angle)) == pytest.approx(area(ring), rel=1e-6)


@QUICK
@given(st.floats(0.1, 50.0), st.floats(0.1, 50.0), st.floats(5.0, 75.0))
def test_rectangular_roofs_have_the_volumes_of_the_textbook(width, depth, angle):
    ring = np.array([(0, 0), (width, 0), (width, depth), (0, depth)])
    long, short = max(width, depth), min(width, depth)
    height = 0.5 * short * math.tan(math.radians(angle))
    gable = 0.5 * short * height * long
    assert measure.volumes(roof_gable(lots([ring]), angle)) == pytest.approx([gable])
    assert measure.volumes(roof_hip(lots([ring]), angle)) == pytest.approx([gable - short * short * height / 6.0])


@QUICK
@given(st.floats(1.0, 50.0), st.floats(1.0, 50.0), OVERHANGS, OVERHANGS, st.booleans())
def test_rectangle_formulas_agree_with_the_skeleton(width, depth, overhang_x, overhang_y, is_hip):
    # Doubling the first corner keeps the skeleton from taking the short cut.
    ring = np.array([(0, 0), (width, 0), (width, depth), (0, depth)])
    doubled = np.append(ring, ring[:1], axis=0)

    def roof(corners):
        lot = lots([corners])
        if is_hip:
            return roof_hip(lot, 40.0, overhang=overhang_x)
        return roof_gable(lot, 40.0, overhang_x=overhang_x, overhang_y=overhang_y)

    fast, slow = roof(ring), roof(doubled)
    assert fast.num_faces == slow.num_faces
    for face in range(fast.num_faces):
        first, second = face_points(fast, face), face_points(slow, face)
        assert sorted(map(tuple, first.round(6) + 0.0)) == sorted(set(map(tuple, second.round(6) + 0.0)))


@pytest.mark.parametrize("roof", [roof_hip, roof_gable, roof_pyramid, roof_shed, roof_ridge])
@bulk(25)
@given(ring=simple, share=st.floats(0.05, 2.0))
def test_roofs_by_height_are_that_high(roof, ring, share):
    height = share * math.sqrt(area(ring))
    _, high = roof(lots([ring]), height, "height").bounds()
    assert high[0, 1] == pytest.approx(height)


@QUICK
@given(convex(), st.floats(10.0, 60.0), st.floats(0.01, 0.3))
def test_overhangs_continue_the_slopes_by_their_length(ring, angle, overhang):
    plain, wide = roof_hip(lots([ring]), angle), roof_hip(lots([ring]), angle, overhang=overhang)
    low, _ = wide.bounds()
    assert low[0, 1] == pytest.approx(-overhang * math.sin(math.radians(angle)))
    assert measure.face_normals(wide) == pytest.approx(measure.face_normals(plain), abs=1e-6)


def test_overhangs_on_a_rectangle_have_their_measures():
    roof = roof_gable(lots([LOT]), 30.0, overhang_x=2.0, overhang_y=1.0)
    low, high = roof.bounds()
    out, drop = 2.0 * math.cos(math.radians(30.0)), 2.0 * math.sin(math.radians(30.0))
    assert low[0] == pytest.approx([-1.0, -drop, -out])
    assert high[0] == pytest.approx([31.0, 6.0 * math.tan(math.radians(30.0)), 12.0 + out])


@QUICK
@given(st.floats(4.0, 50.0), st.floats(4.0, 50.0), st.floats(10.0, 60.0), st.floats(-1.0, 1.0))
def test_overhangs_on_a_rectangle_move_the_lower_ends_of_slopes_both_ways(width, depth, angle, overhang):
    roof = roof_hip(lots([np.array([(0, 0), (width, 0), (width, depth), (0, depth)])]), angle, overhang=overhang)
    slopes = measure.face_areas(roof)[1:].sum()
    out = 2.0 * overhang * math.cos(math.radians(angle))
    assert slopes * math.cos(math.radians(angle)) == pytest.approx((width + out) * (depth + out))
    assert measure.face_areas(roof)[0] == pytest.approx(width * depth)


def test_a_triangle_has_no_gables():
    triangle = lots([np.array([(0, 0), (10, 0), (4, 7)], float)])
    assert np.array_equal(roof_gable(triangle, 30.0).points, roof_hip(triangle, 30.0).points)


def test_overhangs_have_no_undersides():
    roof = roof_gable(lots([LOT, LOT_L]), 30.0, overhang_x=2.0, overhang_y=1.0)
    assert np.diff(roof.mesh_faces).tolist() == [5, 7]
    assert not measure.is_closed(roof).any()


def test_overhangs_in_a_narrow_notch_do_not_run_into_each_other():
    notch = np.array([(0, 0), (10, 0), (10, 10), (5.5, 10), (5.5, 4), (4.5, 4), (4.5, 10), (0, 10)], float)
    roof = roof_hip(lots([notch]), 45.0, overhang=3.0)
    low, high = roof.bounds()
    assert low[0, 1] == pytest.approx(-0.5, abs=0.01)
    assert high[0, 0] == pytest.approx(10.5, abs=0.01)


def test_an_l_has_gables_at_the_ends_of_its_wings():
    roof = roof_gable(lots([LOT_L]), 45.0)
    is_vertical = np.abs(measure.face_normals(roof)[:, 1]) < 1e-9
    assert np.flatnonzero(is_vertical).tolist() == [1, 4]
    assert measure.volumes(roof) == pytest.approx([1899.0])


def test_a_rectangle_has_gables_at_its_short_edges_unless_told_otherwise():
    def gables(**options):
        roof = roof_gable(lots([LOT]), 45.0, **options)
        return (np.flatnonzero(np.abs(measure.face_normals(roof)[:, 1]) < 1e-9) - 1).tolist()

    assert gables() == [0, 2]
    assert [gables(index=index) for index in (0, 1, 2, -1)] == [[0, 2], [1, 3], [0, 2], [1, 3]]


def test_the_ridge_of_a_square_runs_along_its_first_edge():
    square = np.array([(0, 0), (0, -6), (6, -6), (6, 0)], float)
    for ring in (square, np.insert(square, 2, (3, -6), axis=0)):
        roof = roof_gable(lots([ring]), 45.0)
        ridge = roof.points[roof.points[:, 1] > 2.9]
        assert np.ptp(ridge, axis=0) == pytest.approx([0.0, 0.0, 6.0])


def test_a_slope_that_only_has_the_area_of_a_triangle_is_no_gable():
    ring = np.array([(4, 2), (4, 1), (1, 1), (1, 0), (5, 0), (5, 1), (7, 1), (7, -3), (9, -3), (9, 2)], float)
    roof = roof_gable(lots([ring]), 45.0)
    assert np.abs(measure.face_normals(roof)[10, 1]) == pytest.approx(math.cos(math.radians(45.0)))


def test_straight_corners_do_not_keep_a_wing_from_its_gable():
    ring = np.array([(0, 0), (0, -5), (0, -12), (30, -12), (30, 0)], float)
    roof = roof_gable(lots([ring]), 45.0)
    assert np.flatnonzero(np.abs(measure.face_normals(roof)[:, 1]) < 1e-9).tolist() == [1, 2, 4]
    assert measure.volumes(roof) == pytest.approx([1080.0])


def test_an_even_hip_on_a_trapezoid_has_a_level_ridge_at_the_mean_height():
    trapezoid = np.array([(0, 0), (30, -2), (30, 10), (0, 8)], float)
    uneven, even = roof_hip(lots([trapezoid]), 45.0), roof_hip(lots([trapezoid]), 45.0, even=True)
    first, second = (np.sort(roof.points[roof.points[:, 1] > 1.0, 1]) for roof in (uneven, even))
    assert np.ptp(first) > 0.5
    assert second == pytest.approx([first.mean()] * 2)


def test_even_changes_nothing_where_ridges_are_level():
    for roof in (roof_hip, roof_gable):
        first, second = roof(lots([LOT_L]), 45.0), roof(lots([LOT_L]), 45.0, even=True)
        assert first.points == pytest.approx(second.points)


@QUICK
@given(simple, st.floats(0.1, 5.0))
def test_pyramids_have_a_third_of_the_prism(ring, share):
    height = share * math.sqrt(area(ring))
    roof = roof_pyramid(lots([ring]), height, "height")
    assert measure.is_closed(roof).all()
    assert roof.num_faces == len(ring) + 1
    assert measure.volumes(roof) == pytest.approx([area(ring) * height / 3.0], rel=1e-6)


@QUICK
@given(simple, st.floats(5.0, 75.0))
def test_a_pyramid_has_its_tip_over_the_mean_corner_and_the_angle_from_the_middle_of_the_first_edge(ring, angle):
    roof = roof_pyramid(lots([ring]), angle)
    tip = roof.points[roof.points[:, 1].argmax()]
    corners = lots([ring]).points
    assert tip[[0, 2]] == pytest.approx(corners.mean(axis=0)[[0, 2]], abs=1e-6)
    run = np.linalg.norm((tip - corners[:2].mean(axis=0))[[0, 2]])
    assert tip[1] == pytest.approx(run * math.tan(math.radians(angle)), abs=1e-6)


@QUICK
@given(convex(), st.floats(5.0, 75.0), st.integers(-20, 20))
def test_sheds_rise_from_their_edge_at_the_angle(ring, angle, index):
    lot = lots([ring])
    roof = roof_shed(lot, angle, index=index)
    assert math.degrees(math.acos(measure.face_normals(roof)[1, 1])) == pytest.approx(angle, abs=1e-5)
    edge = index % len(ring)
    expected = [lot.points[edge].tolist(), lot.points[(edge + 1) % len(ring)].tolist()]
    assert face_points(roof, 1)[:2].tolist() == expected


def test_sheds_on_a_rectangle_have_half_the_prism_and_fall_when_negative():
    for value in (10.0, -10.0):
        roof = roof_shed(lots([LOT]), value, "height", index=1)
        assert measure.volumes(roof) == pytest.approx([1800.0])
        front = roof.points[roof.points[:, 2] > 11.9, 1]
        assert front.max() == pytest.approx(0.0 if value > 0.0 else 10.0)


def test_ridges_run_along_the_x_axis_whatever_the_shape():
    # The same for a rectangle and for one with a doubled corner, which takes the general way.
    for ring in (LOT, np.append(LOT, LOT[:1], axis=0), LOT_L):
        roof = roof_ridge(lots([ring]), 45.0)
        depth = np.ptp(ring[:, 1])
        top = roof.points[roof.points[:, 1] > 0.5 * depth - 1e-6]
        assert top[:, 1] == pytest.approx(np.full(2, 0.5 * depth))
        assert top[:, 2] == pytest.approx(np.full(2, 0.5 * depth))


def test_ridges_across_a_u_make_a_slope_on_each_leg():
    ring = np.array([(0, 0), (10, 0), (10, 10), (7, 10), (7, 3), (3, 3), (3, 10), (0, 10)], float)
    roof = roof_ridge(lots([ring]), 45.0)
    assert measure.is_closed(roof).all()
    normals = measure.face_normals(roof)
    assert np.count_nonzero(normals[:, 1] > 0.1) == 3


@pytest.mark.parametrize("roof", [roof_hip, roof_gable, roof_pyramid, roof_shed, roof_ridge])
def test_values_that_are_not_finite_are_refused(roof):
    for value in (math.nan, math.inf):
        with pytest.raises(DerivationError, match="finite"):
            roof(lots([LOT]), value)


@pytest.mark.parametrize("roof", [roof_hip, roof_gable, roof_pyramid, roof_shed, roof_ridge])
def test_upright_and_level_slopes_are_limited(roof):
    for angle in (0.0, 90.0, 400.0, -90.0):
        result = roof(lots([LOT, LOT_L]), angle)
        assert np.isfinite(result.points).all()
        assert measure.is_closed(result).all()


@pytest.mark.parametrize("roof", [roof_hip, roof_gable, roof_pyramid, roof_shed, roof_ridge])
def test_no_meshes_give_no_roofs(roof):
    assert len(roof(lots([LOT]).take(np.zeros(0, int)), 45.0)) == 0


def test_values_may_differ_from_mesh_to_mesh_and_stand_on_any_plane():
    upright = LOT @ np.array([[1, 0, 0], [0, -1, 0.0]])
    wall = Meshes.from_polygons(np.concatenate([upright[::-1], upright[::-1]]), np.array([4, 4]))
    roof = roof_hip(wall, np.array([3.0, 6.0]), "height")
    low, high = roof.bounds()
    assert (high - low)[:, 2] == pytest.approx([3.0, 6.0])
