"""Energy of a grid, and which patch each of its windows is nearest to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.problem import AWAY, WINDOW, Problem

_AT_ONCE = 10_000_000
"""Windows times patches that are compared at once."""


def distances(problem: Problem, labels: Labels) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Of the window about each cell the nearest patch, the first of equals, and how many labels differ (Eq. 2).

    Args:
        problem: what windows are compared with.
        labels: [rows, columns].

    Returns:
        nearest patch [rows, columns] and labels that differ [rows, columns]; -1 and 0 where there is no window.
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
    """E(O): labels that differ, over all windows (Eq. 1)."""
    return int(distances(problem, labels)[1].sum())


def votes(problem: Problem, nearest: NDArray[np.int64]) -> NDArray[np.int64]:
    """How many windows over a cell have each label there, when each is the patch it is nearest to.

    Args:
        problem: what windows are compared with.
        nearest: [rows, columns] patch of the window about each cell.

    Returns:
        [rows, columns, labels]
    """
    found = np.zeros((problem.rows + 2, problem.columns + 2, problem.num_labels), dtype=np.int64)
    for kind, patches in enumerate(problem.patches):
        row, column = np.nonzero(problem.kind == kind)
        for up, right in np.ndindex(WINDOW, WINDOW):
            label = patches[nearest[row, column], up, right]
            counted = label != AWAY
            np.add.at(found, (row[counted] + up, column[counted] + right, label[counted]), 1)
    return found[1:-1, 1:-1]
