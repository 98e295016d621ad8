"""A preference as a function of few columns: levels, needed columns, and what is said about models never seen."""

import numpy as np

from grammarlab.preference.base import AbstractPreference, Prediction
from grammarlab.preference.levels import levels_of, snapped
from grammarlab.preference.pruning import change, needed_columns
from grammarlab.preference.simplified import SimplifiedPreference


class Linear(AbstractPreference):
    """Ten for each unit of the first column."""

    num_columns = 3

    def predict(self, rows):
        return Prediction(10.0 * np.asarray(rows)[:, 0], np.zeros(len(np.asarray(rows))))

    def explain(self, group_names):
        return []


def bits(number, columns, seed=0):
    return np.random.default_rng(seed).integers(0, 2, (number, columns)).astype(float)


def test_two_columns_that_matter_only_together_are_both_found():
    rows = bits(400, 8)
    values = 50.0 * (rows[:, 2] != rows[:, 5])
    assert set(needed_columns(rows, values, np.ones(400), np.arange(8), 1e-4)) == {2, 5}


def test_of_columns_that_say_the_same_one_is_kept():
    rows = bits(300, 3)
    rows = np.column_stack([rows, 1.0 - rows[:, 0]])
    assert needed_columns(rows, 40.0 * rows[:, 0], np.ones(300), np.arange(4), 1e-4).tolist() == [0]


def test_a_constant_preference_needs_no_column():
    assert len(needed_columns(bits(50, 4), np.full(50, 30.0), np.ones(50), np.arange(4), 0.0)) == 0


def test_nothing_changes_where_every_group_has_one_value():
    values = np.array([1.0, 1.0, 5.0])
    assert change(np.array([0, 0, 1]), values, np.ones(3)) == 0.0
    assert change(np.zeros(3, int), values, np.ones(3)) > 0.0


def test_known_values_give_what_was_predicted_and_new_ones_ask_the_preference():
    rows = np.array([[0.0, 1.0, 0.0], [2.0, 0.0, 0.0]])
    simple = SimplifiedPreference(Linear(), np.array([0]), np.zeros(0), rows, np.array([7.0, 20.0]), np.ones(2))
    assert simple(np.array([[0.0], [2.0], [3.0]])).tolist() == [7.0, 20.0, 30.0]


def test_levels_are_left_alone_by_snapping():
    levels = levels_of(np.array([0.0, 40.0, 20.0, 40.0]))
    assert snapped(levels, levels).tolist() == levels.tolist()
