"""What designs may be split by: readings, their parts, and a prior over them."""

import numpy as np
import pytest

from grammarlab.preference.growth.split_columns import SplitColumns
from grammarlab.preference.growth.splits import Names, Split, Value


def columns_of(rows, groups=None, continuous=None, scores=None, priors=None):
    width = rows.shape[1]
    numbers = np.arange(width) if groups is None else np.array(groups)
    drawn = np.zeros(width, dtype=bool) if continuous is None else np.array(continuous)
    given = np.arange(float(len(rows))) if scores is None else scores
    return SplitColumns.of(rows, numbers, drawn, given, priors)


def probability(columns, reading):
    return float(np.exp(-columns.prices[columns.place(reading)]))


def test_what_is_read_is_cut_into_intervals():
    rows = np.array([[0.0, 1.0], [1.0, 1.0], [3.0, 0.0], [4.0, 7.0]])
    assert Split(Value(0), (0.5, 3.0)).parts(rows).tolist() == [0, 1, 1, 2]
    names = Names((1,), np.array([[1.0], [0.0]]))
    assert Split(names, (0.5,)).parts(rows).tolist() == [0, 0, 1, -1]


def test_names_are_equal_up_to_rounding_whatever_their_scale():
    names = Names((0,), np.array([[1.0], [3e6]]) / 1e5)
    rows = np.array([[1.0], [2.0], [3e6 * (1.0 + 1e-12)], [3e6 + 1.0]]) / 1e5
    np.testing.assert_array_equal(names.read(rows), [0.0, np.nan, 1.0, np.nan])


@pytest.mark.parametrize("seed", range(5))
def test_probabilities_sum_to_one_whatever_says_the_same(seed):
    randomness = np.random.default_rng(seed)
    choice = randomness.integers(4, size=40)
    rows = np.column_stack(
        [choice[:, None] == np.arange(4), randomness.integers(5, size=(40, 3)), randomness.random(40)]
    )
    rows = np.column_stack([rows, rows[:, 4], -rows[:, 5], np.ones(40)])
    groups, continuous = [0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7], [False] * 7 + [True] + [False] * 3
    columns = columns_of(rows, groups, continuous, randomness.random(40), randomness.random(11))
    assert np.exp(-columns.prices).sum() == pytest.approx(1.0)
    assert columns.values.shape == (40, len(columns.readings))


def test_columns_that_order_designs_alike_share_their_probability():
    rows = np.random.default_rng(0).random((30, 3))
    alone = columns_of(rows, continuous=[True] * 3)
    both = columns_of(np.column_stack([rows, 5.0 - rows[:, 0] ** 3]), continuous=[True] * 4)
    assert len(both.readings) == 3
    assert probability(alone, Value(0)) == pytest.approx(1.0 / 3.0)
    assert probability(both, Value(0)) == probability(both, Value(3)) == pytest.approx(0.5)


def test_a_group_has_one_share_and_its_names_that_of_a_column():
    choice = np.array([0, 1, 2, 2, 1, 0, 1, 2] * 3)
    rows = np.column_stack([np.eye(3)[choice], np.tile([0.0, 1.0, 1.0, 0.0], 6)])
    columns = columns_of(rows, [0, 0, 0, 1], scores=np.array([30.0, 0.0, 90.0])[choice])
    names = next(reading for reading in columns.readings if isinstance(reading, Names))
    # In the order of mean scores: the second, the first, the third.
    assert names.patterns.tolist() == np.eye(3)[[1, 0, 2]].tolist()
    assert probability(columns, names) == pytest.approx(0.125)
    assert [probability(columns, Value(column)) for column in range(4)] == pytest.approx([0.125] * 3 + [0.5])


def test_a_continuous_column_has_a_smaller_share_than_a_count():
    rows = np.column_stack([np.arange(24) % 4, np.linspace(0.0, 1.0, 24)]).astype(np.float64)
    columns = columns_of(rows, continuous=[False, True])
    assert columns.readings == (Value(0), Value(1))
    assert probability(columns, Value(1)) == pytest.approx(0.15 / 1.15)


def test_without_labels_or_differences_there_is_nothing_to_split_by():
    for rows in (np.zeros((0, 3)), np.ones((5, 3))):
        columns = columns_of(rows)
        assert columns.readings == ()
        assert columns.place(Value(0)) is None
