"""The best tree of some labels: what it divides by, and the errors of the person."""

import numpy as np
import pytest

from grammarlab.preference.growth.split_columns import SplitColumns
from grammarlab.preference.growth.tree_growth import Others, TreeGrowth
from grammarlab.preference.judge.evidence_of_trees import log_evidence
from grammarlab.preference.judge.judge import best_tree
from grammarlab.preference.judge.labelled_columns import Labels
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.judge.unexplained_scores import log_evidence_of_nothing
from grammarlab.preference.person import Person


def labels_of(values, scores):
    values = np.asarray(values, dtype=float)
    return Labels.of(values, np.full(values.shape[1], 3.0), np.asarray(scores, dtype=float))


def test_bands_and_smooth_functions_are_found_by_their_columns():
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


def test_the_gain_of_trees_is_what_they_explain_beyond_any_distribution():
    randomness = np.random.default_rng(13)
    rows, person = randomness.integers(0, 2, (96, 60)).astype(np.float64), Person(10.0, 0.03)
    scores = np.clip(90.0 * rows[:, 3] + randomness.normal(0.0, 10.0, 96), 0.0, 100.0).round()

    def gain_of(scores, price=4.0):
        columns = SplitColumns.plain(rows, np.where(np.arange(60) == 3, price, np.log(60.0)))
        trees = Others(TreeGrowth(columns, LeafEvidence.of(scores, person)).trees(), rows)
        return log_evidence(columns, trees, scores, person) - log_evidence_of_nothing(scores, -1e9)

    assert gain_of(scores) > 50.0
    assert gain_of(randomness.permutation(scores)) < 1.0
    assert gain_of(scores, price=9.0) == pytest.approx(gain_of(scores, price=8.0) - 1.0, abs=0.01)
    assert gain_of(np.full(96, 30.0)) < -5.0


def test_one_distribution_of_values_is_as_good_a_rival_as_any_distribution_of_scores():
    scores = np.repeat([0.0, 92.4], [13, 11])
    of_scores = log_evidence_of_nothing(scores, -1e9)
    assert log_evidence_of_nothing(scores, 0.0) == pytest.approx(-np.log(2.0), abs=0.01)
    assert log_evidence_of_nothing(scores, of_scores + np.log(2.0)) == pytest.approx(of_scores + np.log(2.0))
    # What is given again and again is hardly a surprise.
    assert -24 * np.log(5.0) < of_scores < -24 * np.log(2.0)
