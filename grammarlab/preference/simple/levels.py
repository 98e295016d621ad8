"""Quantisation of values to few levels, so that a grammar has fewer states."""

from __future__ import annotations

import numpy as np

from grammarlab.preference.base import Floats

_MOST = 256
"""Largest number of different values; more are first merged into this number of steps of their roots."""


def drawn_to_levels(values: Floats, masses: Floats, num_levels: int) -> Floats:
    """Values [n] quantised to at most a number of levels, each the mean of consecutive values.

    Of all partitions, the one with the least squared change of the square roots is used (Fisher 1958, by dynamic
    programming): values near 0 are merged with other small values first, and 0 itself changes last.

    Args:
        values: [n] >= 0.
        masses: [n] >= 0, weight of each value.
        num_levels: >= 1.

    >>> drawn_to_levels(np.array([60.0, 20.0, 22.0, 0.0]), np.ones(4), 3).round(6).tolist()
    [60.0, 21.0, 21.0, 0.0]
    """
    different, place = np.unique(values, return_inverse=True)
    if len(different) <= num_levels:
        return values
    if len(different) > _MOST:
        steps = np.floor(np.sqrt(different / different[-1]) * (_MOST - 1)).astype(np.int64)
        place = np.unique(steps, return_inverse=True)[1][place]
    # If all masses are 0, all values have equal weight.
    masses = masses + 1e-12 * max(float(masses.sum()), 1e-300)
    mass = np.bincount(place, masses).astype(np.float64)
    means = np.bincount(place, masses * values) / mass
    ends = _cuts(np.sqrt(means), mass, min(num_levels, len(means)))
    level = np.repeat(np.arange(len(ends) - 1), np.diff(ends))
    return (np.bincount(level, mass * means) / np.bincount(level, mass))[level[place]]


def _cuts(roots: Floats, mass: Floats, num_levels: int) -> list[int]:
    """Offsets of the levels of ascending values."""
    size = len(roots)
    sums = [np.concatenate([[0.0], np.cumsum(column)]) for column in (mass, mass * roots, mass * roots**2)]
    first, last = np.arange(size + 1)[:, None], np.arange(size + 1)[None, :]
    m, r, s = (column[last] - column[first] for column in sums)
    with np.errstate(divide="ignore", invalid="ignore"):
        cost = np.where(first < last, np.maximum(np.nan_to_num(s - r**2 / m), 0.0), np.inf)
    best = cost[0]
    choices = []
    for _ in range(num_levels - 1):
        total = best[:, None] + cost
        choices.append(total.argmin(axis=0))
        best = total.min(axis=0)
    ends = [size]
    for choice in reversed(choices):
        ends.append(int(choice[ends[-1]]))
    return [0, *reversed(ends)]
