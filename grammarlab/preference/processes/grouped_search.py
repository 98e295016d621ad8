"""Kernels in which a group of columns shares one weight: their evidence, and a search for the best.

A kernel has an amplitude, a noise and one weight theta_g for each group of columns; column d of group g counts with
theta_g / range_d^2, where range_d is the range of the labelled rows, so that units do not matter. The search minimises

    E = -log p(u | theta, m) + sum_g log(1 + (1 + A) theta_g / eps) + (log-normal terms for amplitude and noise)

over the logarithms, by L-BFGS; A is the amplitude. The second term is a prior with a heavy tail instead of the paper's
Lasso (Equation 4.8): a relevant group has a price of 5 nats or more, almost independent of its weight. It grows with
A theta_g, the size of the group's effect on scores, and with the number of groups (`KernelProblem.epsilon`): otherwise
dozens of groups of small weight explain a person's errors.
Two thirds of the groups are usually irrelevant after a few iterations; they are then left out.
Searches start from equal weights of all groups, of groups of counts, and of random halves of the groups.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.observations import Observations
from grammarlab.preference.person import NOISE_PRIOR
from grammarlab.preference.processes.evidence import MIN_BLOCK, Data, Minimum, loss, minimise, padded, padded_size
from grammarlab.preference.processes.posterior import Hyperparameters

EPSILON = 0.04
"""Smallest weights of relevant groups, all together: eps of one group is its part of it."""
AMPLITUDE = (0.2, 1.0)
"""Median of the amplitude's prior, as a share of the squared highest score, and standard deviation of its logarithm."""
NOISE = ((NOISE_PRIOR[0] / MAX_SCORE) ** 2, 2.0 * NOISE_PRIOR[1])
"""The same of the noise, a variance."""
_MAX_DEVIATIONS = 3.0
"""Largest number of standard deviations of amplitude and noise from their medians, by their priors."""
_WEIGHT_BOUNDS = (1e-5, 1e3)
"""Bounds of a weight, per squared range of a column."""
_IRRELEVANT_WEIGHT = 1e-4
"""Weight below which groups are left out."""
_MAX_FREE_LOSS = 0.05
"""Largest loss by groups that are left out, in nats. Many groups of small weight can explain an additive preference."""
_LOG_NO_WEIGHT = float(np.log(np.finfo(np.float64).tiny))
"""Logarithm of a weight without effect."""
_STAGE_ITERATIONS = (20, 80)
"""L-BFGS iterations with all groups, and with the remaining ones."""


@dataclass(frozen=True, slots=True)
class Kernel:
    """Variables of the search."""

    weights: Floats
    """[G] theta_g >= 0; 0 for groups that are left out."""
    amplitude: float
    """Amplitude, as a share of the squared highest score."""
    noise: float
    """Noise, as a share of the squared highest score."""
    energy: float = np.inf
    """E; infinite before a search."""


@dataclass(frozen=True, slots=True)
class KernelProblem:
    """Labels scaled for the search."""

    observations: Observations
    """Rows divided by the range of each column, scores by the highest one."""
    groups: Ints
    """[F] group number of each column."""
    num_groups: int
    varying: Floats
    """[G] 1 if some column of the group varies among the labelled rows, otherwise 0."""

    @property
    def epsilon(self) -> float:
        """eps: the price of a relevant group is its logarithm with a minus sign, so choices among many cost more."""
        return EPSILON / max(float(self.varying.sum()), 1.0)


def scales_of(rows: Floats) -> Floats:
    """[F] the range of each column of labelled rows [n, F]; 1 for constant columns."""
    ranges = np.ptp(rows, axis=0)
    return np.where(ranges > 0.0, ranges, 1.0)


def problem_of(observations: Observations, groups: Ints, scales: Floats, highest: float) -> KernelProblem:
    """Scale labels for the search.

    Args:
        observations: the labels.
        groups: [F] group numbers.
        scales: [F] > 0, divisors of the columns.
        highest: divisor of the scores, > 0.
    """
    scaled = observations.scaled(scales, highest)
    num_groups = int(groups.max(initial=-1)) + 1
    varies = np.ptp(observations.all_rows, axis=0) > 0.0
    varying = np.bincount(groups[varies], minlength=num_groups) > 0
    return KernelProblem(scaled, groups, num_groups, varying.astype(np.float64))


def starting_kernels(problem: KernelProblem, seed: int, num_random: int, continuous: Floats) -> list[Kernel]:
    """Starts of searches: all groups with small weights, with larger weights, counts only, and random halves of groups.

    Args:
        problem: the labels.
        seed: seed of the halves.
        num_random: number of halves.
        continuous: [G] 1 for continuous groups, which overfit more easily than counts; otherwise 0.
    """
    randomness = np.random.default_rng(seed)
    middle = (AMPLITUDE[0], NOISE[0])
    chosen = [randomness.random(problem.num_groups) < 0.5 for _ in range(num_random)]
    weights = [0.05 * problem.varying, 0.5 * problem.varying, *(0.05 * problem.varying * half for half in chosen)]
    counts = problem.varying * (1.0 - continuous)
    if (counts < problem.varying).any() and counts.any():
        weights.insert(2, 0.05 * counts)
    return [Kernel(weight, *middle) for weight in weights]


