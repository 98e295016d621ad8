"""Skeletons of trees as columns against the stem-by-stem interpreter."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.trees.growth import grow
from tests.trees.oracle import Tree
from tests.trees.rows import ASPEN, row, tree_keys

LARGE = {"branches_1": 110, "branches_2": 115}
"""About 10,000 stems."""


@pytest.mark.parametrize("leaves", [0, 25])
def test_grow_a_tree_of_10000_stems(benchmark, leaves):
    """At most .1 CPU s without leaves."""
    rows, keys = row(**ASPEN | LARGE | {"leaves": leaves})[None], tree_keys(1)
    skeleton = benchmark(grow, rows, keys)
    benchmark.extra_info |= {
        "stems": sum(len(stems) for stems in skeleton.levels),
        "leaves": len(skeleton.leaves),
    }


def test_grow_a_tree_of_10000_stems_that_fork_and_are_pruned(benchmark):
    named = {"leaves": 0, "seg_splits_1": 0.2, "split_angle_1": 20.0, "prune_ratio": 0.5, "branches_2": 60}
    skeleton = benchmark(grow, row(**ASPEN | LARGE | named)[None], tree_keys(1))
    benchmark.extra_info["stems"] = sum(len(stems) for stems in skeleton.levels)


def test_grow_a_tree_stem_by_stem(benchmark):
    """The aspen of 1,250 stems and 22,000 leaves: `test_grow_an_aspen` is at least 50 times as fast."""
    benchmark.pedantic(lambda: Tree(row(**ASPEN), int(tree_keys(1)[0])), rounds=3)


def test_grow_an_aspen(benchmark):
    skeleton = benchmark(grow, row(**ASPEN)[None], tree_keys(1))
    benchmark.extra_info["leaves"] = len(skeleton.leaves)


def test_grow_1000_trees_of_180_stems(benchmark):
    rows = np.tile(row(**ASPEN | {"branches_1": 20, "branches_2": 10, "leaves": 5}), (1000, 1))
    skeleton = benchmark.pedantic(grow, (rows, tree_keys(1000)), rounds=3)
    benchmark.extra_info["stems per tree"] = sum(len(stems) for stems in skeleton.levels) / 1000
