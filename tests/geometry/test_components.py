import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.components import (
    EAVE,
    HIP,
    NO_ROOF_EDGE,
    RIDGE,
    VALLEY,
    ComponentMeshes,
    edges,
    face_sets,
    faces,
    upwards,
    vertices,
)
from grammarlab.geometry.meshes.edges import num_edges
from grammarlab.geometry.meshes.measure import (
    areas,
    corner_edges,
    face_areas,
    face_normals,
    is_closed,
    num_vertices,
)
from grammarlab.geometry.meshes.mesh import BORDER, INSIDE, Meshes
from grammarlab.geometry.meshes.primitives import box, disk, quad
from tests.geometry.bodies import FRAME, prism, rotations, solids, turned
from tests.geometry.polygons import LOT_L, lots

QUICK = settings(max_examples=40, deadline=None)


def back_in_place(parts: ComponentMeshes) -> np.ndarray:
    """Points of the component shapes, in the axes of their meshes."""
    part = parts.shapes.mesh_of_point()
    return parts.origin[part] + np.einsum("pij,pj->pi", parts.rotation[part], parts.shapes.points)


@QUICK
@given(st.lists(solids, min_size=1, max_size=3), rotations())
def test_faces_lie_in_their_frames_and_go_back_to_where_they_were(batch, rotation):
    meshes = turned(Meshes.concatenate(batch), rotation)
    parts = faces(meshes)
    scale = np.abs(meshes.points).max()
    assert np.einsum("kij,kil->kjl", parts.rotation, parts.rotation) == pytest.approx(
        np.broadcast_to(np.eye(3), (len(parts), 3, 3)), abs=1e-9
    )
    assert np.linalg.det(parts.rotation) == pytest.approx(1.0)
    low, high = parts.shapes.bounds()
    assert low == pytest.approx(0.0, abs=1e-12 * scale)
    assert high == pytest.approx(parts.size, abs=1e-9 * scale)
    assert (parts.size[:, 2] == 0.0).all()
    assert back_in_place(parts)[parts.shapes.corner_points()] == pytest.approx(
        meshes.points[meshes.corner_points()], abs=1e-9 * scale
    )
    assert areas(parts.shapes) == pytest.approx(face_areas(meshes), rel=1e-7)


@QUICK
@given(solids, rotations())
def test_x_follows_the_first_edge_and_z_is_the_outward_normal(solid, rotation):
    meshes = turned(solid, rotation)
    parts = faces(meshes)
    first = corner_edges(meshes)[meshes.face_offsets[:-1]]
    assert np.einsum("ki,ki->k", first, parts.rotation[:, :, 0]) == pytest.approx(np.linalg.norm(first, axis=1))
    assert parts.rotation[:, :, 2] == pytest.approx(face_normals(meshes), abs=1e-9)
    assert parts.pivot == pytest.approx(meshes.points[meshes.corner_points()[meshes.face_offsets[:-1]]])
    assert (parts.direction == face_normals(meshes)).all()


def test_components_know_their_mesh_and_number():
    parts = faces(Meshes.concatenate([quad(), box(), quad()]))
    assert parts.mesh.tolist() == [0, 1, 1, 1, 1, 1, 1, 2]
    assert parts.index.tolist() == [0, 0, 1, 2, 3, 4, 5, 0]
    some = parts.take(np.array([6, 0]))
    assert some.mesh.tolist() == [1, 0]
    assert some.shapes.points == pytest.approx(np.concatenate([parts.shapes.points[24:28], parts.shapes.points[:4]]))


def test_a_face_whose_first_edge_has_no_length_takes_the_next():
    points = np.array([[0, 0, 0], [0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0.0]])
    assert faces(Meshes.from_polygons(points, np.array([5]))).rotation[0, :, 0].tolist() == [0, 0, 1]


def test_a_face_without_area_still_has_a_frame():
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]])
    frame = faces(Meshes.from_polygons(points, np.array([3]))).rotation[0]
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert frame[:, 0].tolist() == [1, 0, 0]


def test_sets_of_faces_share_points_and_the_frame_of_their_first():
    cube = Meshes.concatenate([quad(), box(), box()])
    sets = face_sets(cube, np.array([4, 5, 3, 7, 8, 9, 10, 11, 12]), np.array([3, 6]))
    assert sets.mesh.tolist() == [1, 2]
    assert sets.index.tolist() == [3, 0]
    assert sets.rotation[0, :, 2].tolist() == [1, 0, 0]
    assert sets.size.tolist() == [[1, 1, 1], [1, 1, 1]]
    assert num_vertices(sets.shapes).tolist() == [8, 8]
    assert is_closed(sets.shapes).tolist() == [False, True]
    whole = cube.points[cube.mesh_points[1] : cube.mesh_points[3]]
    assert sorted(back_in_place(sets).tolist()) == sorted(whole.tolist())


@QUICK
@given(st.lists(solids, min_size=1, max_size=3), rotations())
def test_edges_run_along_x_from_their_start(batch, rotation):
    meshes = turned(Meshes.concatenate(batch), rotation)
    parts = edges(meshes)
    assert np.bincount(parts.mesh) == pytest.approx(num_edges(meshes))
    scale = np.abs(meshes.points).max()
    ends = back_in_place(parts).reshape(-1, 2, 3)
    assert ends[:, 0] == pytest.approx(parts.pivot)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) == pytest.approx(parts.size[:, 0])
    known = {tuple(np.round(point / scale, 7) + 0.0) for point in meshes.points}
    assert {tuple(np.round(point / scale, 7) + 0.0) for point in ends.reshape(-1, 3)} <= known
    assert np.linalg.det(parts.rotation) == pytest.approx(1.0)
    assert np.einsum("ki,ki->k", parts.rotation[:, :, 2], parts.direction) == pytest.approx(
        np.linalg.norm(parts.direction, axis=1)
    )


