"""What labels may be split by, each with its prior probability.

Columns of one group are alternatives of one choice: all of them together are names, beside each column alone. Each
group has the same share of the prior, since few groups matter; a continuous one has less, since it can explain
anything. What orders the labels alike has the sum of the priors, since it says the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grammarlab.arrays import NUM_LEVELS, Flags, Floats, Ints
from grammarlab.preference.growth.ranks import ranks_of
from grammarlab.preference.growth.screening import coarse_bins
from grammarlab.preference.growth.splits import Names, Reading, Value

_CONTINUOUS_SHARE = 0.15
"""Prior of a continuous group; all others have 1."""


@dataclass(frozen=True, eq=False)
class SplitColumns:
    """C different readings of n labels."""

    readings: tuple[Reading, ...]
    values: Floats
    """[n, C] what is read."""
    prices: Floats
    """[C] minus the log of the prior probability, in nats."""
    places: dict[tuple[type, tuple[int, ...]], int]
    """Index of each reading by its kind and columns, also of those that say the same as another one."""

    @cached_property
    def coarse(self) -> Ints:
        """[C, n] bins of the values for screening."""
        return coarse_bins(self.values)

    def place(self, reading: Reading) -> int | None:
        """Index of the reading that divides the labels as a given one does; None if it is constant."""
        return self.places.get((type(reading), reading.columns))

    @classmethod
    def plain(cls, values: Floats, prices: Floats) -> SplitColumns:
        """Columns [n, C] that are read as they are, with prices [C] in nats."""
        readings = tuple(Value(column) for column in range(values.shape[1]))
        places: dict[tuple[type, tuple[int, ...]], int] = {
            (Value, reading.columns): column for column, reading in enumerate(readings)
        }
        return cls(readings, values, prices, places)

    @classmethod
    def of(
        cls, rows: Floats, groups: Ints, continuous: Flags, scores: Floats, priors: Floats | None = None
    ) -> SplitColumns:
        """Readings of rows.

        Args:
            rows: [n, F] rows of the labels.
            groups: [F] group numbers.
            continuous: [F] whether columns are continuous instead of counts.
            scores: [n] scores of the rows, 0-100, by which names are ordered.
            priors: [F] how likely columns are to matter, relative to each other; None if all are equally likely. A
                group has the prior of its most likely column.
        """
        varying = np.flatnonzero(np.ptp(rows, axis=0) > 0.0) if len(rows) else np.zeros(0, dtype=np.int64)
        readings, masses = list[Reading](), list[float]()
        for group in np.unique(groups[varying]).tolist():
            columns = varying[groups[varying] == group]
            share = _CONTINUOUS_SHARE if continuous[columns].all() else 1.0
            share *= 1.0 if priors is None else float(priors[groups == group].max())
            for reading, part in _of_group(rows, columns, continuous, scores):
                readings.append(reading)
                masses.append(share * part)
        if not readings:
            return cls((), np.zeros((len(rows), 0)), np.zeros(0), {})
        values = np.array([reading.read(rows) for reading in readings]).T
        first, same = _different(values)
        prices = np.log(sum(masses)) - np.log(np.bincount(same, masses, minlength=len(first)))
        places: dict[tuple[type, tuple[int, ...]], int] = {
            (type(reading), reading.columns): place for reading, place in zip(readings, same.tolist(), strict=True)
        }
        return cls(tuple(readings[index] for index in first.tolist()), values[:, first], prices, places)


def _of_group(rows: Floats, columns: Ints, continuous: Flags, scores: Floats) -> Iterator[tuple[Reading, float]]:
    """Readings of the columns of a group, each with its share of the prior of the group; the sum is 1."""
    counts, rest = columns[~continuous[columns]], 1.0
    if len(counts) > 1:
        names = _names(rows, counts, scores)
        if 2 < len(names.patterns) <= NUM_LEVELS:
            rest = len(columns) / (len(columns) + 1.0)
            yield names, 1.0 - rest
    for column in columns.tolist():
        yield Value(column), rest / len(columns)


def _names(rows: Floats, columns: Ints, scores: Floats) -> Names:
    """The different patterns of columns, in the order of their mean scores."""
    patterns, index = np.unique(rows[:, columns], axis=0, return_inverse=True)
    number = index.reshape(-1)
    means = np.bincount(number, scores) / np.bincount(number)
    return Names(tuple(columns.tolist()), patterns[np.argsort(means, kind="stable")])


def _different(values: Floats) -> tuple[Ints, Ints]:
    """[K] the first of each set of columns [n, C] with one order of labels or its reverse, and [C] the set of each."""
    ranks = ranks_of(values)
    highest = ranks.max(axis=1, keepdims=True)
    # Counted from the end where the first label is nearer to it; if it is in the middle, by the first that is not.
    away = np.sign(highest - 2 * ranks)
    side = np.take_along_axis(away, (away != 0).argmax(axis=1)[:, None], axis=1)
    _, first, same = np.unique(
        np.where(side < 0, highest - ranks, ranks), axis=0, return_index=True, return_inverse=True
    )
    order = np.argsort(first, kind="stable")
    place = np.empty(len(first), dtype=np.int64)
    place[order] = np.arange(len(first))
    return first[order], place[same.reshape(-1)]
