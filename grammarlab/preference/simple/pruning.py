"""Selection of the columns that a preference needs: the fewest that distinguish models of different values.

Columns are added one by one, each time the one that explains most of the rest, and in the end redundant columns are
removed. So one of several equivalent columns is kept, even if the preference has no weight on it, and errors of a
preference about a few models do not add columns. If columns explain values only together, no single column is a first
step; then columns are removed from the set of all columns instead.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammarlab.preference.base import Floats, Ints

MOST_COLUMNS = 20
"""Largest number of columns added one by one."""
LEAST_GAIN = 2e-4
"""Smallest gain of an added column."""
_ROUNDING = 1e-9
_MOST_GROUPS = 4
"""Largest ratio of group numbers to models for which sums over sparse numbers are faster than renumbering."""


def needed_columns(rows: Floats, values: Floats, weights: Floats, candidates: Ints, tolerance: float) -> Ints:
    """Columns needed to predict the values of models.

    Args:
        rows: [n, F] features of models.
        values: [n] >= 0, the preference.
        weights: [n] >= 0, weight of each model.
        candidates: [C] candidate columns, most relevant first.
        tolerance: largest loss relative to all candidates; see `change`.

    Returns:
        [K] columns, the most informative first.
    """
    search = _Search(rows, values, weights, candidates)
    bound = search.left(candidates.tolist()) + tolerance + _ROUNDING
    chosen = search.upwards(bound)
    if search.left(chosen) > bound:
        chosen = candidates.tolist()
    return np.array(search.downwards(chosen, bound), dtype=np.int64)


class _Search:
    def __init__(self, rows: Floats, values: Floats, weights: Floats, candidates: Ints) -> None:
        self.candidates = candidates.tolist()
        self.codes = {column: _numbered(rows[:, column]) for column in self.candidates}
        # Rows are compared by random sums of their values: different rows have almost never equal sums.
        factors = np.random.default_rng(0).integers(1, 2**63, len(candidates), dtype=np.int64)
        self.factors = dict(zip(self.candidates, factors, strict=True))
        self.values, self.weights = values, weights

    def left(self, columns: Sequence[int]) -> float:
        """Loss of a set of columns."""
        return self._left(self._sums(columns))

    def upwards(self, bound: float) -> list[int]:
        """Columns added until they explain enough or none explains more."""
        chosen: list[int] = []
        waiting = self.candidates.copy()
        groups = np.zeros(len(self.values), dtype=np.int64)
        remaining = change(groups, self.values, self.weights)
        while remaining > bound and waiting and len(chosen) < MOST_COLUMNS:
            after = np.array([change(self._divided(groups, c), self.values, self.weights) for c in waiting])
            best = int(np.argmin(np.round(after, 9)))
            if remaining - after[best] < LEAST_GAIN:
                break
            remaining = float(after[best])
            chosen.append(waiting.pop(best))
            groups = _numbered(self._divided(groups, chosen[-1]))
        return chosen

    def downwards(self, columns: Sequence[int], bound: float) -> list[int]:
        """Columns removed as long as the others explain enough, the last one first."""
        kept, sums = list(columns), self._sums(columns)
        for column in reversed(columns):
            without = sums - self._term(column)
            if self._left(without) <= bound:
                kept.remove(column)
                sums = without
        return kept

    def _divided(self, groups: Ints, column: int) -> Ints:
        """[n] numbers of groups that are divided further by the values of a column, below a few times n."""
        codes = self.codes[column]
        width = int(codes.max(initial=0)) + 1
        divided = groups * width + codes
        few = (int(groups.max(initial=0)) + 1) * width <= _MOST_GROUPS * len(codes)
        return divided if few else _numbered(divided)

    def _sums(self, columns: Sequence[int]) -> Ints:
        return sum((self._term(column) for column in columns), np.zeros(len(self.values), dtype=np.int64))

    def _term(self, column: int) -> Ints:
        return self.codes[column] * self.factors[column]

    def _left(self, sums: Ints) -> float:
        return change(_numbered(sums), self.values, self.weights)


def change(groups: Ints, values: Floats, weights: Floats) -> float:
    """Change of a density if all models of a group get their mean value: 0 to 2.

    Args:
        groups: [n] number of the group of each model.
        values: [n] >= 0.
        weights: [n] >= 0.
    """
    total = float(weights @ values)
    if total <= 0.0:
        return 0.0
    mass = np.bincount(groups, weights)
    mean = np.bincount(groups, weights * values) / np.where(mass > 0.0, mass, 1.0)
    return float(weights @ np.abs(values - mean[groups])) / total


def _numbered(column: Floats | Ints) -> Ints:
    """[n] the index of each value among the different ones."""
    return np.unique(column, return_inverse=True)[1].astype(np.int64).reshape(-1)
