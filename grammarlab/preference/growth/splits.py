"""Splits of designs into parts by what is read from their rows, a value or one of several names.

What is read is cut into intervals: a bound, a band, one number among others and all numbers apart are the same kind of
split. Names have no order of their own, so they are put in the order of their mean scores.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from grammarlab.arrays import ROUNDING, Floats, Ints


class Value(NamedTuple):
    """The value of a column."""

    column: int

    @property
    def columns(self) -> tuple[int, ...]:
        """Indices of the columns that are read."""
        return (self.column,)

    def read(self, rows: Floats) -> Floats:
        """[m] what is read from each row [m, F]."""
        return rows[:, self.column]


class Names(NamedTuple):
    """Which of some patterns columns have: the alternatives of a choice."""

    columns: tuple[int, ...]
    patterns: Floats
    """[P, columns] values of the columns, in an order."""

    def read(self, rows: Floats) -> Floats:
        """[m] index of the pattern of each row [m, F]; NaN for none of them."""
        distance = np.abs(rows[:, None, list(self.columns)] - self.patterns)
        equal = (distance <= ROUNDING * np.maximum(np.abs(self.patterns), 1.0)).all(axis=2)
        return np.where(equal.any(axis=-1), equal.argmax(axis=-1), np.nan)


Reading = Value | Names


class Split(NamedTuple):
    """What is read, cut into intervals."""

    reading: Reading
    bounds: tuple[float, ...]
    """The largest value of each interval but the last one, ascending."""

    @property
    def columns(self) -> tuple[int, ...]:
        """Indices of the columns that the split reads."""
        return self.reading.columns

    def parts(self, rows: Floats) -> Ints:
        """[m] number of the interval of each row [m, F]; -1 where nothing can be read.

        >>> Split(Value(0), (0.5, 2.0)).parts(np.array([[0.0], [0.5], [2.0], [3.0]])).tolist()
        [0, 0, 1, 2]
        """
        values = self.reading.read(rows)
        return np.where(np.isnan(values), -1, np.searchsorted(np.array(self.bounds), values))
