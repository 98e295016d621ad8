"""Models similar to the few liked ones, while hardly any are known.

Explanations of so few liked models are unreliable. A single high score among many low ones can also be a blunder: if
similar models are liked, it is none, and if they are not, less is lost than by looking for its reasons elsewhere.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.preference.base import MAX_SCORE, Floats, Ints
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.observations import observe
from grammarlab.preference.processes.posterior import Hyperparameters, condition
from grammarlab.preference.questions.liked import liked

FEW_LIKED = 4
"""Number of liked models from which questions follow from explanations only."""
_DOUBTED = 0.25
"""Share of a score below which the value by cells means that they take it for a blunder."""
_ALIKE_DISTANCE = 2.6
"""Weighted squared distance between two typical models if all columns have equal weight."""
_ALIKE_NOISE = 1e-3
"""Noise, as a share of the amplitude."""


def surely_liked(preference: BlendedPreference, known: Floats, scores: Floats) -> NDArray[np.bool_]:
    """[n] whether a model seems liked, and its score is no blunder to cells.

    Args:
        preference: the preference.
        known: [n, F] rows of scored models.
        scores: [n] their scores.
    """
    return liked(scores, preference.noise) & (preference.partition.predict(known).mean >= _DOUBTED * scores)


def most_alike(
    pool: Floats,
    asked: Ints,
    scores: Floats,
    num: int,
    allowed: NDArray[np.bool_],
    randomness: np.random.Generator,
) -> Ints:
    """Models similar to liked ones and different from others, under a Gaussian process with equal weights.

    Args:
        pool: [m, F] rows of all models.
        asked: [n] pool indices of scored models.
        scores: [n] their scores.
        num: number of models; fewer if there are no more.
        allowed: [m] whether a model may be chosen.
        randomness: decides between equally similar models.
    """
    variance = pool.var(axis=0)
    varies = variance > 0.0
    weights = np.zeros(len(variance))
    weights[varies] = _ALIKE_DISTANCE / (2.0 * varies.sum() * variance[varies])
    alike = condition(Hyperparameters(MAX_SCORE**2, weights, _ALIKE_NOISE * MAX_SCORE**2), observe(pool[asked], scores))
    open_ = randomness.permutation(np.flatnonzero(allowed))
    return open_[np.argsort(-alike.predict(pool[open_]).mean, kind="stable")[:num]]
