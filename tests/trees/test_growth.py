"""Skeletons against the stem-by-stem oracle."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.trees.growth import grow
from grammarlab.trees.parameters import COLUMN
from grammarlab.trees.skeleton import Skeleton, Stems
from tests.cases import some
from tests.trees.oracle import Leaf, Stem, Tree
from tests.trees.rows import random_row, tree_keys


def assert_same_stems(stems: Stems, expected: list[Stem], parents: list[Stem], tolerance: float) -> None:
    rows = {id(stem): row for row, stem in enumerate(expected)}
    parent_rows = {id(stem): row for row, stem in enumerate(parents)} | {id(None): -1}
    assert stems.key.tolist() == [stem.key for stem in expected]
    assert stems.parent.tolist() == [parent_rows[id(stem.parent)] for stem in expected]
    assert stems.source.tolist() == [-1 if stem.source is None else rows[id(stem.source)] for stem in expected]
    assert stems.first.tolist() == [stem.first for stem in expected]
    assert stems.num_nodes.tolist() == [len(stem.points) for stem in expected]
    for name in ("length", "radius", "offset"):
        np.testing.assert_allclose(
            getattr(stems, name), [getattr(stem, name) for stem in expected], rtol=1e-6, atol=tolerance
        )
    np.testing.assert_allclose(stems.points, np.concatenate([stem.points for stem in expected]), atol=tolerance)
    np.testing.assert_allclose(stems.frames, np.concatenate([stem.frames for stem in expected]), atol=1e-6)


def assert_same_leaves(skeleton: Skeleton, expected: list[Leaf], last: list[Stem], tolerance: float) -> None:
    leaves, rows = skeleton.leaves, {id(stem): row for row, stem in enumerate(last)}
    assert leaves.stem.tolist() == [rows[id(leaf.stem)] for leaf in expected]
    assert leaves.is_blossom.tolist() == [leaf.is_blossom for leaf in expected]
    if not expected:
        return
    for name, absolute in (
        ("offset", tolerance),
        ("position", tolerance),
        ("frame", 1e-6),
        ("length", 1e-9),
        ("width", 1e-9),
    ):
        values = np.array([getattr(leaf, name) for leaf in expected])
        np.testing.assert_allclose(getattr(leaves, name), values, atol=absolute)


@pytest.mark.parametrize("seed", some(range(200)))
def test_a_tree_is_that_of_the_oracle(seed: int):
    row, keys = random_row(seed), tree_keys(1, seed)
    skeleton, tree = grow(row[None], keys), Tree(row, int(keys[0]))
    # Lengths of pruned stems are found by bisection, to 2^-24.
    tolerance = tree.scale * (1e-5 if row[COLUMN["prune_ratio"]] > 0.0 else 1e-8)
    assert [len(stems) for stems in skeleton.levels] == [len(stems) for stems in tree.levels]
    for level, stems in enumerate(tree.levels):
        assert_same_stems(skeleton.levels[level], stems, tree.levels[level - 1] if level else [], tolerance)
    assert_same_leaves(skeleton, tree.leaves, tree.levels[-1], tolerance)
