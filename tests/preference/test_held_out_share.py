"""Shares of a process beside cells: whichever of them predicts held-out scores."""

import numpy as np
import pytest
from scipy.stats import norm

from grammarlab.preference.held_out_share import PROCESS_SHARES, HeldOut, mean_share, share_by
from grammarlab.preference.person import MODEL_NOISES


def shared(process, cells, scores, row=None):
    """Share of a process that misses scores by some points, and cells that miss them by others."""
    predicted = np.clip(np.stack([scores + process, scores + cells]), 0.0, 100.0)
    return share_by(predicted, scores, np.arange(len(scores)) if row is None else row)


def test_cells_are_preferred_if_both_parts_are_equally_good():
    scores = np.linspace(20.0, 80.0, 40)
    same = 5.0 * np.random.default_rng(0).normal(size=40)
    assert shared(same, same, scores) == pytest.approx(np.sum(PROCESS_SHARES) / (20.0 + len(PROCESS_SHARES) - 1.0))


def test_the_share_is_a_mean_over_the_posterior_of_shares():
    randomness, scores = np.random.default_rng(1), np.linspace(20.0, 80.0, 30)
    process, cells = 4.0 * randomness.normal(size=30), 6.0 * randomness.normal(size=30)

    def density(share, noise):
        return np.prod(0.97 * norm.pdf(share * process + (1.0 - share) * cells, 0.0, noise) + 0.03 / 100.0)

    densities = np.array([sum(density(share, noise) for noise in MODEL_NOISES) for share in PROCESS_SHARES])
    odds = densities**0.25 * np.append(20.0, np.ones(len(PROCESS_SHARES) - 1))
    assert shared(process, cells, scores) == pytest.approx(odds @ PROCESS_SHARES / odds.sum())


def test_infinite_odds_decide():
    equal = np.zeros(len(PROCESS_SHARES))
    assert mean_share(equal, np.inf) == 0.0
    assert mean_share(equal, -np.inf) == pytest.approx(np.mean(PROCESS_SHARES[1:]))


def test_the_better_part_gets_almost_all():
    randomness = np.random.default_rng(2)
    good, poor = 3.0 * randomness.normal(size=60), 20.0 * randomness.normal(size=60)
    scores = np.linspace(20.0, 80.0, 60)
    assert shared(good, poor, scores) > 0.85
    assert shared(poor, good, scores) < 0.05


def test_a_random_score_does_not_choose_the_part():
    randomness = np.random.default_rng(3)
    good, poor = 4.0 * randomness.normal(size=60), 12.0 * randomness.normal(size=60)
    good[7] = 70.0
    assert shared(good, poor, np.full(60, 20.0)) > 0.7


def test_scores_of_one_design_count_once():
    randomness = np.random.default_rng(4)
    good, poor = 4.0 * randomness.normal(size=20), 12.0 * randomness.normal(size=20)
    scores, row = np.linspace(20.0, 80.0, 20), np.arange(20)
    again = np.append(row, [3] * 40)
    assert shared(good[again], poor[again], scores[again], again) == pytest.approx(shared(good, poor, scores))


def test_contradicting_scores_of_a_design_are_its_mean():
    scores, row = np.append(np.zeros(8), np.full(8, 90.0)), np.tile(np.arange(8), 2)
    assert share_by(np.stack([np.full(16, 45.0), np.zeros(16)]), scores, row) > 0.9


def test_the_explained_variance_is_that_of_a_regression():
    scores = np.array([10.0, 40.0, 70.0, 80.0])
    perfect, mean = HeldOut(0.0, 0.0, np.zeros(4), scores, ()), HeldOut(0.0, 0.0, scores.mean() - scores, scores, ())
    half = HeldOut(0.0, 0.0, (scores.mean() - scores) / np.sqrt(2.0), scores, ())
    worse, equal = HeldOut(0.0, 0.0, 2.0 * scores, scores, ()), HeldOut(0.0, 0.0, np.zeros(4), np.full(4, 50.0), ())
    found = [case.explained_variance for case in (perfect, mean, half, worse)]
    assert found == pytest.approx([1.0, 0.0, 0.5, 0.0])
    assert equal.explained_variance is None
