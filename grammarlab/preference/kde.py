"""Score-weighted kernel density estimation, the paper's baseline (4.7, after Talton et al. 2009).

The wanted models' density is a sum of Gaussians at the labelled rows, each with its score as its weight. A score of
zero adds nothing there, which is what the Gaussian process does better. Columns are scaled by their standard deviation
over the labelled rows; the one bandwidth left is the one under which the density at each label, made of all others, is
nearest to proportional to the scores (least squares, zeros included). The likelihood of the wanted rows, the usual
choice, ends far worse in hundreds of columns: bandwidths so small that only the labelled rows themselves are wanted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.preference.base import (
    MAX_SCORE,
    AbstractPreference,
    Floats,
    Ints,
    Prediction,
    Relevance,
    Rows,
    rows_to_predict,
)
from grammarlab.preference.explain import relevances
from grammarlab.preference.observations import Observations, checked_groups, observe, thinned
from grammarlab.preference.posterior import squared_distances

MAX_ROWS_TO_KEEP = 4096
"""Distinct rows that predictions rest on; of more, a part with the same distribution of scores is taken."""
MAX_ROWS_TO_FIT = 1024
"""Distinct rows that the bandwidth is chosen by."""

_BANDWIDTHS = np.exp(np.linspace(-3.0, 3.0, 25))
"""What is tried, as multiples of the root mean squared distance of two rows."""
_ROWS_AT_ONCE = 4096


@dataclass(frozen=True)
class KernelDensityPreference(AbstractPreference):
    """`method="kde"`: a density of wanted models, scaled so that it is the highest score at its highest label."""

    num_columns: int
    groups: Ints
    """[F] group number of each column, for `explain`."""
    observations: Observations
    weights: Floats
    """[F] one over the squared bandwidth of each column; 0 for columns that do not vary."""
    scale: float
    """Score for a unit of score-weighted kernel sum."""

    def predict(self, rows: Rows) -> Prediction:
        """The density as a score, and 50 / sqrt(1 + number of labels within reach) in place of an uncertainty.

        Density estimation has no uncertainty of its own; the number stands for how well a place has been explored.
        """
        table = rows_to_predict(rows, self.num_columns)
        mean, reach = np.empty(len(table)), np.empty(len(table))
        with threadpool_limits(1, "blas"):
            for start in range(0, len(table), _ROWS_AT_ONCE):
                block = slice(start, start + _ROWS_AT_ONCE)
                mean[block], reach[block] = _sums(table[block], self.observations, self.weights)
        return Prediction(self.scale * mean, MAX_SCORE / 2.0 / np.sqrt(1.0 + reach))

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        return relevances(self.observations.rows, self.weights, self.groups, group_names)


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    groups: ArrayLike | None = None,
    seed: int = 0,
    warm: AbstractPreference | None = None,
) -> KernelDensityPreference:
    """The score-weighted density of labelled rows.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100; only their ratios matter.
        groups: [F] group numbers, for `explain` only.
        seed: chooses among rows where there are more than `MAX_ROWS_TO_FIT`.
        warm: not used; nothing is searched for that a previous preference could help to find.

    Raises:
        UsageError: when labels or groups are out of range.
    """
    observations = thinned(observe(rows, scores), MAX_ROWS_TO_KEEP, seed)
    numbers = checked_groups(groups, observations.rows.shape[1])
    with threadpool_limits(1, "blas"):
        weights = _chosen_weights(thinned(observations, MAX_ROWS_TO_FIT, seed))
        highest = float(np.max(_sums(observations.rows, observations, weights)[0]))
    scale = float(np.max(observations.means)) / highest if highest > 0.0 else 0.0
    return KernelDensityPreference(len(numbers), numbers, observations, weights, scale)


def _chosen_weights(observations: Observations) -> Floats:
    """[F] one over the squared bandwidths under which each row's score is best told from the others."""
    variance = np.var(observations.rows, axis=0)
    unit = np.divide(1.0, variance, out=np.zeros_like(variance), where=variance > 0.0)
    scaled = (observations.rows - observations.rows.mean(axis=0)) * np.sqrt(unit)
    squared = squared_distances(scaled, scaled)
    np.fill_diagonal(squared, np.inf)
    typical = 2.0 * max(int(np.count_nonzero(unit)), 1)  # mean squared distance of two rows, columns of variance 1

    def misfit(bandwidth: float) -> float:
        density = np.exp(-0.5 * squared / (bandwidth**2 * typical)) @ (observations.means * observations.counts)
        scale = float(density @ observations.means) / max(float(density @ density), np.finfo(np.float64).tiny)
        return float(np.sum((observations.means - scale * density) ** 2))

    best = min(_BANDWIDTHS, key=misfit)
    return unit / (best**2 * typical)


def _sums(rows: Floats, observations: Observations, weights: Floats) -> tuple[Floats, Floats]:
    """For rows [m, F]: the sums over labels of score times kernel and of the kernel alone, [m] each."""
    center, root = observations.rows.mean(axis=0), np.sqrt(weights)
    kernel = np.exp(-0.5 * squared_distances((rows - center) * root, (observations.rows - center) * root))
    return kernel @ (observations.means * observations.counts), kernel @ observations.counts
