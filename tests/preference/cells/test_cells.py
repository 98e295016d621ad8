"""Cells: evidence and posterior beside sums over all values."""

import numpy as np
import pytest

from grammarlab.preference.cells.cells import ScoreCells, grid_of
from grammarlab.preference.person import log_likelihood

SCORES = np.array([0.0, 0.0, 62.0, 60.0, 3.0, 57.0])


def cells_of(noise=5.0):
    return ScoreCells(SCORES, grid_of(SCORES), noise, 0.05)


def prior_of(cells):
    """[G] one quarter at 0, the rest over the even grid and the scores.

    Of those below 1.5 standard deviations of the noise nine tenths go to 0.
    """
    even = np.isin(cells.grid, np.arange(0.0, 101.0, 4.0))
    prior = 0.75 * (0.8 * even / even.sum() + 0.2 / len(cells.grid))
    prior[0] += 0.25
    for place, value in enumerate(cells.grid.tolist()):
        if 0.0 < value < 1.5 * cells.noise:
            prior[0] += 0.9 * prior[place]
            prior[place] *= 0.1
    return prior


@pytest.mark.parametrize("cell", [[0], [2, 3, 5], [0, 2], [0, 1, 2, 3, 4, 5]])
def test_evidence_and_posterior_are_sums_over_all_values(cell):
    cells, cell = cells_of(), np.array(cell)
    terms = prior_of(cells) * np.exp(log_likelihood(SCORES[cell], cells.grid, 5.0, 0.05).astype(float).sum(axis=0))
    assert cells.of_labels(cell) == pytest.approx(np.log(terms.sum()), abs=1e-4)
    np.testing.assert_allclose(cells.posterior(cell), terms / terms.sum(), atol=1e-5)


def test_a_prior_is_a_distribution():
    assert prior_of(cells_of()).sum() == pytest.approx(1.0)


def test_evidence_of_many_parts_at_once_is_that_of_each():
    cells = cells_of()
    parts = [np.array([0, 1]), np.array([2]), np.array([3, 4, 5]), np.arange(6)]
    inside = np.array([np.isin(np.arange(6), part) for part in parts], dtype=np.float32)
    each = [cells.of_labels(part) for part in parts]
    assert cells.log_evidence(inside) == pytest.approx(each, abs=1e-4)
    sums = np.array([cells.terms[part].sum(axis=0) for part in parts]).reshape(2, 2, -1)
    assert cells.of_sums(sums) == pytest.approx(np.reshape(each, (2, 2)), abs=1e-4)
    assert cells.of_sums(np.zeros((1, sums.shape[-1])))[0] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("num", [1, 5, 24])
def test_a_grid_has_all_of_few_different_scores(num):
    scores = np.random.default_rng(num).uniform(0.0, 100.0, num)
    grid = grid_of(np.tile(scores, 3))
    assert set(scores) | set(np.arange(0.0, 101.0, 4.0)) == set(grid)
    assert len(grid_of(np.random.default_rng(num).uniform(0.0, 100.0, 500))) <= 26 + 24
