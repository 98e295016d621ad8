"""Score-weighted kernel density estimation, the paper's baseline (4.7, after Talton et al. 2009).

The density of liked models is a sum of Gaussians at the labelled rows, weighted by scores. The value of a model
is that density divided by the density of the shown models, the same sum without scores: shown models are samples of the
grammar, and frequent models are not necessarily liked. Columns are scaled by their standard deviation over the
labelled rows; the single bandwidth is chosen so that the value of each label, computed from all others, is nearest to
its score (least squares). The likelihood of liked rows, the usual criterion, is far worse in hundreds of columns:
it gives bandwidths so small that only the labelled rows themselves are liked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Prediction, Relevance, Rows, rows_to_predict
from grammarlab.preference.factors import relevances
from grammarlab.preference.observations import Observations, checked_groups, observe, thinned
from grammarlab.preference.processes.posterior import squared_distances

MAX_ROWS_TO_KEEP = 4096
"""Largest number of distinct rows for predictions; of more, a selection of the same score distribution is used."""
MAX_ROWS_TO_FIT = 1024
"""Largest number of distinct rows for choosing the bandwidth."""

_BANDWIDTHS = np.exp(np.linspace(-3.0, 3.0, 25))
"""Candidate bandwidths, as multiples of the root mean squared distance of two rows."""
_ROWS_AT_ONCE = 4096
"""Number of predictions per block, which bounds the memory."""


@dataclass(frozen=True)
class KernelDensityPreference(AbstractPreference):
    """Result of `fit` with `method="kde"`: the density of liked models divided by that of the shown models."""

    num_columns: int
    groups: Ints
    """[F] group number of each column, for `explain`."""
    observations: Observations
    weights: Floats
    """[F] one over the squared bandwidth of each column; 0 for columns that do not vary."""

    def predict(self, rows: Rows) -> Prediction:
        """The ratio of the densities, 0 out of reach of all labels, and 50 / sqrt(1 + number of labels within reach).

        Density estimation has no uncertainty; the second number measures how well a place is explored.
        """
        table = rows_to_predict(rows, self.num_columns)
        mean, reach = np.empty(len(table)), np.empty(len(table))
        with threadpool_limits(1, "blas"):
            for start in range(0, len(table), _ROWS_AT_ONCE):
                block = slice(start, start + _ROWS_AT_ONCE)
                mean[block], reach[block] = _ratio(table[block], self.observations, self.weights)
        return Prediction(mean, MAX_SCORE / 2.0 / np.sqrt(1.0 + reach))

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
        seed: selects rows if there are more than `MAX_ROWS_TO_FIT`.
        warm: not used.

    Raises:
        UsageError: If labels or groups are out of range.
    """
    observations = thinned(observe(rows, scores), MAX_ROWS_TO_KEEP, seed)
    numbers = checked_groups(groups, observations.rows.shape[1])
    with threadpool_limits(1, "blas"):
        weights = _chosen_weights(thinned(observations, MAX_ROWS_TO_FIT, seed))
    return KernelDensityPreference(len(numbers), numbers, observations, weights)


def _chosen_weights(observations: Observations) -> Floats:
    """[F] one over the squared bandwidths with the best leave-one-out predictions of scores."""
    variance = np.var(observations.rows, axis=0)
    unit = np.divide(1.0, variance, out=np.zeros_like(variance), where=variance > 0.0)
    scaled = (observations.rows - observations.rows.mean(axis=0)) * np.sqrt(unit)
    squared = squared_distances(scaled, scaled)
    np.fill_diagonal(squared, np.inf)
    typical = 2.0 * max(int(np.count_nonzero(unit)), 1)  # mean squared distance of two rows, columns of variance 1

    def misfit(bandwidth: float) -> float:
        kernel = np.exp(-0.5 * squared / (bandwidth**2 * typical))
        return float(np.sum((observations.means - _weighted(kernel, observations)[0]) ** 2))

    best = min(_BANDWIDTHS, key=misfit)
    return unit / (best**2 * typical)


def _ratio(rows: Floats, observations: Observations, weights: Floats) -> tuple[Floats, Floats]:
    """For rows [m, F]: the ratio of the densities, and the sum over labels of the kernel, [m] each."""
    center, root = observations.rows.mean(axis=0), np.sqrt(weights)
    kernel = np.exp(-0.5 * squared_distances((rows - center) * root, (observations.rows - center) * root))
    return _weighted(kernel, observations)


def _weighted(kernel: Floats, observations: Observations) -> tuple[Floats, Floats]:
    """For a kernel [m, n] with n labels: its weighted mean score, 0 where it is 0, and its sum, [m] each."""
    density, liked_density = kernel @ observations.counts, kernel @ (observations.means * observations.counts)
    return np.divide(
        liked_density, density, out=np.zeros(len(density)), where=density > np.finfo(np.float64).tiny
    ), density
