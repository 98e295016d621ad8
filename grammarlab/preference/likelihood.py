"""What a score says about the value that somebody had in mind.

A score y stands for the interval [y - h, y + h] of its scale, open at 0 and 100: who would give less than nothing says
0. The person misses the value v by normal noise of standard deviation sigma, and now and then, with probability pi,
gives any score at all:

    p(y | v) = (1 - pi) [Phi((y + h - v) / sigma) - Phi((y - h - v) / sigma)] + pi (length of the interval) / 100
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from grammarlab.preference.base import MAX_SCORE, Floats

HALF_STEP = 0.5
"""h, in points."""
_LEAST = 1e-12
"""No score is impossible, whatever the noise."""

Singles = NDArray[np.float32]


def log_likelihood(scores: Floats, values: Floats, noise: float, blunders: float) -> Singles:
    """[n, G] log p(y | v) of scores [n] for values [G], both 0 to 100.

    Args:
        scores: what was said.
        values: what may have been meant.
        noise: sigma > 0, in points.
        blunders: pi, 0 to 1.

    >>> np.exp(log_likelihood(np.array([0.0, 50.0]), np.array([0.0, 50.0]), 0.1, 0.0)).round(3).tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    at_bottom, at_top = scores <= HALF_STEP / 2.0, scores >= MAX_SCORE - HALF_STEP / 2.0
    low = np.where(at_bottom, -np.inf, scores - HALF_STEP)[:, None]
    high = np.where(at_top, np.inf, scores + HALF_STEP)[:, None]
    meant = ndtr((high - values) / noise) - ndtr((low - values) / noise)
    length = np.where(at_bottom | at_top, HALF_STEP, 2.0 * HALF_STEP)[:, None]
    return np.log((1.0 - blunders) * meant + blunders * length / MAX_SCORE + _LEAST).astype(np.float32)


def expected_score(values: Floats, noise: float, blunders: float) -> Floats:
    """[m] the mean of the scores that are given to values [m]: more than the value near 0, less near 100.

    >>> expected_score(np.array([0.0, 50.0]), 10.0, 0.0).round(2).tolist()
    [3.99, 50.0]
    """
    low, high = values / noise, (MAX_SCORE - values) / noise
    # E max(0, v + e) is v Phi(v / sigma) + sigma phi(v / sigma); what lies above 100 is cut off likewise.
    above_0 = values * ndtr(low) + noise * _density(low)
    above_100 = (values - MAX_SCORE) * ndtr(-high) + noise * _density(high)
    return (1.0 - blunders) * (above_0 - above_100) + blunders * MAX_SCORE / 2.0


def value_of(scores: Floats, noise: float, blunders: float) -> Floats:
    """[m] the values whose mean scores are given: the inverse of `expected_score`, within 0 to 100."""
    values = np.linspace(0.0, MAX_SCORE, 401)
    return np.interp(scores, expected_score(values, noise, blunders), values)


def _density(deviations: Floats) -> Floats:
    return np.exp(-0.5 * deviations**2) / np.sqrt(2.0 * np.pi)
