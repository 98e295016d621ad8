"""Regression trees: a preference as splits of few columns, in the order of their gain.

Trees grow best first, so that the first k splits of a tree are the tree of k + 1 leaves: a sequence of increasingly
fine functions. Values are compared by their square roots: the squared distance of square roots is, up to a factor, the
Hellinger distance of the densities, which is close to their Jensen-Shannon divergence. So small values instead of 0
count as errors, as they do there.
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heappop, heappush
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import ROUNDING, Floats, Ints

MAX_CODES = 128
"""Largest number of different values of a column; more are divided into this number of ranges of equal size."""
_MAX_CODES_AT_ONCE = 1 << 22
"""Number of codes that are summed at once."""


class Split(NamedTuple):
    """The rows of a leaf whose value is at least a bound move on to a new leaf, numbered in the order of the splits."""

    leaf: int
    column: int
    bound: float


Tree = Sequence[Split]


def leaves_of(tree: Tree, rows: Floats) -> Ints:
    """[n] the leaf, from 0, of each row [n, F]."""
    leaf = np.zeros(len(rows), dtype=np.int64)
    for number, split in enumerate(tree, 1):
        leaf[(leaf == split.leaf) & (rows[:, split.column] >= split.bound)] = number
    return leaf


def means_of(leaf: Ints, num_leaves: int, values: Floats, weights: Floats) -> Floats:
    """[num_leaves] the weighted mean of values [n] in each leaf, 0 in those without weight."""
    mass = np.bincount(leaf, weights, num_leaves)
    return np.bincount(leaf, weights * values, num_leaves) / np.where(mass > 0.0, mass, 1.0)


def grow(
    rows: Floats, values: Floats, weights: Floats, columns: Ints, max_leaves: int, least_rows: int = 1
) -> tuple[Split, ...]:
    """Splits that explain most of the values, best first.

    Args:
        rows: [n, F] features of models.
        values: [n] >= 0.
        weights: [n] >= 0, weight of each model.
        columns: [C] candidate columns; of equivalent ones the first is used.
        max_leaves: largest number of leaves, >= 1.
        least_rows: approximate smallest number of rows with a weight in each leaf.
    """
    counted = np.flatnonzero(weights > 0.0)
    return _Growth(rows[counted], np.sqrt(values[counted]), weights[counted], columns, least_rows).run(max_leaves)


class _Growth:
    def __init__(self, rows: Floats, roots: Floats, weights: Floats, columns: Ints, least_rows: int) -> None:
        self.least_rows = least_rows
        self.rows, self.roots, self.weights, self.columns = rows, roots, weights, columns
        self.codes, self.edges = _coded(rows, columns)
        self.width = max([1, *(len(edges) + 1 for edges in self.edges)])
        self.least = ROUNDING * float(weights @ roots**2)

    def run(self, max_leaves: int) -> tuple[Split, ...]:
        leaf_rows = [np.arange(len(self.roots))]
        waiting: list[tuple[float, int, int, int]] = []
        self._offer(waiting, 0, leaf_rows[0])
        splits: list[Split] = []
        while waiting and len(leaf_rows) < max_leaves:
            _, leaf, column, code = heappop(waiting)
            rows = leaf_rows[leaf]
            bound = self._bound(rows, column, code)
            above = self.rows[rows, self.columns[column]] >= bound
            splits.append(Split(leaf, int(self.columns[column]), bound))
            leaf_rows[leaf] = rows[~above]
            leaf_rows.append(rows[above])
            for number in (leaf, len(leaf_rows) - 1):
                self._offer(waiting, number, leaf_rows[number])
        return tuple(splits)

    def _offer(self, waiting: list[tuple[float, int, int, int]], leaf: int, rows: Ints) -> None:
        """Add the best split of a leaf to the queue, if there is one."""
        if len(rows) < 2 or not len(self.columns) or np.ptp(self.roots[rows]) == 0.0:
            return
        gains = np.concatenate([self._gains(rows, first, last) for first, last in pairwise(self._parts(len(rows)))])
        best = int(np.argmax(gains.max(axis=1) >= gains.max() * (1.0 - ROUNDING)))
        code = int(gains[best].argmax())
        if gains[best, code] > self.least:
            heappush(waiting, (-float(gains[best, code]), leaf, best, code))

    def _parts(self, num_rows: int) -> list[int]:
        step = max(1, _MAX_CODES_AT_ONCE // num_rows)
        return [*range(0, len(self.columns), step), len(self.columns)]

    def _gains(self, rows: Ints, first: int, last: int) -> Floats:
        """[last - first, width] squared error that each split of columns removes."""
        cell = (self.codes[rows, first:last] + np.arange(last - first) * self.width).ravel()
        weights = self.weights[rows]
        sums = [
            np.bincount(cell, np.repeat(values, last - first), (last - first) * self.width)
            .reshape(-1, self.width)
            .cumsum(axis=1)
            for values in (weights, weights * self.roots[rows], np.ones(len(rows)))
        ]
        mass, total, number = sums
        left_mass, right_mass = mass, mass[:, -1:] - mass
        with np.errstate(divide="ignore", invalid="ignore"):
            gains = total**2 / left_mass + (total[:, -1:] - total) ** 2 / right_mass - total[:, -1:] ** 2 / mass[:, -1:]
        # Rounding error of an empty remainder.
        possible = (left_mass > 0.0) & (right_mass > 1e-12 * mass[:, -1:])
        possible &= np.minimum(number, number[:, -1:] - number) >= self.least_rows
        return np.where(possible, gains, 0.0)

    def _bound(self, rows: Ints, column: int, code: int) -> float:
        """A round number between the values on both sides of a split, at the best place within its ranges."""
        values = self.rows[rows, self.columns[column]]
        order = np.argsort(values, kind="stable")
        values, weights, roots = values[order], self.weights[rows][order], self.roots[rows][order]
        cuts = np.flatnonzero(np.diff(values) > 0.0)
        codes = self.codes[rows, column][order]
        cuts = cuts[(codes[cuts] <= code + 1) & (codes[cuts + 1] >= code)]
        mass, total = np.cumsum(weights), np.cumsum(weights * roots)
        left_mass, right_mass = mass[cuts], np.maximum(mass[-1] - mass[cuts], 1e-300)
        best = int(cuts[np.argmax(total[cuts] ** 2 / left_mass + (total[-1] - total[cuts]) ** 2 / right_mass)])
        return round_between(float(values[best]), float(values[best + 1]))


def round_between(low: float, high: float) -> float:
    """Number with the fewest digits that is above ``low`` and at most ``high``; of several the largest.

    >>> round_between(2.9471, 3.1234), round_between(0.0, 1.0), round_between(4.0, 4.5)
    (3.0, 1.0, 4.5)
    """
    for digits in range(-6, 17):
        rounded = float(f"{np.floor(high * 10.0**digits) / 10.0**digits:.{max(digits, 0)}f}")
        if low < rounded <= high:
            return rounded
    return high


def _coded(rows: Floats, columns: Ints) -> tuple[NDArray[np.int64], list[Floats]]:
    """[n, C] the range of each value, and the lower ends of the ranges after the first."""
    codes = np.zeros((len(rows), len(columns)), dtype=np.int64)
    edges: list[Floats] = []
    for index, column in enumerate(columns.tolist()):
        values = np.unique(rows[:, column])
        if len(values) > MAX_CODES:
            values = np.unique(np.quantile(rows[:, column], np.arange(MAX_CODES) / MAX_CODES, method="lower"))
        edges.append(values[1:])
        codes[:, index] = np.searchsorted(values[1:], rows[:, column], side="right")
    return codes, edges
