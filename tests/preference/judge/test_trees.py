"""Divisions, trees and lines: the best ones, with the totals that their description gives."""

from itertools import combinations, pairwise

import numpy as np
import pytest

from grammarlab.preference.judge.cuts import MAX_BINS, BinnedColumns, best_cuts
from grammarlab.preference.judge.labelled_columns import Labels, Person
from grammarlab.preference.judge.score_tree import NODE_PRICE, ScoreTree, TreeGrowth
from grammarlab.preference.judge.screening import explained
from grammarlab.preference.judge.tree_search import best_tree


def labels_of(values, scores):
    values = np.asarray(values, dtype=float)
    return Labels.of(values, np.full(values.shape[1], 3.0), np.asarray(scores, dtype=float))


def growth_of(labels, noise=5.0):
    return TreeGrowth(labels.binned, labels.prices, labels.scores, labels.evidence(Person(noise, 0.03)))


def test_bins_keep_the_order_of_values_and_equal_values_together():
    randomness = np.random.default_rng(0)
    columns = np.column_stack([randomness.integers(0, 5, 200), randomness.random(200), randomness.integers(0, 40, 200)])
    columns = columns.astype(np.float64)
    binned = BinnedColumns.of(columns)
    for column, codes, size in zip(columns.T, binned.codes, binned.sizes, strict=True):
        assert size <= MAX_BINS
        assert set(codes) == set(range(size))
        order = np.argsort(column, kind="stable")
        assert (np.diff(codes[order]) >= 0).all()
        assert all(len(set(codes[column == value])) == 1 for value in set(column))
    assert binned.sizes.tolist()[0] == 5
    # About as many labels in each bin.
    assert np.ptp(np.bincount(binned.codes[1])) <= 2


@pytest.mark.parametrize("seed", range(6))
def test_the_best_division_of_a_column_is_that_of_brute_force(seed):
    randomness = np.random.default_rng(seed)
    column = randomness.integers(0, 6, 14)
    scores = np.where(
        randomness.random(14) < 0.7, 90.0 * ((column == 2) | (column == 3)), randomness.integers(0, 101, 14)
    )
    labels = labels_of(column[:, None], scores)
    evidence, chosen = labels.evidence(Person(5.0, 0.03)), np.array([0, 2, 3, 5, 6, 7, 9, 10, 11, 13])
    found = best_cuts(labels.binned, np.array([0]), chosen, evidence.terms, evidence)
    present = np.unique(column[chosen])
    best = -np.inf
    for number in range(1, len(present)):
        for bounds in combinations(range(1, len(present)), number):
            part = np.searchsorted(present[list(bounds)], column[chosen], side="right")
            total = sum(evidence.of_labels(chosen[part == index]) for index in range(number + 1))
            places = len(present) - 1
            # The number of bounds is geometric, and there are at most as many as places.
            price = number * np.log(2.0 * places) + np.log(sum(0.5**count for count in range(1, places + 1)))
            best = max(best, total - price)
    assert found.log_evidence[0] == pytest.approx(best)
    parts = found.cuts[0].parts(labels.binned, chosen)
    assert sorted(np.concatenate(parts).tolist()) == chosen.tolist()
    assert all(column[low].max() < column[high].min() for low, high in pairwise(parts))


def described(tree: ScoreTree, labels: Labels, growth: TreeGrowth, used: list[int]) -> float:
    """Total of a tree by its description, nodes in the order of their first labels' bins."""
    if tree.cut is None:
        return growth.evidence.of_labels(tree.labels) - np.log(2.0)
    column = tree.cut.column
    again = np.log(2.0) + np.log(len(set(used))) if column in used else np.inf
    first = labels.prices[column] + (np.log(2.0) if used else 0.0)
    places = len(np.unique(labels.binned.codes[column, tree.labels])) - 1
    of_number = np.log(sum(0.5**count for count in range(1, places + 1)))
    total = -np.log(2.0) - min(again, first) - len(tree.cut.first) * np.log(2.0 * places) - of_number
    used = [*used, column]
    for part in tree.parts:
        total += described(part, labels, growth, used)
        used = [*used, *part.columns]
    return total


@pytest.mark.parametrize("seed", range(4))
def test_the_total_of_a_tree_is_its_evidence_less_its_description(seed):
    randomness = np.random.default_rng(seed)
    values = np.column_stack([randomness.integers(0, 3, (90, 8)), randomness.random((90, 4))])
    taste = np.where(
        values[:, 2] > 0, np.where(values[:, 9] > 0.4, 90.0, 20.0), np.where(values[:, 9] > 0.7, 60.0, 0.0)
    )
    labels = labels_of(values, np.clip(taste + randomness.normal(0.0, 5.0, 90), 0.0, 100.0).round())
    growth = growth_of(labels)
    tree = growth.grown(labels.every)
    assert {2, 9} <= tree.columns
    assert tree.total == pytest.approx(described(tree, labels, growth, []))
    assert sorted(np.concatenate([leaf.labels for leaf in tree.leaves()]).tolist()) == labels.every.tolist()
    assert tree.total > growth.evidence.of_labels(labels.every) - NODE_PRICE


def test_descriptions_of_small_trees_are_a_distribution():
    """The prices of all trees of two columns with two values each: their probabilities are at most 1 together."""
    price = np.log(2.0)

    def probability(free, used):
        """Probability of all descriptions of a node whose divisions may use some columns."""
        total = np.exp(-NODE_PRICE)
        for column in free:
            named = np.exp(-price - (np.log(2.0) if used else 0.0))
            named += 0.5 / len(used) if column in used else 0.0
            bounds = np.exp(-np.log(2.0))
            below = probability([other for other in free if other != column], {*used, column}) ** 2
            total += np.exp(-NODE_PRICE) * min(named, 1.0) * bounds * below
        return total

    assert probability([0, 1], set()) <= 1.0


def test_a_band_one_level_and_a_smooth_function_are_found():
    randomness = np.random.default_rng(1)
    values = np.column_stack([randomness.integers(0, 2, (96, 30)), randomness.random((96, 10))])
    start = [Person(8.0, 0.03)]
    band = 90.0 * (np.abs(values[:, 34] - 0.5) < 0.2)
    assert best_tree(labels_of(values, band), start).explanation.columns == {34}
    smooth = (100.0 * np.exp(-0.5 * ((values[:, 36] - 0.5) / 0.2) ** 2)).round()
    assert best_tree(labels_of(values, smooth), start).explanation.columns == {36}


def test_the_errors_of_the_person_are_found():
    randomness = np.random.default_rng(2)
    values = randomness.integers(0, 2, (200, 5))
    exact = best_tree(labels_of(values, 60.0 * values[:, 1]), [Person(20.0, 0.03)]).explanation.person
    assert exact.noise <= 1.5
    noisy = np.clip(60.0 * values[:, 1] + randomness.normal(0.0, 13.0, 200), 0.0, 100.0).round()
    assert 10.0 <= best_tree(labels_of(values, noisy), [Person(0.5, 0.03)]).explanation.person.noise <= 17.0


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
