"""Trees that are too large, and rows that are no trees."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.trees.budget import MAX_NODES
from grammarlab.trees.growth import grow, grow_chunks
from grammarlab.trees.parameters import COLUMNS, HIGH, IS_INTEGER, LOW
from tests.trees.rows import ASPEN, random_row, row, tree_keys


@pytest.mark.parametrize(
    ("named", "factor"),
    [
        ({"branches_1": 1000, "branches_2": 1000, "branches_3": 1000, "levels": 4}, "branches_1 = 1000"),
        ({"seg_splits_0": 4, "curve_res_0": 40}, "seg_splits_0 = 4"),
        ({"seg_splits_2": 4, "curve_res_2": 40}, "seg_splits_2 = 4"),
        ({"branches_1": 100, "branches_2": 100, "leaves": 500}, "leaves = 500"),
        ({"branches_1": 50, "branches_2": 1700, "curve_res_2": 40}, "branches_2 = 1700"),
    ],
)
def test_trees_that_are_too_large_end_in_a_message_before_memory_is_taken(named: dict[str, float], factor: str):
    tracemalloc.start()
    with pytest.raises(UsageError, match=rf"tree 1 would have .* are possible\. {factor} multiplies them most"):
        grow(np.stack([row(), row(**named)]), tree_keys(2))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 30e6


@pytest.mark.parametrize("value", [np.nan, np.inf, 9.0])
def test_rows_that_are_no_trees_are_refused(value: float):
    with pytest.raises(UsageError, match=r"tree 1: levels is .*; expected a number from 1 to 4\."):
        grow(np.stack([row(), row(levels=value)]), tree_keys(2))


def test_rows_of_another_width_are_refused():
    with pytest.raises(UsageError, match=rf"{len(COLUMNS)} parameters, found .* \(2, 3\)"):
        grow(np.zeros((2, 3)), tree_keys(2))


def test_every_possible_row_is_a_tree_of_numbers_or_too_large():
    """Uniform rows over all limits, but for the numbers of stems and leaves."""
    rng = np.random.default_rng(1)
    few = {"branches": 8, "seg_splits": 0.1, "curve_res": 8, "base_splits": 2, "leaves": 20}
    high = HIGH.copy()
    for column, name in enumerate(COLUMNS):
        high[column] = next((most for start, most in few.items() if name.startswith(start)), high[column])
    num_trees = 0
    for seed in range(40):
        values = rng.uniform(np.maximum(LOW, -high), high)
        values = np.where(IS_INTEGER, np.rint(values), values)
        try:
            skeleton = grow(values[None], tree_keys(1, seed))
        except UsageError:
            continue
        num_trees += 1
        for stems in skeleton.levels:
            assert np.isfinite(stems.points).all()
            assert (stems.length > 0).all()
            assert (stems.radius >= 0).all()
            products = np.einsum("nij,nik->njk", stems.frames, stems.frames)
            np.testing.assert_allclose(products, np.broadcast_to(np.eye(3), products.shape), atol=1e-9)
        assert np.isfinite(skeleton.leaves.frame).all()
    assert num_trees > 10


def test_no_trees_have_no_stems():
    skeleton = grow(np.zeros((0, len(COLUMNS))), tree_keys(0))
    assert (skeleton.num_trees, len(skeleton.levels), len(skeleton.leaves)) == (0, 1, 0)


@pytest.mark.parametrize("max_nodes", [1, 20_000, MAX_NODES])
def test_chunks_are_the_batch(max_nodes: int):
    rows = np.stack([random_row(seed) for seed in range(12)] + [row(**ASPEN)])
    keys = tree_keys(len(rows))
    chunks = list(grow_chunks(rows, keys, max_nodes))
    batch = grow(rows, keys)
    assert sum(chunk.num_trees for chunk in chunks) == len(rows)
    for chunk in chunks:
        nodes = sum(len(stems.points) for stems in chunk.levels) + 2 * len(chunk.leaves)
        assert chunk.num_trees == 1 or nodes <= max_nodes
    assert len(chunks) == {1: len(rows), MAX_NODES: 1}.get(max_nodes, len(chunks))
    np.testing.assert_array_equal(np.concatenate([chunk.leaves.position for chunk in chunks]), batch.leaves.position)
