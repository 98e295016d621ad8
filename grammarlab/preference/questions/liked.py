"""What is liked: scores above those that a person who errs gives to what they do not like."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.preference.base import AbstractPreference, Floats
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.cells.partition import PartitionPreference

EXACT = 1.5
"""Noise in points up to which a person seems not to err."""
FAR = 2.5
"""Standard deviations of the noise that what is not liked hardly exceeds: one such score in 160 does."""
RARE = 1 / 16
"""Liked models are rare where a smaller part of the scored ones, `FEWEST` or more, was liked."""
FEWEST = 64


def noise_of(preference: AbstractPreference | None) -> float:
    """Standard deviation, in points, of what a person says around what is meant; 0 where it is not known."""
    return preference.noise if isinstance(preference, BlendedPreference | PartitionPreference) else 0.0


def liked(scores: Floats, noise: float) -> NDArray[np.bool_]:
    """[n] which scores say that a model is liked.

    Args:
        scores: [n] 0 to 100.
        noise: of the person, in points.

    >>> liked(np.array([0.0, 5.0, 30.0]), 0.5).tolist(), liked(np.array([0.0, 5.0, 30.0]), 10.0).tolist()
    ([False, True, True], [False, False, True])
    """
    return scores > (FAR * noise if noise > EXACT else 0.0)


def liked_are_rare(scores: Floats, noise: float = 0.0) -> bool:
    """Whether models that are liked have been so rare at any time that proposals should be picked among many more.

    Args:
        scores: [n] in the order in which they were given.
        noise: of the person, in points.

    >>> liked_are_rare(np.zeros(63)), liked_are_rare(np.zeros(64)), liked_are_rare(np.repeat([0.0, 50.0], [60, 4]))
    (False, True, False)
    """
    number = np.arange(1, len(scores) + 1)
    return bool(np.any((np.cumsum(liked(scores, noise)) < RARE * number)[FEWEST - 1 :]))
