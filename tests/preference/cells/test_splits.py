"""Ways to divide labels: rows that are equal are found, whatever their number."""

import numpy as np
import pytest

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
    options = np.arange(2), np.ones(2, dtype=bool)
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
    assert Splits.of(rows[:20], *options, [used]).splits == Splits.of(rows[:20], *options).splits
