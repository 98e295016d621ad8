"""Points of chosen columns: the most likely ones, how certain they are, and the evidence of the choice.

Points per standard deviation of a column are normal numbers before any score, and nearly so afterwards (Laplace's
approximation around the most likely ones): the evidence of a choice of columns is the likelihood there, times the share
of the prior that agrees with the scores.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.lines.line_scores import LineScores
from grammarlab.preference.lines.newton import Height, climbed

POINTS = 15.0
"""Standard deviation of the points per standard deviation of a column, before any score."""
SOFTNESS = 0.2
"""Standard deviation of the normal numbers that are added to sums, in points."""
WIDE = 20.0
"""The same at the beginning of a search, which then has slopes everywhere."""
LEAST_SLOPE = 0.15
"""Smallest slope of a value by its sum, for how certain points are: scores of sums beyond an end bind these from one
side."""


@dataclass(frozen=True, eq=False)
class FittedLine:
    """Points of some columns."""

    terms: tuple[int, ...]
    """The columns."""
    points: Floats
    """[k + 1] points of the mean design, then of each column per standard deviation."""
    precision: Floats
    """[k + 1, k + 1] inverse covariance of the points."""
    log_evidence: float
    """Log-evidence of the scores, in nats."""
    scores: LineScores
    """The scores, with the errors of the person."""

    def sums(self, table: Floats) -> tuple[Floats, Floats]:
        """Means and variances [m] of the sums of designs with columns [m, F]."""
        design = with_ones(table[:, list(self.terms)])
        # The inverse of the factor is small, and quicker than a solution for each design.
        away = design @ np.linalg.inv(np.linalg.cholesky(self.precision)).T
        return design @ self.points, np.einsum("mk,mk->m", away, away)


def fitted(
    table: Floats, terms: tuple[int, ...], scores: LineScores, start: Floats, *, wide: bool = False
) -> FittedLine:
    """The most likely points of some columns.

    Args:
        table: [n, F] columns of mean 0 and variance 1.
        terms: the columns.
        scores: the n scores.
        start: [k + 1] points that the search starts with.
        wide: whether to start with slopes everywhere, for points that are not near the best ones yet.
    """
    design, points = with_ones(table[:, list(terms)]), start
    prior, middle = prior_precision(len(terms)), np.zeros(len(terms) + 1)
    # Points of the mean design are normal around the middle, with a standard deviation as large as that.
    middle[0] = MAX_SCORE / 2.0
    for softness in (WIDE, SOFTNESS) if wide else (SOFTNESS,):
        points = climbed(partial(_height, design, scores, prior, middle, softness), points)
    slopes = scores.slopes(design @ points, SOFTNESS, LEAST_SLOPE)
    precision = (design.T * slopes.curvature) @ design + np.diag(prior)
    evidence = slopes.log_likelihood - 0.5 * prior @ (points - middle) ** 2
    evidence += 0.5 * (np.log(prior).sum() - np.linalg.slogdet(precision)[1])
    return FittedLine(terms, points, precision, float(evidence), scores)


def _height(
    design: Floats, scores: LineScores, prior: Floats, middle: Floats, softness: float, points: Floats
) -> Height:
    """Log-posterior of points."""
    slopes, away = scores.slopes(design @ points, softness), points - middle
    return Height(
        slopes.log_likelihood - 0.5 * float(prior @ away**2),
        design.T @ slopes.first - prior * away,
        (design.T * slopes.curvature) @ design + np.diag(prior),
    )


def prior_precision(num_terms: int) -> Floats:
    """[k + 1] inverse variance of the points before any score."""
    return np.append((2.0 / MAX_SCORE) ** 2, np.full(num_terms, 1.0 / POINTS**2))


def with_ones(table: Floats) -> Floats:
    """[n, k + 1] a column of ones before the others."""
    return np.column_stack([np.ones(len(table)), table])
