"""Fresh scores: distributions against sums by hand, and intervals against what simulated persons say."""

import numpy as np
import pytest
from scipy.stats import norm

from grammarlab.learning.fitting import fit
from grammarlab.preference import blended
from grammarlab.preference.cells import partition
from grammarlab.preference.factors import ProductPreference
from tests.cases import some
from tests.preference.fresh import SCORES, FreshScores, fresh_scores


def coins(number, width, seed):
    return np.random.default_rng(seed).integers(0, 2, (number, width)).astype(float)


def wanted(name, rows):
    if name == "sum":
        return rows[:, :4] @ np.array([40.0, 30.0, 20.0, 10.0])
    return 40.0 * rows[:, 0] + 50.0 * rows[:, 0] * rows[:, 1]


def said(person, values, seed):
    randomness = np.random.default_rng(seed)
    if person == "sd10":
        return np.clip(values + randomness.normal(0.0, 10.0, len(values)), 0.0, 100.0)
    if person == "blunders10":
        return np.where(randomness.random(len(values)) < 0.1, 100.0 * randomness.random(len(values)), values)
    return values


def test_an_interval_is_the_shortest_that_holds_enough():
    randomness = np.random.default_rng(0)
    probabilities = randomness.dirichlet(np.full(len(SCORES), 0.1), 40)
    low, high = FreshScores(probabilities).interval(0.8)
    for row, bottom, top in zip(probabilities, low, high, strict=True):
        ends = [
            (first, last)
            for first in range(len(SCORES))
            for last in range(first, len(SCORES))
            if row[first : last + 1].sum() >= 0.8
        ]
        shortest = min(last - first for first, last in ends)
        held = np.abs(SCORES - (bottom + top) / 2.0) < (top - bottom) / 2.0 + 0.5 - 1e-9
        assert held.sum() == shortest + 1
        assert row[held].sum() >= 0.8 - 1e-9
        assert 0.0 <= bottom < top <= 100.0


def test_quantiles_are_those_of_the_distribution():
    found = FreshScores(np.array([norm.pdf(SCORES, 40.0, 8.0), norm.pdf(SCORES, 60.0, 5.0)]))
    for part in (0.05, 0.5, 0.9):
        assert np.abs(found.quantile(part) - norm.ppf(part, [40.0, 60.0], [8.0, 5.0])).max() <= 1.0


def test_known_values_under_noise_have_clipped_normal_scores():
    rows = np.repeat([[0.0], [1.0]], 60, axis=0)
    scores = said("sd10", 50.0 * rows[:, 0], 1)
    found = partition.fit(rows, scores)
    told = fresh_scores(found, [[0.0], [1.0]]).probabilities
    at_0 = np.array([norm.cdf(0.5, 0.0, found.noise), *np.diff(norm.cdf(SCORES[1:] - 0.5, 0.0, found.noise))])
    assert np.abs(told[0, :-1] - at_0).max() < 0.06
    assert np.abs(told[1] @ SCORES - 50.0) < 5.0
    assert np.allclose(told.sum(axis=1), 1.0)


def test_who_does_not_err_has_intervals_of_one_score():
    rows = coins(64, 6, 2)
    found = blended.fit(rows, wanted("conjunction", rows))
    low, high = fresh_scores(found, coins(200, 6, 3)).interval()
    values = wanted("conjunction", coins(200, 6, 3))
    assert ((low <= values) & (values <= high)).all()
    assert (high - low).max() <= 4.0


@pytest.mark.parametrize("person", some(["sd10", "blunders10"]))
@pytest.mark.parametrize("name", ["sum", "conjunction"])
def test_intervals_hold_as_many_scores_as_they_say(name, person):
    held = []
    for seed in range(2):
        rows, fresh = coins(64, 6, seed), coins(1000, 6, 100 + seed)
        found = blended.fit(rows, said(person, wanted(name, rows), 10 + seed))
        low, high = fresh_scores(found, fresh).interval(0.9)
        answers = said(person, wanted(name, fresh), 20 + seed)
        held.append(((low <= answers) & (answers <= high)).mean())
    assert 0.84 <= np.mean(held) <= 0.97


def test_a_product_of_one_factor_is_that_factor():
    rows = coins(40, 4, 4)
    found = blended.fit(rows, wanted("sum", rows))
    product = fresh_scores(ProductPreference({"all": found}), rows).probabilities
    assert np.array_equal(product, fresh_scores(found, rows).probabilities)


def test_methods_that_tell_a_mean_and_a_deviation_have_intervals_too():
    rows = coins(40, 4, 5)
    found = fit(rows, wanted("sum", rows), method="grouped")
    told = found.predict(rows)
    low, high = fresh_scores(found, rows).interval()
    assert (low <= np.clip(told.mean, 0.0, 100.0) + 1e-6).all()
    assert (high >= np.clip(told.mean, 0.0, 100.0) - 1e-6).all()
