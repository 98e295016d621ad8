import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes import measure
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.outlines.inner_rectangle import RECTANGLE, inner_rect, inner_rectangle, largest_rectangle
from grammarlab.geometry.outlines.setback import REMAINDER
from tests.geometry.polygons import LOT_L, area, combs, convex, lots, moved, rectilinear, stars

GRID = 1e-4
"""Metres of the grid on which rectangles along edges have their sides."""
QUICK = settings(max_examples=25, deadline=None)
LOT = np.array([(0, 0), (0, -12), (30, -12), (30, 0)], float)
FRAME = Meshes.single(
    np.array([[0, 0, 0], [0, 0, 9], [9, 0, 9], [9, 0, 0], [3, 0, 3], [6, 0, 3], [6, 0, 6], [3, 0, 6.0]]),
    [(0, 1, 2, 3, 0, 4, 5, 6, 7, 4)],
)
shapes = st.one_of(stars(12), rectilinear(), combs(), convex(8))


def signed(meshes):
    return measure.area_vectors(meshes)[:, 1]


def outlines(meshes):
    """Faces as seen from above."""
    corners = np.split(meshes.points[meshes.corner_points()][:, [0, 2]], meshes.face_offsets[1:-1])
    return [shapely.Polygon(ring) for ring in corners]


def extent(rectangle):
    return float(np.prod(rectangle[1] - rectangle[0]))


def found_in(ring):
    rectangle = largest_rectangle([ring])
    assert rectangle is not None
    return rectangle


@QUICK
@given(shapes)
def test_the_largest_rectangle_lies_inside(ring):
    rectangle = found_in(ring)
    (left, low), (right, high) = rectangle.tolist()
    outside = shapely.box(left, low, right, high).difference(shapely.Polygon(ring))
    assert outside.area <= 1e-8 * area(ring)


@QUICK
@given(st.one_of(rectilinear(), combs()))
def test_in_rectilinear_polygons_no_rectangle_between_corners_is_larger(ring):
    polygon = shapely.Polygon(ring)
    x, y = (np.unique(ring[:, i]) for i in range(2))
    sides = [*itertools.product(itertools.combinations(x, 2), itertools.combinations(y, 2))]
    boxes = shapely.box(*np.array([(left, low, right, high) for (left, right), (low, high) in sides]).T)
    inside = boxes[shapely.covers(polygon, boxes)]
    assert extent(found_in(ring)) == pytest.approx(shapely.area(inside).max())


@pytest.mark.parametrize("first", range(3))
def test_of_the_equal_rectangles_of_a_triangle_the_one_on_the_longest_edge_is_used(first):
    triangle = np.roll(np.array([(0, 0), (2, -11), (15, -3.0)]), first, axis=0)
    longest = np.array([15, -3]) / np.hypot(15, -3)
    result = inner_rectangle(lots([triangle]), "edge")
    corners = result.meshes.points[result.meshes.corner_points()[:4]][:, [0, 2]]
    along = (np.roll(corners, -1, axis=0) - corners) @ (longest * [1, -1])
    assert sorted(np.abs(along)) == pytest.approx([0, 0, *[0.5 * np.hypot(15, 3)] * 2], abs=2 * GRID)


@QUICK
@given(st.one_of(stars(9), convex(8)), st.integers(0, 2**32 - 1))
def test_no_random_rectangle_inside_is_larger(ring, seed):
    polygon = shapely.Polygon(ring)
    best = found_in(ring)
    random = np.random.default_rng(seed)
    anywhere = random.uniform(ring.min(axis=0), ring.max(axis=0), (2000, 2, 2))
    near = best + random.normal(0.0, 0.02, (2000, 2, 2))
    sides = np.concatenate([anywhere, near])
    boxes = shapely.box(*np.concatenate([sides.min(axis=1), sides.max(axis=1)], axis=1).T)
    inside = boxes[shapely.covers(polygon, boxes)]
    assert shapely.area(inside).max(initial=0.0) <= extent(best) * (1.0 + 1e-9)


def test_textbook_polygons_have_their_known_largest_rectangles():
    triangle = np.array([(0, 0), (4, 0), (2, 3)], float)
    assert found_in(triangle) == pytest.approx(np.array([(1, 0), (3, 1.5)]))
    turns = 2.0 * math.pi * np.arange(32) / 32
    disk = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    assert extent(found_in(disk)) == pytest.approx(2.0)
    assert found_in(LOT_L) == pytest.approx(np.array([(8, -22), (26, 0)]))


