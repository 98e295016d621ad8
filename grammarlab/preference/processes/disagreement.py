"""Uncertainty of a grouped preference about many models, and the most informative models.

A fitted kernel is overconfident: the irrelevance of a group is known from a few models only. So columns have a least
weight when questions are chosen, so that models with new properties stay uncertain. The disagreement of the
explanations is added.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from grammarlab.arrays import ROUNDING, Floats, Ints
from grammarlab.preference.observations import Observations, observe
from grammarlab.preference.processes.grouped import Explanation, GroupedPreference
from grammarlab.preference.processes.grouped_search import NOISE
from grammarlab.preference.processes.posterior import Hyperparameters, blas_libraries, condition, squared_distances

CAUTION_DISTANCE = 0.4
"""Weighted squared distance between two typical models in columns that seem irrelevant."""
DOUBT_WEIGHT = 0.1
"""Least weight, per squared range, of a column that was the same in all liked models."""
_TRUST_PER_MODEL = 3.0
"""Decrease of that weight by liked models in which the column differs: to 1 / (1 + this x models)."""
TEMPERATURE = 10.0
"""Shares of explanations are raised to one over this, since worse explanations may be nearer the truth."""
_MIN_SHARE = 0.05
"""Smallest share of an explanation; those below it are left out."""


def joint(preference: GroupedPreference, rows: Floats, least: Floats) -> tuple[Floats, Floats]:
    """Mean [m] and covariance [m, m] of the scores of rows [m, F], all explanations taken together.

    Args:
        preference: the preference.
        rows: [m, F] models.
        least: [F] >= 0, the least weight of each column.
    """
    shares = np.array([explanation.share for explanation in preference.explanations]) ** (1.0 / TEMPERATURE)
    shares = np.where(shares >= _MIN_SHARE * shares.max(), shares, 0.0)
    shares /= shares.sum()
    covariance, means = np.zeros((len(rows), len(rows))), np.zeros((len(shares), len(rows)))
    with blas_libraries().limit(limits=1, user_api="blas"):
        for number in np.flatnonzero(shares):
            explanation = preference.explanations[number]
            means[number] = explanation.posterior.predict(rows).mean
            cautious = _cautious(preference, explanation, least)
            covariance += shares[number] * _covariance(cautious, preference.observations, rows)
    mean = shares @ means
    away = np.sqrt(shares)[:, None] * (means - mean)
    return mean, covariance + away.T @ away


def cautious_weights(preference: GroupedPreference, rows: Floats) -> Floats:
    """[F] least weights that make typical rows [m, F] slightly different for any difference."""
    total = 2.0 * float(np.sum(np.var(rows / preference.scales, axis=0)))
    return CAUTION_DISTANCE / (max(total, ROUNDING) * preference.scales**2)


def doubtful_weights(preference: GroupedPreference, liked: Floats) -> Floats:
    """[F] least weights for models that seem liked: high for columns that are equal in all liked models [n, F].

    A person may dislike a liked model after one part is exchanged. Only other liked models with that part show that it
    is irrelevant; disliked models with and without it do not.
    """
    others = np.array([len(column) - np.unique(column, return_counts=True)[1].max(initial=0) for column in liked.T])
    return DOUBT_WEIGHT / ((1.0 + _TRUST_PER_MODEL * others) * preference.scales**2)


def most_doubtful(covariance: Floats, num: int, noise: float, stakes: Floats, allowed: NDArray[np.bool_]) -> Ints:
    """Models of the largest variance times stakes, chosen one after the other, each given the scores of those before.

    Args:
        covariance: [m, m] covariance of the scores.
        num: number of models, at most the number of allowed ones.
        noise: variance of one score around the function, > 0.
        stakes: [m] >= 0, weight of the variance of each model; equal weights if all are zero.
        allowed: [m] whether a model may be chosen.

    Returns:
        [num] indices, best first.
    """
    return _greedy(covariance, num, noise, stakes, allowed, lambda posterior, counts: np.diagonal(posterior) * counts)


def most_telling(covariance: Floats, num: int, noise: float, stakes: Floats, allowed: NDArray[np.bool_]) -> Ints:
    """Models whose scores would lower the total variance most, chosen one after the other.

    Args:
        covariance: [m, m] covariance of the scores.
        num: number of models, at most the number of allowed ones.
        noise: variance of one score around the function, > 0.
        stakes: [m] >= 0, weight of the variance of each model; equal weights if all are zero.
        allowed: [m] whether a model may be chosen.

    Returns:
        [num] indices, best first.
    """
    return _greedy(
        covariance,
        num,
        noise,
        stakes,
        allowed,
        lambda posterior, counts: (posterior * posterior) @ counts / (np.diagonal(posterior) + noise),
    )


def _greedy(
    covariance: Floats,
    num: int,
    noise: float,
    stakes: Floats,
    allowed: NDArray[np.bool_],
    gain: Callable[[Floats, Floats], Floats],
) -> Ints:
    posterior, is_open = covariance.copy(), allowed.copy()
    counts = stakes if stakes.any() else np.ones(len(stakes))
    chosen = np.empty(num, dtype=np.int64)
    for index in range(num):
        best = chosen[index] = int(np.argmax(np.where(is_open, gain(posterior, counts), -1.0)))
        is_open[best] = False
        posterior -= np.outer(posterior[best], posterior[best] / (posterior[best, best] + noise))
    return chosen


def conditional_covariance(covariance: Floats, chosen: Ints, noise: float) -> Floats:
    """[m, m] covariance given the scores of some models."""
    if not len(chosen):
        return covariance
    inner = covariance[np.ix_(chosen, chosen)] + noise * np.eye(len(chosen))
    return covariance - covariance[:, chosen] @ np.linalg.solve(inner, covariance[chosen])


def unexplained(scored_rows: Floats, rows: Floats, weights: Floats, amplitude: float, noise: float) -> Floats:
    """[m, m] covariance of unknown additional effects: a process that has seen only scores of 0.

    Args:
        scored_rows: [n, F] rows with scores.
        rows: [m, F] other rows.
        weights: [F] >= 0, weights of the columns.
        amplitude: variance of the additional effects.
        noise: variance of a score.
    """
    hyperparameters = Hyperparameters(amplitude, weights, noise)
    return _covariance(hyperparameters, observe(scored_rows, np.zeros(len(scored_rows))), rows)


def _cautious(preference: GroupedPreference, explanation: Explanation, least: Floats) -> Hyperparameters:
    """The kernel of an explanation, with least weights and a least noise."""
    fitted = explanation.posterior.hyperparameters
    # Less would make the covariance of nearly equal models singular.
    noise = max(fitted.noise, NOISE[0] * preference.highest**2)
    return Hyperparameters(fitted.amplitude, np.maximum(fitted.weights, least), noise)


def _covariance(hyperparameters: Hyperparameters, observations: Observations, rows: Floats) -> Floats:
    """[m, m] covariance of rows [m, F], given observations."""
    posterior = condition(hyperparameters, observations)
    across = posterior.covariance_with_observed(rows)
    explained = solve_triangular(posterior.factor, across.T, lower=True, overwrite_b=True, check_finite=False)
    scaled = rows * np.sqrt(hyperparameters.weights)
    return hyperparameters.amplitude * np.exp(-0.5 * squared_distances(scaled, scaled)) - explained.T @ explained
