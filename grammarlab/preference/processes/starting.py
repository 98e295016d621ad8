"""Start of searches for a kernel: the best relevance that all columns can share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve, cholesky

from grammarlab.preference.base import MAX_SCORE, Floats
from grammarlab.preference.observations import Observations
from grammarlab.preference.processes.posterior import squared_distances

_RELEVANCES = np.exp(np.linspace(-4.0, 4.0, 9))
"""Candidate relevances, as multiples of one over the mean squared distance of two rows."""


@dataclass(frozen=True, slots=True)
class StartingKernel:
    """A kernel with equal relevance of all columns."""

    amplitude: float
    """theta_0 in squared scores."""
    weights: Floats
    """[F] the same for all columns once each is scaled to the range 0-1; 0 for columns that do not vary, about which
    the labels say nothing."""


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
