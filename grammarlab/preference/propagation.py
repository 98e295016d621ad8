"""Expectation propagation: what was said of values that are jointly normal beforehand (Minka 2001).

Each thing that was said is replaced by a normal site, so that mean and variance of its value are right given all other
sites. Of one thing said the result is exact; of comparisons it is that of Chu and Ghahramani (2005) with better means.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from grammarlab.preference.base import Floats
from grammarlab.preference.likelihood import Intervals, matched

MOST_SWEEPS = 50
_STEP = 0.7
"""Part of the way to its new value that a site goes in a sweep: all go at once, so that they overshoot otherwise."""
_NEAR = 1e-4
"""Change of a mean, as a part of its deviation, at which sweeps end."""
_LEAST_PRECISION = 1e-8


class Sites(NamedTuple):
    """What normal observations would say the same."""

    precisions: Floats
    """[k] > 0, one over the variance of each."""
    shifts: Floats
    """[k] their means times their precisions."""
    mean: Floats
    """[k] of the values, given all that was said."""
    covariance: Floats
    """[k, k]"""

    @property
    def variances(self) -> Floats:
        """[k] of the normal observations."""
        return 1.0 / self.precisions

    @property
    def means(self) -> Floats:
        """[k] of the normal observations."""
        return self.shifts / self.precisions


def propagate(mean: Floats, covariance: Floats, said: Intervals, noise: float, blunders: float) -> Sites:
    """Sites for what was said of values.

    Args:
        mean: [k] of the values beforehand.
        covariance: [k, k] of the values beforehand.
        said: [k] what was said of each.
        noise: standard deviation of a look at a value, > 0.
        blunders: how often anything at all is said.
    """
    precisions, shifts = np.full(len(said), _LEAST_PRECISION), np.zeros(len(said))
    for _ in range(MOST_SWEEPS):
        known, spread = _given(mean, covariance, precisions, shifts)
        own = np.maximum(np.diagonal(spread), 1e-9)
        # Each value as all other sites have it.
        left = np.maximum(1.0 / own - precisions, _LEAST_PRECISION)
        others = (known / own - shifts) / left
        _, means, variances = matched(said, others, 1.0 / left, noise, blunders)
        new = np.maximum(1.0 / variances - left, _LEAST_PRECISION)
        precisions = precisions + _STEP * (new - precisions)
        shifts = shifts + _STEP * ((means * (left + new) - others * left) - shifts)
        if np.all(np.abs(means - known) <= _NEAR * np.sqrt(own)):
            break
    return Sites(precisions, shifts, *_given(mean, covariance, precisions, shifts))


def _given(mean: Floats, covariance: Floats, precisions: Floats, shifts: Floats) -> tuple[Floats, Floats]:
    """Mean and covariance of the values, given the sites."""
    roots = np.sqrt(precisions)
    inner = roots[:, None] * covariance * roots
    inner.flat[:: len(mean) + 1] += 1.0
    factor = cholesky(inner, lower=True, overwrite_a=True, check_finite=False)
    explained = solve_triangular(factor, roots[:, None] * covariance, lower=True, check_finite=False)
    spread = covariance - explained.T @ explained
    return mean + spread @ (shifts - precisions * mean), spread
