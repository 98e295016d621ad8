"""Products of preferences, one per factor with its own labels (Equation 4.3), and the relevance of groups of columns.

The share of a group is the loss of correlation of two models that differ in this group only: one minus the kernel's
correlation exp(-1/2 sum over the group of weight_d (x_d - x'_d)^2), averaged over all pairs of labelled rows that
differ in it. A share is called strong from 1/2, medium from 1/10, weak from 1/100, and none below that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial.distance import pdist

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.preference.base import (
    MAX_SCORE,
    NEGLIGIBLE_SHARE,
    AbstractPreference,
    Level,
    Prediction,
    Relevance,
    Rows,
)

_LEVELS: tuple[tuple[float, Level], ...] = ((0.5, "strong"), (0.1, "medium"), (NEGLIGIBLE_SHARE, "weak"))
"""Smallest share of each word."""


class ProductPreference(AbstractPreference):
    """The product of named factors, each as a share of the highest score: u = 100 prod_i u_i / 100.

    Expected scores of factors are clipped to 0 and the highest score.
    """

    def __init__(self, factors: Mapping[str, AbstractPreference]) -> None:
        """Join factors.

        Args:
            factors: at least one, all fitted on the same columns.

        Raises:
            UsageError: If there is none, or they were fitted on different numbers of columns.
        """
        sizes = {name: factor.num_columns for name, factor in factors.items()}
        if len(set(sizes.values())) != 1:
            listing = ", ".join(f"{name}: {size}" for name, size in sizes.items()) or "none"
            raise UsageError(f"factors: expected at least one, all fitted on the same columns; found {listing}.")
        self.factors = dict(factors)
        self.num_columns = next(iter(sizes.values()))

    def predict(self, rows: Rows) -> Prediction:
        """Mean and standard deviation of the product of independent factors.

        With means m_i and variances v_i as shares, the product has mean prod m_i and variance
        prod (v_i + m_i^2) - prod m_i^2.
        """
        parts = [factor.predict(rows) for factor in self.factors.values()]
        mean = np.clip([part.mean for part in parts], 0.0, MAX_SCORE) / MAX_SCORE
        variance = (np.array([part.std for part in parts]) / MAX_SCORE) ** 2
        product = np.prod(mean, axis=0)
        total = np.prod(variance + mean**2, axis=0) - product**2
        return Prediction(MAX_SCORE * product, MAX_SCORE * np.sqrt(np.maximum(total, 0.0)))

    @property
    def explaining(self) -> ProductPreference:
        """The product of what the factors explain."""
        return ProductPreference({name: factor.explaining for name, factor in self.factors.items()})

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        """One entry per factor and group, ``factor: group``, most relevant first."""
        entries = [
            Relevance(f"{name}: {entry.name}", entry.share, entry.level)
            for name, factor in self.factors.items()
            for entry in factor.explain(group_names)
        ]
        return sorted(entries, key=lambda entry: -entry.share)


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
    entries = []
    for number, name in enumerate(group_names):
        columns = np.flatnonzero((groups == number) & (weights > 0.0))
        share = _share(rows[:, columns] * np.sqrt(weights[columns]))
        entries.append(Relevance(name, share, level_of(share)))
    return sorted(entries, key=lambda relevance: -relevance.share)


def level_of(share: float) -> Level:
    """The word for a share.

    >>> [level_of(share) for share in (0.8, 0.5, 0.2, 0.03, 0.001)]
    ['strong', 'strong', 'medium', 'weak', 'none']
    """
    for least, level in _LEVELS:
        if share >= least:
            return level
    return "none"


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
