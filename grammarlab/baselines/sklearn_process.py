"""scikit-learn's GaussianProcessRegressor with the same interface, for comparison.

The kernel is that of `method="paper"`, fitted by the evidence only: its weights cannot be penalised. Its gradient needs
an [n, n, F] array, so the number of rows is limited to a quarter of a gigabyte, and a fit of hundreds of labels
and columns takes minutes.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats, Ints
from grammarlab.baselines.gaussian_process import common_relevance
from grammarlab.preference.base import AbstractPreference, Prediction, Relevance, Rows, rows_to_predict
from grammarlab.preference.factors import relevances
from grammarlab.preference.observations import Observations, checked_groups, observe, thinned
from grammarlab.preference.processes.evidence import minimise

NOISE = 0.01
"""Variance of one label in squared scores."""
MAX_ITERATIONS = 100
"""Largest number of L-BFGS iterations."""
MAX_GRADIENT_NUMBERS = 1 << 25
"""Largest number of entries of the array for the gradient: a quarter of a gigabyte."""

_MIN_WEIGHT = 1e-11
"""Smallest weight of a column at the start, so that length scales are finite."""


@dataclass(frozen=True)
class SklearnPreference(AbstractPreference):
    """Result of `fit` with `method="sklearn"`: a fitted regressor."""

    num_columns: int
    groups: Ints
    """[F] group number of each column, for `explain`."""
    observations: Observations
    weights: Floats
    """[F] theta_d of Equation 4.6: one over the squared length scales."""
    regressor: GaussianProcessRegressor

    def predict(self, rows: Rows) -> Prediction:
        table = rows_to_predict(rows, self.num_columns)
        if not len(table):
            return Prediction(np.empty(0), np.empty(0))
        with warnings.catch_warnings(), threadpool_limits(1, "blas"):
            warnings.simplefilter("ignore", UserWarning)  # "variances smaller than 0": it sets them to 0
            prediction: Any = self.regressor.predict(_at_least_one_column(table), return_std=True)
        mean, std = prediction
        return Prediction(mean, np.sqrt(std**2 + NOISE))

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        return relevances(self.observations.rows, self.weights, self.groups, group_names)


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    groups: ArrayLike | None = None,
    seed: int = 0,
    warm: AbstractPreference | None = None,
) -> SklearnPreference:
    """A Gaussian process whose length scales maximise the evidence (Equation 4.7).

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100; if all are zero, the kernel is the start of the search.
        groups: [F] group numbers, for `explain` only.
        seed: selects rows if there are too many.
        warm: a preference of this method on the same columns; the search starts from its weights.

    Raises:
        UsageError: If labels or groups are out of range.
    """
    observations = observe(rows, scores)
    num_columns = observations.rows.shape[1]
    most = int(np.sqrt(MAX_GRADIENT_NUMBERS / max(num_columns, 1)))
    observations = thinned(observations, most, seed)
    numbers = checked_groups(groups, num_columns)
    start = common_relevance(observations, NOISE, 0.0)
    weights = start.weights
    if isinstance(warm, SklearnPreference) and warm.num_columns == num_columns:
        weights = warm.weights
    scales: Any = 1.0 / np.sqrt(np.maximum(weights, _MIN_WEIGHT)) if num_columns else np.ones(1)
    options: dict[str, Any] = {
        "alpha": NOISE / observations.counts,
        "optimizer": _optimise if np.any(observations.means > 0.0) else None,
    }
    kernel: Any = ConstantKernel(start.amplitude, (1e-3, 1e9)) * RBF(scales, (1e-3, 1e6))
    regressor = GaussianProcessRegressor(kernel, **options)
    with warnings.catch_warnings(), threadpool_limits(1, "blas"):
        warnings.simplefilter("ignore")  # warnings about length scales at their bound, which irrelevant columns have
        regressor.fit(_at_least_one_column(observations.rows), observations.means)
    kernel = regressor.kernel_
    length_scales = np.broadcast_to(kernel.k2.length_scale, (max(num_columns, 1),))[:num_columns]
    return SklearnPreference(num_columns, numbers, observations, 1.0 / length_scales**2, regressor)


def _optimise(objective: Any, start: Floats, bounds: Floats) -> tuple[Floats, float]:
    """scikit-learn's optimiser slot, with the budget that `method="paper"` has."""
    minimum = minimise(
        lambda point: objective(point, eval_gradient=True),
        start,
        bounds[:, 0],
        bounds[:, 1],
        max_iterations=MAX_ITERATIONS,
    )
    return minimum.point, minimum.value


def _at_least_one_column(rows: Floats) -> Floats:
    """Rows with a constant column if they have none, since scikit-learn refuses them."""
    return rows if rows.shape[1] else np.zeros((len(rows), 1))
