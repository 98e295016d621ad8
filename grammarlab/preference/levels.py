"""Scores that a person gave again and again, and predictions drawn to them."""

from __future__ import annotations

import numpy as np

from grammarlab.preference.base import Floats

MOST_LEVELS = 12
"""A person who gives more different scores is taken to mean a continuous scale."""
CLOSEST = 5.0
"""Levels lie at least this far apart, in scores."""
REACH = 0.4
"""A prediction is drawn to a level from so far away at most, as a part of the way to the next level."""


def levels_of(scores: Floats) -> Floats:
    """The levels [L] of a person's scores, ascending; none where the scores look like a continuous scale.

    >>> levels_of(np.array([40.0, 0.0, 40.0, 20.0, 0.0])).tolist()
    [0.0, 20.0, 40.0]
    >>> levels_of(np.array([40.0, 0.0, 41.0])).tolist()
    []
    """
    found = np.unique(scores)
    apart = len(found) < 2 or float(np.diff(found).min()) >= CLOSEST
    return found if apart and len(found) <= MOST_LEVELS else np.zeros(0)


def snapped(means: Floats, levels: Floats) -> Floats:
    """Predictions [n] moved to the level that they clearly belong to; those in between stay, none is below 0.

    Args:
        means: [n] predicted scores.
        levels: [L] ascending, as `levels_of` gives them.

    >>> snapped(np.array([-3.0, 1.0, 11.0, 17.0, 45.0]), np.array([0.0, 20.0, 40.0])).tolist()
    [0.0, 0.0, 11.0, 20.0, 40.0]
    """
    positive = np.maximum(means, 0.0)
    if not len(levels):
        return positive
    distance = np.abs(means[:, None] - levels)
    nearest = np.argmin(distance, axis=1)
    # Beyond the lowest and the highest level there is nothing to be taken for instead.
    gaps = np.concatenate([[np.inf], np.diff(levels), [np.inf]])
    gap = np.where(means < levels[nearest], gaps[nearest], gaps[nearest + 1])
    clear = distance[np.arange(len(means)), nearest] <= REACH * gap
    return np.where(clear, levels[nearest], positive)
