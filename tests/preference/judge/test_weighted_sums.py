"""Weighted sums: weights of half-spaces and of weighted votes, rounded, each at a price."""

import numpy as np
import pytest
from scipy.optimize import minimize

from grammarlab.preference.judge.judge import judged
from grammarlab.preference.judge.votes import MAX_TERMS
from grammarlab.preference.judge.weighted_sums import _SPREAD, _fitted, weighted_sums
from tests.cases import takes_turns

NONE = np.zeros((128, 0))


def draws(num, width, seed):
    return np.random.default_rng(seed).random((num, width))


def test_weights_are_the_most_likely_ones():
    design, randomness = np.column_stack([np.ones(60), draws(60, 3, 0)]), np.random.default_rng(1)
    liked = (design @ [-1.0, 3.0, 0.0, -1.0] + randomness.logistic(size=60) > 0.0).astype(float)

    def minus_log_posterior(weights):
        sums = design @ weights
        return np.logaddexp(0.0, sums).sum() - liked @ sums + 0.5 * (weights[1:] ** 2).sum() / _SPREAD**2

    best = minimize(minus_log_posterior, np.zeros(4)).x
    assert _fitted(design, liked, np.zeros(4)) == pytest.approx(best, abs=0.02)


@takes_turns
@pytest.mark.parametrize("noise", [0.0, 10.0])
def test_a_half_space_is_one_column(noise):
    columns, fresh, randomness = 1.0 + 9.0 * draws(128, 8, 2), 1.0 + 9.0 * draws(4000, 8, 3), np.random.default_rng(4)

    def liked(some):
        return 2.0 * some[:, 1] + 0.7 * some[:, 4] - some[:, 6] < 6.0

    scores = np.clip(100.0 * liked(columns) + noise * randomness.normal(size=128), 0.0, 100.0).round()
    verdict = judged(columns, NONE, np.zeros(0), NONE, columns, scores)
    (found,) = verdict.sums
    assert set(found.columns) == {1, 4, 6}
    sums, inside = found.values(fresh), liked(fresh)
    bound = np.sort(sums)[int(inside.sum())]
    assert np.mean((sums < bound) == inside) > 0.96
    assert verdict.total > verdict.known + 5.0
    shuffled = judged(columns, NONE, np.zeros(0), NONE, columns, scores[randomness.permutation(len(scores))])
    assert shuffled.sums == ()


def test_prices_count_sets_digits_and_signs():
    columns = draws(90, 6, 5)
    scores = np.where(columns @ [3.0, -2.0, 1.0, 0.0, 0.0, 0.0] > 1.0, 100.0, 0.0)
    found = list(weighted_sums(columns, scores))
    assert found
    assert max(len(some.columns) for some in found) <= MAX_TERMS
    for some in found:
        assert some.weights[0] == 1.0
        assert len(set(some.columns)) == len(some.columns) == len(some.weights)
        digits = max(len(f"{abs(weight):.2g}".replace(".", "").strip("0")) for weight in some.weights)
        prices = {each.price for each in found if len(each.columns) == len(some.columns)}
        assert some.price in prices
        assert digits == 1 or some.price == max(prices)


def test_scores_that_are_all_liked_or_all_disliked_have_no_sums():
    columns = draws(20, 3, 6)
    assert list(weighted_sums(columns, np.full(20, 40.0))) == []
    assert list(weighted_sums(np.ones((20, 3)), np.arange(20.0))) == []
