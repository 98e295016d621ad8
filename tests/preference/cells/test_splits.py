"""Ways to divide labels: rows that are equal are found, whatever their number."""

import numpy as np
import pytest

from grammarlab.preference.cells.splits import Above, Splits, best_intervals, different


@pytest.mark.parametrize(("number", "width"), [(0, 3), (1, 1), (40, 3), (300, 5), (50, 400)])
def test_equal_rows_are_those_of_a_comparison_entry_by_entry(number, width):
    sides = np.random.default_rng(width).integers(0, 2, (number, width)).astype(bool)
    sides = np.concatenate([sides, sides[::3], ~sides[::4]])
    first, of = different(sides)
    assert np.array_equal(sides[first][of], sides)
    assert len(np.unique(sides, axis=0)) == len(first)
    # The first of equal rows stands for them.
    assert all((sides[:row] != sides[row]).any(axis=1).all() for row in first.tolist())


def bounds_of(rows, scores, near=()):
    """The bounds on each of two continuous columns, and the total prior mass."""
    splits = Splits.of(rows, np.arange(2), np.ones(2, dtype=bool), scores, near)
    found = [split for split in splits.splits if isinstance(split, Above)]
    assert len(found) == len(splits.splits)
    assert np.exp(splits.log_prior).sum() == pytest.approx(1.0)
    return [{split.bound for split in found if split.column == column} for column in range(2)]


def test_near_given_splits_a_column_of_many_values_is_divided_at_every_bound():
    rows, scores = np.random.default_rng(0).uniform(0.0, 1.0, (100, 2)), np.zeros(100)
    coarse = bounds_of(rows, scores)
    few = np.array(sorted(coarse[0]))
    finer = bounds_of(rows, scores, [Above(0, few[10])])
    assert finer[1] == coarse[1]
    values = np.sort(rows[:, 0])
    every = (values[1:] + values[:-1]) / 2.0
    assert finer[0] == coarse[0] | set(every[(every > few[9]) & (every < few[11])].tolist())
    assert len(finer[0]) > len(coarse[0])
    # Bounds of other labels count as well, and those outside do no harm.
    shifted = [bounds_of(rows, scores, [Above(0, few[10] + shift)])[0] for shift in (-1e-9, 1e-9)]
    assert finer[0] <= shifted[0] | shifted[1]
    assert all(coarse[1] <= bounds_of(rows, scores, [Above(1, bound)])[1] for bound in (-1.0, 2.0))
    assert bounds_of(rows[:20], scores[:20], [Above(0, 0.5)]) == bounds_of(rows[:20], scores[:20])


@pytest.mark.parametrize("seed", range(3))
def test_the_interval_that_explains_most_is_that_of_all_intervals(seed):
    randomness = np.random.default_rng(seed)
    values, scores = randomness.integers(0, 12, (30, 4)) / 4.0, randomness.uniform(0.0, 100.0, 30)
    left = []
    for column, (low, high) in zip(values.T, best_intervals(values, scores), strict=True):
        ends = [-np.inf, *(np.unique(column)[1:] + np.unique(column)[:-1]) / 2.0, np.inf]
        assert {low, high} <= set(ends)

        def spread(low, high, column=column):
            inside = (column > low) & (column < high)
            return sum(scores[side].var() * side.sum() for side in (inside, ~inside) if side.any())

        least = min(spread(low, high) for number, low in enumerate(ends) for high in ends[number + 1 :])
        left.append(spread(low, high) - least)
    assert np.abs(left) == pytest.approx(0.0, abs=1e-6)


def test_both_ends_of_the_best_interval_are_among_few_bounds():
    rows = np.column_stack([np.arange(200.0), np.arange(200.0)])
    first, second = bounds_of(rows, np.where((rows[:, 0] > 50.0) & (rows[:, 0] < 54.0), 100.0, 0.0))
    assert {50.5, 53.5} <= first
    assert first == second
    assert len(first) <= 26


@pytest.mark.parametrize("num", [1, 2])
def test_few_rows_have_intervals(num):
    assert best_intervals(np.arange(float(num))[:, None], np.zeros(num)).shape == (1, 2)
