"""Evidence of hyperparameters (Equations 4.6 and 4.7), with an analytic gradient, in JAX, and its minimum by L-BFGS.

`loss` can be composed with any parametrisation and penalty and differentiated: weights shared by a group of columns
are ``weights = group_weights[groups]``. Its gradient costs two more matrix products and an inverse, and needs no
[n, n, F] array: with S = 1/2 (C^-1 - a a^T) * K and a = C^-1 u,

    dE / d weight_d = -1/2 sum_ij S_ij (x_id - x_jd)^2 = -(sum_i x_id^2 sum_j S_ij - sum_i x_id (S X)_id).

Everything is float64. JAX has this option per thread, so callers compute inside ``with jax.enable_x64(True)`` and
do not affect the rest of the program.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.linalg import solve_triangular
from scipy.optimize import minimize

from grammarlab.arrays import Floats
from grammarlab.preference.observations import Observations

Evaluate = Callable[[Floats], tuple[float, Floats]]
"""Function from a point [d] to its value and gradient [d]."""
MIN_BLOCK = 64
"""Smallest size of matrices. Halving a smaller one costs more than it saves, and smaller tables are padded to it, so
that few sizes are compiled."""


@dataclass(frozen=True, slots=True)
class Minimum:
    """Result of a search."""

    point: Floats
    """[d] the best point."""
    value: float
    iterations: int
    evaluations: int
    converged: bool
    """Whether it converged before the limit of iterations."""


class Data(NamedTuple):
    """Observations as arrays of a few fixed sizes, so that a growing label set is rarely recompiled."""

    rows: jax.Array | Floats
    """[n, F] centred rows, zeros for padding."""
    means: jax.Array | Floats
    """[n] mean scores, 0 for padding."""
    counts: jax.Array | Floats
    """[n] number of labels of each row; 0 for padding."""
    spread: jax.Array | float
    """Sum of the squared distances of labels to the mean of their row, as in `Observations`."""
    others: jax.Array | Floats | None = None
    """[n, F] subtracted rows as in `Differences`, shifted like the rows; None if all observations are of one row."""
    compared: jax.Array | Floats | None = None
    """[n] 1 if a row is subtracted, else 0."""
    variances: jax.Array | Floats | None = None
    """[n] variance of each observation; 0 for mean scores."""


def minimise(
    evaluate: Evaluate,
    start: Floats,
    low: Floats,
    high: Floats,
    *,
    max_iterations: int,
    relative_gain: float = 1e-7,
) -> Minimum:
    """A local minimum, or the best evaluated point, within low <= point <= high, by SciPy's L-BFGS-B.

    Args:
        evaluate: the function; a point with a value that is not finite counts as very bad.
        start: [d] initial point.
        low: [d] lower bounds.
        high: [d] upper bounds.
        max_iterations: largest number of iterations.
        relative_gain: stop when an iteration gains less than this share of the value's size.
    """
    first = np.clip(start, low, high)
    visited = _Visited(evaluate, first)
    result = minimize(
        visited,
        first,
        jac=True,
        method="L-BFGS-B",
        bounds=np.stack((low, high), axis=1),
        options={"maxiter": max_iterations, "maxfun": 2 * max_iterations + 20, "ftol": relative_gain, "gtol": 1e-4},
    )
    # Near cliffs the line search may step up and report convergence; then the search continues from the best point.
    rose = result.fun > visited.value
    return Minimum(
        visited.point, visited.value, int(result.nit), int(result.nfev), converged=bool(result.success) and not rose
    )


def padded(observations: Observations, num_columns_padded: int, num_rows_padded: int = 0) -> Data:
    """Observations padded to one of few sizes: two sizes per doubling of rows, and a given number of columns.

    Args:
        observations: the labels.
        num_columns_padded: at least their number of columns; weights of added columns must be finite.
        num_rows_padded: number of rows instead, at least their number; 0 for two sizes per doubling.
    """
    num_rows, num_columns = observations.rows.shape
    n = num_rows_padded or padded_size(num_rows, 2)
    center = observations.rows.mean(axis=0)

    def filled(rows: Floats) -> Floats:
        table = np.zeros((n, num_columns_padded))
        table[:num_rows, :num_columns] = rows - center
        return table

    def column(values: Floats) -> Floats:
        return np.concatenate([values, np.zeros(n - num_rows)])

    differences = observations.differences
    data = Data(
        rows=filled(observations.rows),
        means=column(observations.means),
        counts=column(observations.counts),
        spread=observations.spread,
    )
    if differences is None:
        return data
    others, compared, variances = (
        filled(differences.others),
        column(differences.compared),
        column(differences.variances),
    )
    return data._replace(others=others, compared=compared, variances=variances)


def padded_size(size: int, steps: int) -> int:
    """The next larger size of a grid with a given number of equal steps between powers of two; at least 16.

    >>> [padded_size(n, 2) for n in (1, 16, 17, 25, 33, 100, 256, 257)]
    [16, 16, 24, 32, 48, 128, 256, 384]
    """
    if size <= 16:
        return 16
    step = (1 << (size - 1).bit_length() - 1) // steps
    return -(-size // step) * step


@jax.custom_vjp
def loss(amplitude: jax.Array, weights: jax.Array, noise: jax.Array, data: Data) -> jax.Array:
    """-log p(u | theta, m) of all labels (Equation 4.7), a scalar.

    Args:
        amplitude: theta_0 > 0.
        weights: [F] theta_d >= 0.
        noise: 1 / beta > 0.
        data: the labels; no gradient is taken with respect to them.
    """
    return _loss_and_gradient(amplitude, weights, noise, data)[0]


def covariance(rows: jax.Array, others: jax.Array, amplitude: jax.Array, weights: jax.Array) -> jax.Array:
    """[m, n] kernel of Equation 4.6 without noise, between rows [m, F] and [n, F].

    Args:
        rows: [m, F] rows.
        others: [n, F] rows.
        amplitude: theta_0.
        weights: [F] theta_d of Equation 4.6.
    """
    weighted = rows * weights
    squared = jnp.sum(weighted * rows, axis=1)[:, None] + jnp.sum(others * weights * others, axis=1)
    return amplitude * jnp.exp(-0.5 * jnp.maximum(squared - 2.0 * weighted @ others.T, 0.0))


class _Visited:
    """A function that records its best point; values that are not finite count as very bad."""

    def __init__(self, evaluate: Evaluate, start: Floats) -> None:
        self.point, self.value = start, np.inf
        self._evaluate, self._worst = evaluate, 0.0

    def __call__(self, point: Floats) -> tuple[float, Floats]:
        value, gradient = self._evaluate(point)
        if not (np.isfinite(value) and np.isfinite(gradient).all()):
            return 10.0 * self._worst + 1e6, np.zeros_like(point)
        if value < self.value:
            self.point, self.value = point.copy(), value
        self._worst = max(self._worst, abs(value))
        return value, gradient


def _loss_and_gradient(
    amplitude: jax.Array, weights: jax.Array, noise: jax.Array, data: Data
) -> tuple[jax.Array, tuple[jax.Array, jax.Array, jax.Array]]:
    """The loss and its derivatives by amplitude, weights [F] and noise."""
    X, u, m = jnp.asarray(data.rows), jnp.asarray(data.means), jnp.asarray(data.counts)
    real = m > 0
    share = jnp.where(real, 1.0 / jnp.maximum(m, 1.0), 0.0)
    here, n, has_differences = jnp.arange(len(u)), len(u), data.others is not None
    if data.others is None or data.compared is None or data.variances is None:
        K = jnp.where(real[:, None] & real, covariance(X, X, amplitude, weights), 0.0)
        # A padded row is independent, of variance 1 and with score 0: it does not change determinant or residual.
        C = K.at[here, here].set(jnp.where(real, amplitude + noise * share, 1.0))
    else:
        variances = jnp.asarray(data.variances)
        X, share = jnp.concatenate([X, data.others]), jnp.where(variances > 0.0, 0.0, share)
        sign = jnp.concatenate([jnp.where(real, 1.0, 0.0), -jnp.asarray(data.compared)])
        K = sign[:, None] * sign * covariance(X, X, amplitude, weights)
        C = K[:n, :n] + K[:n, n:] + K[n:, :n] + K[n:, n:]
        C = C.at[here, here].add(jnp.where(real, noise * share + variances, 1.0))
    inverse, log_determinant = _inverse_and_log_determinant(C)
    a = inverse @ u
    extra = jnp.sum(jnp.where(real, m - 1.0, 0.0))
    value = 0.5 * (
        log_determinant
        + u @ a
        + jnp.sum(m) * jnp.log(2.0 * jnp.pi)
        + extra * jnp.log(noise)
        + jnp.sum(jnp.where(real, jnp.log(jnp.maximum(m, 1.0)), 0.0))
        + data.spread / noise
    )
    by_covariance = 0.5 * (inverse - a[:, None] * a)
    S = (jnp.tile(by_covariance, (2, 2)) if has_differences else by_covariance) * K
    by_weights = jnp.sum(X * (S @ X), axis=0) - jnp.sum(S, axis=1) @ (X * X)
    by_noise = jnp.sum(jnp.diagonal(by_covariance) * share) + 0.5 * (extra / noise - data.spread / noise**2)
    return value, (jnp.sum(S) / amplitude, by_weights, by_noise)


def _inverse_and_log_determinant(C: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Inverse and log-determinant of a symmetric matrix [n, n]; NaN if it is not positive definite."""
    L = jax.lax.linalg.cholesky(C, symmetrize_input=False)
    return _gram(_triangular_inverse(L)), 2.0 * jnp.sum(jnp.log(jnp.diagonal(L)))


