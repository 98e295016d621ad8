"""Children of trees that are worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.trees.branching import rounded
from grammarlab.trees.growth import grow
from grammarlab.trees.skeleton import Skeleton
from tests.trees.rows import row, tree_keys

HAND = {
    "shape": 0,
    "scale": 10.0,
    "base_size": 0.2,
    "levels": 2,
    "ratio": 0.02,
    "ratio_power": 1.0,
    "curve_res_0": 2,
    "branches_1": 4,
    "length_1": 0.4,
    "down_angle_1": 90.0,
    "rotate_1": 90.0,
    "curve_res_1": 1,
}
"""A trunk of 10 m and .2 m, a cone, with four branches above the lowest 2 m."""


def hand(**named: float) -> Skeleton:
    return grow(row(**HAND | named)[None], tree_keys(1))


def test_children_sit_evenly_in_each_segment_beyond_the_base():
    """The first segment bears its share of 3/8 of four children, one and a half, which is rounded up."""
    np.testing.assert_allclose(hand().levels[1].offset, [2.75, 4.25, 6.25, 8.75])


def test_rounding_is_carried_from_segment_to_segment():
    skeleton = hand(base_size=0.0, curve_res_0=10, branches_1=4)
    np.testing.assert_allclose(skeleton.levels[1].offset, [1.5, 3.5, 6.5, 8.5])


def test_lengths_follow_the_shape_and_radii_the_lengths():
    branches = hand().levels[1]
    np.testing.assert_allclose(branches.length, [3.7, 3.1, 2.3, 1.3])
    # The last one would have .026 m, but its parent has .025 m there.
    np.testing.assert_allclose(branches.radius, [0.074, 0.062, 0.046, 0.025])


def test_a_helix_of_right_angles():
    """Frames of the trunk have x along the world's x and y against the world's z."""
    directions = hand().levels[1].frames[::2, :, 2]
    np.testing.assert_allclose(directions, [[1, 0, 0], [0, 0, -1], [-1, 0, 0], [0, 0, 1]], atol=1e-12)


def test_negative_rotations_alternate():
    directions = hand(rotate_1=-90.0).levels[1].frames[::2, :, 2]
    np.testing.assert_allclose(directions, [[-1, 0, 0], [1, 0, 0], [-1, 0, 0], [1, 0, 0]], atol=1e-12)


def test_down_angles_of_a_negative_spread_depend_on_the_height():
    """1 - 2 S(0, r) is 1 - 2 (.2 + .8 r), with r = .90625 at the lowest branch and .15625 at the highest."""
    branches = hand(down_angle_1=60.0, down_angle_1_v=-40.0).levels[1]
    angles = np.degrees(np.arccos(branches.frames[::2, 1, 2]))
    share = np.array([0.90625, 0.71875, 0.46875, 0.15625])
    np.testing.assert_allclose(angles, 60.0 - 40.0 * (0.6 - 1.6 * share))
    assert (np.diff(angles) < 0.0).all()


def test_longer_branches_have_more_children():
    """10 (.2 + .8 S): 9.4, 8.2, 6.6 and 4.6, rounded; each as long as .5 (length - .6 offset)."""
    skeleton = hand(levels=3, branches_2=10, length_2=0.5, curve_res_1=1)
    twigs = skeleton.levels[2]
    np.testing.assert_array_equal(np.bincount(twigs.parent), [9, 8, 7, 5])
    last = twigs.parent == 3
    offsets = 1.3 * (np.arange(5) + 0.5) / 5
    np.testing.assert_allclose(twigs.offset[last], offsets)
    np.testing.assert_allclose(twigs.length[last], 0.5 * (1.3 - 0.6 * offsets))


def test_inner_stems_of_deeper_levels_have_more_children():
    """8 (1 - .5 offset / length of the parent), for stems at 1/8, 3/8, 5/8 and 7/8: 7.5, 6.5, 5.5, 4.5."""
    named = {"levels": 4, "shape": 3, "branches_1": 1, "branches_2": 4, "branches_3": 8, "curve_res_2": 1}
    skeleton = hand(**named)
    np.testing.assert_array_equal(np.bincount(skeleton.levels[3].parent), [8, 7, 6, 5])


@pytest.mark.parametrize("res", [1, 3, 7])
def test_the_number_of_children_does_not_depend_on_the_segments(res: int):
    skeleton = hand(curve_res_0=res, branches_1=23)
    assert len(skeleton.levels[1]) == 23
    assert (np.diff(skeleton.levels[1].offset) > 0.0).all()
    assert skeleton.levels[1].offset.min() > 2.0


def test_a_clone_bears_children_beyond_its_split_only():
    skeleton = hand(base_splits=1, curve_res_0=4, branches_1=16, base_size=0.0, split_angle_0=30.0)
    trunk, clone = (skeleton.levels[1].offset[skeleton.levels[1].parent == stem] for stem in range(2))
    assert (len(trunk), len(clone)) == (16, 12)
    np.testing.assert_allclose(clone, trunk[4:])


def test_a_bare_trunk_has_no_children():
    assert len(hand(length_0=0.2, base_size=0.5).levels) == 1


def test_halves_are_rounded_up_even_after_an_error_of_rounding():
    np.testing.assert_array_equal(rounded(np.array([0.49, 0.5, 0.5 - 1e-12, 1.5, 2.4])), [0, 1, 1, 2, 2])
