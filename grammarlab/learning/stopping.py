"""Stopping: the expected gain of more scores.

The remaining divergence is estimated twice. Functions drawn from the posterior are possible preferences: the mean of
their divergences from the predicted density measures what is open under the explanations that were found. The change
of the predictions when a part of the scores is held out measures how open the explanations themselves are: a mean
without some of the scores has an additional error, which these scores remove. The divergence D(n) after n scores is
assumed to be proportional to 1 / n, as for d free parameters that are estimated from n scores (d / 8n nats), so with k
scores

    JS(density from k scores, density from n scores) = D(k) - D(n) = D(n) (n / k - 1).

Neither estimate sees what the other one measures, so the larger one is taken. An overconfident learner underestimates
both: means over persons are right within a factor of two, estimates of a single person about every other time.
"""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import MANY, ROUNDING, Floats
from grammarlab.learning.designs.design_space import Designs
from grammarlab.learning.round import State, Study
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.preference.base import MAX_SCORE, AbstractPreference
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.factors import ProductPreference
from grammarlab.preference.person import value_of
from grammarlab.preference.processes.disagreement import joint

NUM_MORE = 16
"""Number of scores whose gain is reported."""
_MAX_DESIGNS = 500
"""Number of designs of the pool, evenly spaced, on which densities are compared."""


def expected_gain(study: Study[Designs], state: State, more: int = NUM_MORE) -> float | None:
    """Expected decrease, by more scores, of the divergence of the learned density from the target density, in nats.

    Args:
        study: the pool and its tables.
        state: the state.
        more: number of scores.

    Returns:
        Expected drop of the Jensen-Shannon divergence, 0 to ln 2; None if nothing is liked yet, different scores have
        no explanation yet, or the learning method has no posterior.
    """
    divergence = expected_divergence(study, state)
    num_scores = state.num_answers
    return None if divergence is None else divergence * more / (num_scores + more)


def expected_divergence(study: Study[Designs], state: State) -> float | None:
    """Expected divergence of the learned density from the target density in nats; None as in `expected_gain`."""
    product = state.product
    if product is None:
        return None
    rows, weights = some_designs(study, state)
    divergence = remaining_divergence(product, rows, weights, state.num_answers, study.settings.seed)
    is_constant = np.ptp(product.predict(rows).mean) <= ROUNDING * MAX_SCORE
    if is_constant and any(np.ptp(state.answers[name].scores) > 0.0 for name in state.liked):
        return None
    return divergence


def some_designs(study: Study[Designs], state: State) -> tuple[Floats, Floats]:
    """Rows [m, F] and density weights [m] of some designs of the pool, evenly spaced."""
    weights = study.tables(state.wide).pool_designs.weights
    possible = np.flatnonzero(weights > 0.0)
    num = min(_MAX_DESIGNS, len(possible))
    selected = possible[np.arange(num) * len(possible) // num]
    return study.table(state).rows[selected], weights[selected]


def remaining_divergence(
    product: ProductPreference, rows: Floats, weights: Floats, num_scores: int, seed: int
) -> float | None:
    """Expected divergence of a learned density from the target density in nats; None without a posterior.

    Args:
        product: the preference.
        rows: [m, F] designs.
        weights: [m] >= 0, their density without a preference; not all 0.
        num_scores: number of scores.
        seed: seed of the draws.
    """
    functions = draws(product, rows, MANY, np.random.default_rng(seed))
    if functions is None:
        return None
    # A function that likes nothing leaves the density of the grammar.
    densities = [
        weights * values if (weights * values).any() else weights for values in (*functions, product.predict(rows).mean)
    ]
    *possible, predicted = densities
    open_divergence = float(np.mean([jensen_shannon(density, predicted) for density in possible]))
    return max(open_divergence, _held_out_divergence(product, rows, weights, predicted, num_scores))


def draws(preference: AbstractPreference, rows: Floats, num: int, randomness: np.random.Generator) -> Floats | None:
    """[num, m] scores of rows, 0 to 100, each row one function; None for preferences without a posterior.

    A blend draws from its cells, its process and its lines by their shares, a product from each of its factors.

    Args:
        preference: the preference.
        rows: [m, F] rows of models.
        num: number of functions, >= 1.
        randomness: generator.
    """
    if isinstance(preference, ProductPreference):
        parts = [draws(factor, rows, num, randomness) for factor in preference.factors.values()]
        available = [part for part in parts if part is not None]
        return MAX_SCORE * np.prod(np.array(available) / MAX_SCORE, axis=0) if len(available) == len(parts) else None
    if isinstance(preference, PartitionPreference):
        return _of_cells(preference, rows, num, randomness)
    if isinstance(preference, BlendedPreference):
        by_line = round(preference.line_share * num)
        by_process = round(preference.share * (num - by_line))
        functions = np.concatenate(
            [
                _of_process(preference, rows, by_process, randomness),
                _of_cells(preference.partition, rows, num - by_line - by_process, randomness),
                _of_lines(preference, rows, by_line, randomness),
            ]
        )
        # Factors are independent: one may draw from cells and another from a process.
        return randomness.permutation(functions)
    return None


def _of_cells(preference: PartitionPreference, rows: Floats, num: int, randomness: np.random.Generator) -> Floats:
    functions = np.zeros((num, len(rows)))
    for index, (number, posteriors) in enumerate(preference.divisions(rows, num, randomness)):
        below = posteriors.cumsum(axis=1)
        value = np.argmax(below >= randomness.random((len(below), 1)) * below[:, -1:], axis=1)
        functions[index] = preference.cells.grid[value[number]]
    return functions


def _of_process(preference: BlendedPreference, rows: Floats, num: int, randomness: np.random.Generator) -> Floats:
    """Draws of mean scores, converted to values."""
    if not num:
        return np.zeros((0, len(rows)))
    mean, covariance = joint(preference.process, rows, np.zeros(rows.shape[1]))
    length, direction = np.linalg.eigh(covariance)
    away = randomness.normal(size=(num, len(rows))) @ (direction * np.sqrt(np.maximum(length, 0.0))).T
    return value_of(mean + away, preference.noise, preference.blunders)


def _of_lines(preference: BlendedPreference, rows: Floats, num: int, randomness: np.random.Generator) -> Floats:
    if preference.line is None or not num:
        return np.zeros((0, len(rows)))
    return preference.line.draws(rows, num, randomness)


def _held_out_divergence(
    product: ProductPreference, rows: Floats, weights: Floats, predicted: Floats, num_scores: int
) -> float:
    """Remaining divergence in nats, by how far parts of the scores move the predicted density; 0 without parts."""
    parts = [factor.sketches for factor in product.factors.values() if isinstance(factor, BlendedPreference)]
    if len(parts) < len(product.factors):
        return 0.0
    divergences = [0.0]
    for sketches in zip(*parts, strict=False):
        num_labels = sum(sketch.num_labels for sketch in sketches)
        values = np.prod(
            [np.clip(sketch.predict(rows).mean, 0.0, MAX_SCORE) / MAX_SCORE for sketch in sketches], axis=0
        )
        density = weights * values if (weights * values).any() else weights
        divergences.append(jensen_shannon(density, predicted) * num_labels / max(num_scores - num_labels, 1))
    return sum(divergences) / max(len(divergences) - 1, 1)
