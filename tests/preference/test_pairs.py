"""Pairs to compare, against expected variances by quadrature and Monte Carlo."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from numpy.polynomial.hermite_e import hermegauss
from scipy.special import ndtr

from grammarlab.learning.fitting import fit
from grammarlab.preference.compared_pairs import most_telling_pairs, propose_pairs
from grammarlab.preference.queries import Situation


def variance_left(mean, covariance, noise, stakes, one, other):
    """Weighted variance that is left on average once it is known which of two models is preferred, by quadrature."""
    across = covariance[one] - covariance[other]
    spread, middle = across[one] - across[other], mean[one] - mean[other]
    nodes, weights = hermegauss(200)
    difference = middle + np.sqrt(spread) * nodes
    left = 0.0
    for sign in (1.0, -1.0):
        likely = weights * ndtr(sign * difference / np.sqrt(2.0 * noise)) / weights.sum()
        evidence = likely.sum()
        first = (likely * difference).sum() / evidence
        variance = (likely * (difference - first) ** 2).sum() / evidence
        # All values are linear in the difference, but for what it says nothing of.
        after = np.diagonal(covariance) - across**2 / spread * (1.0 - variance / spread)
        left += evidence * float(stakes @ after)
    return left


@pytest.mark.parametrize("seed", range(6))
def test_the_first_pair_leaves_the_least_variance(seed):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(7, 5)) * 10.0
    covariance, mean = root @ root.T + np.eye(7), rng.normal(size=7) * 30.0
    stakes, noise = rng.random(7), 40.0
    left = {pair: variance_left(mean, covariance, noise, stakes, *pair) for pair in combinations(range(7), 2)}
    found = most_telling_pairs(mean, covariance, 1, noise, stakes, np.ones((7, 7), dtype=bool))
    assert tuple(found[0].tolist()) == min(left, key=left.__getitem__)


@pytest.mark.parametrize("far", [1e3, 1e160, 1e300])
def test_known_answers_are_not_asked_for(far):
    # The values of the first two models vary most, but which of them is preferred, and to the others, is known.
    mean, covariance = np.array([far, -far, 0.0, 1.0]), np.diag([50.0, 40.0, 2.0, 1.0])
    found = most_telling_pairs(mean, covariance, 1, 1.0, np.ones(4), np.ones((4, 4), dtype=bool))
    assert found.tolist() == [[2, 3]]


def test_no_model_is_in_two_pairs_and_none_is_compared_with_itself():
    covariance = np.diag(np.arange(1.0, 12.0))
    found = most_telling_pairs(np.zeros(11), covariance, 9, 1.0, np.ones(11), np.ones((11, 11), dtype=bool))
    assert found.shape == (5, 2)
    assert len(np.unique(found)) == 10
    assert set(found[0].tolist()) == {9, 10}


def situation(num_known, fits):
    rng = np.random.default_rng(3)
    pool = rng.integers(0, 3, size=(120, 4)).astype(float)
    asked = np.arange(num_known)
    scores = 100.0 * (pool[asked, 0] == 2.0)
    preference = fit(pool[asked], scores) if fits else None
    return Situation(pool, np.arange(120) < 90, asked, scores, preference, np.where(np.arange(120) < 90, 1.0, 0.3))


@pytest.mark.parametrize(("num_known", "fits"), [(0, False), (5, False), (12, True), (60, True)])
def test_pairs_are_those_of_the_seed_and_none_is_asked_about_again(num_known, fits):
    known = situation(num_known, fits)
    nothing = np.zeros((0, 2), dtype=np.int64)
    pairs = propose_pairs(known, nothing, 6, 1)
    assert np.array_equal(pairs, propose_pairs(known, nothing, 6, 1))
    assert not np.array_equal(pairs, propose_pairs(known, nothing, 6, 2))
    assert len(np.unique(pairs)) == 12
    again = propose_pairs(known, pairs[:, ::-1], 6, 1)
    assert not {frozenset(pair) for pair in pairs.tolist()} & {frozenset(pair) for pair in again.tolist()}


def test_fewer_pairs_are_given_where_there_are_no_more():
    known = situation(0, False)
    few = Situation(known.pool[:3], known.from_grammar[:3], known.scored, known.scores, None)
    assert len(propose_pairs(few, np.zeros((0, 2), dtype=np.int64), 6, 1)) == 1
    assert len(propose_pairs(few, np.array([[0, 1], [0, 2], [1, 2]]), 6, 1)) == 0
    one = Situation(known.pool[:1], known.from_grammar[:1], known.scored, known.scores, None)
    assert propose_pairs(one, np.zeros((0, 2), dtype=np.int64), 6, 1).shape == (0, 2)
