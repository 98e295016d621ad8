"""How unsure a grouped preference is about many models at once, and which of them would tell most.

A kernel that has been found is surer of itself than it should be: that a group is irrelevant has been seen in a few
models only. For choosing questions columns therefore have a least weight, so that models with something new stay
uncertain. On top comes what the explanations disagree about.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from threadpoolctl import threadpool_limits

from grammarlab.preference.base import Floats, Ints
from grammarlab.preference.observations import Observations, observe
from grammarlab.preference.processes.grouped import Explanation, GroupedPreference
from grammarlab.preference.processes.posterior import Hyperparameters, condition, squared_distances

CAUTION = 0.4
"""Weighted squared distance, by columns that are thought irrelevant, between two typical models."""
DOUBT = 0.1
"""Least weight, per squared range, of a column that was the same in all liked models."""
_TRUST = 3.0
"""How much each liked model in which the column was another lowers that weight: to 1 / (1 + this x models)."""
TEMPERATURE = 10.0
"""Shares of explanations are raised to one over this: what explains far worse may still be nearer the truth."""
_LEAST_SHARE = 0.05
_LEAST_NOISE = 1e-4
"""As a share of the squared highest score: keeps the covariance of nearly equal models regular."""


def joint(preference: GroupedPreference, rows: Floats, least: Floats) -> tuple[Floats, Floats]:
    """Mean [m] and covariance [m, m] of the scores of rows [m, F], all explanations taken together.

    Args:
        preference: what is learned.
        rows: [m, F] models.
        least: [F] >= 0, the least weight of each column.
    """
    shares = np.array([explanation.share for explanation in preference.explanations]) ** (1.0 / TEMPERATURE)
    shares = np.where(shares >= _LEAST_SHARE * shares.max(), shares, 0.0)
    shares /= shares.sum()
    covariance, means = np.zeros((len(rows), len(rows))), np.zeros((len(shares), len(rows)))
    with threadpool_limits(1, "blas"):
        for number in np.flatnonzero(shares):
            explanation = preference.explanations[number]
            means[number] = explanation.posterior.predict(rows).mean
            cautious = _cautious(preference, explanation, least)
            covariance += shares[number] * _covariance(cautious, preference.observations, rows)
    mean = shares @ means
    away = np.sqrt(shares)[:, None] * (means - mean)
    return mean, covariance + away.T @ away


def cautious_weights(preference: GroupedPreference, rows: Floats) -> Floats:
    """[F] least weights that make typical rows [m, F] a little unlike, whatever they differ in."""
    total = 2.0 * float(np.sum(np.var(rows / preference.scales, axis=0)))
    return CAUTION / (max(total, 1e-12) * preference.scales**2)


def doubtful_weights(preference: GroupedPreference, liked: Floats) -> Floats:
    """[F] least weights for models that seem liked: high where the liked models [n, F] have all been the same.

    Someone who likes a thing may well dislike it with one part exchanged. That such a part does not matter is known
    from other liked models that have it, and not from models that are disliked with and without it.
    """
    others = np.array([len(column) - np.unique(column, return_counts=True)[1].max(initial=0) for column in liked.T])
    return DOUBT / ((1.0 + _TRUST * others) * preference.scales**2)


def most_doubtful(covariance: Floats, num: int, noise: float, stakes: Floats, allowed: NDArray[np.bool_]) -> Ints:
    """Models of the largest variance times stakes, chosen one after the other, each given the scores of those before.

    Args:
        covariance: [m, m] of the scores.
        num: how many to choose, at most as many as are allowed.
        noise: variance of one score around the function, > 0.
        stakes: [m] >= 0, how much the variance of each model counts; all alike where all are zero.
        allowed: [m] whether a model may be chosen.

    Returns:
        [num] indices, best first.
    """
    return _greedy(covariance, num, noise, stakes, allowed, lambda left, counts: np.diagonal(left) * counts)


def most_telling(covariance: Floats, num: int, noise: float, stakes: Floats, allowed: NDArray[np.bool_]) -> Ints:
    """Models whose scores would lower the total variance most, chosen one after the other.

    Args:
        covariance: [m, m] of the scores.
        num: how many to choose, at most as many as are allowed.
        noise: variance of one score around the function, > 0.
        stakes: [m] >= 0, how much the variance of each model counts; all alike where all are zero.
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
        lambda left, counts: (left * left) @ counts / (np.diagonal(left) + noise),
    )


def _greedy(
    covariance: Floats,
    num: int,
    noise: float,
    stakes: Floats,
    allowed: NDArray[np.bool_],
    gain: Callable[[Floats, Floats], Floats],
) -> Ints:
    left, open_ = covariance.copy(), allowed.copy()
    counts = stakes if stakes.any() else np.ones(len(stakes))
    chosen = np.empty(num, dtype=np.int64)
    for place in range(num):
        best = chosen[place] = int(np.argmax(np.where(open_, gain(left, counts), -1.0)))
        open_[best] = False
        left -= np.outer(left[best], left[best] / (left[best, best] + noise))
    return chosen


def given(covariance: Floats, chosen: Ints, noise: float) -> Floats:
    """[m, m] the covariance once the scores of some models are known."""
    if not len(chosen):
        return covariance
    inner = covariance[np.ix_(chosen, chosen)] + noise * np.eye(len(chosen))
    return covariance - covariance[:, chosen] @ np.linalg.solve(inner, covariance[chosen])


def unexplained(known: Floats, rows: Floats, weights: Floats, amplitude: float, noise: float) -> Floats:
    """[m, m] covariance of what may be found beside all that is known: a process that has seen nothing but 0.

    Args:
        known: [n, F] rows with scores.
        rows: [m, F] others.
        weights: [F] >= 0 of the columns.
        amplitude: variance of what may be found.
        noise: variance of a score.
    """
    hyperparameters = Hyperparameters(amplitude, weights, noise)
    return _covariance(hyperparameters, observe(known, np.zeros(len(known))), rows)


def _cautious(preference: GroupedPreference, explanation: Explanation, least: Floats) -> Hyperparameters:
    """The kernel of an explanation, with least weights and a least noise."""
    found = explanation.posterior.hyperparameters
    noise = max(found.noise, _LEAST_NOISE * preference.highest**2)
    return Hyperparameters(found.amplitude, np.maximum(found.weights, least), noise)


def _covariance(hyperparameters: Hyperparameters, observations: Observations, rows: Floats) -> Floats:
    """[m, m] of rows [m, F], given observations."""
    posterior = condition(hyperparameters, observations)
    across = posterior.covariance_with_observed(rows)
    explained = solve_triangular(posterior.factor, across.T, lower=True, overwrite_b=True, check_finite=False)
    scaled = rows * np.sqrt(hyperparameters.weights)
    return hyperparameters.amplitude * np.exp(-0.5 * squared_distances(scaled, scaled)) - explained.T @ explained
