"""Totals of counts with a number of points for each: for persons who like many things that add up, or multiply.

Points are found by forward selection in a linear model of the scores, or of their logarithm, in which some scores are
random, and rounded to small whole numbers. How scores depend on the total is for others to learn.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from grammarlab.arrays import Floats, Ints

MAX_TERMS = 8
"""Largest number of counts in a total."""
MIN_SCORES = 32
"""Smallest number of scores."""
_TOP_POINTS = 8
"""Points of the count that matters most, if all other counts then have some."""
_MAX_POINTS = 200
"""Largest points of a count."""
_MIN_NOISE = 0.5
"""Smallest standard deviation of errors, in points of scores."""
_RANDOM_SHARES = 1e-9, 0.05
"""Candidate shares of random scores, which lie anywhere between the lowest and the highest score. While terms are
missing, many scores look random, so the larger share finds fewer terms if no score is."""
_MIN_RANDOM_GAIN = 5.0
"""Gain of the log-likelihood in nats from which some scores are random."""
_NUM_TRIALS = 3
"""Number of counts that are tried as the next term."""
_MAX_STEPS = 12
"""Largest number of Gauss-Newton steps of a model, each followed by a step of expectation maximisation."""
_STEP_SIZES = (1.0, 0.5, 0.25, 0.1)
"""Candidate sizes of a Gauss-Newton step, largest first."""
_MIN_GAIN = 1e-3
"""Gain of the log-likelihood in nats below which a model is found."""
_RIDGE = 1e-3
"""Penalty on squared weights, for terms that are collinear."""
_MAX_LOGARITHM = 6.0
"""Bound on the size of logarithms."""
_TOLERANCE = 1e-6
"""Smallest range of scores and squared length of a column that are not 0."""


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
    """[n] predicted scores, as shares of their range."""
    slopes: Floats
    """[n] derivative of the predictions by the linear part."""
    trust: Floats
    """[n] probability that a score is not random."""
    log_likelihood: float
    """Log-likelihood of the scores, with the most likely noise, in nats."""


_Mean: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]
"""Predictions [n], and their derivative [n], by the linear part [n]."""


def find_points(counts: Ints, scores: Floats) -> list[FoundPoints]:
    """Totals of two or more counts that explain scores, by a sum and by a product; at most two.

    Args:
        counts: [n, F] counts of the features of n models.
        scores: [n] scores of the models.
    """
    if len(scores) < MIN_SCORES or not np.ptp(scores) > _TOLERANCE or not np.ptp(counts, axis=0).any():
        return []
    varying = np.flatnonzero(np.ptp(counts, axis=0) > 0)
    columns = varying[np.sort(np.unique(counts[:, varying], axis=1, return_index=True)[1])]
    ranges, unit = np.ptp(counts[:, columns], axis=0), float(np.ptp(scores))
    term_price = float(np.log(len(columns)) + 0.5 * np.log(len(scores)))
    totals: list[FoundPoints] = []
    for mean, middle in ((_added, float(scores.mean()) / unit), (_multiplied, np.log(max(scores.mean() / unit, 1e-3)))):
        sure, doubtful = (
            _selected(
                counts[:, columns] / ranges,
                scores / unit,
                mean,
                middle,
                _Errors(_MIN_NOISE / unit, random),
                term_price,
            )
            for random in _RANDOM_SHARES
        )
        gain = doubtful[1].log_likelihood - sure[1].log_likelihood - term_price * (len(doubtful[0]) - len(sure[0]))
        terms, model = doubtful if gain > _MIN_RANDOM_GAIN else sure
        weights = np.zeros(counts.shape[1], dtype=np.int64)
        weights[columns[terms]] = _rounded(model.weights[1:] / ranges[terms])
        if np.count_nonzero(weights) > 1:
            price = len(terms) * term_price + 0.5 * float(np.log(len(scores)))
            totals.append(FoundPoints(weights, unit * model.predicted, price))
    return totals


def _rounded(slopes: Floats) -> Ints:
    """Whole numbers about in proportion to slopes."""
    if not np.abs(slopes).max(initial=0.0) > 0.0:
        return np.zeros(len(slopes), dtype=np.int64)
    sizes = np.abs(slopes)
    scale = min(max(_TOP_POINTS / sizes.max(), 1.0 / max(sizes.min(), 1e-300)), _MAX_POINTS / sizes.max())
    return np.round(slopes * scale).astype(np.int64)


def _selected(
    columns: Floats, scores: Floats, mean: _Mean, middle: float, errors: _Errors, price: float
) -> tuple[Ints, _Model]:
    """Columns [n, C] whose model explains scores best, term by term while each gains more than its price in nats."""
    terms = list[int]()
    model = _fitted(columns[:, terms], scores, mean, np.array([middle]), errors)
    while len(terms) < MAX_TERMS:
        # Columns are compared by what they explain beside the terms, to first order.
        size = model.slopes * np.sqrt(model.trust)
        basis = np.linalg.qr(np.column_stack([np.ones(len(scores)), columns[:, terms]]) * size[:, None])[0]
        orthogonal, residuals = columns * size[:, None], (scores - model.predicted) * np.sqrt(model.trust)
        orthogonal, residuals = orthogonal - basis @ (basis.T @ orthogonal), residuals - basis @ (basis.T @ residuals)
        sizes = (orthogonal**2).sum(axis=0)
        gains = np.where(sizes > _TOLERANCE, (orthogonal.T @ residuals) ** 2 / np.maximum(sizes, _TOLERANCE), 0.0)
        gains[terms] = -1.0
        trials = [
            [*terms, index] for index in np.argsort(-gains, kind="stable")[:_NUM_TRIALS].tolist() if gains[index] > 0.0
        ]
        start = np.append(model.weights, 0.0)
        models = [_fitted(columns[:, trial], scores, mean, start, errors) for trial in trials]
        best = int(np.argmax([fit.log_likelihood for fit in models])) if models else -1
        if best < 0 or models[best].log_likelihood - model.log_likelihood < price:
            break
        terms, model = trials[best], models[best]
    return np.array(terms, dtype=np.int64), model


def _added(linear: Floats) -> tuple[Floats, Floats]:
    return linear, np.ones(len(linear))


def _multiplied(linear: Floats) -> tuple[Floats, Floats]:
    value = np.exp(np.clip(linear, -_MAX_LOGARITHM, _MAX_LOGARITHM))
    return value, value


def _fitted(columns: Floats, scores: Floats, mean: _Mean, weights: Floats, errors: _Errors) -> _Model:
    """The model of columns [n, k] that is most likely near the weights [1 + k] to start with."""
    table = np.column_stack([np.ones(len(scores)), columns])
    model = _judged(table, scores, mean, weights, np.ones(len(scores)), errors)
    for _ in range(_MAX_STEPS):
        steep = table * model.slopes[:, None]
        ridge = _RIDGE * np.append(0.0, np.ones(columns.shape[1]))
        matrix = (steep * model.trust[:, None]).T @ steep + np.diag(ridge + _TOLERANCE)
        residuals = model.trust * (scores - model.predicted)
        step = np.linalg.solve(matrix, steep.T @ residuals - ridge * model.weights)
        trials = (
            _judged(table, scores, mean, model.weights + size * step, model.trust, errors) for size in _STEP_SIZES
        )
        better = next((trial for trial in trials if trial.log_likelihood > model.log_likelihood), model)
        if better.log_likelihood < model.log_likelihood + _MIN_GAIN:
            break
        model = better
    return model


def _judged(table: Floats, scores: Floats, mean: _Mean, weights: Floats, trust: Floats, errors: _Errors) -> _Model:
    """A model, with the noise that is most likely if scores have some trust [n], and the trust that follows."""
    predicted, slopes = mean(table @ weights)
    squares = (scores - predicted) ** 2
    variance = max(float((trust * squares).sum() / max(trust.sum(), 1.0)), errors.least**2)
    density = (1.0 - errors.random) * np.exp(-0.5 * squares / variance) / np.sqrt(2.0 * np.pi * variance)
    return _Model(
        weights, predicted, slopes, density / (density + errors.random), float(np.log(density + errors.random).sum())
    )
