from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes.clip import slabs, trimmed
from grammarlab.geometry.meshes.extrude import extrude
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
from grammarlab.geometry.meshes.mesh import BORDER, Meshes
from grammarlab.geometry.meshes.primitives import box, cylinder, disk, quad, sphere
from grammarlab.geometry.meshes.triangulate import triangulate
from tests.derivation.operations.leaves import L_SHAPE, TRIANGLE, sampled, world_meshes
from tests.geometry.bodies import FRAME, prism, rotations, solids, turned
from tests.geometry.polygons import combs, convex, lots, rectilinear, simple, stars

QUICK = settings(max_examples=40, deadline=None)
axes = st.integers(0, 2)
shares = st.lists(
    st.one_of(st.floats(0.0, 1.0), st.sampled_from([0.25, 0.5, 0.75])), min_size=1, max_size=4, unique=True
)
GRID = st.integers(1, 7).map(lambda k: k / 8)
grid_prisms = st.one_of(rectilinear(), combs()).map(prism)
"""Solids with many faces in the planes of likely cuts."""

HOLLOW = Meshes.concatenate([box().with_points(3.0 * box().points), box().with_points(1.0 + box().points).reversed()])
"""A cube with a cubic hollow, as two meshes."""


def hollow_cube():
    """A closed mesh whose sections are squares with square holes."""
    corners = np.concatenate((HOLLOW.corners[:24], HOLLOW.corners[24:] + 8)).reshape(-1, 4)
    return Meshes.single(HOLLOW.points, corners.tolist())


def sliced(mesh, axis, cuts):
    """The mesh in slabs between its ends, cut at these shares of its extent."""
    low, high = mesh.bounds()
    marks = [0.0, *sorted(cuts), 1.0]
    levels = low[0, axis] + np.array(marks) * (high - low)[0, axis]
    levels[-1] = high[0, axis]
    return slabs(mesh, np.zeros(len(marks) - 1, np.int64), axis, levels[:-1], levels[1:]), levels


@QUICK
@given(st.one_of(solids, grid_prisms), rotations(), axes, shares)
def test_slabs_of_a_solid_are_closed_and_fill_it(solid, rotation, axis, cuts):
    whole = turned(solid, rotation)
    parts, _ = sliced(whole, axis, cuts)
    assert volumes(parts).sum() == pytest.approx(volumes(whole)[0], rel=1e-6)
    assert (volumes(parts) >= -1e-9 * volumes(whole)[0]).all()
    assert (is_closed(parts) | (num_faces(parts) == 0)).all()


@QUICK
@given(grid_prisms, axes, st.lists(st.integers(0, 16), min_size=1, max_size=4, unique=True))
def test_cuts_through_faces_edges_and_corners_leave_closed_parts(solid, axis, cuts):
    whole = solid.with_points(np.round(solid.points * [1.0, 4.0, 1.0]))
    low, high = whole.bounds()
    levels = np.unique(np.clip([low[0, axis], *cuts, high[0, axis]], low[0, axis], high[0, axis]))
    parts = slabs(whole, np.zeros(len(levels) - 1, np.int64), axis, levels[:-1], levels[1:])
    assert volumes(parts).sum() == pytest.approx(volumes(whole)[0])
    assert is_closed(parts).all()
    assert (face_areas(parts) > 0.0).all()


@QUICK
@given(simple, rotations(), axes, shares)
def test_areas_of_the_parts_of_a_face_add_up(ring, rotation, axis, cuts):
    whole = turned(lots([ring]), rotation)
    assume(np.ptp(whole.points[:, axis]) > 1e-6)
    parts, _ = sliced(whole, axis, cuts)
    assert areas(parts).sum() == pytest.approx(areas(whole)[0], rel=1e-6)
    agreement = area_vectors(parts) @ face_normals(whole)[0]
    assert agreement == pytest.approx(face_areas(parts), rel=1e-6)


