"""Likelihood of scores, given the sums of points that designs have, with its slopes.

A sum u means the value v = E[min(max(u + e, 0), 100)], with e a normal number of a small standard deviation: nearly u
clipped to 0-100, but with a slope near the ends as well, so that sums beyond an end are found step by step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from grammarlab.arrays import Floats
from grammarlab.preference.base import MAX_SCORE, SCORE_STEP
from grammarlab.preference.person import Person, intervals_of, log_likelihood


class Slopes(NamedTuple):
    """Log-likelihood of n scores, and how it changes with their sums."""

    log_likelihood: float
    first: Floats
    """[n] first derivative by the sum, per point."""
    curvature: Floats
    """[n] >= 0, expected size of the second derivative, per squared point."""


@dataclass(frozen=True, eq=False)
class LineScores:
    """n scores of a person with known errors."""

    scores: Floats
    """[n] 0-100."""
    person: Person
    """The errors of the person."""

    @cached_property
    def _table(self) -> Floats:
        """[n, 101] log-likelihood of each score for each value in points."""
        return log_likelihood(self.scores, np.arange(MAX_SCORE + 1.0), *self.person).astype(np.float64)

    @cached_property
    def _reliable(self) -> Floats:
        """[n, 101] probability that a score is no blunder, for each value."""
        by_chance = self.person.blunders * intervals_of(self.scores).length / MAX_SCORE
        return np.clip(1.0 - by_chance[:, None] * np.exp(-self._table), 0.0, 1.0)

    def slopes(self, sums: Floats, deviation: float, least: float = 0.0) -> Slopes:
        """The likelihood and its slopes.

        Args:
            sums: [n] sums of points.
            deviation: standard deviation of the normal numbers that are added.
            least: smallest slope of a value by its sum, which is 0 far beyond an end.
        """
        values, slope = clipped(sums, np.full(len(sums), deviation))
        slope = np.maximum(slope, least)
        index = np.minimum(values.astype(np.int64), int(MAX_SCORE) - 1)
        every, part = np.arange(len(sums)), values - index
        low, high = self._table[every, index], self._table[every, index + 1]
        variance = max(self.person.noise, SCORE_STEP) ** 2
        # Slopes of a table near a bend exceed those of any score.
        first = np.clip(high - low, -MAX_SCORE / variance, MAX_SCORE / variance)
        likelihood = float((low + part * (high - low)).sum())
        return Slopes(likelihood, slope * first, slope**2 * self._reliable[every, index] / variance)


def clipped(means: Floats, deviations: Floats) -> tuple[Floats, Floats]:
    """Mean [m] of normal numbers clipped to 0-100, and its slope by their mean.

    Args:
        means: [m] means.
        deviations: [m] > 0, standard deviations.

    >>> means, slopes = clipped(np.array([-50.0, 0.0, 50.0]), np.ones(3))
    >>> means.round(2).tolist(), slopes.round(2).tolist()
    ([0.0, 0.4, 50.0], [0.0, 0.5, 1.0])
    """
    low, high = means / deviations, (MAX_SCORE - means) / deviations
    above_0 = means * ndtr(low) + deviations * _density(low)
    above_100 = (means - MAX_SCORE) * ndtr(-high) + deviations * _density(high)
    inside = ndtr(high) - ndtr(-low)
    return np.clip(above_0 - above_100, 0.0, MAX_SCORE), np.maximum(inside, 0.0)


def _density(deviations: Floats) -> Floats:
    return np.exp(-0.5 * np.minimum(deviations**2, 1400.0)) / np.sqrt(2.0 * np.pi)
