"""Intervals of columns that explain scores."""

from __future__ import annotations

import numpy as np

from grammarlab.preference.base import Floats


def best_intervals(values: Floats, scores: Floats) -> Floats:
    """[C, 2] ends of the interval of each column [n, C] inside and outside of which scores [n] vary least.

    Ends lie halfway between neighbouring values, or are infinite.

    >>> best_intervals(np.array([[1.0], [2.0], [3.0], [5.0]]), np.array([0.0, 90.0, 80.0, 10.0])).tolist()
    [[1.5, 4.0]]
    """
    num, width = values.shape
    order = np.argsort(values, axis=0, kind="stable")
    ascending = np.take_along_axis(values, order, axis=0)
    sums = np.concatenate([np.zeros((1, width)), np.cumsum((scores - scores.mean())[order], axis=0)])
    bounds = np.full((num + 1, width), np.inf)
    bounds[0] = -np.inf
    bounds[1:num] = (ascending[1:] + ascending[:-1]) / 2.0
    # No interval ends between equal values.
    apart = np.ones((num + 1, width), dtype=bool)
    apart[1:num] = ascending[1:] > ascending[:-1]
    found = np.empty((width, 2))
    first, last = np.triu_indices(num + 1, 1)
    some = last - first < num
    first, last = first[some], last[some]
    size = (last - first).astype(np.float64)
    # Scores are centred, so that what is outside has the opposite sum.
    scale = 1.0 / size + 1.0 / (num - size)
    # Column by column, since pairs of bounds are many.
    for column in range(width):
        inside = sums[last, column] - sums[first, column]
        between = np.where(apart[first, column] & apart[last, column], inside**2 * scale, -1.0)
        best = int(np.argmax(between)) if len(between) else 0
        found[column] = (bounds[first[best], column], bounds[last[best], column]) if len(between) else (-np.inf, np.inf)
    return found