@QUICK
@given(st.one_of(simple, rectilinear(), combs()), st.sampled_from([0, 2]), st.one_of(st.floats(0.05, 0.95), GRID))
def test_parts_of_a_polygon_are_those_of_shapely(ring, axis, share):
    whole = lots([ring])
    parts, levels = sliced(whole, axis, [share])
    low, high = whole.bounds()
    for k in range(2):
        window = np.array([[low[0, 0], low[0, 2]], [high[0, 0], high[0, 2]]])
        window[:, axis // 2] = levels[k : k + 2]
        expected = shapely.Polygon(whole.points[:, [0, 2]]).intersection(shapely.box(*window.ravel()))
        found = [outline(parts.take(np.array([k])), f) for f in range(int(num_faces(parts)[k]))]
        assert all(polygon.is_valid for polygon in found)
        union = shapely.union_all(found)
        assert sum(polygon.area for polygon in found) == pytest.approx(expected.area, rel=1e-6)
        assert union.symmetric_difference(expected).area <= 1e-6 * shapely.Polygon(ring).area


def outline(mesh, face):
    corners = mesh.corner_points()[mesh.face_offsets[face] : mesh.face_offsets[face + 1]]
    return shapely.Polygon(mesh.points[corners][:, [0, 2]])


@QUICK
@given(solids, axes, st.lists(st.integers(1, 63).map(lambda k: k / 64), min_size=1, max_size=4, unique=True))
def test_parts_end_exactly_where_their_neighbours_begin(solid, axis, cuts):
    parts, levels = sliced(solid, axis, cuts)
    low, high = parts.bounds()
    assert low[:, axis].tolist() == levels[:-1].tolist()
    assert high[:, axis].tolist() == levels[1:].tolist()


@QUICK
@given(convex(), rotations(), st.floats(-0.5, 0.5))
def test_a_convex_solid_cut_by_a_plane_is_what_trimesh_says(ring, rotation, offset):
    import trimesh

    whole = turned(prism(ring), rotation)
    mesh = trimesh.Trimesh(whole.points, triangulate(whole)[0], process=False)
    expected = trimesh.intersections.slice_mesh_plane(mesh, [0.0, -1.0, 0.0], [0.0, offset, 0.0], cap=True)
    part = slabs(whole, np.zeros(1, np.int64), 1, np.array([-np.inf]), np.array([offset]))
    assume(volumes(part)[0] > 1e-3 and expected is not None and len(expected.faces) > 0)
    assert expected is not None
    assert volumes(part)[0] == pytest.approx(expected.volume, rel=1e-6, abs=1e-9)
    assert areas(part)[0] == pytest.approx(expected.area, rel=1e-6, abs=1e-9)


def test_the_section_of_a_hollow_cube_is_a_face_with_a_hole():
    whole = hollow_cube()
    parts = slabs(whole, np.zeros(3, np.int64), 1, np.array([0, 1.5, 2.5]), np.array([1.5, 2.5, 3]))
    assert is_closed(parts).all()
    assert volumes(parts) == pytest.approx([9 * 1.5 - 0.5, 9 - 0.5, 4.5])
    caps = face_areas(parts)[np.abs(face_normals(parts)[:, 1]) == 1.0]
    assert sorted(caps.tolist()) == pytest.approx([1, 1, 8, 8, 9, 9, 9, 9])
    triangles, face = triangulate(parts)
    sizes = np.cross(
        parts.points[triangles[:, 1]] - parts.points[triangles[:, 0]],
        parts.points[triangles[:, 2]] - parts.points[triangles[:, 0]],
    )
    covered = np.bincount(face, 0.5 * np.linalg.norm(sizes, axis=1))
    assert covered == pytest.approx(face_areas(parts))


def test_a_tube_cut_across_its_keyholed_ends_falls_into_closed_parts():
    whole = extrude(FRAME, np.array([2.0]))
    for axis, cuts in ((0, [1.5, 4.5, 6.0]), (1, [0.5, 1.0]), (2, [3.0, 4.0, 8.0])):
        high = whole.bounds()[1][0, axis]
        levels = np.array([0.0, *cuts, high])
        parts = slabs(whole, np.zeros(len(levels) - 1, np.int64), axis, levels[:-1], levels[1:])
        assert is_closed(parts).all()
        assert volumes(parts).sum() == pytest.approx(144.0)


def test_two_solids_that_touch_in_a_point_of_the_cut_get_two_caps():
    shifted = box().points + np.array([1.0, 0.0, 1.0])
    twins = Meshes.single(
        np.concatenate((box().points, shifted)),
        [*box().corners.reshape(6, 4).tolist(), *(box().corners.reshape(6, 4) + 8).tolist()],
    )
    points, welded = np.unique(twins.points, axis=0, return_inverse=True)
    touching = Meshes.single(points, welded[twins.corners].reshape(-1, 4).tolist())
    part = slabs(touching, np.zeros(1, np.int64), 1, np.zeros(1), np.array([0.5]))
    assert is_closed(part)[0]
    caps = np.flatnonzero(face_normals(part)[:, 1] == 1.0)
    assert face_areas(part)[caps].tolist() == [1.0, 1.0]


def test_cuts_that_go_around_get_caps_also_in_open_meshes():
    sides = cylinder(8).corners[16:].reshape(8, 4).tolist()
    open_tube, half_tube = (Meshes.single(cylinder(8).points, some) for some in (sides, sides[:4]))
    both = Meshes.concatenate([open_tube, cylinder(8), half_tube])
    parts = slabs(both, np.array([0, 1, 2]), 1, np.full(3, 0.25), np.full(3, 0.5))
    assert num_faces(parts).tolist() == [10, 10, 4]
    assert is_closed(parts).tolist() == [True, True, False]


def test_faces_inside_a_slab_are_passed_through_untouched():
    parts = slabs(sphere(), np.zeros(1, np.int64), 0, np.array([-1.0]), np.array([2.0]))
    assert np.array_equal(parts.corners, sphere().corners)
    assert np.array_equal(parts.points, sphere().points)


@QUICK
@given(st.permutations([0.0, 0.3, 0.5, 1.0]), axes)
def test_parts_may_come_from_any_mesh_in_any_order(levels, axis):
    batch = Meshes.concatenate([box(), disk(), cylinder(5)])
    mesh = np.array([2, 0, 2, 1, 0])
    low = np.array([min(pair) for pair in pairwise([*levels, levels[0], levels[1]])])
    high = low + 0.25
    together = slabs(batch, mesh, axis, low, high)
    for k in range(5):
        alone = slabs(batch.take(mesh[k : k + 1]), np.zeros(1, np.int64), axis, low[k : k + 1], high[k : k + 1])
        part = together.take(np.array([k]))
        assert np.array_equal(part.points, alone.points)
        assert np.array_equal(part.corners, alone.corners)
        assert np.array_equal(part.face_offsets, alone.face_offsets)


def test_a_flat_mesh_across_the_axis_belongs_to_the_slab_that_begins_there():
    for meshes in (quad(), quad().reversed()):
        parts = slabs(meshes, np.zeros(3, np.int64), 1, np.array([-1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
        assert num_faces(parts).tolist() == [0, 1, 1]


def test_a_floor_that_looks_up_stays_in_the_lowest_slab_of_an_open_mesh():
    corners = box().corners.reshape(6, 4).tolist()
    room = Meshes.single(box().points, [*corners[2:], corners[0][::-1]])
    parts = slabs(room, np.zeros(2, np.int64), 1, np.array([0.0, 0.5]), np.array([0.5, 1.0]))
    assert num_faces(parts).tolist() == [6, 5]


def test_a_terrace_belongs_to_the_part_below_it():
    steps = prism(np.array([[0, 0], [4, 0], [4, 1], [2, 1], [2, 2], [0, 2.0]]))
    upright = Meshes(
        steps.points[:, [0, 2, 1]] * [1, -1, 1],
        steps.corners,
        steps.face_offsets,
        steps.mesh_faces,
        steps.mesh_points,
        steps.tags,
    )
    parts = slabs(upright, np.zeros(2, np.int64), 1, np.array([0.0, 1.0]), np.array([1.0, 2.0]))
    assert is_closed(parts).all()
    assert volumes(parts) == pytest.approx([4.0, 2.0])
    tops = face_normals(parts)[:, 1] == 1.0
    assert face_areas(parts)[tops].tolist() == pytest.approx([2.0, 2.0, 2.0])


@pytest.mark.parametrize(("axis", "low", "high"), [(0, 0.2, 0.7), (1, 0.2, 0.7), (2, 0.0, 0.4), (2, 0.4, 1.0)])
def test_first_edges_keep_their_direction(axis, low, high):
    part = slabs(box(), np.zeros(1, np.int64), axis, np.array([low]), np.array([high]))
    first = corner_edges(part)[part.face_offsets[:-1]]
    pieces = face_normals(part)[:, axis] == 0.0
    for normal, edge in zip(face_normals(part)[pieces], first[pieces], strict=True):
        whole = np.flatnonzero((face_normals(box()) == normal).all(axis=1))[0]
        before = corner_edges(box())[box().face_offsets[whole]]
        assert before @ edge == pytest.approx(np.linalg.norm(edge))


def test_caps_come_last_or_first_where_the_first_face_was_cut_away():
    cut = slabs(box(), np.zeros(2, np.int64), 1, np.array([0.0, 0.5]), np.array([0.5, 1.0]))
    normals = face_normals(cut).reshape(2, 6, 3)
    assert normals[0, 5].tolist() == [0, 1, 0]
    assert normals[1, 0].tolist() == [0, -1, 0]


def test_pieces_keep_the_tags_of_their_faces():
    tagged = Meshes.single(quad().points, [[0, 1, 2, 3]], [BORDER])
    part = slabs(tagged, np.zeros(1, np.int64), 0, np.array([0.5]), np.array([1.0]))
    assert part.tags.tolist() == [BORDER]


@QUICK
@given(stars(), st.floats(0.05, 0.95))
def test_cut_polygons_meet_in_the_same_points(ring, share):
    face, other = lots([ring]), lots([ring]).reversed()
    lamina = Meshes.single(face.points, [face.corners.tolist(), other.corners.tolist()])
    low, high = lamina.bounds()
    level = low[0, 0] + share * (high - low)[0, 0]
    part = slabs(lamina, np.zeros(1, np.int64), 0, low[:, 0], np.array([level]))
    assert is_closed(part)[0]
    assert volumes(part)[0] == pytest.approx(0.0, abs=1e-12)


def test_nothing_is_left_of_nothing():
    nothing = Meshes.single(np.zeros((0, 3)), [])
    assert len(slabs(nothing, np.zeros(0, np.int64), 0, np.zeros(0), np.zeros(0))) == 0
    assert slabs(nothing, np.zeros(2, np.int64), 0, np.zeros(2), np.ones(2)).num_faces == 0
    assert slabs(box(), np.zeros(1, np.int64), 0, np.array([0.5]), np.array([0.5])).num_faces == 0


LEG = 1.0 - 0.002 * 2**0.5
"""Leg of the triangle between the corner of a unit square and a line 2 mm from its diagonal."""


@pytest.mark.parametrize(
    ("offset", "num", "area"),
    [
        (-0.002, 4, LEG**2 + 2.0 * LEG),
        (-0.0009, 4, 3.0),
        (0.0, 4, 3.0),
        (0.0009, 4, 3.0),
        (0.002, 6, 2.0 - LEG**2 + 2.0 + 2.0 * (1.0 - LEG)),
    ],
)
def test_a_plane_within_a_millimetre_of_the_diagonal_of_a_cube_halves_it_without_slivers(offset, num, area):
    half = trimmed(box(), np.array([0]), np.array([[1.0, 0.0, 1.0]]) / 2**0.5, np.array([0.5**0.5 + offset]))
    assert (half.num_faces, areas(half)[0]) == (num, pytest.approx(area, abs=1e-12))


HEXAGON = np.array([[0, 0, 0], [3, 0, 12], [14, 0, 19], [27, 0, 14], [29, 0, 3], [13, 0, -4.0]])


@pytest.mark.parametrize("footprint", [L_SHAPE, TRIANGLE, HEXAGON], ids=["L", "triangle", "hexagon"])
@pytest.mark.parametrize("axis", ["x", "z"])
def test_a_piece_between_two_cuts_is_as_that_of_one_cut_after_the_other(footprint, axis):
    at_once = f"split({axis}) {{ 4 : NIL | ~1 : B. | 3 : NIL }}"
    in_turn = f"split({axis}) {{ 4 : NIL | ~1 : split({axis}) {{ ~1 : B. | 3 : NIL }} }}"
    meshes = [world_meshes(sampled(f"Lot --> extrude(10) {cuts}", footprint)) for cuts in (at_once, in_turn)]
    corners = [mesh.points[mesh.corners] for mesh in meshes]
    assert np.array_equal(meshes[0].face_offsets, meshes[1].face_offsets)
    assert np.allclose(*corners, atol=1e-9)


def test_faces_that_close_pieces_of_a_prism_stand_on_its_floor():
    rules = "Lot --> extrude(10) split(z) { 4 : NIL | ~1 : comp(f) { side : W. } | 3 : NIL }"
    assert sampled(rules, HEXAGON).leaves.size[:, 1] == pytest.approx(10.0)
