"""Boosted trees: what they promise beyond what every method does (`test_fitting`)."""

import numpy as np
import pytest

from grammarlab.baselines import boosted_trees
from grammarlab.baselines.boosted_trees import MAX_TREES, fit


def stepped(num_rows, noise=0.0, num_columns=12, seed=0):
    """Counts of 0 to 4 with 90 points where the first is above 2, and noise."""
    generator = np.random.default_rng(seed)
    rows = generator.integers(0, 5, (num_rows, num_columns)).astype(np.float64)
    scores = np.where(rows[:, 0] > 2, 90.0, 0.0)
    return rows, scores, np.clip(scores + generator.normal(0.0, noise, num_rows), 0.0, 100.0)


def test_a_step_is_predicted_where_nobody_scored():
    rows, _, scores = stepped(64)
    fresh, truth, _ = stepped(500, seed=1)
    preference = fit(rows, scores)
    np.testing.assert_allclose(preference.predict(fresh).mean, truth, atol=2.0)
    first = preference.explain([f"column {number}" for number in range(12)])[0]
    assert (first.name, first.level) == ("column 0", "strong")


def test_noise_asks_for_fewer_trees_and_shows_in_the_uncertainty():
    exact, noisy = (fit(rows, scores) for rows, _, scores in (stepped(64), stepped(64, noise=20.0)))
    assert noisy.num_trees < exact.num_trees <= MAX_TREES
    fresh, truth, scored = stepped(500, noise=20.0, seed=1)
    predicted = noisy.predict(fresh)
    errors = predicted.mean - scored
    assert np.sqrt(np.mean(predicted.std**2)) == pytest.approx(np.sqrt(np.mean(errors**2)), rel=0.3)
    assert exact.predict(fresh).std.mean() < 0.3 * predicted.std.mean()
    assert np.mean((predicted.mean - truth) ** 2) < 0.5 * np.var(truth)


def test_members_differ_where_few_rows_were_scored():
    rows = np.repeat([[0.0], [1.0], [5.0]], [30, 30, 1], axis=0) + np.arange(61)[:, None] * 1e-3
    scores = np.repeat([0.0, 90.0, 40.0], [30, 30, 1])
    known, rare = fit(rows, scores).predict([[0.015], [5.06]]).std
    assert rare > 2.0 * known


def test_the_seed_draws_the_samples():
    rows, _, scores = stepped(40, noise=10.0)
    one, same, other = (fit(rows, scores, seed=seed).predict(rows).std for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


def test_the_number_of_trees_is_the_best_outside_the_samples(monkeypatch):
    rows, _, scores = stepped(40, noise=25.0)
    chosen = fit(rows, scores)
    for number in (10, 100, MAX_TREES):
        monkeypatch.setattr(boosted_trees, "MAX_TREES", number)
        monkeypatch.setattr(boosted_trees, "_TREE_STEP", number)
        assert fit(rows, scores).error >= chosen.error - 1e-9
