"""Products of preferences, one per factor with its own labels: Equation 4.3."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from grammarlab.errors import UsageError
from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Prediction, Relevance, Rows


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
            found = ", ".join(f"{name}: {size}" for name, size in sizes.items()) or "none"
            raise UsageError(f"factors: expected at least one, all fitted on the same columns; found {found}.")
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

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        """One entry per factor and group, ``factor: group``, most relevant first."""
        entries = [
            Relevance(f"{name}: {entry.name}", entry.share, entry.level)
            for name, factor in self.factors.items()
            for entry in factor.explain(group_names)
        ]
        return sorted(entries, key=lambda entry: -entry.share)
