"""Columns that differ from each other, of mean 0 and variance 1."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from grammarlab.arrays import ROUNDING, Floats, Ints


class Distinct(NamedTuple):
    """Columns of n designs that differ from each other."""

    columns: Ints
    """[C] indices: no column is constant, no two say the same."""
    means: Floats
    """[C] their means."""
    scales: Floats
    """[C] > 0, their standard deviations."""

    @classmethod
    def of(cls, rows: Floats) -> Distinct:
        """Of columns [n, F] that say the same, the first one."""
        scales = rows.std(axis=0)
        varying = np.flatnonzero(scales > 0.0)
        table = (rows[:, varying] - rows[:, varying].mean(axis=0)) / scales[varying]
        signed = np.rint(table * np.where(table[:1] < 0.0, -1.0, 1.0) / ROUNDING) + 0.0
        known = dict[bytes, int]()
        for index, column in zip(varying.tolist(), np.ascontiguousarray(signed.T), strict=True):
            known.setdefault(column.tobytes(), index)
        columns = np.array(list(known.values()), dtype=np.int64)
        return cls(columns, rows[:, columns].mean(axis=0), scales[columns])

    def take(self, chosen: Ints) -> Distinct:
        """Some of these columns."""
        return Distinct(self.columns[chosen], self.means[chosen], self.scales[chosen])

    def table(self, rows: Floats) -> Floats:
        """[m, C] these columns of designs [m, F], of mean 0 and variance 1 for the n designs."""
        return (rows[:, self.columns] - self.means) / self.scales
