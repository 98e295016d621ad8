"""Divisions of the labels of a node by the values of one column, the best one found exactly.

The labels are in a few bins by the rank of their value, equal values together. A division cuts the bins
into intervals: a bound, a band, one level among others and all levels apart are the same operation. The best one is
found by dynamic programming over the evidence of all intervals, for each number of bounds: bounds are a set, which is
one of all with so many.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import gammaln

from grammarlab.arrays import Floats, Ints


@dataclass(frozen=True, eq=False)
class Cuts:
    """The best division by each of K columns."""

    log_evidence: Floats
    """[K] evidence of the parts and log-probability of the bounds; minus infinity for constant columns."""
    widths: Ints
    """[K] number of bins."""
    numbers: Ints
    """[K] number of bounds, >= 1; arbitrary for constant columns."""
    previous: Ints
    """[K, bins, bins + 1] first bin of the last interval of the best division of the bins before each one by each
    number of bounds."""

    def first(self, index: int) -> tuple[int, ...]:
        """First bin of each interval but the lowest, ascending, by one of the columns."""
        bounds, bound = list[int](), int(self.widths[index])
        for number in range(int(self.numbers[index]), 0, -1):
            bound = int(self.previous[index, number, bound])
            bounds.append(bound)
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
    every, most = np.arange(len(codes)), int(widths.max())
    best = np.full((len(codes), most, most + 1), -np.inf)
    previous = np.zeros(best.shape, dtype=np.int64)
    best[:, 0] = of_interval[:, 0]
    for end in range(2, most + 1):
        through = best[:, :-1, 1:end] + of_interval[:, None, 1:end, end]
        previous[:, 1:, end] = through.argmax(axis=2) + 1
        best[:, 1:, end] = through.max(axis=2)
    totals = best[every, :, widths] - _prices(most, widths - 1)
    numbers = totals.argmax(axis=1)
    return Cuts(totals[every, numbers], widths, numbers, previous)


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
    most = int(widths.max())
    total = np.full((len(codes), most, most + 1), -np.inf)
    total[:, 0] = of_interval[:, 0]
    for end in range(2, most + 1):
        through = total[:, :-1, 1:end] + of_interval[:, None, 1:end, end]
        total[:, 1:, end] = np.logaddexp.reduce(through, axis=2)
    return np.logaddexp.reduce(total[np.arange(len(codes)), :, widths] - _prices(most, widths - 1), axis=1)


def price_of_bounds(num: int, num_places: int) -> float:
    """Description length of the bounds of a division in nats: a set of some of the places between different values.

    There is another bound with even odds, until there are as many as places, and all sets of one size are equally
    likely.

    Args:
        num: number of bounds.
        num_places: >= 1.

    >>> price_of_bounds(1, 1), round(price_of_bounds(1, 4), 3), round(price_of_bounds(4, 4), 3)
    (0.0, 2.015, 2.708)
    """
    return float(_prices(num + 1, np.array([num_places]))[0, num])


def _prices(most: int, num_places: Ints) -> Floats:
    """[K, most] `price_of_bounds` for each number of bounds below ``most`` at numbers of places [K]; infinite for none.

    A column without places has no division.
    """
    numbers, places = np.arange(most), np.maximum(num_places, 1)[:, None]
    sets = gammaln(places + 1.0) - gammaln(numbers + 1.0) - gammaln(np.maximum(places - numbers, 0) + 1.0)
    prices = numbers * np.log(2.0) + sets + np.log1p(-(0.5**places))
    return np.where((numbers > 0) & (numbers <= num_places[:, None]), prices, np.inf)


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
