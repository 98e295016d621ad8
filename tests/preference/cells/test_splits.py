"""Ways to divide labels: rows that are equal are found, whatever their number."""

import numpy as np
import pytest

from grammarlab.preference.cells.intervals import best_intervals
from grammarlab.preference.cells.splits import Above, Splits, different


@pytest.mark.parametrize(("number", "width"), [(0, 3), (1, 1), (40, 3), (300, 5), (50, 400)])
def test_equal_rows_are_those_of_a_comparison_entry_by_entry(number, width):
    sides = np.random.default_rng(width).integers(0, 2, (number, width)).astype(bool)
    sides = np.concatenate([sides, sides[::3], ~sides[::4]])
    first, of = different(sides)
    assert np.array_equal(sides[first][of], sides)
    assert len(np.unique(sides, axis=0)) == len(first)
    # The first of equal rows stands for them.
    assert all((sides[:row] != sides[row]).any(axis=1).all() for row in first.tolist())


def test_near_given_splits_a_column_of_many_values_is_divided_at_every_bound():
    rows = np.random.default_rng(0).uniform(0.0, 1.0, (100, 2))
    options = np.arange(2), np.ones(2, dtype=bool), np.zeros(100)
    coarse = Splits.of(rows, *options)
    used = next(split for split in coarse.splits[10:] if split.column == 0)
    finer = Splits.of(rows, *options, [used])
    assert set(coarse.splits) < set(finer.splits)
    added = sorted(split.bound for split in set(finer.splits) - set(coarse.splits))
    assert {split.column for split in set(finer.splits) - set(coarse.splits)} == {0}
    values = np.sort(rows[:, 0])
    bounds = (values[1:] + values[:-1]) / 2.0
    few = np.array([split.bound for split in coarse.splits if split.column == 0])
    around = (bounds > few[few < used.bound].max()) & (bounds < few[few > used.bound].min())
    assert added == [bound for bound in bounds[around].tolist() if bound != used.bound]
    for splits in (coarse, finer):
        assert np.exp(splits.log_prior).sum() == pytest.approx(1.0)
    # Bounds of other labels count as well, and those outside do no harm.
    shifted = [Splits.of(rows, *options, [Above(0, used.bound + shift)]).splits for shift in (-1e-9, 1e-9)]
    assert set(finer.splits) <= set(shifted[0]) | set(shifted[1])
    assert all(set(coarse.splits) <= set(Splits.of(rows, *options, [Above(1, bound)]).splits) for bound in (-1.0, 2.0))
    few = *options[:2], np.zeros(20)
    assert Splits.of(rows[:20], *few, [used]).splits == Splits.of(rows[:20], *few).splits


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
    values = np.arange(200.0)[:, None]
    inside = (values[:, 0] > 50.0) & (values[:, 0] < 54.0)
    splits = Splits.of(values, np.zeros(1, dtype=np.int64), np.ones(1, dtype=bool), 100.0 * inside)
    assert {Above(0, 50.5), Above(0, 53.5)} <= set(splits.splits)
    assert len(splits.splits) <= 26


@pytest.mark.parametrize("num", [1, 2])
def test_few_rows_have_intervals(num):
    assert best_intervals(np.arange(float(num))[:, None], np.zeros(num)).shape == (1, 2)
