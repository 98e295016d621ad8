"""Grids of whole columns: the best choice among candidates, exactly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.bounds.chains import Costs, SequenceTally, cheapest
from grammarlab.facade.examples.labels.bounds.folding import cheapest_palindrome
from grammarlab.facade.examples.labels.problem import AWAY, WINDOW, Problem

_LARGEST = 2e8
"""Largest number of additions for all windows at one column."""
_STRAY = 10.0
"""Cost of a cell with a forbidden label: more than its 9 windows can gain by it."""


def best_columns(
    problem: Problem,
    candidates: Labels,
    noise: Costs,
    limits: Sequence[tuple[int, int, int]] = (),
    symmetric: bool = False,
) -> NDArray[np.int64]:
    """The grid of least energy whose columns are all candidates.

    Args:
        problem: the windows and their patches.
        candidates: [states, rows] columns.
        noise: [rows, columns, labels] added to the energy, to choose among equal grids.
        limits: label, least and largest count; ignored if there is no such grid.
        symmetric: whether the columns form a palindrome.

    Returns:
        [columns] index of the candidate of each column.
    """
    rows = np.arange(problem.rows)
    extra = noise + _STRAY * ~problem.domain
    own = list(extra[rows[None, :], :, candidates].sum(axis=1).T)  # [columns][states]
    known: dict[tuple[int, ...], Costs] = {}
    costs = []
    for column in range(problem.columns):
        kinds = tuple(problem.kind[:, column].tolist())
        if kinds not in known:
            known[kinds] = _triplets(problem, candidates, kinds)
        found = known[kinds]
        found = found if column else found[:1]
        costs.append(found if column + 1 < problem.columns else found[:, :, :1])
    solve = cheapest_palindrome if symmetric else cheapest
    if limits:
        weight = np.stack([(candidates == label).sum(axis=1) for label, _, _ in limits], axis=1)
        tally = SequenceTally((weight,) * problem.columns, tuple(at[1] for at in limits), tuple(at[2] for at in limits))
        chain = solve(costs, own, tally)
        if np.isfinite(chain.cost):
            return chain.states
    return solve(costs, own).states


def suits(problem: Problem, candidates: Labels) -> bool:
    """Whether there are few enough candidates."""
    most = max(len(patches) for patches in problem.patches)
    return float(len(candidates)) ** 3 * most * problem.rows <= _LARGEST


def _triplets(problem: Problem, candidates: Labels, kinds: tuple[int, ...]) -> Costs:
    """[states, states, states] energy of the windows at a column, by the states of the column and its neighbours."""
    size = len(candidates)
    ring = np.full((size, problem.rows + 2), AWAY, dtype=np.int64)
    ring[:, 1:-1] = candidates
    total = np.zeros((size, size, size), dtype=np.float32)
    for row, kind in enumerate(kinds):
        if kind < 0:
            continue
        patches = problem.patches[kind]
        here = ring[:, row : row + WINDOW]  # [states, 3]
        counts = np.zeros((WINDOW, size, len(patches)), dtype=np.uint8)
        for up, right in np.ndindex(WINDOW, WINDOW):
            wanted = patches[:, up, right]
            counts[right] += (here[:, up, None] != wanted) & (wanted != AWAY)
        left, middle, right = counts
        nearest = np.full((size, size, size), 255, dtype=np.uint8)
        for patch in range(len(patches)):
            pair = left[:, None, patch] + middle[None, :, patch]
            np.minimum(nearest, pair[:, :, None] + right[None, None, :, patch], out=nearest)
        total += nearest
    return total.astype(np.float64)
