"""Trees: skeletons as columns against the stem-by-stem interpreter, and their meshes."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.scene import triangles
from grammarlab.scene.triangles import count_triangles
from grammarlab.trees.growth import grow
from grammarlab.trees.scene import realize_trees
from grammarlab.trees.species import Look
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


@pytest.mark.parametrize("detail", ["full", "medium", "low"])
def test_realize_a_tree_of_10000_stems(benchmark, detail):
    """At most .2 CPU s at full detail."""
    skeleton = grow(row(**ASPEN | LARGE | {"leaves": 3})[None], tree_keys(1))
    scene = benchmark(realize_trees, skeleton, Look(), detail)
    benchmark.extra_info["triangles"] = int(count_triangles(scene).sum())


def test_merge_the_triangles_of_a_tree_of_10000_stems(benchmark):
    benchmark(triangles, realize_trees(grow(row(**ASPEN | LARGE | {"leaves": 3})[None], tree_keys(1)), Look()))


def test_grow_realize_and_merge_1000_low_trees(benchmark):
    """At most 10 CPU s for about 2,000 triangles each, 50 trees at a time."""
    rows = np.tile(row(**ASPEN | {"branches_1": 24, "branches_2": 8, "leaves": 6}), (50, 1))
    keys = np.split(tree_keys(1000), 20)

    def run() -> int:
        return sum(len(triangles(realize_trees(grow(rows, part), Look(), "low")).triangles) for part in keys)

    benchmark.extra_info["triangles per tree"] = benchmark.pedantic(run, rounds=2) / 1000


def test_draw_the_cards_of_a_tree(benchmark):
    skeleton = grow(row(**ASPEN | {"leaves": 5})[None], tree_keys(1))
    benchmark.pedantic(realize_trees, (skeleton, Look(), "cards"), rounds=2)
