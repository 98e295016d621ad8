"""Rectified outlines: edges are parallel to axes or as they were, and doing it again changes nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.geometry.meshes.measure import areas
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.outlines.rectify import rectified
from grammarlab.language.grammar import Grammar
from tests.cases import bulk
from tests.derivation.operations.leaves import world_meshes

L_SHAPE = np.array([[0, 0, 0], [0, 0, 12], [8, 0, 12], [8, 0, 22], [26, 0, 22], [26, 0, 0.0]])


def flat(points: np.ndarray) -> Meshes:
    return Meshes.from_polygons(points, np.array([len(points)]))


def deviations(mesh: Meshes) -> np.ndarray:
    """Degrees of each edge of a polygon in the plane y = 0 from the nearer axis."""
    along = np.abs(np.roll(mesh.points, -1, axis=0) - mesh.points)
    return np.degrees(np.arctan2(along[:, [0, 2]].min(axis=1), along[:, [0, 2]].max(axis=1)))


@given(st.integers(0, 10**6), st.floats(0.0, 45.0))
@bulk(60)
def test_edges_below_the_limit_are_parallel_to_axes_and_others_keep_their_free_ends(seed, angle):
    shift = np.random.default_rng(seed).normal(0.0, 0.6, (6, 3)) * [1.0, 0.0, 1.0]
    before = flat(L_SHAPE + shift)
    after = rectified(before, np.array([angle]))
    near = deviations(before) < angle
    assert deviations(after)[near] == pytest.approx(0.0, abs=1e-9)
    free = ~near & ~np.roll(near, 1)
    assert np.array_equal(after.points[free], before.points[free])
    assert np.array_equal(after.points[:, 1], before.points[:, 1])
    if near.all():
        assert np.allclose(rectified(after, np.array([angle])).points, after.points)


def test_a_sheared_rectangle_keeps_its_area_and_a_diagonal_stays():
    skew = flat(np.array([[0, 0, 0], [1, 0, 10], [21, 0, 12], [20, 0, 2.0]]))
    straight = rectified(skew, np.array([10.0]))
    assert straight.points[:, [0, 2]].tolist() == [[0.5, 1.0], [0.5, 11.0], [20.5, 11.0], [20.5, 1.0]]
    assert areas(straight) == pytest.approx(200.0)
    assert np.array_equal(rectified(skew, np.array([5.0])).points, skew.points)
    cut = flat(np.array([[0, 0, 0], [0, 0, 10], [10, 0, 10], [15, 0, 5], [15, 0, 0.0]]))
    assert np.array_equal(rectified(cut, np.array([45.0])).points, cut.points)


@pytest.mark.parametrize("axes", [[0, 1, 2], [1, 2, 0], [2, 0, 1]])
def test_the_plane_is_the_one_that_the_faces_are_most_parallel_to(axes):
    skew = np.array([[0, 0.1, 0], [1, 0, 10], [21, 0.2, 12], [20, 0, 2.0]])
    expected = rectified(flat(skew), np.array([10.0])).points
    assert np.array_equal(rectified(flat(skew[:, axes]), np.array([10.0])).points, expected[:, axes])


def test_a_rule_gives_each_shape_its_own_angle_and_fits_the_scope():
    rule = "Lot --> split(x) { '0.5 : rectify(20) A | ~1 : rectify(0) B }"
    lot = np.array([[0, 0, 0], [1, 0, 10], [21, 0, 11], [20, 0, 0.0]])
    forest = derive(Grammar.parse(rule), 1, 1, footprint=lot)
    assert areas(world_meshes(forest)).sum() == pytest.approx(areas(flat(lot))[0], rel=0.01)
    one, other = forest.leaves.size
    assert areas(world_meshes(forest))[0] == pytest.approx(one[0] * one[2])
    assert areas(world_meshes(forest))[1] < other[0] * other[2]
