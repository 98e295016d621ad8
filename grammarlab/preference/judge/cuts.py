"""Divisions of the labels of a node by the values of one column, the best one found exactly.

The labels are in a few bins by the rank of their value, equal values together. A division cuts the bins
into intervals: a bound, a band, one level among others and all levels apart are the same operation. The best one is
found by dynamic programming over the evidence of all intervals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints

MAX_BINS = 24
"""Largest number of bins of a column."""
COARSE_BINS = 8
"""Number of bins of a first screening: enough for a band or a wave, few enough to explain little by chance."""
_CHUNK = 2_000_000
"""Largest number of floats of the sums of intervals at a time."""


@dataclass(frozen=True, eq=False)
class BinnedColumns:
    """Columns of n labels in bins."""

    codes: Ints
    """[C, n] bin of each label, ascending by value, from 0."""
    sizes: Ints
    """[C] number of bins."""

    @classmethod
    def of(cls, columns: Floats, most: int = MAX_BINS) -> BinnedColumns:
        """At most so many bins of columns [n, C], of about as many labels each if there are more values."""
        codes = ranks_of(columns)
        many = np.flatnonzero(codes.max(axis=1, initial=-1) >= most)
        if len(many):
            codes[many] = np.take_along_axis(bins_of_ranks(codes[many], most), codes[many], axis=1)
        return cls(codes, codes.max(axis=1, initial=-1) + 1)

    @cached_property
    def coarse(self) -> Ints:
        """[C, n] codes of few bins."""
        sizes = self.sizes[:, None]
        return np.where(sizes > COARSE_BINS, self.codes * COARSE_BINS // np.maximum(sizes, 1), self.codes)

    def __len__(self) -> int:
        return len(self.codes)

    def __add__(self, other: BinnedColumns) -> BinnedColumns:
        return BinnedColumns(np.concatenate([self.codes, other.codes]), np.concatenate([self.sizes, other.sizes]))

    def take(self, columns: Ints) -> BinnedColumns:
        """Some of the columns."""
        return BinnedColumns(self.codes[columns], self.sizes[columns])


def ranks_of(columns: Floats) -> Ints:
    """[C, n] index of each value among the different values of its column, for columns [n, C].

    >>> ranks_of(np.array([[0.5], [0.1], [0.5], [0.9]])).tolist()
    [[1, 0, 1, 2]]
    """
    rows = np.ascontiguousarray(columns.T)
    # Equal values have one rank, so their order does not matter.
    order = np.argsort(rows, axis=1)
    ranks = np.empty(rows.shape, dtype=np.int64)
    np.put_along_axis(ranks, order, _steps(np.take_along_axis(rows, order, axis=1)), axis=1)
    return ranks


def bins_of_ranks(ranks: Ints, most: int) -> Ints:
    """[C, R] bin of each rank of columns [C, n]: by the number of labels with a smaller value."""
    num_columns, num = ranks.shape
    num_ranks = int(ranks.max()) + 1
    flat = ranks + np.arange(num_columns)[:, None] * num_ranks
    count = np.bincount(flat.reshape(-1), minlength=num_columns * num_ranks).reshape(num_columns, num_ranks)
    return _steps((np.cumsum(count, axis=1) - count) * most // num)


def _steps(ascending: Floats | Ints) -> Ints:
    """[C, n] index of each value among the different values of its row, which is ascending."""
    steps = np.zeros(ascending.shape, dtype=np.int64)
    np.cumsum(ascending[:, 1:] > ascending[:, :-1], axis=1, out=steps[:, 1:])
    return steps


class Cut(NamedTuple):
    """A division of labels by one column."""

    column: int
    first: tuple[int, ...]
    """First bin of each interval but the lowest, ascending."""

    def parts(self, columns: BinnedColumns, labels: Ints) -> list[Ints]:
        """The labels of each interval."""
        interval = np.searchsorted(np.array(self.first), columns.codes[self.column, labels], side="right")
        return [labels[interval == number] for number in range(len(self.first) + 1)]


class CutColumns(NamedTuple):
    """The best division by each column."""

    log_evidence: Floats
    """[C] evidence of the parts and log-probability of the bounds; minus infinity for constant columns."""
    cuts: list[Cut]
    """[C]"""


def best_cuts(
    columns: BinnedColumns, chosen: Ints, labels: Ints, terms: Floats, evidence: Callable[[Floats], Floats]
) -> CutColumns:
    """The best division of some labels by each of some columns.

    Args:
        columns: the columns of all n labels.
        chosen: [C] indices of the columns.
        labels: [m] indices of the labels.
        terms: [n, W] terms of all labels.
        evidence: log-evidence [...] of parts from the sums [..., W] of their terms.
    """
    codes, first_code = _occupied(columns.codes[np.ix_(chosen, labels)])
    widths = codes.max(axis=1, initial=-1) + 1
    values, cuts = np.full(len(chosen), -np.inf), [Cut(int(column), ()) for column in chosen]
    for width in np.unique(widths[widths > 1]).tolist():
        alike = np.flatnonzero(widths == width)
        per_chunk = max(1, _CHUNK // (width * (width + 1) // 2 * terms.shape[1]))
        for start in range(0, len(alike), per_chunk):
            rows = alike[start : start + per_chunk]
            values[rows], bounds = _divided(codes[rows], width, terms[labels], evidence)
            for row, bins in zip(rows.tolist(), bounds, strict=True):
                cuts[row] = Cut(int(chosen[row]), tuple(first_code[row, list(bins)].tolist()))
    return CutColumns(values, cuts)


def price_of_bounds(num: int, num_places: int) -> float:
    """Description length of the bounds of a division in nats: each is at one of the places between different values.

    There is another bound with even odds, until there are as many as places.

    Args:
        num: number of bounds.
        num_places: >= 1.

    >>> price_of_bounds(1, 1), round(price_of_bounds(1, 4), 3)
    (0.0, 2.015)
    """
    return float(num * (np.log(num_places) + np.log(2.0)) + np.log1p(-(0.5**num_places)))


def _occupied(codes: Ints) -> tuple[Ints, Ints]:
    """Codes [C, m] without the bins that have no label, and the code [C, B] of each remaining bin."""
    num, width = len(codes), int(codes.max(initial=-1)) + 1
    flags = np.zeros((num, width), dtype=bool)
    flags[np.arange(num)[:, None], codes] = True
    rank = np.cumsum(flags, axis=1) - 1
    first = np.zeros((num, width), dtype=np.int64)
    row, code = np.nonzero(flags)
    first[row, rank[row, code]] = code
    return np.take_along_axis(rank, codes, axis=1), first


def _divided(
    codes: Ints, width: int, terms: Floats, evidence: Callable[[Floats], Floats]
) -> tuple[Floats, list[tuple[int, ...]]]:
    """Evidence [C] of the best division by each of C columns with bins [C, m], none empty, and its bounds."""
    num, size = len(codes), terms.shape[1]
    in_bin = (codes[:, None, :] == np.arange(width)[:, None]).astype(np.float64)
    below = np.zeros((num, width + 1, size))
    np.cumsum(in_bin @ terms, axis=1, out=below[:, 1:])
    low, high = np.triu_indices(width + 1, 1)
    of_interval = np.full((num, width + 1, width + 1), -np.inf)
    of_interval[:, low, high] = evidence(below[:, high] - below[:, low])
    price = price_of_bounds(1, width - 1) - price_of_bounds(0, width - 1)
    best = np.full((num, width + 1), -np.inf)
    best[:, 0] = 0.0
    previous = np.zeros((num, width + 1), dtype=np.int64)
    for end in range(1, width + 1):
        through = best[:, :end] - np.where(np.arange(end) > 0, price, 0.0) + of_interval[:, :end, end]
        if end == width:
            # The whole is no division.
            through[:, 0] = -np.inf
        previous[:, end] = through.argmax(axis=1)
        best[:, end] = through.max(axis=1)
    of_number = price_of_bounds(0, width - 1)
    return best[:, width] - of_number, [_walked(row, width) for row in previous.tolist()]


def _walked(previous: list[int], end: int) -> tuple[int, ...]:
    """Bounds from the last interval back to the first."""
    bounds = list[int]()
    while previous[end] > 0:
        end = previous[end]
        bounds.append(end)
    return tuple(bounds[::-1])
