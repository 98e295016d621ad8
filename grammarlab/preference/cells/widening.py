"""Shares of sums as further columns, and splits of the rows with them."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from grammarlab.preference.base import Floats, Ints
from grammarlab.preference.cells.splits import Above, Flags, Splits


def splits_of(
    rows: Floats,
    groups: Ints,
    continuous: Flags,
    shares_of: tuple[Ints, ...],
    scores: Floats,
    near: Collection[Above] = (),
) -> Splits:
    """`Splits.of` rows, including splits by shares."""
    owners = np.concatenate([groups, *(groups[columns] for columns in shares_of)])
    added = np.ones(sum(len(columns) for columns in shares_of), dtype=bool)
    return Splits.of(widened(rows, shares_of), owners, np.concatenate([continuous, added]), scores, near)


def widened(rows: Floats, shares_of: tuple[Ints, ...]) -> Floats:
    """Rows with the share of each column of some sets in their sum; -1/2 if the sum is 0."""
    if not shares_of:
        return rows
    parts = []
    for columns in shares_of:
        total = rows[:, columns].sum(axis=1, keepdims=True)
        parts.append(np.where(total > 0.0, rows[:, columns] / np.where(total > 0.0, total, 1.0), -0.5))
    return np.concatenate([rows, *parts], axis=1)


def sums_of(rows: Floats, groups: Ints, continuous: Flags) -> tuple[Ints, ...]:
    """Groups whose counts have different sums: the share of a column may be relevant."""
    found = []
    for group in np.unique(groups[~continuous]).tolist():
        columns = np.flatnonzero((groups == group) & ~continuous)
        total = rows[:, columns].sum(axis=1)
        if len(columns) > 1 and np.ptp(total) > 0.0 and total.max() > 1.0:
            found.append(columns)
    return tuple(found)
