"""Energy of a grid, and the nearest patch of each of its windows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.problem import AWAY, WINDOW, Problem

_AT_ONCE = 10_000_000
"""Largest number of windows times patches that are compared at once."""


def distances(problem: Problem, labels: Labels) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The nearest patch of the window at each cell, the first of equals, and the number of differing labels (Eq. 2).

    Args:
        problem: the windows and their patches.
        labels: [rows, columns] labels of the grid.

    Returns:
        [rows, columns] nearest patch, and number of differing labels; -1 and 0 for cells without a window.
    """
    nearest = np.full(labels.shape, -1, dtype=np.int64)
    differ = np.zeros(labels.shape, dtype=np.int64)
    ring = np.full((problem.rows + 2, problem.columns + 2), AWAY, dtype=np.int64)
    ring[1:-1, 1:-1] = labels
    for kind, patches in enumerate(problem.patches):
        row, column = np.nonzero(problem.kind == kind)
        turn = max(1, _AT_ONCE // len(patches))
        for start in range(0, len(row), turn):
            place = row[start : start + turn], column[start : start + turn]
            counts = np.zeros((len(place[0]), len(patches)), dtype=np.uint8)
            for up, right in np.ndindex(WINDOW, WINDOW):
                wanted = patches[:, up, right]
                here = ring[place[0] + up, place[1] + right]
                counts += (here[:, None] != wanted) & (wanted != AWAY)
            nearest[place] = counts.argmin(axis=1)
            differ[place] = counts.min(axis=1)
    return nearest, differ


def energy(problem: Problem, labels: Labels) -> int:
    """E(O): number of differing labels, summed over all windows (Eq. 1)."""
    return int(distances(problem, labels)[1].sum())


def votes(problem: Problem, nearest: NDArray[np.int64]) -> NDArray[np.int64]:
    """Number of windows over a cell that have each label there, if each is replaced by its nearest patch.

    Args:
        problem: the windows and their patches.
        nearest: [rows, columns] patch of the window at each cell.

    Returns:
        [rows, columns, labels] counts.
    """
    found = np.zeros((problem.rows + 2, problem.columns + 2, problem.num_labels), dtype=np.int64)
    for kind, patches in enumerate(problem.patches):
        row, column = np.nonzero(problem.kind == kind)
        for up, right in np.ndindex(WINDOW, WINDOW):
            label = patches[nearest[row, column], up, right]
            counted = label != AWAY
            np.add.at(found, (row[counted] + up, column[counted] + right, label[counted]), 1)
    return found[1:-1, 1:-1]
