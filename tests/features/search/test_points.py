"""Points for counts: sums and products of what a person likes, found among many counts."""

import numpy as np
import pytest

from grammarlab.features.search.points import MAX_TERMS, MIN_SCORES, find_points

POINTS = np.array([30.0, 25.0, 20.0, 15.0])
PLACES = np.array([3, 11, 19, 27])


def models(num, width=60, seed=0):
    randomness = np.random.default_rng(seed)
    return (randomness.random((num, width)) < randomness.uniform(0.3, 0.7, width)).astype(np.int64)


def said(meant, noise, seed=1):
    return np.clip(meant + np.random.default_rng(seed).normal(0.0, 1.0, len(meant)) * noise, 0.0, 100.0)


def points(counts, scores):
    return find_points(counts, np.asarray(scores, dtype=np.float64))


def likelihood(found, scores):
    left = max(float(((scores - found.predicted) ** 2).mean()), 0.25)
    return -0.5 * len(scores) * np.log(left) - found.price


@pytest.mark.parametrize("noise", [0.0, 5.0, 10.0])
def test_points_that_add_up_are_found_in_proportion(noise):
    counts = models(128)
    scores = said(5.0 + counts[:, PLACES] @ POINTS, noise)
    found = max(points(counts, scores), key=lambda each: likelihood(each, scores))
    assert set(np.flatnonzero(found.weights)) == set(PLACES)
    np.testing.assert_allclose(found.weights[PLACES] / 8.0, POINTS / 30.0, atol=0.2)


@pytest.mark.parametrize("noise", [0.0, 10.0])
def test_factors_that_multiply_are_found_in_proportion_to_their_logarithms(noise):
    counts = models(128)
    factors = np.array([4.0, 3.0, 2.0])
    scores = said(4.0 * np.prod(factors ** counts[:, PLACES[:3]], axis=1), noise)
    found = max(points(counts, scores), key=lambda each: likelihood(each, scores))
    assert set(PLACES[:3]) <= set(np.flatnonzero(found.weights))
    np.testing.assert_allclose(
        found.weights[PLACES[:3]] / found.weights[PLACES[0]], np.log(factors) / np.log(4), atol=0.25
    )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("multiplied", [False, True])
def test_points_are_found_although_every_tenth_score_is_random(multiplied, seed):
    counts, randomness = models(128), np.random.default_rng(seed)
    linear = counts[:, PLACES[:3]] @ (np.log([4.0, 3.0, 2.0]) if multiplied else POINTS[:3])
    meant = 4.0 * np.exp(linear) if multiplied else linear
    scores = np.where(randomness.random(128) < 0.1, randomness.uniform(0.0, 100.0, 128), meant)
    found = points(counts, scores)[multiplied]
    assert set(np.flatnonzero(found.weights)) == set(PLACES[:3])
    np.testing.assert_allclose(found.predicted, meant, atol=2.0)


def test_a_small_weight_of_a_large_count_is_kept():
    counts = models(128)
    counts[:, 5] = np.random.default_rng(2).integers(0, 60, 128)
    scores = 1.0 * counts[:, 5] + 40.0 * counts[:, 8]
    weights = points(counts, scores)[0].weights
    assert weights[8] == 40 * weights[5] > 0


def test_a_dislike_has_points_below_zero():
    counts = models(128)
    weights = points(counts, 50.0 + 30.0 * counts[:, 4] - 45.0 * counts[:, 9])[0].weights
    assert weights[9] == -8
    assert weights[4] == 5


def test_scores_without_a_reason_have_no_points():
    found = [points(models(64, 300, seed), np.random.default_rng(seed).uniform(0.0, 100.0, 64)) for seed in range(20)]
    assert sum(map(bool, found)) <= 1


def test_what_one_count_explains_has_no_points():
    counts = models(96)
    assert points(counts, 80.0 * counts[:, 7]) == []
    assert points(counts, said(80.0 * counts[:, 7], 10.0)) == []


def test_more_points_have_a_higher_price_and_are_never_too_many():
    counts = models(256)
    prices = []
    for terms in (2, 3, 4):
        found = points(counts, 5.0 + counts[:, PLACES[:terms]] @ POINTS[:terms])[0]
        assert np.count_nonzero(found.weights) == terms
        prices.append(found.price)
    assert prices[0] < prices[1] < prices[2]
    found = points(counts, said(counts[:, :20].sum(axis=1) * 5.0, 3.0))
    assert all(np.count_nonzero(each.weights) <= MAX_TERMS for each in found)


@pytest.mark.parametrize("scale", [0.25, 0.5])
def test_points_do_not_depend_on_the_scale_of_scores(scale):
    counts = models(128)
    scores = said(5.0 + counts[:, PLACES] @ POINTS, 8.0)
    for one, other in zip(points(counts, scores), points(counts, scale * scores), strict=True):
        np.testing.assert_array_equal(one.weights, other.weights)
        np.testing.assert_allclose(other.predicted, scale * one.predicted, atol=1e-6)


def test_points_do_not_depend_on_the_order_of_models():
    counts, order = models(128), np.random.default_rng(3).permutation(128)
    scores = said(5.0 + counts[:, PLACES] @ POINTS, 8.0)
    for one, other in zip(points(counts, scores), points(counts[order], scores[order]), strict=True):
        np.testing.assert_array_equal(one.weights, other.weights)


def test_equal_scores_few_scores_and_few_counts_have_no_points():
    counts = models(64)
    assert points(counts, np.full(64, 40.0)) == []
    assert points(counts, np.full(64, 5e-324)) == []
    assert points(counts[: MIN_SCORES - 1], counts[: MIN_SCORES - 1, :2].sum(axis=1) * 40.0) == []
    assert points(counts[:, :0], counts[:, 0] * 40.0) == []
    assert points(counts[:, :1], counts[:, 0] * 40.0) == []
    assert points(np.ones((64, 5), dtype=np.int64), counts[:, 0] * 40.0) == []
    assert points(counts, np.where(np.arange(64) < 1, 5e-324, 0.0)) == []


def test_counts_near_the_largest_are_compared_like_others():
    counts = models(128)
    large = counts * (2**31 - 1)
    scores = counts[:, PLACES[:2]] @ POINTS[:2]
    np.testing.assert_array_equal(points(large, scores)[0].weights, points(counts, scores)[0].weights)
