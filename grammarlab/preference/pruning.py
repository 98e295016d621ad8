"""Which columns a preference needs: the others are left out one by one as long as hardly any value changes.

A column is not needed where the others already tell the models apart that have different values, whether the
preference looks at it or not. So of several columns that say the same in other words, one is kept.
"""

from __future__ import annotations

import numpy as np

from grammarlab.preference.base import Floats, Ints


def needed_columns(rows: Floats, values: Floats, weights: Floats, order: Ints, tolerance: float) -> Ints:
    """The columns that are still needed to tell the values of models, the most important first.

    Args:
        rows: [n, F] what describes models.
        values: [n] >= 0, the preference.
        weights: [n] >= 0, how much each model stands for.
        order: [C] the columns to begin with, the one to be left out first at the beginning.
        tolerance: how much may be moved in all: the sum of all changes by the sum of all values.

    Returns:
        [K] columns, those that come late in the order first.
    """
    # Rows are compared by random sums of their values: different rows have equal sums as good as never.
    factors = np.random.default_rng(0).integers(1, 2**63, len(order), dtype=np.int64)
    terms = [_numbered(rows[:, column]) * factor for column, factor in zip(order, factors, strict=True)]
    sums = sum(terms, np.zeros(len(rows), dtype=np.int64))
    kept: list[int] = []
    for column, term in zip(order.tolist(), terms, strict=True):
        groups = np.unique(sums - term, return_inverse=True)[1].reshape(-1)
        if change(groups, values, weights) <= tolerance:
            sums = sums - term
        else:
            kept.append(column)
    return np.array(kept[::-1], dtype=np.int64)


def change(groups: Ints, values: Floats, weights: Floats) -> float:
    """How much of a density moves where all models of a group get their mean value: 0 to 2.

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


def _numbered(column: Floats) -> Ints:
    return np.unique(column, return_inverse=True)[1].astype(np.int64).reshape(-1)
