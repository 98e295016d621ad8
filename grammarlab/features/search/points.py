"""Totals of counts with a number of points for each: for persons who like many things that add up, or multiply.

Points are found by forward selection in a linear model of the scores, or of their logarithm, in which some scores are
random, and rounded to small whole numbers. How scores depend on the total is for others to learn.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from grammarlab.arrays import Floats, Ints

MOST_TERMS = 8
"""Largest number of counts in a total."""
FEWEST = 32
"""Smallest number of scores."""
_POINTS = 8
"""Points of the count that matters most, if all others then have some, too."""
_MOST_POINTS = 200
_LEAST_NOISE = 0.5
"""Smallest standard deviation of errors, in points of scores."""
_RANDOM = 1e-9, 0.05
"""Candidate shares of random scores, which lie anywhere between the lowest and the highest score. While terms are
missing, many scores look random, so the larger share finds fewer terms if no score is."""
_DOUBT = 5.0
"""Gain of the log-likelihood in nats from which some scores are random."""
_TRIED = 3
"""Number of counts that are tried as the next term."""
_STEPS = 12
"""Gauss-Newton steps of a model, each followed by a step of expectation maximisation."""
_SIZES = (1.0, 0.5, 0.25, 0.1)
_SAME = 1e-3
"""Gain of the log-likelihood in nats below which a model is found."""
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


class _Errors(NamedTuple):
    least: float
    """Smallest standard deviation of errors, as a share of the range of scores."""
    random: float
    """Share of random scores."""


class _Model(NamedTuple):
    """A fit in which each score may be random."""

    weights: Floats
    """[1 + k] constant, and the weight of each term."""
    predicted: Floats
    """[n]"""
    slopes: Floats
    """[n] derivative of the predictions by the linear part."""
    trust: Floats
    """[n] probability that a score is not random."""
    log_likelihood: float
    """Of the scores, with the most likely noise."""


_Mean: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]
"""Predictions [n], and their derivative [n], by the linear part [n]."""


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
    one = float(np.log(len(columns)) + 0.5 * np.log(len(scores)))
    found: list[FoundPoints] = []
    for mean, middle in ((_added, float(scores.mean()) / unit), (_multiplied, np.log(max(scores.mean() / unit, 1e-3)))):
        sure, doubtful = (
            _selected(
                counts[:, columns] / ranges, scores / unit, mean, middle, _Errors(_LEAST_NOISE / unit, random), one
            )
            for random in _RANDOM
        )
        gain = doubtful[1].log_likelihood - sure[1].log_likelihood - one * (len(doubtful[0]) - len(sure[0]))
        terms, model = doubtful if gain > _DOUBT else sure
        weights = np.zeros(counts.shape[1], dtype=np.int64)
        weights[columns[terms]] = _rounded(model.weights[1:] / ranges[terms])
        if np.count_nonzero(weights) > 1:
            price = len(terms) * one + 0.5 * float(np.log(len(scores)))
            found.append(FoundPoints(weights, unit * model.predicted, price))
    return found


def _rounded(slopes: Floats) -> Ints:
    """Whole numbers about in proportion to slopes."""
    if not np.abs(slopes).max(initial=0.0) > 0.0:
        return np.zeros(len(slopes), dtype=np.int64)
    sizes = np.abs(slopes)
    scale = min(max(_POINTS / sizes.max(), 1.0 / max(sizes.min(), 1e-300)), _MOST_POINTS / sizes.max())
    return np.round(slopes * scale).astype(np.int64)


def _selected(
    columns: Floats, scores: Floats, mean: _Mean, middle: float, errors: _Errors, price: float
) -> tuple[Ints, _Model]:
    """Columns [n, C] whose model explains scores best, term by term while each gains more than its price in nats."""
    terms = list[int]()
    model = _fitted(columns[:, terms], scores, mean, np.array([middle]), errors)
    while len(terms) < MOST_TERMS:
        # Columns are compared by what they explain beside the terms, to first order.
        size = model.slopes * np.sqrt(model.trust)
        basis = np.linalg.qr(np.column_stack([np.ones(len(scores)), columns[:, terms]]) * size[:, None])[0]
        beside, left = columns * size[:, None], (scores - model.predicted) * np.sqrt(model.trust)
        beside, left = beside - basis @ (basis.T @ beside), left - basis @ (basis.T @ left)
        sizes = (beside**2).sum(axis=0)
        gains = np.where(sizes > _NONE, (beside.T @ left) ** 2 / np.maximum(sizes, _NONE), 0.0)
        gains[terms] = -1.0
        trials = [
            [*terms, place] for place in np.argsort(-gains, kind="stable")[:_TRIED].tolist() if gains[place] > 0.0
        ]
        start = np.append(model.weights, 0.0)
        models = [_fitted(columns[:, trial], scores, mean, start, errors) for trial in trials]
        best = int(np.argmax([each.log_likelihood for each in models])) if models else -1
        if best < 0 or models[best].log_likelihood - model.log_likelihood < price:
            break
        terms, model = trials[best], models[best]
    return np.array(terms, dtype=np.int64), model


def _added(linear: Floats) -> tuple[Floats, Floats]:
    return linear, np.ones(len(linear))


def _multiplied(linear: Floats) -> tuple[Floats, Floats]:
    value = np.exp(np.clip(linear, -_HIGHEST, _HIGHEST))
    return value, value


def _fitted(columns: Floats, scores: Floats, mean: _Mean, weights: Floats, errors: _Errors) -> _Model:
    """The model of columns [n, k] that is most likely near the weights [1 + k] to start with."""
    table = np.column_stack([np.ones(len(scores)), columns])
    model = _judged(table, scores, mean, weights, np.ones(len(scores)), errors)
    for _ in range(_STEPS):
        steep = table * model.slopes[:, None]
        ridge = _RIDGE * np.append(0.0, np.ones(columns.shape[1]))
        matrix = (steep * model.trust[:, None]).T @ steep + np.diag(ridge + _NONE)
        left = model.trust * (scores - model.predicted)
        step = np.linalg.solve(matrix, steep.T @ left - ridge * model.weights)
        trials = (_judged(table, scores, mean, model.weights + size * step, model.trust, errors) for size in _SIZES)
        better = next((trial for trial in trials if trial.log_likelihood > model.log_likelihood), model)
        if better.log_likelihood < model.log_likelihood + _SAME:
            break
        model = better
    return model


def _judged(table: Floats, scores: Floats, mean: _Mean, weights: Floats, trust: Floats, errors: _Errors) -> _Model:
    """A model, with the noise that is most likely if scores have some trust [n], and the trust that follows."""
    predicted, slopes = mean(table @ weights)
    away = (scores - predicted) ** 2
    variance = max(float((trust * away).sum() / max(trust.sum(), 1.0)), errors.least**2)
    meant = (1.0 - errors.random) * np.exp(-0.5 * away / variance) / np.sqrt(2.0 * np.pi * variance)
    return _Model(
        weights, predicted, slopes, meant / (meant + errors.random), float(np.log(meant + errors.random).sum())
    )
