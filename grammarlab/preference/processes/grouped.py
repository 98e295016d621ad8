"""Preference by groups: Gaussian processes with a weight for each group of columns, averaged by their evidence.

Columns of one group are alternatives of one choice, so they matter together or not at all: one weight per group is
much less to learn than one per column. Few labels allow several explanations, which the search (`grouped_search`)
finds from different starts. Predictions average over them in proportion to exp(-E); if they disagree, the prediction
is uncertain. A column that has not varied yet has its group's weight: a model with a new alternative differs from all
others if the choice matters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import jax
import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.arrays import FEW, ROUNDING, Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.preference.base import (
    MANY_LABELS,
    MAX_SCORE,
    MIN_SHARE,
    AbstractPreference,
    Prediction,
    Relevance,
    Rows,
    rows_to_predict,
)
from grammarlab.preference.factors import relevances
from grammarlab.preference.observations import Observations, checked_groups, checked_kinds, observe, thinned
from grammarlab.preference.processes.grouped_search import (
    AMPLITUDE,
    NOISE,
    Kernel,
    KernelProblem,
    hyperparameters,
    problem_of,
    scales_of,
    search,
    starting_kernels,
)
from grammarlab.preference.processes.posterior import MAX_ROWS, Posterior, condition

NUM_RANDOM_STARTS = 2
"""Number of random starts of the search for kernels."""


@dataclass(frozen=True, slots=True)
class Explanation:
    """One kernel, and its posterior."""

    kernel: Kernel
    posterior: Posterior
    share: float
    """Weight of the kernel in the average; all shares sum to 1."""


@dataclass(frozen=True)
class GroupedPreference(AbstractPreference):
    """Result of `fit` with `method="grouped"`."""

    num_columns: int
    groups: Ints
    """[F] group number of each column."""
    observations: Observations
    """The labels used for predictions."""
    scales: Floats
    """[F] > 0, the range of each column among the labels, 1 for constant columns."""
    highest: float
    """The highest score, > 0; `MAX_SCORE` if all are nearly zero."""
    explanations: tuple[Explanation, ...]
    """At least one, all different, best first."""

    def predict(self, rows: Rows) -> Prediction:
        table = rows_to_predict(rows, self.num_columns)
        counting = [explanation for explanation in self.explanations if explanation.share >= MIN_SHARE]
        parts = [explanation.posterior.predict(table) for explanation in counting]
        shares = np.array([explanation.share for explanation in counting])
        shares /= shares.sum()
        means = np.stack([part.mean for part in parts])
        mean = shares @ means
        variance = shares @ (np.stack([part.std for part in parts]) ** 2 + (means - mean) ** 2)
        return Prediction(mean, np.sqrt(variance))

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        return relevances(self.observations.all_rows, self.column_weights(), self.groups, group_names)

    def conditioned_on(self, observations: Observations) -> GroupedPreference:
        """Preference of the same kernels and shares, with the posterior of other observations."""
        explanations = tuple(
            replace(explanation, posterior=condition(explanation.posterior.hyperparameters, observations))
            for explanation in self.explanations
        )
        return replace(self, observations=observations, explanations=explanations)

    @property
    def noise_variance(self) -> float:
        """Variance of a score around the function, by the best explanation, in squared points."""
        return self.explanations[0].posterior.hyperparameters.noise

    @property
    def prior_variance(self) -> float:
        """Variance of the function before any label, by the best explanation, in squared points."""
        return self.explanations[0].posterior.hyperparameters.amplitude

    def column_weights(self) -> Floats:
        """[F] the weight of each column, averaged over the explanations."""
        weights = np.stack([explanation.posterior.hyperparameters.weights for explanation in self.explanations])
        return np.array([explanation.share for explanation in self.explanations]) @ weights


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    groups: ArrayLike | None = None,
    continuous: ArrayLike | None = None,
    seed: int = 0,
    warm: AbstractPreference | None = None,
    starts: int | None = None,
) -> GroupedPreference:
    """A preference with weights of groups of columns, averaged over the explanations of the labels.

    If all scores are zero, they contain no information about relevance: all groups that vary then have a small weight.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100.
        groups: [F] group numbers; by default every column is its own group.
        continuous: [F] whether columns are continuous instead of counts; by default none is.
        seed: seed of the random starts, and of the selection of rows if there are more than `MANY_LABELS`.
        warm: a preference found by this method on the same columns; its explanations are further starts.
        starts: largest number of starts, for a fast approximation.

    Raises:
        UsageError: If labels or groups are out of range, or `warm` has other columns.
    """
    return fit_observed(
        observe(rows, scores), groups=groups, continuous=continuous, seed=seed, warm=warm, starts=starts
    )


def fit_observed(
    labels: Observations,
    *,
    groups: ArrayLike | None = None,
    continuous: ArrayLike | None = None,
    seed: int = 0,
    warm: AbstractPreference | None = None,
    starts: int | None = None,
) -> GroupedPreference:
    """`fit` from observations, which may include differences of two rows."""
    observations = thinned(labels, MAX_ROWS, seed)
    num_columns = observations.rows.shape[1]
    numbers = checked_groups(groups, num_columns)
    scales = scales_of(observations.all_rows)
    differences = observations.differences
    plain = observations.means if differences is None else observations.means[differences.variances == 0.0]
    highest = float(np.max(plain, initial=0.0))
    highest = highest if highest > ROUNDING else MAX_SCORE
    problem = problem_of(thinned(observations, MANY_LABELS, seed), numbers, scales, highest)
    drawn = np.zeros(problem.num_groups)
    drawn[numbers[checked_kinds(continuous, num_columns)]] = 1.0
    kernels = _warm_starts(warm, num_columns, numbers) + starting_kernels(problem, seed, NUM_RANDOM_STARTS, drawn)
    with jax.enable_x64(True), threadpool_limits(1, "blas"):
        kernels = _best(problem, kernels[:starts]) if np.any(observations.means != 0.0) else [_indifferent(problem)]
    shares = np.exp(kernels[0].energy - np.array([kernel.energy for kernel in kernels]))
    shares /= shares.sum()
    explanations = tuple(
        Explanation(kernel, condition(hyperparameters(kernel, numbers, scales, highest), observations), float(share))
        for kernel, share in zip(kernels, shares, strict=True)
    )
    return GroupedPreference(num_columns, numbers, observations, scales, highest, explanations)


def _warm_starts(warm: AbstractPreference | None, num_columns: int, groups: Ints) -> list[Kernel]:
    if warm is None:
        return []
    if not isinstance(warm, GroupedPreference) or not np.array_equal(warm.groups, groups):
        raise UsageError(
            f'warm: expected a preference that method="grouped" found on the same {num_columns} columns and groups, '
            f"found {type(warm).__name__} on {warm.num_columns}. Leave it out when the columns have changed."
        )
    return [explanation.kernel for explanation in warm.explanations[:FEW]]


def _best(problem: KernelProblem, starts: list[Kernel]) -> list[Kernel]:
    """Results of the searches, without duplicates, best first."""
    ends = sorted((search(problem, start) for start in starts), key=lambda kernel: kernel.energy)
    different: list[Kernel] = []
    for end in ends:
        if not any(_alike(end, other) for other in different):
            different.append(end)
    return different


def _alike(first: Kernel, second: Kernel) -> bool:
    """Whether two searches have the same result."""
    return abs(first.energy - second.energy) < 0.1 and bool(np.allclose(first.weights, second.weights, atol=0.05))


def _indifferent(problem: KernelProblem) -> Kernel:
    """A kernel with equal weights of all groups that vary, under which two typical models are almost uncorrelated."""
    rows = problem.observations.all_rows
    spread = 2.0 * float(np.sum(np.var(rows, axis=0)))
    return Kernel(problem.varying / max(spread, 1.0), AMPLITUDE[0], NOISE[0], 0.0)
