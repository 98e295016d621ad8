"""Totals of counts: those that matter by their parity, which no single count shows, and those that matter by number."""

from itertools import combinations

import numpy as np
import pytest

from grammarlab.features.search.totals import MAX_TERMS, MIN_SCORES, find_totals


def models(num, width, seed=0):
    randomness = np.random.default_rng(seed)
    return (randomness.random((num, width)) < randomness.uniform(0.2, 0.6, width)).astype(np.int64)


def said(meant, noise, seed=0):
    return np.clip(meant + np.random.default_rng(seed).normal(0.0, 1.0, len(meant)) * noise, 0.0, 100.0)


def weights_of(counts, scores):
    return [found.weights for found in find_totals(counts, scores)]


@pytest.mark.parametrize("noise", [0.0, 20.0])
@pytest.mark.parametrize("terms", range(2, MAX_TERMS + 1))
def test_a_parity_of_a_few_counts_is_found(terms, noise):
    counts = models(64, 30)
    chosen = np.arange(terms) * 4
    scores = said(100.0 * (counts[:, chosen].sum(axis=1) % 2), noise)
    assert chosen.tolist() in [np.flatnonzero(weights).tolist() for weights in weights_of(counts, scores)]


def test_the_parity_is_that_of_the_most_agreeing_set_of_all():
    clear = 0
    for seed in range(5):
        counts = models(40, 9, seed)
        liked = said(100.0 * (counts[:, :4].sum(axis=1) % 2), 45.0, seed) > 50.0
        sets = [list(each) for size in range(2, MAX_TERMS + 1) for each in combinations(range(9), size)]
        agreement = [abs(np.mean((counts[:, each].sum(axis=1) % 2 == 1) == liked) - 0.5) for each in sets]
        found = [np.flatnonzero(weights).tolist() for weights in weights_of(counts, 100.0 * liked)]
        if max(agreement) > 0.35:
            clear += 1
            assert sets[int(np.argmax(agreement))] in found
    assert clear >= 2


def test_an_odd_number_of_repeated_parts_counts_them_all():
    counts = np.random.default_rng(0).integers(0, 5, (96, 12))
    (weights,) = weights_of(counts, 60.0 * ((counts[:, 2] + counts[:, 7]) % 2))
    assert np.flatnonzero(weights).tolist() == [2, 7]


@pytest.mark.parametrize("noise", [0.0, 15.0])
def test_a_majority_is_found_with_its_signs(noise):
    counts = models(128, 40)
    total = counts[:, 3] + counts[:, 11] - counts[:, 30]
    found = weights_of(counts, said(np.where(total >= 1, 90.0, 10.0), noise))
    assert any((counts @ weights == total).all() or (counts @ weights == -total).all() for weights in found)


@pytest.mark.parametrize("num", [MIN_SCORES, 64, 128])
def test_scores_without_a_reason_have_no_total(num):
    for seed in range(12):
        scores = np.random.default_rng(seed).permutation(np.repeat([0.0, 100.0], [num - num // 2, num // 2]))
        assert find_totals(models(num, 60, seed), scores) == []


def test_a_single_count_is_no_total():
    counts = models(96, 20)
    assert find_totals(counts, 100.0 * counts[:, 5]) == []


def test_totals_of_more_terms_cost_more():
    counts = models(200, 20)
    few, many = (find_totals(counts, 100.0 * (counts[:, :terms].sum(axis=1) % 2))[0].price for terms in (3, 5))
    assert 0.0 < few < many


def test_few_or_equal_scores_have_none():
    counts = models(MIN_SCORES, 8)
    assert find_totals(counts[1:], 100.0 * (counts[1:, :2].sum(axis=1) % 2)) == []
    assert find_totals(counts, np.full(MIN_SCORES, 40.0)) == []
    assert find_totals(counts[:, :0], 100.0 * counts[:, 0]) == []
    assert find_totals(np.zeros((40, 3), dtype=np.int64), np.arange(40.0)) == []


@pytest.mark.parametrize("highest", [5e-324, 1e-160, 100.0])
def test_the_scale_of_scores_does_not_matter(highest):
    counts = models(80, 20)
    (total, *_) = find_totals(counts, highest * (counts[:, :3].sum(axis=1) % 2))
    assert np.flatnonzero(total.weights).tolist() == [0, 1, 2]


def test_the_order_of_models_does_not_matter():
    counts = models(80, 30)
    scores = said(100.0 * (counts[:, 4:8].sum(axis=1) % 2), 15.0)
    order = np.random.default_rng(1).permutation(80)
    for one, other in zip(find_totals(counts, scores), find_totals(counts[order], scores[order]), strict=True):
        np.testing.assert_array_equal(one.weights, other.weights)
