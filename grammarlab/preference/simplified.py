"""A preference as a function of few columns: what a grammar can be compiled from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.distance import cdist

from grammarlab.preference.base import AbstractPreference, Floats, Ints
from grammarlab.preference.levels import snapped

_AT_ONCE = 2048
"""Rows that are compared with all known ones at once."""


@dataclass(frozen=True)
class SimplifiedPreference:
    """A preference that looks at some columns of a row only.

    Values of these columns that some known model has give what was predicted for that model. For all others, the
    remaining columns are taken from the known model that is most alike, and the preference is asked.
    """

    preference: AbstractPreference
    columns: Ints
    """[K] which columns are looked at."""
    levels: Floats
    """[L] what predictions are drawn to; see `grammarlab.preference.levels`."""
    rows: Floats
    """[m, F] known models, as the preference sees them."""
    values: Floats
    """[m] their predictions, drawn to the levels."""
    weights: Floats
    """[m] >= 0, how much each known model stands for."""

    def __call__(self, read: Floats) -> Floats:
        """The score [n] of values [n, K] of the columns, on the scale of the rows."""
        known, first, scores = self._table
        result = np.zeros(len(read))
        if not len(self.columns):
            return np.full(len(read), scores[0])
        for start in range(0, len(read), _AT_ONCE):
            part = read[start : start + _AT_ONCE]
            distance = cdist(part, known, "sqeuclidean")
            nearest = distance.argmin(axis=1)
            found = scores[nearest]
            new = distance[np.arange(len(part)), nearest] > 1e-18
            if new.any():
                rows = self.rows[first[nearest[new]]]
                rows[:, self.columns] = part[new]
                found[new] = snapped(self.preference.predict(rows).mean, self.levels)
            result[start : start + _AT_ONCE] = found
        return result

    @cached_property
    def _table(self) -> tuple[Floats, Ints, Floats]:
        """The different values [T, K] of the columns, a row that has them [T], and the score most of those have [T]."""
        known, group = np.unique(self.rows[:, self.columns], axis=0, return_inverse=True)
        group = group.reshape(-1)
        levels, level = np.unique(self.values, return_inverse=True)
        pair, first, number = np.unique(group * len(levels) + level, return_index=True, return_inverse=True)
        mass = np.bincount(number.reshape(-1), self.weights)
        order = np.lexsort((mass, pair // len(levels)))
        best = order[np.searchsorted(pair[order] // len(levels), np.arange(len(known)), side="right") - 1]
        return known, first[best], levels[pair[best] % len(levels)]