def test_of_equal_rectangles_the_one_nearest_the_centroid_is_taken():
    rake = np.array(
        [(0, 0), (12, 0), (12, 11), (10, 11), (10, 1), (7, 1), (7, 11), (5, 11), (5, 1), (2, 1), (2, 11), (0, 11)]
    )
    assert found_in(rake.astype(float)) == pytest.approx(np.array([(5, 0), (7, 11)]))


SYMMETRIC = {
    "L": [(0, 0), (10, 0), (10, 3), (3, 3), (3, 10), (0, 10)],
    "U": [(0, 0), (10, 0), (10, 20), (7, 20), (7, 3), (3, 3), (3, 20), (0, 20)],
    "narrow U": [(0, 0), (10, 0), (10, 20), (7, 20), (7, 2), (3.00005, 2), (3.00005, 20), (0, 20)],
    "plus": [(4, 0), (8, 0), (8, 4), (12, 4), (12, 8), (8, 8), (8, 12), (4, 12), (4, 8), (0, 8), (0, 4), (4, 4)],
}


@pytest.mark.parametrize("name", SYMMETRIC)
@pytest.mark.parametrize("alignment", ["scope", "edge"])
def test_the_remainder_leaves_out_the_rectangle_that_was_chosen_among_equal_ones(name, alignment):
    for degrees in range(0, 46, 5):
        x, y = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        lot = lots([np.array(SYMMETRIC[name], float) @ np.array([[x, y], [-y, x]])])
        result = inner_rectangle(lot, alignment)
        assert result.group[0] == RECTANGLE
        (face,) = outlines(lot)
        rectangle, *rest = outlines(result.meshes)
        reach = 1e-8 if alignment == "scope" else math.sqrt(2.0) * GRID
        gap = reach * rectangle.length
        assert rectangle.intersection(shapely.union_all(rest)).area <= gap
        assert face.difference(shapely.union_all([rectangle, *rest])).area <= gap
        assert face.buffer(reach, join_style="mitre").covers(rectangle)


@QUICK
@given(st.one_of(shapes, moved(stars(9)), moved(rectilinear())), st.sampled_from(["scope", "edge"]))
def test_rectangle_and_remainder_are_the_whole(ring, alignment):
    result = inner_rectangle(lots([ring]), alignment)
    assert np.count_nonzero(result.group == RECTANGLE) == 1
    assert (signed(result.meshes) > 0.0).all()
    rectangle = result.meshes.points[result.meshes.corner_points()][:4]
    sides = np.roll(rectangle, -1, axis=0) - rectangle
    size = np.linalg.norm(sides, axis=1)
    gap = GRID * size.sum() if alignment == "edge" else 0.0
    assert signed(result.meshes).sum() == pytest.approx(area(ring), abs=1e-6 * area(ring) + gap)
    assert (sides * np.roll(sides, -1, axis=0)).sum(axis=1) == pytest.approx(np.zeros(4), abs=1e-6 * size.max() ** 2)


@QUICK
@given(st.one_of(stars(9), rectilinear()))
def test_aligning_to_edges_tries_the_direction_of_every_long_edge(ring):
    result = inner_rectangle(lots([ring]), "edge")
    along = np.roll(ring, -1, axis=0) - ring
    length = np.hypot(*along.T)
    expected = 0.0
    for x, y in (along / length[:, None])[length > 0.25 * length.max()]:
        expected = max(expected, extent(found_in(ring @ np.array([[x, -y], [y, x]]))))
    gap = GRID * 2.0 * np.ptp(ring, axis=0).sum()
    assert expected - gap <= signed(result.meshes)[0] <= expected + gap


def test_only_faces_larger_than_the_grid_have_their_rectangles_on_it():
    for size, on_grid in ((1.0, True), (1e-6, False)):
        result = inner_rectangle(lots([LOT_L * size]), "edge")
        sides = np.ptp(result.meshes.points[result.meshes.corner_points()][:4], axis=0)[[0, 2]]
        short = np.array([18.0, 22.0]) * size - sides
        assert short == pytest.approx([GRID, GRID] if on_grid else [0.0, 0.0], abs=1e-9)


