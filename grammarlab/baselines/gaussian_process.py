"""The paper's preference: a zero-mean Gaussian process with automatic relevance detection (4.5.3, Equations 4.4-4.8).

Each column has its own weight theta_d. Weights and amplitude theta_0 minimise

    E(theta) = -log p(u | theta, m) + penalty sum_d |theta_d|                                              (4.8)

over log theta, by L-BFGS instead of the paper's conjugate gradients. E has many local minima. The search starts from
the best relevance that all columns can share, each scaled to the range 0-1 of the labelled rows. It goes in stages:
after each, columns with irrelevant weights are left out, so that most of the work is done on few columns;
after convergence, left-out columns that would lower E are added again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_solve, cholesky
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Prediction, Relevance, Rows, rows_to_predict
from grammarlab.preference.factors import relevances
from grammarlab.preference.observations import Observations, checked_groups, observe, thinned
from grammarlab.preference.processes.evidence import Data, loss, minimise, padded, padded_size
from grammarlab.preference.processes.posterior import Hyperparameters, Posterior, condition, squared_distances

NOISE = 0.01
"""1 / beta of Equation 4.6, in squared scores."""
PENALTY = 0.1
"""lambda of Equation 4.8."""

MAX_ROWS_TO_FIT = 1024
"""Largest number of distinct rows for fitting; of more, a selection with the same distribution of scores is used."""
MAX_ROWS_TO_KEEP = 4096
"""Largest number of distinct rows for predictions, selected in the same way."""

MAX_ITERATIONS = 100
"""Largest number of L-BFGS iterations of a search."""
_ITERATIONS_PER_STAGE = 20
"""Largest number of iterations before columns are left out."""

_RELEVANCES = np.exp(np.linspace(-4.0, 4.0, 9))
"""Candidate relevances, as multiples of one over the mean squared distance of two rows."""

_MIN_LOG_THETA, _MAX_LOG_THETA = np.log(1e-11), np.log(1e5)
"""Bounds of log theta: wide enough to be inactive, narrow enough for exp."""

_MAX_IRRELEVANT = 3e-3
"""Weight times squared range below which a column may be left out: it lowers a correlation by 0.15 % at most."""
_RETURN_WEIGHT = 3e-3
"""Weight times squared range of an added column; in log theta, a smaller one would hardly change."""
_RETURN_SLOPE = 0.05
"""Decrease of E per unit of weight times squared range from which a column is added again."""
_MAX_RETURNS = 32
"""Largest number of columns that are added again at once."""


@dataclass(frozen=True, slots=True)
class StartingKernel:
    """A kernel with equal relevance of all columns."""

    amplitude: float
    """theta_0 in squared scores."""
    weights: Floats
    """[F] equal for all columns once each is scaled to the range 0-1; 0 for columns that do not vary, about which
    the labels say nothing."""


@dataclass(frozen=True, slots=True)
class HyperparameterPoint:
    """A point of the search for hyperparameters, with the cost of reaching it."""

    log_amplitude: float
    weights: Floats
    """[F] 0 for columns that are left out."""
    energy: float = np.inf
    """E of Equation 4.8 over the fitted rows; infinite before the first stage."""
    iterations: int = 0
    evaluations: int = 0
    resting: bool = False
    """Whether the last stage converged."""


@dataclass(frozen=True)
class GaussianProcessPreference(AbstractPreference):
    """Result of `fit` with `method="paper"`."""

    num_columns: int
    groups: Ints
    """[F] group number of each column, for `explain`."""
    rows: Floats
    """[n, F] distinct labelled rows."""
    posterior: Posterior
    search: HyperparameterPoint
    """Result of the search for weights."""

    def predict(self, rows: Rows) -> Prediction:
        return self.posterior.predict(rows_to_predict(rows, self.num_columns))

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        return relevances(self.rows, self.search.weights, self.groups, group_names)


def common_relevance(observations: Observations, noise: float, penalty: float) -> StartingKernel:
    """The start with the best evidence (Equation 4.8) among a few relevances.

    For each the best amplitude has a closed form, taking noise as a share of the mean squared score. If all scores
    are zero, no choice is possible: the amplitude is then half of `MAX_SCORE` squared.

    Args:
        observations: the labels.
        noise: 1 / beta > 0 in squared scores.
        penalty: lambda >= 0.
    """
    ranges = np.ptp(observations.rows, axis=0)
    unit = np.divide(1.0, ranges**2, out=np.zeros_like(ranges), where=ranges > 0.0)
    scaled = (observations.rows - observations.rows.mean(axis=0)) * np.sqrt(unit)
    squared, u = squared_distances(scaled, scaled), observations.means
    n, typical = len(u), float(np.mean(squared)) or 1.0
    best, least = StartingKernel((MAX_SCORE / 2.0) ** 2, unit / typical), np.inf
    if not np.any(u > 0.0):
        return best
    ratio = noise / float(np.mean(u * u))
    for relevance in _RELEVANCES / typical:
        correlation = np.exp(-0.5 * relevance * squared)
        correlation.flat[:: n + 1] += ratio / observations.counts + 1e-12
        factor = cholesky(correlation, lower=True, overwrite_a=True, check_finite=False)
        amplitude = float(u @ cho_solve((factor, True), u, check_finite=False)) / n
        energy = float(np.sum(np.log(np.diag(factor))) + 0.5 * n * np.log(amplitude) + penalty * relevance * unit.sum())
        if energy < least:
            best, least = StartingKernel(amplitude, relevance * unit), energy
    return best


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    groups: ArrayLike | None = None,
    seed: int = 0,
    warm: AbstractPreference | None = None,
    noise: float = NOISE,
    penalty: float = PENALTY,
) -> GaussianProcessPreference:
    """The Gaussian process of Equations 4.4-4.8, with the relevance of each column learned.

    If all scores are zero, they contain no information about relevance: the amplitude is then 50 squared, and all
    columns that vary have equal relevance.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100.
        groups: [F] group numbers, for `explain` only.
        seed: selects rows if there are more than `MAX_ROWS_TO_FIT`; nothing else is random.
        warm: a preference found by this method on the same columns. The search then also starts from its weights, and
            the better end is taken.
        noise: 1 / beta > 0, in squared scores.
        penalty: lambda >= 0.

    Raises:
        UsageError: If labels, groups, noise or penalty are out of range, or `warm` has other columns.
    """
    if not (0.0 < noise < np.inf and 0.0 <= penalty < np.inf):
        raise UsageError(f"expected noise > 0 and penalty >= 0, found noise {noise} and penalty {penalty}.")
    observations = thinned(observe(rows, scores), MAX_ROWS_TO_KEEP, seed)
    num_columns = observations.rows.shape[1]
    numbers = checked_groups(groups, num_columns)
    to_fit = thinned(observations, MAX_ROWS_TO_FIT, seed)
    previous = [] if warm is None else [_warm_start(warm, num_columns)]
    with jax.enable_x64(True), threadpool_limits(1, "blas"):
        common = common_relevance(to_fit, noise, penalty)
        search = HyperparameterPoint(float(np.log(common.amplitude)), common.weights)
        if np.any(observations.means > 0.0):
            ends = [_descend(start, to_fit, noise, penalty) for start in (search, *previous)]
            search = min(ends, key=lambda end: end.energy)
    hyperparameters = Hyperparameters(float(np.exp(search.log_amplitude)), search.weights, noise)
    return GaussianProcessPreference(
        num_columns, numbers, observations.rows, condition(hyperparameters, observations), search
    )


def _warm_start(warm: AbstractPreference, num_columns: int) -> HyperparameterPoint:
    if not isinstance(warm, GaussianProcessPreference) or warm.num_columns != num_columns:
        raise UsageError(
            f'warm: expected a preference that method="paper" found on the same {num_columns} columns, found '
            f"{type(warm).__name__} on {warm.num_columns}. Leave it out when the columns have changed."
        )
    return HyperparameterPoint(warm.search.log_amplitude, warm.search.weights)


def _energy(log_theta: jax.Array, noise: jax.Array, penalty: jax.Array, data: Data) -> jax.Array:
    """E of Equation 4.8 at log theta [1 + F], the amplitude first."""
    theta = jnp.exp(log_theta)
    return loss(theta[0], theta[1:], noise, data) + penalty * jnp.sum(theta[1:])


_energy_and_gradient = jax.jit(jax.value_and_grad(_energy))
_loss_by_weights = jax.jit(jax.grad(loss, argnums=1))


def _descend(
    start: HyperparameterPoint, observations: Observations, noise: float, penalty: float
) -> HyperparameterPoint:
    """Stages of L-BFGS, with columns removed and added in between, until convergence or the limit of iterations."""
    ranges = np.ptp(observations.rows, axis=0)
    varying = np.where(ranges > 0.0, start.weights, 0.0)
    search = replace(start, weights=varying)
    while True:
        search = _stage(search, observations, ranges, noise, penalty)
        if search.iterations >= MAX_ITERATIONS:
            return search
        if search.resting:
            weights = _with_returning(search, observations, ranges, noise, penalty)
            if weights is None:
                return search
            search = replace(search, weights=weights)


def _stage(
    search: HyperparameterPoint, observations: Observations, ranges: Floats, noise: float, penalty: float
) -> HyperparameterPoint:
    """Iterations of L-BFGS over the columns with a weight; then irrelevant columns are left out."""
    active = np.flatnonzero(search.weights > 0.0)
    data = _on_device(observations, active)
    size = data.rows.shape[1] + 1
    used = len(active) + 1

    def evaluate(log_theta: Floats) -> tuple[float, Floats]:
        padding = np.full(size - used, _MIN_LOG_THETA)
        value, gradient = _energy_and_gradient(np.concatenate((log_theta, padding)), noise, penalty, data)
        return float(value), np.asarray(gradient)[:used]

    minimum = minimise(
        evaluate,
        np.concatenate(([search.log_amplitude], np.log(search.weights[active]))),
        np.full(used, _MIN_LOG_THETA),
        np.full(used, _MAX_LOG_THETA),
        max_iterations=min(_ITERATIONS_PER_STAGE, MAX_ITERATIONS - search.iterations),
    )
    active_weights = np.exp(minimum.point[1:])
    _, gradient = evaluate(minimum.point)
    scaled = active_weights * ranges[active] ** 2
    weights = np.zeros_like(search.weights)
    weights[active] = np.where((scaled < _MAX_IRRELEVANT) & (gradient[1:] >= 0.0), 0.0, active_weights)
    return HyperparameterPoint(
        float(minimum.point[0]),
        weights,
        minimum.value,
        search.iterations + max(minimum.iterations, 1),
        search.evaluations + minimum.evaluations + 1,
        minimum.converged,
    )


def _on_device(observations: Observations, active: Ints) -> Data:
    """The active columns, padded to the number of all columns or to 1/4 or 1/16 of it, for few compilations."""
    full = padded_size(observations.rows.shape[1], 8)
    size = next(size for size in (full // 16, full // 4, full) if size >= len(active) and (size >= 32 or size == full))
    part = replace(observations, rows=observations.rows[:, active])
    return jax.tree.map(jnp.asarray, padded(part, size))


def _with_returning(
    search: HyperparameterPoint, observations: Observations, ranges: Floats, noise: float, penalty: float
) -> Floats | None:
    """The weights [F] with columns added that would lower E; None if there are none."""
    num_columns = len(ranges)
    data = _on_device(observations, np.arange(num_columns))
    weights = np.zeros(data.rows.shape[1])
    weights[:num_columns] = search.weights
    slope = np.asarray(_loss_by_weights(np.exp(search.log_amplitude), weights, noise, data))[:num_columns] + penalty
    outside = np.flatnonzero((search.weights * ranges**2 < _RETURN_WEIGHT) & (ranges > 0.0))
    gain = -slope[outside] / ranges[outside] ** 2
    order = np.argsort(-gain, kind="stable")[:_MAX_RETURNS]
    returning = outside[order[gain[order] > _RETURN_SLOPE]]
    if not len(returning):
        return None
    weights = search.weights.copy()
    weights[returning] = _RETURN_WEIGHT / ranges[returning] ** 2
    return weights
