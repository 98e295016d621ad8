"""Models to ask about again: high scores that may be blunders, while little else is liked.

A liked model among many disliked ones looks like a blunder. Asked again it has a high score again, which a second
blunder gives in one of a few hundred cases, so that one question tells more than any about a new model.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from grammarlab.preference.base import Floats, Ints
from grammarlab.preference.blended import FEWEST, BlendedPreference
from grammarlab.preference.questions.liked import liked

FEW_LIKED = 4
"""Number of liked models below which the next questions are about them, or about similar models."""
_DOUBTED = 0.25
"""Share of a score below which the value by cells means that they doubt it."""


class Asked(NamedTuple):
    """Different models with scores."""

    models: Ints
    """[k] pool indices, ascending."""
    scores: Floats
    """[k] the lowest score of each."""
    times: Ints
    """[k] number of scores of each."""


def asked_of(models: Ints, scores: Floats) -> Asked:
    """Models by pool index [n] with their scores [n].

    >>> [column.tolist() for column in asked_of(np.array([7, 3, 7]), np.array([90.0, 20.0, 5.0]))]
    [[3, 7], [20.0, 5.0], [1, 2]]
    """
    different, place, times = np.unique(models, return_inverse=True, return_counts=True)
    lowest = np.full(len(different), np.inf)
    np.minimum.at(lowest, place.reshape(-1), scores)
    return Asked(different, lowest, times)


def few_liked(preference: BlendedPreference, pool: Floats, asked: Asked) -> tuple[Ints, Ints]:
    """Models of doubtful scores, highest first, and models that are liked, if there are few of both kinds.

    Args:
        preference: the preference.
        pool: [m, F] rows of all models.
        asked: models with scores.

    Returns:
        Pool indices; both are empty if enough models are liked, or too few have scores.
    """
    nothing = np.zeros(0, dtype=np.int64)
    high = np.flatnonzero(liked(asked.scores, preference.noise))
    if asked.times.sum() < FEWEST or not len(high):
        return nothing, nothing
    means = preference.partition.predict(pool[asked.models[high]]).mean
    doubted = (asked.times[high] == 1) & (means < _DOUBTED * asked.scores[high])
    sure = asked.models[high[~doubted]]
    if len(sure) >= FEW_LIKED:
        return nothing, nothing
    doubtful = high[doubted]
    return asked.models[doubtful[np.argsort(-asked.scores[doubtful], kind="stable")]], sure
