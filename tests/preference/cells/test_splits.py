"""Ways to divide labels: rows that are equal are found, whatever their number."""

import numpy as np
import pytest

from grammarlab.preference.cells.splits import different


@pytest.mark.parametrize(("number", "width"), [(0, 3), (1, 1), (40, 3), (300, 5), (50, 400)])
def test_equal_rows_are_those_of_a_comparison_entry_by_entry(number, width):
    sides = np.random.default_rng(width).integers(0, 2, (number, width)).astype(bool)
    sides = np.concatenate([sides, sides[::3], ~sides[::4]])
    first, of = different(sides)
    assert np.array_equal(sides[first][of], sides)
    assert len(np.unique(sides, axis=0)) == len(first)
    # The first of equal rows stands for them.
    assert all((sides[:row] != sides[row]).any(axis=1).all() for row in first.tolist())
