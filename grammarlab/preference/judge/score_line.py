"""Lines that explain scores: points for parts add up, the sum clipped to 0-100.

Terms are added one by one, the one first that reduces the squared residuals most. Scores of 0 and 100 say only that the
sum is at most 0 or at least 100: their sums are replaced by expected ones given the others (a Tobit regression by
expectation-maximisation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from grammarlab.arrays import Floats
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.person import log_likelihood

MAX_TERMS = 8
"""Largest number of terms."""
_NUM_STEPS = 6
"""Number of steps of expectation-maximisation after each new term."""
_MIN_NORM = 1e-9
"""Share of a column's variance below which the other terms say all that it says."""


@dataclass(frozen=True, eq=False)
class ScoreLine:
    """A sum of points."""

    columns: tuple[int, ...]
    """Its terms."""
    total: float
    """Evidence minus description length, in nats."""


def best_line(columns: Floats, prices: Floats, scores: Floats, noise: float, blunders: float) -> ScoreLine:
    """The best of the lines of 0 to `MAX_TERMS` terms.

    Args:
        columns: [n, C] values.
        prices: [C] price of each column, in nats.
        scores: [n] 0-100.
        noise: standard deviation of the errors, in points.
        blunders: probability of a random score.
    """
    spread = columns.std(axis=0)
    usable = np.flatnonzero(spread > 0.0)
    table = (columns[:, usable] - columns[:, usable].mean(axis=0)) / spread[usable]
    terms, latent = list[int](), scores.copy()
    best = ScoreLine((), -np.inf)
    for _ in range(min(MAX_TERMS, len(usable)) + 1):
        predicted, latent = _fitted(table[:, terms], scores, latent, noise)
        total = _likelihood(predicted, scores, noise, blunders) - 0.5 * np.log(len(scores)) * (len(terms) + 1)
        total -= float(prices[usable[terms]].sum()) + np.log(2.0) * (len(terms) + 1)
        if total > best.total:
            best = ScoreLine(tuple(usable[terms].tolist()), total)
        following = _next(table, terms, latent - predicted)
        if following is None:
            break
        terms.append(following)
    return best


def _fitted(table: Floats, scores: Floats, latent: Floats, noise: float) -> tuple[Floats, Floats]:
    """Sums [n] that least squares give, and the sums [n] that scores stand for."""
    design = np.column_stack([np.ones(len(scores)), table])
    predicted = design @ np.linalg.lstsq(design, latent, rcond=None)[0]
    at_bottom, at_top = scores <= 0.0, scores >= MAX_SCORE
    for _ in range(_NUM_STEPS if at_bottom.any() or at_top.any() else 0):
        deviation = max(noise, float(np.sqrt(np.mean((latent - predicted) ** 2))))
        latent = scores.copy()
        latent[at_bottom] = -_above(-predicted[at_bottom], deviation)
        latent[at_top] = MAX_SCORE + _above(predicted[at_top] - MAX_SCORE, deviation)
        predicted = design @ np.linalg.lstsq(design, latent, rcond=None)[0]
    return predicted, latent


def _above(means: Floats, deviation: float) -> Floats:
    """Expected values of normal numbers with these means that are above 0."""
    ratio = np.clip(means / deviation, -30.0, 30.0)
    density = np.exp(-0.5 * ratio**2) / np.sqrt(2.0 * np.pi)
    return deviation * (ratio + density / np.maximum(ndtr(ratio), 1e-300))


def _likelihood(predicted: Floats, scores: Floats, noise: float, blunders: float) -> float:
    """Log-likelihood of scores for sums, to the nearest point."""
    grid = np.arange(MAX_SCORE + 1.0)
    table = log_likelihood(scores, grid, noise, blunders)
    return float(table[np.arange(len(scores)), np.rint(np.clip(predicted, 0.0, MAX_SCORE)).astype(np.int64)].sum())


def _next(table: Floats, terms: list[int], residual: Floats) -> int | None:
    """The column that reduces squared residuals most beside the terms; None if all are the same as these."""
    basis = np.linalg.qr(np.column_stack([np.ones(len(residual)), table[:, terms]]))[0]
    norms = len(residual) - ((basis.T @ table) ** 2).sum(axis=0)
    products = (residual - basis @ (basis.T @ residual)) @ table
    usable = norms > _MIN_NORM * len(residual)
    if not usable.any():
        return None
    reduced = np.where(usable, products**2 / np.maximum(norms, _MIN_NORM), -1.0)
    best = int(np.argmax(reduced))
    return best if reduced[best] > 0.0 else None
