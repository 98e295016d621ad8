"""Choices of few examples: what is made alike several times in one tells no more than once."""

import numpy as np
import pytest
from scipy import sparse

from grammarlab.density.samples.levels import Shrinkage
from grammarlab.density.samples.mixture import Cells

CELLS = Cells(np.array([0.5, 0.3, 0.2]), np.zeros(3, dtype=np.int64))
NO = np.zeros(1, dtype=bool)


def shrinkage(counts, weights=None):
    weights = np.ones(len(counts)) if weights is None else weights
    return Shrinkage.of(CELLS, NO, NO, sparse.csr_array(counts.astype(float)), weights)


@pytest.mark.parametrize("times", [2, 7])
def test_what_is_made_alike_several_times_counts_as_one(times):
    once = np.eye(3)[np.random.default_rng(0).choice(3, 40, p=[0.5, 0.3, 0.2])]
    one, several = shrinkage(once), shrinkage(times * once)
    np.testing.assert_array_equal(one.spread, 1.0)
    np.testing.assert_array_equal(one.total, once.sum(axis=0))
    # One example in N is spent on the mean.
    np.testing.assert_allclose(several.total, one.total * (1.0 - 1.0 / 40))


def test_what_is_made_independently_counts_each_time():
    counts = np.random.default_rng(0).multinomial(5, CELLS.original, 4_000)
    assert shrinkage(counts).spread == pytest.approx(1.0, abs=0.05)
    # More even than chance has it: no reason to count more.
    np.testing.assert_array_equal(shrinkage(np.tile([5, 3, 2], (40, 1))).total, [200.0, 120.0, 80.0])


def test_examples_that_count_nothing_change_nothing():
    counts = np.random.default_rng(1).multinomial(3, CELLS.original, 30)
    more = np.concatenate([counts, [[3, 0, 0], [0, 0, 0]]])
    other = shrinkage(more, np.append(np.ones(30), [0.0, 1.0]))
    np.testing.assert_allclose(other.total, shrinkage(counts).total)


def test_choices_that_decide_more_of_a_model_are_likelier_to_matter():
    cells = Cells(np.full(6, 0.5), np.repeat(np.arange(3), 2))
    counts, none = sparse.csr_array(np.ones((4, 6))), np.zeros(3, dtype=bool)
    drawn = np.array([False, False, True])
    odds = [
        Shrinkage.of(cells, none, drawn, counts, np.ones(4), extents).odds
        for extents in (None, np.array([1.0, 1.0, 0.0]), np.array([0.75, 0.25, 0.0]), np.zeros(3))
    ]
    np.testing.assert_allclose(np.exp(odds), [[0.5, 0.5, 1.0], [0.5, 0.5, 1.0], [0.625, 0.375, 1.0], [0.5, 0.5, 1.0]])


def test_one_example_or_one_branch_is_possible():
    np.testing.assert_array_equal(shrinkage(np.array([[4, 0, 0]])).total, [4.0, 0.0, 0.0])
    np.testing.assert_array_equal(shrinkage(np.array([[4, 0, 0], [2, 0, 0]])).total, [6.0, 0.0, 0.0])
