"""Liked models, and models similar to liked ones that have no reliable explanation yet.

A liked model has a score above those that a person with errors gives to disliked models. While hardly any liked models
are known, all explanations are unreliable. Later, a high score among many low ones may be an error, or the first model
of another liked kind. If similar models are liked, it is none, and if they are not, less is lost than by looking for
its reasons elsewhere.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.base import LIKED_SHARE, MAX_SCORE, AbstractPreference
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.observations import observe
from grammarlab.preference.person import EXACT_NOISE, MODEL_NOISE, expected_score
from grammarlab.preference.processes.posterior import Hyperparameters, condition

RARE_SHARE = 1 / 16
"""Share of liked models among `MIN_SCORED` or more scored ones below which liked models are rare."""
MIN_SCORED = 64
"""Smallest number of scored models for a share of liked ones."""
FEW_LIKED = 4
"""Number of liked models from which questions follow from explanations only."""
_FAR_DEVIATIONS = 2.5
"""Number of standard deviations of the noise that scores of disliked models rarely exceed: one in 160 does."""
_SIMILAR_DISTANCE = 2.6
"""Weighted squared distance between two typical models if all columns have equal weight."""
_SIMILAR_NOISE = 1e-3
"""Noise, as a share of the amplitude."""
_MIN_EXCESS_SDS = 1.5
"""Number of standard deviations by which a score is above the expected one if it has no explanation."""
_MAX_CANDIDATES = 8_000
"""Largest number of models that are compared with scored ones; a pool for rare tastes has many more."""
_VALUE_SHARE = 0.5
"""Value of models of another liked kind, as a share of the highest value."""


def noise_of(preference: AbstractPreference | None) -> float:
    """Standard deviation of a person's scores around their values, in points; 0 if it is unknown."""
    return preference.noise if isinstance(preference, BlendedPreference | PartitionPreference) else 0.0


def blunders_of(preference: AbstractPreference | None) -> float:
    """Probability of a random score of a person; 0 if it is unknown."""
    return preference.blunders if isinstance(preference, BlendedPreference | PartitionPreference) else 0.0


def liked_are_rare(scores: Floats, noise: float = 0.0, blunders: float = 0.0) -> bool:
    """Whether liked models have ever been so rare that questions need a larger pool.

    Args:
        scores: [n] in the order in which they were given.
        noise: noise of the person, in points.
        blunders: probability of a random score, which seems to mean that a model is liked.

    >>> liked_are_rare(np.zeros(63)), liked_are_rare(np.zeros(64)), liked_are_rare(np.repeat([0.0, 50.0], [60, 4]))
    (False, True, False)
    """
    number = np.arange(1, len(scores) + 1)
    return bool(np.any((np.cumsum(liked(scores, noise)) < (RARE_SHARE + blunders) * number)[MIN_SCORED - 1 :]))


def liked(scores: Floats, noise: float) -> NDArray[np.bool_]:
    """[n] whether scores mean that a model is liked.

    Args:
        scores: [n] 0 to 100.
        noise: noise of the person, in points.

    >>> liked(np.array([0.0, 5.0, 30.0]), 0.5).tolist(), liked(np.array([0.0, 5.0, 30.0]), 10.0).tolist()
    ([False, True, True], [False, False, True])
    """
    return scores > (_FAR_DEVIATIONS * noise if noise > EXACT_NOISE else 0.0)


def surely_liked(preference: BlendedPreference, rows: Floats, scores: Floats) -> NDArray[np.bool_]:
    """[n] whether a model seems liked, and its score is no blunder to cells.

    Args:
        preference: the preference.
        rows: [n, F] rows of scored models.
        scores: [n] scores of these models, 0-100.
    """
    return liked(scores, preference.noise) & (preference.partition.predict(rows).mean >= LIKED_SHARE * scores)


def most_unexplained(
    preference: BlendedPreference,
    pool: Floats,
    scored: Ints,
    scores: Floats,
    num: int,
    allowed: NDArray[np.bool_],
    randomness: np.random.Generator,
) -> Ints:
    """Models similar to those with higher scores than cells explain, and different from those without.

    A cell of many disliked models takes the scores of a rare liked kind for errors, and has no reason to ask for more.

    Args:
        preference: the preference.
        pool: [m, F] rows of all models.
        scored: [n] pool indices of scored models.
        scores: [n] scores of these models, 0-100.
        num: number of models; none if cells explain all scores.
        allowed: [m] whether a model may be chosen.
        randomness: decides between equally similar models.
    """
    cells = preference.partition
    values, noise = cells.predict(pool[scored]).mean, max(cells.noise, MODEL_NOISE)
    excess = np.maximum(scores - expected_score(values, noise, 0.0), 0.0)
    if not (excess > _MIN_EXCESS_SDS * noise).any():
        return scored[:0]
    amplitude = _VALUE_SHARE * max(float(values.max()), noise)
    candidates = randomness.permutation(np.flatnonzero(allowed))[:_MAX_CANDIDATES]
    return _nearest(pool, scored, excess, (noise / amplitude) ** 2, candidates)[:num]


def most_similar(
    pool: Floats,
    scored: Ints,
    scores: Floats,
    num: int,
    allowed: NDArray[np.bool_],
    randomness: np.random.Generator,
) -> Ints:
    """Models similar to liked ones and different from others, under a Gaussian process with equal weights.

    Args:
        pool: [m, F] rows of all models.
        scored: [n] pool indices of scored models.
        scores: [n] scores of these models, 0-100.
        num: number of models; fewer if there are no more.
        allowed: [m] whether a model may be chosen.
        randomness: decides between equally similar models.
    """
    return _nearest(pool, scored, scores, _SIMILAR_NOISE, randomness.permutation(np.flatnonzero(allowed)))[:num]


def _nearest(pool: Floats, scored: Ints, scores: Floats, noise: float, candidates: Ints) -> Ints:
    """Candidates by their expected scores, highest first; the noise is a share of the amplitude."""
    variance = pool.var(axis=0)
    varies = variance > 0.0
    weights = np.zeros(len(variance))
    weights[varies] = _SIMILAR_DISTANCE / (2.0 * varies.sum() * variance[varies])
    process = condition(Hyperparameters(MAX_SCORE**2, weights, noise * MAX_SCORE**2), observe(pool[scored], scores))
    return candidates[np.argsort(-process.predict(pool[candidates]).mean, kind="stable")]
