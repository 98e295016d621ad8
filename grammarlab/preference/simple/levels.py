"""Few levels in place of many different values: what a grammar need not tell apart is one."""

from __future__ import annotations

import numpy as np

from grammarlab.preference.base import Floats

_MOST = 256
"""More different values are taken together in as many steps of their roots first."""


def drawn_to_levels(values: Floats, masses: Floats, num_levels: int) -> Floats:
    """Values [n] drawn to at most so many levels, each the mean of the values next to each other that it stands for.

    Of all ways to do so the one that moves the square roots least, in squares, is taken (Fisher 1958, by dynamic
    programming): what is near 0 is drawn to other small values first, and 0 itself moves last.

    Args:
        values: [n] >= 0.
        masses: [n] >= 0, how much each counts.
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
    # Where nothing counts, all count alike.
    masses = masses + 1e-12 * max(float(masses.sum()), 1e-300)
    mass = np.bincount(place, masses).astype(np.float64)
    means = np.bincount(place, masses * values) / mass
    ends = _cuts(np.sqrt(means), mass, min(num_levels, len(means)))
    level = np.repeat(np.arange(len(ends) - 1), np.diff(ends))
    return (np.bincount(level, mass * means) / np.bincount(level, mass))[level[place]]


def _cuts(roots: Floats, mass: Floats, num_levels: int) -> list[int]:
    """Where the levels of ascending values begin, and the end."""
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
