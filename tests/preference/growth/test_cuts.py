"""Bins, divisions and screening: the best divisions and the sum of all by brute force, at their prices."""

from itertools import combinations, pairwise, permutations
from math import comb

import numpy as np
import pytest

from grammarlab.preference.growth.cuts import all_cuts, best_cuts, price_of_bounds
from grammarlab.preference.growth.ranks import binned, ranks_of
from grammarlab.preference.growth.screening import explained
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.person import Person


def test_bins_keep_the_order_of_values_and_equal_values_together():
    randomness = np.random.default_rng(0)
    columns = np.column_stack([randomness.integers(0, 5, 200), randomness.random(200), randomness.integers(0, 40, 200)])
    columns = columns.astype(np.float64)
    bins = binned(columns, 24)
    for column, codes in zip(columns.T, bins, strict=True):
        assert codes.max() < 24
        assert set(codes) == set(range(codes.max() + 1))
        order = np.argsort(column, kind="stable")
        assert (np.diff(codes[order]) >= 0).all()
        assert all(len(set(codes[column == value])) == 1 for value in set(column))
    assert bins[0].max() == 4
    # About as many labels in each bin.
    assert np.ptp(np.bincount(bins[1])) <= 2


@pytest.mark.parametrize("seed", range(6))
def test_the_best_division_of_a_column_and_the_sum_of_all_are_those_of_brute_force(seed):
    randomness = np.random.default_rng(seed)
    column = randomness.integers(0, 6, 14)
    scores = np.where(
        randomness.random(14) < 0.7, 90.0 * ((column == 2) | (column == 3)), randomness.integers(0, 101, 14)
    )
    evidence, chosen = LeafEvidence.of(scores, Person(5.0, 0.03)), np.array([0, 2, 3, 5, 6, 7, 9, 10, 11, 13])
    codes = ranks_of(column[chosen, None].astype(np.float64))
    found = best_cuts(codes, evidence.terms[chosen], evidence.of_sums)
    present = np.unique(column[chosen])
    best, every = -np.inf, list[float]()
    for number in range(1, len(present)):
        for bounds in combinations(range(1, len(present)), number):
            part = np.searchsorted(present[list(bounds)], column[chosen], side="right")
            total = sum(evidence.of_labels(chosen[part == index]) for index in range(number + 1))
            places = len(present) - 1
            # The number of bounds is geometric, at most that of places, and each set of so many is as likely.
            price = np.log(comb(places, number)) + number * np.log(2.0)
            price += np.log(sum(0.5**count for count in range(1, places + 1)))
            best = max(best, total - price)
            every.append(total - price - 0.7 * (number + 1))
    assert all_cuts(codes, evidence.terms[chosen], evidence.of_sums, -0.7)[0] == pytest.approx(
        np.logaddexp.reduce(every)
    )
    assert found.log_evidence[0] == pytest.approx(best)
    part_of = np.searchsorted(np.array(found.first(0)), codes[0], side="right")
    assert set(part_of) == set(range(len(found.first(0)) + 1))
    parts = [chosen[part_of == part] for part in range(len(found.first(0)) + 1)]
    assert sum(evidence.of_labels(part) for part in parts) > best
    assert all(column[low].max() < column[high].min() for low, high in pairwise(parts))


@pytest.mark.parametrize("num_places", range(1, 7))
def test_bounds_are_a_set(num_places):
    """A set is as likely as all orders of its bounds together, and all sets sum to 1."""
    sets: dict[frozenset[int], float] = {}
    for number in range(1, num_places + 1):
        orders = list(permutations(range(num_places), number))
        for order in orders:
            of_number = 0.5**number / (1.0 - 0.5**num_places)
            sets[frozenset(order)] = sets.get(frozenset(order), 0.0) + of_number / len(orders)
    assert sum(sets.values()) == pytest.approx(1.0)
    for bounds, probability in sets.items():
        assert price_of_bounds(len(bounds), num_places) == pytest.approx(-np.log(probability))


def test_screening_measures_means_and_forgives_chance():
    randomness = np.random.default_rng(4)
    scores = randomness.normal(50.0, 20.0, 100)
    level = (scores > 50.0).astype(np.int64)
    noise = randomness.integers(0, 8, (300, 100))
    gains = explained(np.vstack([level, noise]), 8, scores)
    assert gains[0] > 20.0
    assert gains[0] == pytest.approx(-50.0 * np.log(1.0 - between(level, scores)) - 0.5 * (1.0 + np.log(100 / 98)))
    assert abs(np.mean(gains[1:])) < 1.0
    assert (explained(noise, 8, np.full(100, 7.0)) == 0.0).all()


def between(level, scores):
    means = np.array([scores[level == 0].mean(), scores[level == 1].mean()])
    return ((means[level] - scores.mean()) ** 2).sum() / ((scores - scores.mean()) ** 2).sum()
