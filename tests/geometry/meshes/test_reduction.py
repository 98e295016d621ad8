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
from tests.derivation.operations.leaves import world_meshes


def grid(n, height=lambda x, z: 0.0 * x):
    """n by n squares of one metre, with shared points."""
    z, x = np.divmod(np.arange((n + 1) ** 2), n + 1)
    points = np.column_stack((x, height(x, z), z)).astype(float)
    starts = [row * (n + 1) + column for row in range(n) for column in range(n)]
    return Meshes.single(points, [[k, k + n + 1, k + n + 2, k + 1] for k in starts])


def ball(share):
    text = f"Lot --> s(8, 8, 8) primitiveSphere(16, 12) reduceGeometry({share}) X."
    return world_meshes(derive(Grammar.parse(text), 1, 1))


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.8])
def test_this_share_of_the_points_is_gone(share):
    hills = grid(12, lambda x, z: np.sin(x) + np.cos(z))
    assert len(reduced(hills, share).points) == int(169 * (1.0 - share))


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_a_plane_keeps_its_outline(share):
    plate = reduced(grid(8), share)
    assert len(plate.points) == int(81 * (1.0 - share))
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