def _gram(L: jax.Array) -> jax.Array:
    """L^T L of a lower triangular matrix."""
    n = len(L)
    if n <= MIN_BLOCK:
        return L.T @ L
    h = n // 2
    corner = L[h:, :h].T @ L[h:, h:]
    return jnp.block([[_gram(L[:h, :h]) + L[h:, :h].T @ L[h:, :h], corner], [corner.T, _gram(L[h:, h:])]])


# By halves: most of the work becomes products of full blocks, which run near the machine's peak, and the blocks known
# to be zero are left out. At n = 512 this takes 60 % of the time of two triangular solves.


def _triangular_inverse(L: jax.Array) -> jax.Array:
    n = len(L)
    if n <= MIN_BLOCK:
        return solve_triangular(L, jnp.eye(n, dtype=L.dtype), lower=True)
    h = n // 2
    top, bottom = _triangular_inverse(L[:h, :h]), _triangular_inverse(L[h:, h:])
    return jnp.block([[top, jnp.zeros((h, n - h), L.dtype)], [-bottom @ (L[h:, :h] @ top), bottom]])


def _forward(amplitude: jax.Array, weights: jax.Array, noise: jax.Array, data: Data):  # noqa: ANN202
    return _loss_and_gradient(amplitude, weights, noise, data)


def _backward(gradient: tuple[jax.Array, ...], outer: jax.Array):  # noqa: ANN202
    by_amplitude, by_weights, by_noise = gradient
    return outer * by_amplitude, outer * by_weights, outer * by_noise, None


loss.defvjp(_forward, _backward)
