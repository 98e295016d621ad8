"""How unsure a grouped preference is about many models at once, and which of them would tell most.

A kernel that has been found is surer of itself than it should be: that a group is irrelevant has been seen in a few
models only. For choosing questions every column therefore counts at least a little (`CAUTION`), so that models with
something new stay uncertain. On top comes what the explanations disagree about.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from threadpoolctl import threadpool_limits

from grammarlab.preference.base import Floats, Ints
from grammarlab.preference.grouped import Explanation, GroupedPreference
from grammarlab.preference.posterior import Hyperparameters, condition, squared_distances

CAUTION = 0.4
"""Weighted squared distance, by columns that are thought irrelevant, between two typical models."""
TEMPERATURE = 10.0
"""Shares of explanations are raised to one over this: what explains far worse may still be nearer the truth."""
_LEAST_SHARE = 0.05
_LEAST_NOISE = 1e-4
"""As a share of the squared highest score: keeps the covariance of nearly equal models regular."""


def joint(preference: GroupedPreference, rows: Floats) -> tuple[Floats, Floats]:
    """Mean [m] and covariance [m, m] of the scores of rows [m, F], explanations and caution taken together."""
    shares = np.array([explanation.share for explanation in preference.explanations]) ** (1.0 / TEMPERATURE)
    shares = np.where(shares >= _LEAST_SHARE * shares.max(), shares, 0.0)
    shares /= shares.sum()
    least = _cautious_weights(preference, rows)
    covariance, means = np.zeros((len(rows), len(rows))), np.zeros((len(shares), len(rows)))
    with threadpool_limits(1, "blas"):
        for number in np.flatnonzero(shares):
            explanation = preference.explanations[number]
            means[number] = explanation.posterior.predict(rows).mean
            covariance += shares[number] * _covariance(preference, explanation, least, rows)
    mean = shares @ means
    away = np.sqrt(shares)[:, None] * (means - mean)
    return mean, covariance + away.T @ away


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
    left, open_ = covariance.copy(), allowed.copy()
    counts = stakes if stakes.any() else np.ones(len(stakes))
    chosen = np.empty(num, dtype=np.int64)
    for place in range(num):
        variance = np.diagonal(left) + noise
        gain = np.where(open_, (left * left) @ counts / variance, -1.0)
        best = chosen[place] = int(np.argmax(gain))
        open_[best] = False
        left -= np.outer(left[best], left[best] / variance[best])
    return chosen


def given(covariance: Floats, chosen: Ints, noise: float) -> Floats:
    """[m, m] the covariance once the scores of some models are known."""
    if not len(chosen):
        return covariance
    inner = covariance[np.ix_(chosen, chosen)] + noise * np.eye(len(chosen))
    return covariance - covariance[:, chosen] @ np.linalg.solve(inner, covariance[chosen])


def _cautious_weights(preference: GroupedPreference, rows: Floats) -> Floats:
    """[F] the least weight of each column."""
    total = 2.0 * float(np.sum(np.var(rows / preference.scales, axis=0)))
    return CAUTION / (max(total, 1e-12) * preference.scales**2)


def _covariance(preference: GroupedPreference, explanation: Explanation, least: Floats, rows: Floats) -> Floats:
    found = explanation.posterior.hyperparameters
    noise = max(found.noise, _LEAST_NOISE * preference.highest**2)
    cautious = Hyperparameters(found.amplitude, np.maximum(found.weights, least), noise)
    posterior = condition(cautious, preference.observations)
    across = posterior.covariance_with_observed(rows)
    explained = solve_triangular(posterior.factor, across.T, lower=True, overwrite_b=True, check_finite=False)
    scaled = rows * np.sqrt(cautious.weights)
    return cautious.amplitude * np.exp(-0.5 * squared_distances(scaled, scaled)) - explained.T @ explained
