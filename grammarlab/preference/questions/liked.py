"""Liked models: scores above those that a person with errors gives to disliked models."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.preference.base import AbstractPreference, Floats
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.cells.partition import PartitionPreference

EXACT = 1.5
"""Largest noise in points of a person without errors."""
FAR = 2.5
"""Number of standard deviations of the noise that scores of disliked models rarely exceed: one in 160 does."""
RARE = 1 / 16
"""Share of liked models among `FEWEST` or more scored ones below which liked models are rare."""
FEWEST = 64


def noise_of(preference: AbstractPreference | None) -> float:
    """Standard deviation of a person's scores around their values, in points; 0 if it is unknown."""
    return preference.noise if isinstance(preference, BlendedPreference | PartitionPreference) else 0.0


def blunders_of(preference: AbstractPreference | None) -> float:
    """Probability of a random score of a person; 0 if it is unknown."""
    return preference.blunders if isinstance(preference, BlendedPreference | PartitionPreference) else 0.0


def liked(scores: Floats, noise: float) -> NDArray[np.bool_]:
    """[n] whether scores mean that a model is liked.

    Args:
        scores: [n] 0 to 100.
        noise: noise of the person, in points.

    >>> liked(np.array([0.0, 5.0, 30.0]), 0.5).tolist(), liked(np.array([0.0, 5.0, 30.0]), 10.0).tolist()
    ([False, True, True], [False, False, True])
    """
    return scores > (FAR * noise if noise > EXACT else 0.0)


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
    return bool(np.any((np.cumsum(liked(scores, noise)) < (RARE + blunders) * number)[FEWEST - 1 :]))