def test_a_rectangle_is_its_own_inner_rectangle():
    turned = LOT @ np.array([[0.8, 0.6], [-0.6, 0.8]])
    result = inner_rectangle(lots([LOT, turned]), "edge")
    assert result.group.tolist() == [RECTANGLE, RECTANGLE]
    assert result.meshes.points.tolist() == lots([LOT, turned]).points.tolist()
    assert inner_rectangle(lots([LOT, turned]), "scope").group[0] == RECTANGLE
    assert REMAINDER in inner_rectangle(lots([LOT, turned]), "scope").group


def test_the_rectangle_begins_along_the_first_edge():
    result = inner_rectangle(lots([LOT_L]), "scope")
    points = result.meshes.points[result.meshes.corner_points()][:4]
    assert points == pytest.approx(np.array([[8, 0, 0], [8, 0, 22], [26, 0, 22], [26, 0, 0]]))
    assert signed(result.meshes) == pytest.approx([396.0, 96.0])


def test_the_remainder_keeps_the_corners_of_the_face():
    lot = lots([LOT_L])
    result = inner_rectangle(lot, "scope")
    points = result.meshes.points[result.meshes.corner_points()][4:]
    assert points[:3].tolist() == lot.points[:3].tolist()


def test_a_rectangle_in_the_middle_leaves_a_keyhole():
    rhombus = np.array([(0, -2), (3, 0), (0, 2), (-3, 0)], float)
    result = inner_rectangle(lots([rhombus]), "scope")
    assert signed(result.meshes).tolist() == pytest.approx([6.0, 1.5, 1.5, 1.5, 1.5])
    frame = inner_rectangle(FRAME, "scope")
    assert signed(frame.meshes) == pytest.approx([27.0, 45.0])


def test_slanted_faces_get_rectangles_as_seen_along_the_nearest_axis():
    # A roof plane over LOT_L: as seen from above, the same rectangle.
    lot = lots([LOT_L])
    slanted = lot.with_points(lot.points + np.outer(lot.points[:, 2], [0.0, 0.5, 0.0]))
    flat, tilted = (inner_rectangle(each, "scope").meshes for each in (lot, slanted))
    assert tilted.points[:, [0, 2]] == pytest.approx(flat.points[:, [0, 2]])
    assert tilted.points[:, 1] == pytest.approx(0.5 * flat.points[:, 2])


@pytest.mark.parametrize("axes", [[0, 1, 2], [1, 2, 0], [2, 0, 1]])
@pytest.mark.parametrize("turned", [False, True])
def test_faces_may_look_along_any_axis(axes, turned):
    lot = lots([LOT_L])
    face = lot.with_points(lot.points[:, axes])
    result = inner_rectangle(face.reversed() if turned else face, "scope")
    assert measure.face_areas(result.meshes) == pytest.approx([396.0, 96.0])
    expected = measure.face_normals(face)[0] * (-1.0 if turned else 1.0)
    assert measure.face_normals(result.meshes) == pytest.approx(np.array([expected] * 2))


def test_the_older_operation_leaves_only_rectangles():
    result = inner_rect(lots([LOT, LOT_L, np.array([(0, 0), (1, 0), (2, 0)], float)]))
    assert np.diff(result.mesh_faces).tolist() == [1, 1, 0]
    assert signed(result) == pytest.approx([360.0, 396.0])


def test_a_face_gives_the_same_bits_alone_and_in_a_batch():
    lot = lots([LOT, LOT_L, LOT * 1.3 + 1.0, LOT_L * 0.7])
    together = inner_rectangle(lot, "edge").meshes
    for i in range(len(lot)):
        alone = inner_rectangle(lot.take(np.array([i])), "edge").meshes
        assert alone.points.tobytes() == together.take(np.array([i])).points.tobytes()


def test_faces_that_are_no_simple_polygons_are_their_own_remainder():
    bow_tie = np.array([(0, 0), (4, 3), (4, 0), (0, 1)], float)
    line = np.array([(0, 0), (1, 0), (2, 0)], float)
    point = np.array([(1, 1), (1, 1), (1, 1)], float)
    for alignment in ("scope", "edge"):
        result = inner_rectangle(lots([bow_tie, line, point]), alignment)
        assert result.group.tolist() == [REMAINDER] * 3
        assert result.meshes.points.tolist() == lots([bow_tie, line, point]).points.tolist()


def test_no_meshes_give_no_pieces():
    nothing = lots([LOT]).take(np.zeros(0, int))
    assert len(inner_rectangle(nothing).meshes) == 0
    assert len(inner_rect(nothing)) == 0
