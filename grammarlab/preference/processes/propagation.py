"""Expectation propagation: labels of values with a joint normal prior (Minka 2001).

Each label is replaced by a normal site, so that mean and variance of its value are right given all other sites. For a
single label the result is exact; for comparisons it is that of Chu and Ghahramani (2005) with better means.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from grammarlab.preference.base import Floats
from grammarlab.preference.likelihood import Intervals, matched

MOST_SWEEPS = 50
_STEP = 0.7
"""Step of a site towards its new value in a sweep; all sites move at once, so full steps would overshoot."""
_NEAR = 1e-4
"""Change of a mean, as a share of its deviation, below which sweeps end."""
_LEAST_PRECISION = 1e-8


class Sites(NamedTuple):
    """Normal observations equivalent to the labels."""

    precisions: Floats
    """[k] > 0, one over the variance of each."""
    shifts: Floats
    """[k] means times precisions."""
    mean: Floats
    """[k] posterior means of the values."""
    covariance: Floats
    """[k, k] posterior covariance."""

    @property
    def variances(self) -> Floats:
        """[k] variances of the normal observations."""
        return 1.0 / self.precisions

    @property
    def means(self) -> Floats:
        """[k] means of the normal observations."""
        return self.shifts / self.precisions

    def without(self) -> tuple[Floats, Floats]:
        """Mean [k] and variance [k] of each value, given all other labels."""
        own = np.maximum(np.diagonal(self.covariance), 1e-9)
        left = np.maximum(1.0 / own - self.precisions, _LEAST_PRECISION)
        return (self.mean / own - self.shifts) / left, 1.0 / left


def propagate(mean: Floats, covariance: Floats, said: Intervals, noise: float, blunders: float) -> Sites:
    """Sites for labels of values.

    Args:
        mean: [k] prior means of the values.
        covariance: [k, k] prior covariance of the values.
        said: [k] interval of each label.
        noise: standard deviation of the noise of a value, > 0.
        blunders: probability of a blunder.
    """
    sites = _sites(mean, covariance, np.full(len(said), _LEAST_PRECISION), np.zeros(len(said)))
    for _ in range(MOST_SWEEPS):
        others, left = sites.without()
        _, means, variances = matched(said, others, left, noise, blunders)
        new = np.maximum(1.0 / variances - 1.0 / left, _LEAST_PRECISION)
        shifts = means * (1.0 / left + new) - others / left
        rested = np.all(np.abs(means - sites.mean) <= _NEAR * np.sqrt(left))
        sites = _sites(
            mean,
            covariance,
            sites.precisions + _STEP * (new - sites.precisions),
            sites.shifts + _STEP * (shifts - sites.shifts),
        )
        if rested:
            break
    return sites


def _sites(mean: Floats, covariance: Floats, precisions: Floats, shifts: Floats) -> Sites:
    """Sites, with mean and covariance of the values given them."""
    roots = np.sqrt(precisions)
    inner = roots[:, None] * covariance * roots
    inner.flat[:: len(mean) + 1] += 1.0
    factor = cholesky(inner, lower=True, overwrite_a=True, check_finite=False)
    explained = solve_triangular(factor, roots[:, None] * covariance, lower=True, check_finite=False)
    spread = covariance - explained.T @ explained
    return Sites(precisions, shifts, mean + spread @ (shifts - precisions * mean), spread)
