"""Totals of counts with a number of points for each: for persons who like many things that add up, or multiply.

Points are found by forward selection in a linear model of the scores, or of their logarithm, and rounded to small whole
numbers. How scores depend on the total is for others to learn.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_TERMS = 8
"""Largest number of counts in a total."""
FEWEST = 32
"""Smallest number of scores."""
_POINTS = 8
"""Points of the count that matters most, if all others then have some, too."""
_MOST_POINTS = 200
_LEAST_NOISE = 0.5
"""Smallest standard deviation of errors, in points of scores."""
_TRIED = 3
"""Number of counts that are tried as the next term."""
_STEPS = 12
"""Gauss-Newton steps of a model of logarithms."""
_SIZES = (1.0, 0.5, 0.25, 0.1)
_RIDGE = 1e-3
_HIGHEST = 6.0
"""Bound on the size of logarithms."""
_NONE = 1e-6


class FoundPoints(NamedTuple):
    """A total of counts."""

    weights: Ints
    """[F] points for each count."""
    predicted: Floats
    """[n] scores by the total."""
    price: float
    """What the choice of the counts and of their points costs, in nats."""


class _Model(NamedTuple):
    """A least-squares fit."""

    weights: Floats
    """[1 + k] constant, and the weight of each term."""
    predicted: Floats
    """[n]"""
    slopes: Floats
    """[n] derivative of the predictions by the linear part."""


_Fit: TypeAlias = Callable[[Floats, Floats], _Model]


def find_points(counts: Ints, scores: Floats) -> list[FoundPoints]:
    """Totals of two or more counts that explain scores, by a sum and by a product; at most two.

    Args:
        counts: [n, F].
        scores: [n].
    """
    if len(scores) < FEWEST or not np.ptp(scores) > _NONE or not np.ptp(counts, axis=0).any():
        return []
    varying = np.flatnonzero(np.ptp(counts, axis=0) > 0)
    columns = varying[np.sort(np.unique(counts[:, varying], axis=1, return_index=True)[1])]
    ranges, unit = np.ptp(counts[:, columns], axis=0), float(np.ptp(scores))
    found: list[FoundPoints] = []
    for fit in (_added, _multiplied):
        terms, model = _selected(counts[:, columns] / ranges, scores / unit, fit, _LEAST_NOISE / unit)
        weights = np.zeros(counts.shape[1], dtype=np.int64)
        weights[columns[terms]] = _rounded(model.weights[1:] / ranges[terms])
        if np.count_nonzero(weights) > 1:
            price = len(terms) * _price(len(columns), len(scores)) + 0.5 * float(np.log(len(scores)))
            found.append(FoundPoints(weights, unit * model.predicted, price))
    return found


def _rounded(slopes: Floats) -> Ints:
    """Whole numbers about in proportion to slopes."""
    if not np.abs(slopes).max(initial=0.0) > 0.0:
        return np.zeros(len(slopes), dtype=np.int64)
    sizes = np.abs(slopes)
    scale = min(max(_POINTS / sizes.max(), 1.0 / max(sizes.min(), 1e-300)), _MOST_POINTS / sizes.max())
    return np.round(slopes * scale).astype(np.int64)


def _price(num_columns: int, num_scores: int) -> float:
    """What one more term costs, in nats."""
    return float(np.log(num_columns) + 0.5 * np.log(num_scores))


def _selected(columns: Floats, scores: Floats, fit: _Fit, noise: float) -> tuple[Ints, _Model]:
    """Columns [n, C] whose model explains scores best, term by term while each gains more than its price."""
    price, terms = _price(columns.shape[1], len(scores)), list[int]()
    model = fit(columns[:, terms], scores)
    while len(terms) < MOST_TERMS:
        # Columns are compared by what they explain beside the terms, to first order.
        basis = np.linalg.qr(np.column_stack([np.ones(len(scores)), columns[:, terms]]) * model.slopes[:, None])[0]
        beside, left = columns * model.slopes[:, None], scores - model.predicted
        beside, left = beside - basis @ (basis.T @ beside), left - basis @ (basis.T @ left)
        sizes = (beside**2).sum(axis=0)
        gains = np.where(sizes > _NONE, (beside.T @ left) ** 2 / np.maximum(sizes, _NONE), 0.0)
        gains[terms] = -1.0
        trials = [
            [*terms, place] for place in np.argsort(-gains, kind="stable")[:_TRIED].tolist() if gains[place] > 0.0
        ]
        models = [fit(columns[:, trial], scores) for trial in trials]
        likelihoods = [_likelihood(each, scores, noise) for each in models]
        if not models or max(likelihoods) - _likelihood(model, scores, noise) < price:
            break
        best = int(np.argmax(likelihoods))
        terms, model = trials[best], models[best]
    return np.array(terms, dtype=np.int64), model


def _likelihood(model: _Model, scores: Floats, noise: float) -> float:
    """Log-likelihood of scores, with the most likely noise that is no smaller than a given one."""
    variance = float(((scores - model.predicted) ** 2).mean())
    most_likely = max(variance, noise**2)
    return -0.5 * len(scores) * (float(np.log(2.0 * np.pi * most_likely)) + variance / most_likely)


def _added(columns: Floats, scores: Floats) -> _Model:
    """A linear model."""
    table = np.column_stack([np.ones(len(scores)), columns])
    weights = np.linalg.solve(table.T @ table + _RIDGE * np.eye(table.shape[1]), table.T @ scores)
    return _Model(weights.astype(np.float64), table @ weights, np.ones(len(scores)))


def _multiplied(columns: Floats, scores: Floats) -> _Model:
    """A linear model of logarithms, by damped Gauss-Newton steps."""
    table = np.column_stack([np.ones(len(scores)), columns])
    weights = np.zeros(table.shape[1])
    weights[0] = np.log(max(float(scores.mean()), 1e-3))

    def predicted(some: Floats) -> Floats:
        return np.exp(np.clip(table @ some, -_HIGHEST, _HIGHEST))

    def loss(some: Floats) -> float:
        return float(((scores - predicted(some)) ** 2).sum() + _RIDGE * (some[1:] ** 2).sum())

    lowest = loss(weights)
    for _ in range(_STEPS):
        now = predicted(weights)
        steep = table * now[:, None]
        matrix = steep.T @ steep + _RIDGE * np.eye(len(weights))
        step = np.linalg.solve(matrix, steep.T @ (scores - now) - _RIDGE * weights)
        size = next((each for each in _SIZES if loss(weights + each * step) < lowest), 0.0)
        if not size:
            break
        weights = weights + size * step
        lowest = loss(weights)
    now = predicted(weights)
    return _Model(weights, now, now)
