"""Meshes with fewer points and nearly the same surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.measure import areas, is_closed, volumes
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.reduction import reduced
from grammarlab.language.grammar import Grammar
from tests.derivation.operations.leaves import areas_by_symbol, world_meshes


def grid(n, height=lambda x, z: 0.0 * x):
    """n by n squares of one metre, with shared points."""
    z, x = np.divmod(np.arange((n + 1) ** 2), n + 1)
    points = np.column_stack((x, height(x, z), z)).astype(float)
    starts = [row * (n + 1) + column for row in range(n) for column in range(n)]
    return Meshes.single(points, [[k, k + n + 1, k + n + 2, k + 1] for k in starts])


def ball(share):
    text = f"Lot --> s(8, 8, 8) primitiveSphere(16, 12) reduceGeometry({share}) X."
    return world_meshes(derive(Grammar.parse(text), 1, 1))


@pytest.mark.parametrize(
    ("n", "share", "num_points"),
    [
        (12, 0.0, 169),
        (12, 0.2, 135),
        (12, 0.5, 84),
        (12, 0.8, 33),
        (12, 0.002, 169),
        (12, 0.006, 167),
        (9, 0.9, 10),
        (4, 0.8, 5),
        (4, 0.4, 15),
    ],
)
def test_this_share_of_the_points_is_gone(n, share, num_points):
    hills = grid(n, lambda x, z: np.sin(x) + np.cos(z))
    assert len(reduced(hills, share).points) == num_points


@pytest.mark.parametrize("exponent", [-24, 250])
def test_meshes_are_reduced_alike_at_every_size(exponent):
    hills = grid(6, lambda x, z: np.sin(x) + np.cos(z))
    scaled = reduced(hills.with_points(np.ldexp(hills.points, exponent)), 0.5)
    expected = reduced(hills, 0.5)
    assert np.array_equal(scaled.points, np.ldexp(expected.points, exponent))
    assert np.array_equal(scaled.corners, expected.corners)


@pytest.mark.parametrize("reader", ["", ' comp(f) { isTagged("x") : T. | all : N. }'])
@pytest.mark.parametrize("share", [0, 0.5, 1])
def test_a_rectangle_stays_whole_without_its_tags(share, reader):
    text = f'Lot --> s(20, 0, 20) tag("x") reduceGeometry({share}){reader or " N."}'
    forest = derive(Grammar.parse(text), 1, 1)
    assert set(areas_by_symbol(forest)) == {"N."}
    mesh = world_meshes(forest)
    assert len(mesh.points) == 4
    assert areas(mesh)[0] == pytest.approx(400.0)


def test_a_mesh_without_tags_that_loses_no_point_is_the_same_one():
    hills = grid(3)
    assert reduced(hills, 0.0) is hills


def test_a_solid_loses_its_tags_where_no_point_goes():
    text = 'Lot --> extrude(3) tag("x") reduceGeometry(0) comp(f) { isTagged("x") : T. | all : N. }'
    assert set(areas_by_symbol(derive(Grammar.parse(text), 1, 1))) == {"N."}


@pytest.mark.parametrize(("share", "num_points"), [(0.5, 40), (0.9, 8)])
def test_a_plane_keeps_its_outline(share, num_points):
    plate = reduced(grid(8), share)
    assert len(plate.points) == num_points
    assert areas(plate)[0] == pytest.approx(64.0)
    assert {(0, 0), (8, 0), (0, 8), (8, 8)} <= {(x, z) for x, _, z in plate.points.tolist()}


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9, 1.0])
def test_closed_meshes_stay_closed_and_close_to_themselves(share):
    whole, mesh = ball(0), ball(share)
    assert is_closed(mesh)[0]
    edges = len(mesh.corners) // 2
    assert len(mesh.points) - edges + mesh.num_faces == 2
    if share < 0.9:
        assert volumes(mesh)[0] == pytest.approx(volumes(whole)[0], rel=0.1)


def test_something_is_always_there():
    assert [reduced(grid(n), 1.0).num_faces for n in (1, 2, 5)] == [1, 1, 1]


def test_faces_far_from_a_collapse_stay_whole():
    mesh = grid(12, lambda x, z: np.where(x + z > 12, 0.3 * np.sin(3.0 * x) * np.cos(2.0 * z), (x * x + z * z) / 10.0))
    result = reduced(mesh, 0.05)
    counts = np.diff(result.face_offsets)
    assert 90 < np.count_nonzero(counts == 4) < 144


def test_texture_coordinates_that_are_a_function_of_the_position_stay_it():
    plate = grid(6, lambda x, z: 0.2 * np.sin(x + z))
    uv = plate.points[plate.corners][:, [0, 2]] / 6.0
    result = reduced(replace(plate, data=CornerData.of_sets([uv], plate.num_faces)), 0.7)
    assert result.data is not None
    assert np.array_equal(result.data.coordinates(0), result.points[result.corners][:, [0, 2]] / 6.0)


def test_the_edge_of_a_material_stays_where_it_is():
    plate = grid(6)
    slots = (np.arange(36) % 6 >= 2).astype(np.int64)
    uv = np.zeros((len(plate.corners), 2))
    result = reduced(replace(plate, data=CornerData.of_sets([uv], 36, slots=slots)), 0.7)
    assert result.data is not None
    parts = result.mesh_of_face() * 0 + result.data.slots
    x = result.points[result.corners][:, 0]
    of_face = np.repeat(parts, np.diff(result.face_offsets))
    assert x[of_face == 0].max() == x[of_face == 1].min() == 2.0
