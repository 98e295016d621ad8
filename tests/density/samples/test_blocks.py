"""Blocks of choices: what goes together shares a mixture, what does not is multiplied."""

import numpy as np
import pytest
from scipy import sparse

from grammarlab.density.samples.blocks import dependent_choices, fit_blocks, information
from grammarlab.density.samples.mixture import Cells

CELLS = Cells(np.full(8, 0.5), np.repeat(np.arange(4), 2))


@pytest.fixture
def derivations():
    """Four choices of two: the first two always agree, and so do the last two."""
    random = np.random.default_rng(3)
    first, last = random.integers(0, 2, (2, 2_000))
    taken = np.stack([first, first, last, last], axis=1)
    counts = np.zeros((2_000, 8))
    for choice in range(4):
        counts[np.arange(2_000), 2 * choice + taken[:, choice]] = 1.0
    return sparse.csr_array(counts)


def test_choices_that_agree_go_together(derivations):
    together = dependent_choices(CELLS, derivations, np.ones(2_000))
    assert together.tolist() == [[i != j and i // 2 == j // 2 for j in range(4)] for i in range(4)]


def test_blocks_are_multiplied(derivations):
    weights = np.ones(2_000)
    fit = fit_blocks(CELLS, derivations, weights, dependent_choices(CELLS, derivations, weights))
    assert len(fit.mixture.weights) == 4
    assert fit.mixture.weights.sum() == pytest.approx(1.0)
    # Two blocks of two components, each with a weight and two probabilities a component.
    assert fit.num_parameters == 2 * (1 + 2 * 2)
    sums = np.add.reduceat(fit.mixture.probabilities, np.arange(0, 8, 2), axis=1)
    np.testing.assert_allclose(sums, 1.0)
    # Every agreement comes with probability 1/4 instead of 1/16; no disagreement comes at all.
    ratio = np.exp(fit.mixture.log_ratio(CELLS, derivations))
    np.testing.assert_allclose(ratio, 4.0, rtol=0.15)
    mixed = sparse.csr_array(np.array([[1.0, 0, 0, 1.0, 1.0, 0, 1.0, 0]]))
    assert fit.mixture.log_ratio(CELLS, mixed)[0] == -np.inf


def test_what_is_independent_is_one_component():
    random = np.random.default_rng(5)
    counts = np.zeros((2_000, 8))
    for choice in range(4):
        counts[np.arange(2_000), 2 * choice + random.integers(0, 2, 2_000)] = 1.0
    table, weights = sparse.csr_array(counts), np.ones(2_000)
    together = dependent_choices(CELLS, table, weights)
    assert not together.any()
    assert len(fit_blocks(CELLS, table, weights, together).mixture.weights) == 1


def test_dependence_must_be_worth_its_numbers():
    assert information(np.outer([30.0, 70.0], [0.4, 0.6])) < 0.0
    assert information(np.diag([50.0, 50.0])) > 50.0
    assert information(np.array([[3.0, 2.0], [2.0, 3.0]])) < 0.0
    table = np.array([[5.0, 1.0, 0.0], [0.0, 9.0, 2.0]])
    assert information(table) == pytest.approx(information(table.T))
