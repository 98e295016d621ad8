"""Pruning by the envelope."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.arrays import Flags
from grammarlab.trees.envelope import is_inside
from grammarlab.trees.growth import grow
from grammarlab.trees.parameters import COLUMN
from grammarlab.trees.skeleton import Skeleton, Stems
from tests.cases import some
from tests.trees.rows import ASPEN, random_row, row, tree_keys

PRUNED = {"prune_width": 0.4, "prune_width_peak": 0.6, "prune_power_low": 0.6, "length_1": 0.4, "curve_0_v": 0.0}


def aspen(**named: float) -> Skeleton:
    return grow(row(**ASPEN | PRUNED | {"levels": 2, "leaves": 0} | named)[None], tree_keys(1))


def inside(skeleton: Skeleton, stems: Stems, scale: float = 1.0) -> Flags:
    """[N] whether nodes are in the envelope; of stems at a scale about the place where they begin."""
    first = np.repeat(stems.node_offsets[:-1], stems.num_nodes)
    points = stems.points[first] + scale * (stems.points - stems.points[first])
    tree = np.repeat(stems.tree, stems.num_nodes)
    return is_inside(skeleton.rows, tree, skeleton.scale, skeleton.scale, points)


@pytest.mark.parametrize("seed", some(range(60)))
def test_everything_but_the_trunk_is_in_the_envelope_if_its_share_is_1(seed: int):
    values = random_row(seed)
    for name, value in {"prune_ratio": 1.0, "wind_speed": 0.0, "z_scale": 1.0, "z_scale_v": 0.0}.items():
        values[COLUMN[name]] = value
    skeleton = grow(values[None], tree_keys(1))
    for stems in skeleton.levels[1:]:
        assert inside(skeleton, stems).all()


def test_a_pruned_stem_is_as_long_as_the_envelope_permits():
    free, pruned = aspen(), aspen(prune_ratio=1.0)
    share = pruned.levels[1].length / free.levels[1].length
    shortened = np.repeat(share < 1.0, pruned.levels[1].num_nodes)
    assert 0.2 < np.mean(share < 1.0) < 1.0
    assert inside(pruned, pruned.levels[1]).all()
    longer = np.all(inside(pruned, pruned.levels[1], 1.0001).reshape(len(share), -1), axis=1)
    assert not longer[share < 1.0].any()
    # Their draws are the same: only the scale changes.
    np.testing.assert_array_equal(pruned.levels[1].frames[shortened], free.levels[1].frames[shortened])


@pytest.mark.parametrize("ratio", [0.25, 0.5, 0.9])
def test_a_share_of_pruning_is_between_both_lengths(ratio: float):
    free, partly, fully = aspen(), aspen(prune_ratio=ratio), aspen(prune_ratio=1.0)
    expected = (1.0 - ratio) * free.levels[1].length + ratio * fully.levels[1].length
    np.testing.assert_allclose(partly.levels[1].length, expected)


def test_clones_are_pruned_with_their_stem():
    skeleton = aspen(prune_ratio=1.0, seg_splits_1=0.4, split_angle_1=40.0)
    stems = skeleton.levels[1]
    clones = stems.is_clone
    assert clones.any()
    np.testing.assert_array_equal(stems.length[clones], stems.length[stems.source[clones]])
    assert inside(skeleton, stems).all()


def test_an_envelope_of_no_width_prunes_all_branches():
    assert len(aspen(prune_ratio=1.0, prune_width=0.0, curve_0=30.0).levels) == 1
