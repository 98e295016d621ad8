"""Leaves and blossoms."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.trees.foliage import carried
from grammarlab.trees.growth import grow
from grammarlab.trees.skeleton import Skeleton
from tests.trees.rows import ASPEN, row, tree_keys


def aspen(**named: float) -> Skeleton:
    return grow(row(**ASPEN | named)[None], tree_keys(1))


@pytest.mark.parametrize("leaves", [1, 7, 25])
@pytest.mark.parametrize("quality", [1.0, 0.3, 0.02])
def test_the_total_is_that_of_the_formula(leaves: int, quality: float):
    """Leaves · S(4, offset / length of the parent) · quality, summed over the last stems."""
    skeleton = aspen(leaves=leaves, leaf_quality=quality)
    twigs, branches = skeleton.levels[2], skeleton.levels[1]
    share = twigs.offset / branches.length[twigs.parent]
    total = float(np.sum(leaves * quality * (0.5 + 0.5 * share)))
    assert abs(len(skeleton.leaves) - total) <= 0.5 + 1e-3


def test_a_fan_has_its_number_at_every_tip():
    skeleton = aspen(leaves=-5, rotate_3=80.0, down_angle_3=0.0, leaf_bend=0.0)
    twigs, leaves = skeleton.levels[2], skeleton.leaves
    np.testing.assert_array_equal(np.bincount(leaves.stem), np.full(len(twigs), 5))
    tips = twigs.node_offsets[leaves.stem + 1] - 1
    np.testing.assert_array_equal(leaves.position, twigs.points[tips])
    cosines = np.einsum("li,li->l", leaves.frame[:, :, 2], twigs.frames[tips, :, 2]).reshape(-1, 5)
    np.testing.assert_allclose(cosines, np.tile(np.cos(np.radians([40, 20, 0, 20, 40])), (len(twigs), 1)))


def test_fewer_and_larger_leaves_have_the_same_area():
    full, coarse = aspen(), aspen(leaf_quality=0.1)
    areas = [float((skeleton.leaves.length * skeleton.leaves.width).sum()) for skeleton in (full, coarse)]
    assert len(coarse.leaves) == pytest.approx(0.1 * len(full.leaves), abs=1)
    assert areas[1] == pytest.approx(areas[0], rel=1e-3)


def test_leaves_are_as_long_and_wide_as_their_parameters():
    leaves = aspen(leaf_scale=0.3, leaf_scale_x=0.5, blossom_rate=0.25, blossom_scale=0.02, leaf_quality=0.25).leaves
    sizes = np.where(leaves.is_blossom[:, None], [0.04, 0.04], [0.6, 0.3])
    np.testing.assert_allclose(np.column_stack([leaves.length, leaves.width]), sizes)
    assert leaves.is_blossom.mean() == pytest.approx(0.25, abs=0.03)


def test_leaves_have_the_angles_of_the_level_after_their_stem():
    skeleton = aspen(down_angle_3=50.0, leaf_bend=0.0, leaves=9)
    twigs, leaves = skeleton.levels[2], skeleton.leaves
    segment = np.floor(leaves.offset / twigs.length[leaves.stem] * 3).astype(int)
    axis = twigs.frames[twigs.node_offsets[leaves.stem] + segment, :, 2]
    np.testing.assert_allclose(np.einsum("li,li->l", axis, leaves.frame[:, :, 2]), np.cos(np.radians(50.0)))
    # Their upper side looks to the tip of the stem.
    np.testing.assert_allclose(np.einsum("li,li->l", axis, leaves.frame[:, :, 1]), np.sin(np.radians(50.0)))


def test_leaves_that_bend_fully_to_the_light_look_up():
    np.testing.assert_allclose(aspen(leaf_bend=1.0).leaves.frame[:, 1, 1], 1.0)


def test_leaves_look_further_up_and_outward_the_more_they_bend():
    means = []
    for bend in (0.0, 0.3, 0.6, 0.9):
        leaves = aspen(leaf_bend=bend).leaves
        means.append(leaves.frame[:, 1, 1].mean())
    assert (np.diff(means) > 0.05).all()


def test_leaves_of_a_trunk_alone_sit_beyond_its_base():
    skeleton = aspen(levels=1, leaves=30, leaf_scale=1.0)
    assert len(skeleton.leaves) == 30
    assert (skeleton.leaves.offset > 0.4 * skeleton.scale[0]).all()
    assert (skeleton.leaves.level == 0).all()


def test_clones_bear_leaves_beyond_their_split_as_densely_as_their_stem():
    skeleton = grow(
        row(levels=1, base_size=0.0, curve_res_0=4, base_splits=2, split_angle_0=30.0, leaves=40)[None], tree_keys(1)
    )
    assert np.bincount(skeleton.leaves.stem).tolist() == [40, 30, 30]
    assert skeleton.leaves.offset[skeleton.leaves.stem > 0].min() > 0.25 * skeleton.levels[0].length[0]


def test_rounding_is_carried_within_each_tree_only():
    tree = np.repeat([0, 1, 3], [10, 3, 5])
    numbers = np.full(len(tree), 0.25)
    assert carried(tree, numbers).tolist() == [0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 0, 0, 0]
