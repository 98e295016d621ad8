"""Lines of a grid chosen exactly: one row with the other rows fixed, or all columns among candidates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grammarlab.synthesis.label_grid import Labels
from grammarlab.synthesis.labels.problem import AWAY, WINDOW, Problem, distances, votes
from grammarlab.synthesis.labels.strips import Costs, SequenceTally, cheapest, cheapest_palindrome

_MAX_COLUMN_ADDITIONS = 2e8
"""Largest number of additions for all windows at one column."""
_FORBIDDEN_COST = 10.0
"""Cost of a cell with a forbidden label: more than its 9 windows can gain by it."""
_MAX_ROW_ADDITIONS = 3e6
"""Largest number of additions for a row: beyond it, a cell only has the labels that most windows have there."""
_MISMATCH_LIMIT = 100
"""A number of labels above that of any window."""


@dataclass(frozen=True, slots=True)
class RowWindows:
    """The patches of a problem, padded."""

    problem: Problem
    patches: NDArray[np.int64]
    """[kinds + 1, patches, 3, 3] as in `Problem.padded_patches`."""
    cache: dict[tuple[int, int, bytes], tuple[Labels, ...]] = field(default_factory=dict)
    """Cached states of the patches of a row whose cells all have the same labels."""

    @classmethod
    def from_problem(cls, problem: Problem) -> RowWindows:
        return cls(problem, problem.padded_patches)

    @property
    def work(self) -> float:
        """Approximate number of additions for one row."""
        return self._sums * float(self._most**3)

    @property
    def _sums(self) -> float:
        return 3.0 * self.problem.columns * self.patches.shape[1]

    @property
    def _most(self) -> int:
        """Largest number of labels of a cell."""
        return max(2, min(self.problem.num_labels, int((_MAX_ROW_ADDITIONS / self._sums) ** (1 / 3))))

    def best_row(self, labels: Labels, row: int, domain: NDArray[np.bool_], noise: Costs, symmetric: bool) -> Labels:
        """The labels [columns] of a row with the least energy for fixed other rows.

        Args:
            labels: [rows, columns] labels of the grid.
            row: index of the row.
            domain: [columns, labels] whether its cells may have each label.
            noise: [columns, labels] added to the energy, to choose among equal rows.
            symmetric: whether the row must be a palindrome.
        """
        states = self._states(labels, row, domain, symmetric)
        columns = self.problem.columns
        ring = np.full((self.problem.rows + 2, columns + 2), AWAY, dtype=np.int64)
        ring[1:-1, 1:-1] = labels
        size = states.shape[1]
        total = np.zeros((columns, size, size, size))
        for centre in range(max(0, row - 1), min(self.problem.rows, row + 2)):
            total += self._centred(ring, centre, row - centre + 1, states)
        costs: list[Costs] = [*total]
        costs[0] = costs[0][:1]
        costs[-1] = costs[-1][:, :, :1]
        index = np.arange(columns)[:, None]
        state_costs = list(np.where(domain[index, states], noise[index, states], np.inf))
        chain = (cheapest_palindrome if symmetric else cheapest)(costs, state_costs)
        return states[index[:, 0], chain.states]

    def _states(self, labels: Labels, row: int, domain: NDArray[np.bool_], symmetric: bool) -> Labels:
        """[columns, states] labels of each cell: all allowed ones, if they are not too many."""
        able = np.flatnonzero(domain.any(axis=0))
        if len(able) <= self._most:
            return np.broadcast_to(able, (self.problem.columns, len(able)))
        scores = votes(self.problem, distances(self.problem, labels)[0])[row]
        scores[np.arange(self.problem.columns), labels[row]] += 1
        if symmetric:
            scores = scores + scores[::-1]
        return np.argsort(np.where(domain, -scores, 1), axis=1, kind="stable")[:, : self._most]

    def _centred(self, ring: Labels, centre: int, free: int, states: Labels) -> Costs:
        """[columns, states, states, states] energy of the windows centred in one row, by labels in their row `free`."""
        patches = self.patches[self.problem.kind[centre]]  # [columns, patches, 3, 3]
        columns, most = patches.shape[:2]
        mismatches = np.zeros((columns, most), dtype=np.uint8)
        index = np.arange(columns)
        for up, right in np.ndindex(WINDOW, WINDOW):
            if up != free:
                target = patches[:, :, up, right]
                mismatches += (ring[centre + up, index + right][:, None] != target) & (target != AWAY)
        size = states.shape[1]
        least = np.full((columns, *(size + 2,) * WINDOW), _MISMATCH_LIMIT, dtype=np.uint8)
        np.minimum.at(
            least, (index[:, None], *self._target_states(patches[:, :, free], centre, free, states)), mismatches
        )
        # A label that differs from the patch costs 1, whichever it is: one axis after the other.
        for axis in range(1, 1 + WINDOW):
            before = (slice(None),) * axis
            other = np.minimum(least.min(axis=axis) + np.uint8(1), least[*before, size])
            least = np.minimum(least[*before, :size], np.expand_dims(other, axis))
        return least.astype(np.float64)

    def _target_states(self, targets: Labels, centre: int, free: int, states: Labels) -> tuple[Labels, ...]:
        """Three of [columns, patches] state of a patch's label; `size` for any label, `size` + 1 for an unlisted one.

        Args:
            targets: [columns, patches, 3] labels, or `AWAY`.
            centre: row of the windows' centres.
            free: index in the windows of the row to choose.
            states: [columns, size] labels that each cell may have.
        """
        key = (centre, free, states[0].tobytes())
        is_uniform = (states == states[0]).all()
        if is_uniform and key in self.cache:
            return self.cache[key]
        columns, size = states.shape
        neighbours = np.clip(np.arange(columns)[:, None] + np.arange(-1, 2), 0, columns - 1)
        equal = targets[..., None] == states[neighbours][:, None]  # no labels beyond a border
        target_states = np.where(equal.any(axis=3), equal.argmax(axis=3), size + 1)
        target_states[targets == AWAY] = size
        result = tuple(np.ascontiguousarray(target_states[..., step]) for step in range(WINDOW))
        if is_uniform:
            self.cache[key] = result
        return result


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
    extra = noise + _FORBIDDEN_COST * ~problem.domain
    state_costs = list(extra[rows[None, :], :, candidates].sum(axis=1).T)  # [columns][states]
    cache: dict[tuple[int, ...], Costs] = {}
    costs = []
    for column in range(problem.columns):
        kinds = tuple(problem.kind[:, column].tolist())
        if kinds not in cache:
            cache[kinds] = _triplets(problem, candidates, kinds)
        triplets = cache[kinds]
        triplets = triplets if column else triplets[:1]
        costs.append(triplets if column + 1 < problem.columns else triplets[:, :, :1])
    solve = cheapest_palindrome if symmetric else cheapest
    if limits:
        weight = np.stack([(candidates == label).sum(axis=1) for label, _, _ in limits], axis=1)
        tally = SequenceTally(
            (weight,) * problem.columns, tuple(limit[1] for limit in limits), tuple(limit[2] for limit in limits)
        )
        chain = solve(costs, state_costs, tally)
        if np.isfinite(chain.cost):
            return chain.states
    return solve(costs, state_costs).states


def suits(problem: Problem, candidates: Labels) -> bool:
    """Whether there are few enough candidates."""
    most = max(len(patches) for patches in problem.patches)
    return float(len(candidates)) ** 3 * most * problem.rows <= _MAX_COLUMN_ADDITIONS


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
            target = patches[:, up, right]
            counts[right] += (here[:, up, None] != target) & (target != AWAY)
        before, between, after = counts
        nearest = np.full((size, size, size), 255, dtype=np.uint8)
        for patch in range(len(patches)):
            pair = before[:, None, patch] + between[None, :, patch]
            np.minimum(nearest, pair[:, :, None] + after[None, None, :, patch], out=nearest)
        total += nearest
    return total.astype(np.float64)
