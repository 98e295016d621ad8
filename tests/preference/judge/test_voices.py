"""Two voices: found where the order of scores shows them, and nowhere else."""

import numpy as np
import pytest

from grammarlab.preference.base import ODDS_OF_SIMPLER
from grammarlab.preference.growth.screening import coarse_bins, gains, gains_of_parts
from grammarlab.preference.growth.tree_growth import TreeGrowth
from grammarlab.preference.judge.labelled_columns import Labels
from grammarlab.preference.judge.voices import (
    Division,
    _divisions,
    _explained,
    _predicted,
    two_voices,
)
from grammarlab.preference.person import Person

WIDTH = 30


def columns_of(num, seed):
    randomness = np.random.default_rng(seed)
    return np.column_stack([randomness.integers(0, 2, (num, 20)), randomness.random((num, WIDTH - 20))]).astype(float)


def prices():
    return np.full(WIDTH, np.log(2.0 * WIDTH))


ERRORS = {
    "exact": lambda values, _randomness: values,
    "sd10": lambda values, randomness: np.clip(values + randomness.normal(0.0, 10.0, len(values)), 0.0, 100.0),
    "sd20": lambda values, randomness: np.clip(values + randomness.normal(0.0, 20.0, len(values)), 0.0, 100.0),
    "stars": lambda values, _randomness: np.floor(values / 25.0 + 0.5) * 25.0,
    "random": lambda values, randomness: np.where(
        randomness.random(len(values)) < 0.1, 100.0 * randomness.random(len(values)), values
    ),
}
TASTES = (
    lambda columns: 90.0 * columns[:, 3] * columns[:, 4],
    lambda columns: 40.0 * columns[:, 5] + 50.0 * (columns[:, 25] > 0.6),
    lambda columns: 100.0 * columns[:, 22],
    lambda columns: columns[:, :3] @ [15.0, 30.0, 55.0],
    lambda columns: 80.0 * (columns[:, 1] != columns[:, 2]),
)


def scores_of(columns, taste, error, seed):
    scores = ERRORS[error](TASTES[taste](columns), np.random.default_rng([seed, taste]))
    return scores.round().astype(np.float64)


@pytest.mark.parametrize("error", ["exact", "sd10", "stars"])
def test_a_change_of_taste_is_found_where_it_is(error):
    columns = columns_of(128, seed=1)
    first, second = (scores_of(columns, taste, error, seed=1) for taste in (0, 1))
    found = two_voices(columns, prices(), np.where(np.arange(128) < 60, first, second))
    assert found is not None
    assert found.division.kind == "change"
    assert abs(found.division.number - 60) <= 3


@pytest.mark.parametrize(("length", "num"), [(1, 96), (3, 96), (32, 192), (60, 192)])
def test_two_people_who_take_turns_are_found(length, num):
    columns = columns_of(num, seed=2)
    first, second = (scores_of(columns, taste, "sd10", seed=2) for taste in (0, 1))
    is_second = np.arange(num) // length % 2 == 1
    found = two_voices(columns, prices(), np.where(is_second, second, first))
    assert found is not None
    assert (found.division.kind, found.division.number) == ("turns", length)
    assert found.division.is_second.tolist() == is_second.tolist()
    # What both say together: nearer to the mean of the two tastes than the scores are.
    together = (TASTES[0](columns) + TASTES[1](columns)) / 2.0
    given = np.where(is_second, second, first)
    assert np.abs(found.agreed - together).mean() < 0.5 * np.abs(given - together).mean()


@pytest.mark.parametrize("taste", range(len(TASTES)))
def test_one_consistent_person_is_never_two(taste):
    for seed, error in enumerate(list(ERRORS)[taste % 2 :: 2]):
        columns = columns_of((32, 64, 96)[seed % 3], seed)
        assert two_voices(columns, prices(), scores_of(columns, taste, error, seed)) is None


@pytest.mark.parametrize("taste", range(len(TASTES)))
def test_a_sorted_file_is_of_one_person(taste):
    """Sorted by score, or by a kind of design."""
    columns = columns_of(48, seed=8)
    scores = scores_of(columns, taste, "sd10", 8)
    for key in (-scores, columns[:, 4], columns[:, 25]):
        order = np.argsort(key, kind="stable")
        assert two_voices(columns[order], prices(), scores[order]) is None


def test_scores_without_a_pattern_are_those_of_one_person():
    columns = columns_of(64, seed=3)
    for seed in range(2):
        scores = np.random.default_rng(seed).permutation(scores_of(columns, 1, "sd10", seed)).astype(np.float64)
        assert two_voices(columns, prices(), scores) is None


@pytest.mark.parametrize("num", [0, 1, 15, 16])
def test_few_scores_and_equal_ones_are_of_one_person(num):
    columns = columns_of(num, seed=4)
    assert two_voices(columns, prices(), np.full(num, 50.0)) is None
    assert two_voices(columns, prices(), np.linspace(0.0, 100.0, num)) is None
    assert two_voices(columns[:, :0], prices()[:0], np.linspace(0.0, 100.0, num)) is None


@pytest.mark.parametrize("num", [16, 40, 400])
def test_prices_are_logs_of_probabilities(num):
    """Those of all places of a change, and of the lengths of turns that are offered, have half of them each."""
    changes = [Division.at(place, num) for place in range(num)]
    turns = [division for division in _divisions(num) if division.kind == "turns"]
    for divisions in (changes, turns):
        chances = sum(np.exp(-division.price) for division in divisions)
        assert chances == pytest.approx(0.5 / ODDS_OF_SIMPLER)


def test_two_voices_are_two_explanations_less_the_price():
    columns = columns_of(48, seed=5)
    scores = np.where(np.arange(48) < 20, scores_of(columns, 0, "exact", 5), scores_of(columns, 1, "exact", 5))
    labels, division = Labels.of(columns, prices(), scores), Division.at(20, 48)
    two = _explained(labels, division)
    alone = sum(
        TreeGrowth(labels.columns, labels.evidence.for_person(two.person)).grown(voice).log_posterior
        for voice in (np.arange(20), np.arange(20, 48))
    )
    assert two.total == pytest.approx(alone - two.person.price - division.price)


def test_a_score_is_predicted_by_the_other_scores_of_its_leaf():
    columns, person = columns_of(40, seed=6), Person(10.0, 0.03)
    labels = Labels.of(columns, prices(), scores_of(columns, 0, "sd10", 6))
    evidence = labels.evidence.for_person(person)
    tree = TreeGrowth(labels.columns, evidence).grown(np.arange(30))
    found = _predicted(labels, tree, evidence)
    assert tree.split is not None
    for cell in tree.cells():
        for label in cell.tolist():
            rest = cell[cell != label]
            assert found[label] == pytest.approx(evidence.of_labels(cell) - evidence.of_labels(rest))
    assert (found[30:] < 0.0).all()


def test_parts_at_once_gain_what_each_gains():
    columns, randomness = columns_of(50, seed=7), np.random.default_rng(7)
    scores = scores_of(columns, 1, "sd10", 7)
    coarse, parts = coarse_bins(columns), randomness.random((5, 50)) < 0.5
    found = gains_of_parts(coarse, parts, scores)
    expected = [gains(coarse, np.flatnonzero(part), scores) for part in parts]
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert not gains_of_parts(coarse, parts, np.full(50, 7.0)).any()
