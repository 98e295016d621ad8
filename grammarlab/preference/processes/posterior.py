"""Posterior of a Gaussian process with given hyperparameters: Equations 4.4 and 4.5.

Plain NumPy: a prediction is two matrix products and a triangular solve over the columns that have a weight, a few
dozen of hundreds, and needs no compilation for new sizes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.linalg import LinAlgError, cho_solve, cholesky, solve_triangular
from threadpoolctl import ThreadpoolController

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import GrammarlabError
from grammarlab.preference.base import Prediction
from grammarlab.preference.observations import Observations
from grammarlab.preference.person import DISLIKED

MAX_ROWS = 4096
"""Largest number of rows that a process is conditioned on, and of predictions in one block: a budget of memory."""


@cache
def blas_libraries() -> ThreadpoolController:
    """The BLAS libraries of NumPy and SciPy, whose number of threads can be limited.

    Both are loaded by the imports above. Looking for them again takes milliseconds, more than a small prediction.
    """
    return ThreadpoolController()


@dataclass(frozen=True, slots=True)
class Hyperparameters:
    """Kernel amplitude * exp(-1/2 sum_d weights_d (x_d - x'_d)^2) + noise * delta (Equation 4.6)."""

    amplitude: float
    """theta_0 > 0, in squared scores."""
    weights: Floats
    """[F] theta_d >= 0, per squared unit of column d; 0 for columns that do not matter."""
    noise: float
    """1 / beta > 0, in squared scores: the variance of one label around the function."""


@dataclass(frozen=True, slots=True)
class Posterior:
    """A Gaussian process conditioned on observations."""

    hyperparameters: Hyperparameters
    columns: Ints
    """[A] the columns with a weight above 0."""
    scaled: Floats
    """[n, A] observed rows in these columns, centred and multiplied by the square roots of the weights: the kernel is
    isotropic in them."""
    center: Floats
    """[A] mean of the observed rows, which is subtracted."""
    factor: Floats
    """[n, n] lower Cholesky factor of C_n."""
    solution: Floats
    """[n] C_n^-1 u, for the mean scores u."""
    subtracted: Floats | None = None
    """[n, A] the subtracted rows of observations in the same form; None if all are of one row."""
    compared: Floats | None = None
    """[n] 1 if a row is subtracted, otherwise 0."""
    level: float = 0.0
    """Subtracted from all means: comparisons alone leave it open, so that as many of their rows are disliked as before
    any label."""

    def predict(self, rows: Floats) -> Prediction:
        """Mean (Equation 4.4) and standard deviation (4.5) of the scores of rows [m, F]."""
        mean, variance = np.empty(len(rows)), np.empty(len(rows))
        prior = self.hyperparameters.amplitude + self.hyperparameters.noise
        with blas_libraries().limit(limits=1, user_api="blas"):
            for start in range(0, len(rows), MAX_ROWS):
                block = slice(start, start + MAX_ROWS)
                across = self.covariance_with_observed(rows[block])
                mean[block] = across @ self.solution - self.level
                explained = solve_triangular(self.factor, across.T, lower=True, overwrite_b=True, check_finite=False)
                variance[block] = prior - np.einsum("nm,nm->m", explained, explained)
        return Prediction(mean, np.sqrt(np.maximum(variance, 0.0)))

    def covariance_with_observed(self, rows: Floats) -> Floats:
        """[m, n] kernel between rows [m, F] and observations, without noise."""
        scaled = (rows[:, self.columns] - self.center) * np.sqrt(self.hyperparameters.weights[self.columns])
        across = self.hyperparameters.amplitude * np.exp(-0.5 * squared_distances(scaled, self.scaled))
        if self.subtracted is None or self.compared is None:
            return across
        subtracted = self.hyperparameters.amplitude * np.exp(-0.5 * squared_distances(scaled, self.subtracted))
        return across - self.compared * subtracted


def squared_distances(rows: Floats, others: Floats) -> Floats:
    """[m, n] squared Euclidean distances between rows [m, A] and [n, A], by one matrix product."""
    products = (
        np.einsum("ma,ma->m", rows, rows)[:, None] + np.einsum("na,na->n", others, others) - 2.0 * rows @ others.T
    )
    return np.maximum(products, 0.0, out=products)


def condition(hyperparameters: Hyperparameters, observations: Observations) -> Posterior:
    """The posterior given observations; a row that was scored m times has noise / m.

    Raises:
        GrammarlabError: If the covariance is not positive definite in float64, for example with a noise far below the
            amplitude.
    """
    columns = np.flatnonzero(hyperparameters.weights > 0.0)
    center = observations.rows[:, columns].mean(axis=0)
    scaled = (observations.rows[:, columns] - center) * np.sqrt(hyperparameters.weights[columns])
    covariance = hyperparameters.amplitude * np.exp(-0.5 * squared_distances(scaled, scaled))
    noise, differences = hyperparameters.noise / observations.counts, observations.differences
    subtracted, compared = None, None
    if differences is None:
        covariance.flat[:: len(scaled) + 1] = hyperparameters.amplitude + noise
    else:
        subtracted = (differences.others[:, columns] - center) * np.sqrt(hyperparameters.weights[columns])
        compared = differences.compared
        across = compared * hyperparameters.amplitude * np.exp(-0.5 * squared_distances(scaled, subtracted))
        both = hyperparameters.amplitude * np.exp(-0.5 * squared_distances(subtracted, subtracted))
        covariance += compared[:, None] * compared * both - across - across.T
        covariance.flat[:: len(scaled) + 1] += np.where(differences.variances > 0.0, differences.variances, noise)
    with blas_libraries().limit(limits=1, user_api="blas"):
        try:
            factor = cholesky(covariance, lower=True, overwrite_a=True, check_finite=False)
        except LinAlgError as error:
            raise GrammarlabError(
                f"the covariance of {len(scaled)} labels is singular: the noise {hyperparameters.noise:g} is too small "
                f"for the amplitude {hyperparameters.amplitude:g}. Fit with more noise."
            ) from error
        solution = cho_solve((factor, True), observations.means, check_finite=False)
    posterior = Posterior(
        hyperparameters=hyperparameters,
        columns=columns,
        scaled=scaled,
        center=center,
        factor=factor,
        solution=solution,
        subtracted=subtracted,
        compared=compared,
    )
    if compared is None or not compared.all():
        return posterior
    return replace(posterior, level=float(np.quantile(posterior.predict(observations.all_rows).mean, DISLIKED)))
