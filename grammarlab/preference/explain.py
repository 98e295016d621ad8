"""Relevance of groups of columns, in words.

The share of a group is the loss of correlation of two models that differ in this group only: one minus the kernel's
correlation exp(-1/2 sum over the group of weight_d (x_d - x'_d)^2), averaged over all pairs of labelled rows that
differ in it. A share is called strong from 1/2, medium from 1/10, weak from 1/100, and none below that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.distance import pdist

from grammarlab.errors import UsageError
from grammarlab.preference.base import Floats, Ints, Level, Relevance

LEVELS: tuple[tuple[float, Level], ...] = ((0.5, "strong"), (0.1, "medium"), (0.01, "weak"))
"""Smallest share of each word."""


def level_of(share: float) -> Level:
    """The word for a share.

    >>> [level_of(share) for share in (0.8, 0.5, 0.2, 0.03, 0.001)]
    ['strong', 'strong', 'medium', 'weak', 'none']
    """
    for least, level in LEVELS:
        if share >= least:
            return level
    return "none"


def relevances(rows: Floats, weights: Floats, groups: Ints, group_names: Sequence[str]) -> list[Relevance]:
    """One entry per group, largest share first; groups of equal share in the order of their numbers.

    Args:
        rows: [n, F] labelled rows.
        weights: [F] the kernel's weights, >= 0.
        groups: [F] group number of each column.
        group_names: a name for each group number.

    Raises:
        UsageError: If a group has no name.
    """
    if len(groups) and len(group_names) <= groups.max():
        raise UsageError(f"group_names: expected {groups.max() + 1} names, one per group, found {len(group_names)}.")
    found = []
    for number, name in enumerate(group_names):
        columns = np.flatnonzero((groups == number) & (weights > 0.0))
        share = _share(rows[:, columns] * np.sqrt(weights[columns]))
        found.append(Relevance(name, share, level_of(share)))
    return sorted(found, key=lambda relevance: -relevance.share)


def _share(scaled: Floats) -> float:
    """Mean loss of correlation over pairs of different rows [n, f], with repeats."""
    if not scaled.shape[1]:
        return 0.0
    distinct, counts = np.unique(scaled, axis=0, return_counts=True)
    first, second = np.triu_indices(len(distinct), 1)
    if not len(first):
        return 0.0
    pairs = (counts[first] * counts[second]).astype(np.float64)
    return float(np.average(-np.expm1(-0.5 * pdist(distinct, "sqeuclidean")), weights=pairs))