def test_edges_of_a_box_look_out_between_their_faces():
    parts = edges(box())
    middle = parts.pivot + 0.5 * parts.rotation[:, :, 0] * parts.size[:, :1] - 0.5
    assert np.einsum("ki,ki->k", parts.direction, middle) == pytest.approx(np.sqrt(0.5))


def test_vertices_of_a_box_look_out_from_its_middle():
    parts = vertices(box())
    assert parts.pivot.tolist() == box().points.tolist()
    assert np.einsum("ki,ki->k", parts.direction, parts.pivot - 0.5) == pytest.approx(np.sqrt(0.75))
    assert (parts.rotation[:, :, 2] == parts.direction).all()
    assert np.linalg.det(parts.rotation) == pytest.approx(1.0)
    assert not parts.size.any()
    assert not parts.is_border.any()


def test_borders_are_found_by_sharing_and_by_the_tags_of_offset():
    assert faces(quad()).is_border.tolist() == [True]
    assert edges(quad()).is_border.tolist() == [True] * 4
    assert vertices(disk(5)).is_border.tolist() == [True] * 5
    assert not faces(box()).is_border.any()
    tagged = Meshes.single(box().points, box().corners.reshape(6, 4).tolist(), [BORDER, INSIDE, 0, 0, 0, 0])
    assert faces(tagged).is_border.tolist() == [True, False, False, False, False, False]
    lid = Meshes.single(box().points, box().corners.reshape(6, 4)[1:].tolist(), [0, INSIDE, 0, 0, 0])
    assert faces(lid).is_border.tolist() == [False, False, True, True, True]


def test_a_keyholed_face_keeps_its_hole():
    part = faces(FRAME)
    assert areas(part.shapes)[0] == pytest.approx(72.0)
    assert num_vertices(part.shapes).tolist() == [8]
    assert len(vertices(FRAME)) == 8


def gable_roof():
    """A roof over 4 x 2 with its ridge along x, closed, pediments included."""
    points = np.array([[0, 0, 2], [4, 0, 2], [4, 0, 0], [0, 0, 0], [0, 1, 1], [4, 1, 1.0]])
    return Meshes.single(points, [(0, 1, 5, 4), (2, 3, 4, 5), (1, 2, 5), (3, 0, 4), (3, 2, 1, 0)])


def test_edges_of_a_gable_roof():
    parts = edges(gable_roof())
    level = parts.roof_edge[parts.rotation[:, 1, 0] == 0.0]
    # The edges below the gables are no eaves, so they count as ridges.
    assert sorted(level.tolist()) == [EAVE] * 2 + [HIP] * 2 + [RIDGE]
    assert (parts.roof_edge[parts.rotation[:, 1, 0] != 0.0] == HIP).all()
    open_roof = Meshes.single(gable_roof().points, [(0, 1, 5, 4), (2, 3, 4, 5)])
    assert np.bincount(edges(open_roof).roof_edge, minlength=5).tolist() == [4, 2, 0, 0, 1]
    assert (edges(open_roof).roof_edge == NO_ROOF_EDGE).sum() == 4


def test_the_valley_of_an_l_shaped_prism_is_its_upright_inner_edge():
    parts = edges(prism(LOT_L, 3.0))
    valleys = np.flatnonzero(parts.roof_edge == VALLEY)
    assert parts.pivot[valleys][:, [0, 2]].tolist() == [[8, 12]]
    assert np.count_nonzero(parts.roof_edge == EAVE) == 0


@QUICK
@given(solids, rotations())
def test_upwards_turns_descending_edges_around_in_place(solid, rotation):
    parts = edges(turned(solid, rotation))
    up = upwards(parts)
    assert (up.rotation[:, 1, 0] >= -1e-6).all()
    assert np.linalg.det(up.rotation) == pytest.approx(1.0)
    assert (up.rotation[:, :, 2] == parts.rotation[:, :, 2]).all()
    before = np.sort(back_in_place(parts).reshape(-1, 2, 3), axis=1)
    after = np.sort(back_in_place(up).reshape(-1, 2, 3), axis=1)
    assert after == pytest.approx(before, abs=1e-9 * max(1.0, np.abs(before).max()))


@QUICK
@given(st.lists(solids, min_size=2, max_size=4), st.data())
def test_components_of_a_mesh_are_the_same_alone_and_in_a_batch(batch, data):
    k = data.draw(st.integers(0, len(batch) - 1))
    for take_apart in (faces, edges, vertices):
        together = take_apart(Meshes.concatenate(batch))
        mine = together.take(np.flatnonzero(together.mesh == k))
        alone = take_apart(batch[k])
        for name in ("rotation", "origin", "pivot", "size", "direction", "is_border", "roof_edge", "index"):
            assert np.array_equal(getattr(mine, name), getattr(alone, name)), name
        assert np.array_equal(mine.shapes.points, alone.shapes.points)


def test_nothing_has_no_components():
    nothing = Meshes.single(np.zeros((0, 3)), [])
    assert [len(take_apart(nothing)) for take_apart in (faces, edges, vertices)] == [0, 0, 0]
    assert len(faces(lots([LOT_L]).take(np.zeros(0, np.int64)))) == 0
