"""Two sets of parts that go together or do not: true ones are found, at the price of their choice among all."""

from itertools import chain, combinations
from math import comb, log

import numpy as np
import pytest

from grammarlab.arrays import SEVERAL
from grammarlab.preference.judge.pair_tables import MixedSets, _uncertainty, mixed_sets

ROUND, ANGULAR = (0, 4, 7, 9), (2, 5, 8)


def noisy(values, seed):
    return np.clip(values + np.random.default_rng(seed).normal(0.0, 10.0, len(values)), 0.0, 100.0).round()


def log_likelihood(likes):
    """Of likes from 0 to 1 with one probability of a like."""
    mean = likes.mean() if len(likes) else 0.0
    return sum(part * len(likes) * log(part) for part in (mean, 1.0 - mean) if part > 0.0)


def loss(has, scores, first, second):
    """Price less gain, in plain words."""
    num = has.shape[1]
    price = log(comb(num, len(first)) * comb(num - len(first), len(second))) + (len(first) + len(second) - 1) * log(2.0)
    likes = (scores - scores.min()) / (scores.max() - scores.min())
    both = has[:, list(first)].any(axis=1) & has[:, list(second)].any(axis=1)
    return price - (log_likelihood(likes[both]) + log_likelihood(likes[~both]) - log_likelihood(likes))


def others(num, first, second):
    """Sets with one part more, less or exchanged."""
    rest = sorted({*range(num)} - {*first, *second})
    for one, other in ((first, second), (second, first)):
        yield from (((*one, part), other) for part in rest)
        shorter = [tuple(part for part in one if part != gone) for gone in one if len(one) > 1]
        yield from ((short, other) for short in shorter)
        yield from (((*short, part), other) for short in shorter for part in rest)
        yield from ((short, (*other, part)) for short in shorter for part in rest)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_families_that_must_not_be_mixed_are_found_part_by_part(sign):
    has = np.random.default_rng(1).random((128, 14)) < 0.25
    mixed = has[:, list(ROUND)].any(axis=1) & has[:, list(ANGULAR)].any(axis=1)
    best = mixed_sets(has, noisy(50.0 + sign * 45.0 * (2.0 * mixed - 1.0), 1))[0]
    assert best[:2] == (ROUND, ANGULAR)
    np.testing.assert_array_equal(best.values(has), mixed)
    assert best.price == pytest.approx(log(comb(14, 4) * comb(10, 3) / 2.0) + 7 * log(2.0))


@pytest.mark.parametrize("seed", range(6))
def test_no_part_more_less_or_exchanged_is_better(seed):
    randomness = np.random.default_rng(seed)
    has = randomness.random((60, 7)) < 0.3
    scores = noisy(90.0 * (has[:, [0, 1]].any(axis=1) & has[:, [2, 3]].any(axis=1)) * randomness.random(60), seed)
    listed = mixed_sets(has, scores)
    losses = [loss(has, scores, one.first, one.second) for one in listed]
    assert 0 < len(listed) <= SEVERAL
    assert losses == pytest.approx(sorted(losses))
    share = (scores - scores.min()) / np.ptp(scores)
    for one, of_one in zip(listed, losses, strict=True):
        # Each is of designs that are liked more than others, or of such that are liked less.
        sign = np.sign(share[one.values(has) > 0].mean() - share.mean())
        for first, second in others(7, one.first, one.second):
            both = MixedSets(first, second, 0.0).values(has) > 0
            if both.any() and sign * (share[both].mean() - share.mean()) > 1e-9:
                assert of_one <= loss(has, scores, first, second) + 1e-6


def test_prices_are_the_logs_of_a_prior():
    has = np.random.default_rng(3).random((200, 5)) < 0.4
    sets = list(chain.from_iterable(combinations(range(5), size) for size in range(1, 5)))
    pairs = [(a, b) for a, b in combinations(sets, 2) if not {*a} & {*b}]
    priors = []
    for first, second in pairs:
        both = has[:, list(first)].any(axis=1) & has[:, list(second)].any(axis=1)
        (best, *_) = mixed_sets(has, np.where(both, 100.0, 0.0))
        priors.append(np.exp(-best.price))
    assert len(pairs) == 90
    assert sum(priors) <= 1.0


def test_the_order_of_designs_changes_nothing():
    randomness = np.random.default_rng(4)
    has, order = randomness.random((64, 9)) < 0.3, randomness.permutation(64)
    scores = randomness.integers(0, 101, 64).astype(float)
    assert [one[:2] for one in mixed_sets(has, scores)] == [one[:2] for one in mixed_sets(has[order], scores[order])]


@pytest.mark.parametrize(("width", "high"), [(0, 90.0), (1, 90.0), (4, 0.0)])
def test_nothing_is_mixed_without_parts_or_differences(width, high):
    has = np.random.default_rng(5).random((40, width)) < 0.5
    assert mixed_sets(has, np.linspace(0.0, high, 40)) == []


def test_rounding_errors_of_likes_are_no_evidence():
    number, likes = np.array([3.0, 3.0, 3.0]), np.array([-1e-17, 3.0 + 1e-15, 0.0])
    assert _uncertainty(number, likes) == pytest.approx(0.0, abs=1e-12)
