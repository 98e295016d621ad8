"""Shares of columns in the sum of their group as further columns: how many of the windows are arched."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.preference.growth.split_columns import SplitColumns


def sums_of(rows: Floats, groups: Ints, continuous: Flags) -> tuple[Ints, ...]:
    """Groups whose counts have different sums: the share of a column may be relevant."""
    column_sets = []
    for group in np.unique(groups[~continuous]).tolist():
        columns = np.flatnonzero((groups == group) & ~continuous)
        total = rows[:, columns].sum(axis=1)
        if len(columns) > 1 and np.ptp(total) > 0.0 and total.max() > 1.0:
            column_sets.append(columns)
    return tuple(column_sets)


def split_columns(
    rows: Floats,
    groups: Ints,
    continuous: Flags,
    shares_of: tuple[Ints, ...],
    scores: Floats,
    priors: Floats | None = None,
) -> SplitColumns:
    """`SplitColumns.of` rows, including shares."""
    owners = np.concatenate([groups, *(groups[columns] for columns in shares_of)])
    added = np.ones(sum(len(columns) for columns in shares_of), dtype=bool)
    likely = None if priors is None else np.concatenate([priors, *(priors[columns] for columns in shares_of)])
    return SplitColumns.of(widened(rows, shares_of), owners, np.concatenate([continuous, added]), scores, likely)


def widened(rows: Floats, shares_of: tuple[Ints, ...]) -> Floats:
    """Rows with the share of each column of some sets in their sum; -1/2 if the sum is 0."""
    if not shares_of:
        return rows
    parts = []
    for columns in shares_of:
        total = rows[:, columns].sum(axis=1, keepdims=True)
        parts.append(np.where(total > 0.0, rows[:, columns] / np.where(total > 0.0, total, 1.0), -0.5))
    return np.concatenate([rows, *parts], axis=1)
