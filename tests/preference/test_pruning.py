"""Which columns are needed."""

import numpy as np

from grammarlab.preference.simplified import change, needed_columns
from tests.preference.rows import bits


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