def search(problem: KernelProblem, start: Kernel) -> Kernel:
    """The best kernel that L-BFGS finds from a start; groups without a weight in the start stay without."""
    kernel = replace(start, weights=np.where(problem.varying > 0.0, start.weights, 0.0))
    for iterations in _STAGE_ITERATIONS:
        kernel = _stage(problem, kernel, iterations)
    return kernel


def hyperparameters(kernel: Kernel, groups: Ints, scales: Floats, highest: float) -> Hyperparameters:
    """The kernel in the original units of rows and scores."""
    size = highest**2
    return Hyperparameters(kernel.amplitude * size, kernel.weights[groups] / scales**2, kernel.noise * size)


def _stage(problem: KernelProblem, kernel: Kernel, iterations: int) -> Kernel:
    active = np.flatnonzero(kernel.weights > 0.0)
    columns = np.flatnonzero(np.isin(problem.groups, active))
    data, groups, num_weights = _on_device(problem, columns, active)

    padding = np.full(num_weights - len(active), _LOG_NO_WEIGHT)

    def evaluate(point: Floats) -> tuple[float, Floats]:
        value, gradient = _energy_and_gradient(np.concatenate((point, padding)), groups, data, problem.epsilon)
        return float(value), np.asarray(gradient)[: len(point)]

    priors = [_range_of(*AMPLITUDE), _range_of(*NOISE)]
    bounds = np.array(priors + [np.log(_WEIGHT_BOUNDS)] * len(active))
    start = np.log(np.concatenate(([kernel.amplitude, kernel.noise], kernel.weights[active])))
    minimum = minimise(evaluate, start, bounds[:, 0], bounds[:, 1], max_iterations=iterations)
    point, energy = _without_irrelevant(minimum, lambda point: evaluate(point)[0])
    parameters = np.exp(point)
    weights = np.zeros(problem.num_groups)
    weights[active] = np.where(point[2:] > _LOG_NO_WEIGHT, parameters[2:], 0.0)
    return Kernel(weights, float(parameters[0]), float(parameters[1]), energy)


def _on_device(problem: KernelProblem, columns: Ints, active: Ints) -> tuple[Data, jax.Array, int]:
    """The active columns and their groups, padded to few sizes, since a compilation takes as long as many searches."""
    full = padded_size(len(problem.groups), 4)
    size = MIN_BLOCK if len(columns) <= MIN_BLOCK < full else full
    num_rows = max(MIN_BLOCK, padded_size(len(problem.observations.means), 1))
    part = problem.observations.of_columns(columns)
    # Padded columns are zeros, so their group does not matter.
    groups = np.zeros(size, dtype=np.int64)
    groups[: len(columns)] = np.searchsorted(active, problem.groups[columns])
    return jax.tree.map(jnp.asarray, padded(part, size, num_rows)), jnp.asarray(groups), size


def _energy(point: jax.Array, groups: jax.Array, data: Data, epsilon: float) -> jax.Array:
    """E at the logarithms of amplitude, noise and weights."""
    amplitude, noise, weights = jnp.exp(point[0]), jnp.exp(point[1]), jnp.exp(point[2:])
    penalty = jnp.sum(jnp.log1p((1.0 + amplitude) * weights / epsilon))
    return (
        loss(amplitude, weights[groups], noise, data)
        + penalty
        + _log_normal(point[0], *AMPLITUDE)
        + _log_normal(point[1], *NOISE)
    )


_energy_and_gradient = jax.jit(jax.value_and_grad(_energy))


def _range_of(median: float, deviation: float) -> Floats:
    """[2] the smallest and the largest logarithm."""
    return np.log(median) + _MAX_DEVIATIONS * deviation * np.array([-1.0, 1.0])


def _log_normal(log_value: jax.Array, median: float, deviation: float) -> jax.Array:
    return 0.5 * ((log_value - np.log(median)) / deviation) ** 2


def _without_irrelevant(minimum: Minimum, energy: Callable[[Floats], float]) -> tuple[Floats, float]:
    """The point of a minimum without irrelevant weights, if these cost nothing, and its energy."""
    point = minimum.point.copy()
    point[2:][point[2:] < np.log(_IRRELEVANT_WEIGHT)] = _LOG_NO_WEIGHT
    value = energy(point)
    return (point, value) if value <= minimum.value + _MAX_FREE_LOSS else (minimum.point, minimum.value)
