"""Predictive distribution of scores: probabilities with noise, blunders and the ends of the scale.

A value v becomes the score y with probability p(y | v) of `grammarlab.preference.person`. The unknown v is
integrated out: in cells by their posterior, in a process by its normal distribution. So 0 and 100 have the mass
beyond them, and a person without errors has intervals of one score.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from grammarlab.arrays import Floats
from grammarlab.preference.base import MAX_SCORE, SCORE_STEP, AbstractPreference, Rows
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.factors import ProductPreference
from grammarlab.preference.person import NOISES, log_likelihood

SCORES = np.arange(0.0, MAX_SCORE + SCORE_STEP, SCORE_STEP)
"""[S] distinguished scores; each includes the scores that round to it."""
_EDGES = SCORES[:-1] + SCORE_STEP / 2.0
_ROUNDING = 1e-9
"""Tolerance of sums of probabilities, and smallest deviation in points."""


@dataclass(frozen=True, slots=True)
class FreshScores:
    """Distributions of scores of models."""

    probabilities: Floats
    """[m, S] probabilities of `SCORES`; rows sum to 1."""

    def quantile(self, part: float) -> Floats:
        """[m] quantile: the lowest score that is not exceeded with probability ``part`` or more, 0 to 1."""
        return SCORES[np.argmax(self.probabilities.cumsum(axis=1) >= part - _ROUNDING, axis=1)]

    def interval(self, level: float = 0.9) -> tuple[Floats, Floats]:
        """Ends [m] and [m] of the shortest range that contains a score with probability ``level`` or more.

        A range extends half a point beyond its scores, within 0 to 100, because of rounding.
        """
        below = np.concatenate([np.zeros((len(self.probabilities), 1)), self.probabilities.cumsum(axis=1)], axis=1)
        first, last = np.zeros((2, len(below)), dtype=np.int64)
        open_ = np.arange(len(below))
        for width in range(len(SCORES)):
            mass = below[open_, width + 1 :] - below[open_, : len(SCORES) - width]
            best = mass.argmax(axis=1)
            enough = mass[np.arange(len(open_)), best] >= level - _ROUNDING
            first[open_[enough]], last[open_[enough]] = best[enough], best[enough] + width
            open_ = open_[~enough]
        low, high = SCORES[first] - SCORE_STEP / 2.0, SCORES[last] + SCORE_STEP / 2.0
        return np.maximum(low, 0.0), np.minimum(high, MAX_SCORE)


def fresh_scores(preference: AbstractPreference, rows: Rows) -> FreshScores:
    """Distributions of scores of models by the person whose labels a preference was fitted on.

    Args:
        preference: any preference; a normal distribution is used if it has only means and deviations.
        rows: [m, F] the columns that the preference was fitted on.
    """
    if isinstance(preference, ProductPreference) and len(preference.factors) == 1:
        return fresh_scores(next(iter(preference.factors.values())), rows)
    if isinstance(preference, PartitionPreference):
        return FreshScores(_of_cells(preference, rows))
    if isinstance(preference, BlendedPreference):
        cells, process = _of_cells(preference.partition, rows), _of_process(preference, rows)
        return FreshScores(preference.share * process + (1.0 - preference.share) * cells)
    prediction = preference.predict(rows)
    return FreshScores(_normal(prediction.mean, prediction.std))


def _of_cells(preference: PartitionPreference, rows: Rows) -> Floats:
    likelihood = sum(
        share * np.exp(log_likelihood(SCORES, preference.cells.grid, noise, preference.blunders).T)
        for share, noise in zip(preference.noises.tolist(), NOISES, strict=True)
    )
    joint = preference.values(rows) @ likelihood
    return joint / joint.sum(axis=1, keepdims=True)


def _of_process(preference: BlendedPreference, rows: Rows) -> Floats:
    prediction = preference.predict_values(rows)
    probabilities = _normal(prediction.mean, prediction.std)
    length = np.where((SCORES == 0.0) | (SCORES == MAX_SCORE), SCORE_STEP / 2.0, SCORE_STEP)
    return (1.0 - preference.blunders) * probabilities + preference.blunders * length / MAX_SCORE


def _normal(mean: Floats, deviation: Floats) -> Floats:
    """[m, S] normal distributions, with the mass beyond the ends at the ends."""
    below = ndtr((_EDGES - mean[:, None]) / np.maximum(deviation, _ROUNDING)[:, None])
    return np.diff(below, axis=1, prepend=0.0, append=1.0)
