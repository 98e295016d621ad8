"""Divisions of the labels of a node by the values of one column, the best one found exactly.

The labels are in a few bins by the rank of their value, equal values together. A division cuts the bins
into intervals: a bound, a band, one level among others and all levels apart are the same operation. The best one is
found by dynamic programming over the evidence of all intervals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from grammarlab.arrays import Floats, Ints


@dataclass(frozen=True, eq=False)
class Cuts:
    """The best division by each of K columns."""

    log_evidence: Floats
    """[K] evidence of the parts and log-probability of the bounds; minus infinity for constant columns."""
    widths: Ints
    """[K] number of bins."""
    previous: Ints
    """[K, bins + 1] first bin of the last interval of the best division of the bins before each one."""

    def first(self, index: int) -> tuple[int, ...]:
        """First bin of each interval but the lowest, ascending, by one of the columns."""
        bounds, before = list[int](), self.previous[index].tolist()
        bound = before[int(self.widths[index])]
        while bound > 0:
            bounds.append(bound)
            bound = before[bound]
        return tuple(bounds[::-1])


def best_cuts(codes: Ints, terms: Floats, of_sums: Callable[[Floats], Floats]) -> Cuts:
    """The best division of some labels by each of some columns.

    Args:
        codes: [K, m] bin of each label by each column, ascending by value, from 0; no bin is empty.
        terms: [m, W] terms of the labels.
        of_sums: log-evidence [...] of parts from the sums [..., W] of their terms.
    """
    widths = codes.max(axis=1) + 1
    of_interval = _of_intervals(codes, widths, terms, of_sums)
    every, num_places = np.arange(len(codes)), np.maximum(widths - 1, 1)
    price = np.log(num_places) + np.log(2.0)
    best = np.full((len(codes), int(widths.max()) + 1), -np.inf)
    previous = np.zeros(best.shape, dtype=np.int64)
    # Each interval is priced but the lowest.
    best[:, 0] = price
    for end in range(1, best.shape[1]):
        through = best[:, :end] + of_interval[:, :end, end]
        previous[:, end] = through.argmax(axis=1)
        best[:, end] = through[every, previous[:, end]] - price
    return Cuts(best[every, widths] - np.log1p(-(0.5**num_places)), widths, previous)


def all_cuts(codes: Ints, terms: Floats, of_sums: Callable[[Floats], Floats], of_part: float) -> Floats:
    """[K] log of the sum over all divisions by each of some columns, of what the best one of `Cuts` has.

    Args:
        codes: [K, m] bin of each label by each column, ascending by value, from 0; no bin is empty.
        terms: [m, W] terms of the labels.
        of_sums: log-evidence [...] of parts from the sums [..., W] of their terms.
        of_part: log-prior of each part.
    """
    widths = codes.max(axis=1) + 1
    of_interval = _of_intervals(codes, widths, terms, of_sums) + of_part
    every, num_places = np.arange(len(codes)), np.maximum(widths - 1, 1)
    price = np.log(num_places) + np.log(2.0)
    total = np.full((len(codes), int(widths.max()) + 1), -np.inf)
    total[:, 0] = price
    for end in range(1, total.shape[1]):
        total[:, end] = np.logaddexp.reduce(total[:, :end] + of_interval[:, :end, end], axis=1) - price
    return total[every, widths] - np.log1p(-(0.5**num_places))


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


def _of_intervals(codes: Ints, widths: Ints, terms: Floats, of_sums: Callable[[Floats], Floats]) -> Floats:
    """[K, bins + 1, bins + 1] evidence of the bins of a column from one on and before another, at their indices.

    Those of all columns are found together, since there are few of each. All bins together are no division, and have
    none.
    """
    num, most = len(codes), int(widths.max())
    offsets = np.cumsum(widths) - widths
    inside = np.zeros((int(widths.sum()), codes.shape[1]))
    inside[offsets[:, None] + codes, np.arange(codes.shape[1])] = 1.0
    below = np.zeros((len(inside) + 1, terms.shape[1]))
    np.cumsum(inside @ terms, axis=0, out=below[1:])
    intervals = [_intervals(width) for width in widths.tolist()]
    column = np.repeat(np.arange(num), [len(low) for low, _ in intervals])
    low, high = (np.concatenate(ends) for ends in zip(*intervals, strict=True))
    found = np.full((num, most + 1, most + 1), -np.inf)
    found[column, low, high] = of_sums(below[offsets[column] + high] - below[offsets[column] + low])
    found[np.arange(num), 0, widths] = -np.inf
    return found


@cache
def _intervals(width: int) -> tuple[Ints, Ints]:
    """First bin of each interval of so many bins, and the bin after its last one."""
    low, high = np.triu_indices(width + 1, 1)
    return low, high
