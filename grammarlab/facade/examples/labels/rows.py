"""One row of a grid chosen anew, exactly, while the others stay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.chains import Costs, cheapest
from grammarlab.facade.examples.labels.folding import cheapest_palindrome
from grammarlab.facade.examples.labels.problem import AWAY, WINDOW, Problem


@dataclass(frozen=True, slots=True)
class RowWindows:
    """The patches of a problem by cell."""

    problem: Problem
    patches: NDArray[np.int64]
    """[rows, columns, patches, 3, 3]; the first patch again where a cell has fewer than others."""

    @classmethod
    def of(cls, problem: Problem) -> RowWindows:
        most = max(len(patches) for patches in problem.patches)
        filled = [patches[np.arange(most) % len(patches)] for patches in problem.patches]
        filled.append(np.full((most, WINDOW, WINDOW), AWAY, dtype=np.int64))  # where there is no window
        return cls(problem, np.array(filled)[problem.kind])

    @property
    def work(self) -> float:
        """Sums that one row takes, about."""
        columns, most = self.patches.shape[1:3]
        return 3.0 * columns * most * self.problem.num_labels**3

    def best_row(self, labels: Labels, row: int, domain: NDArray[np.bool_], noise: Costs, symmetric: bool) -> Labels:
        """The labels [columns] of a row that make the energy least when all other rows stay.

        Args:
            labels: [rows, columns] the grid.
            row: which row.
            domain: [columns, labels] labels that its cells may have.
            noise: [columns, labels] added to the energy, to choose among equals.
            symmetric: it reads the same from both sides.
        """
        states = np.flatnonzero(domain.any(axis=0))
        columns = self.problem.columns
        ring = np.full((self.problem.rows + 2, columns + 2), AWAY, dtype=np.int64)
        ring[1:-1, 1:-1] = labels
        total = np.zeros((columns, len(states), len(states), len(states)))
        for centre in range(max(0, row - 1), min(self.problem.rows, row + 2)):
            total += self._centred(ring, centre, row - centre + 1, states)
        costs = list(total)
        costs[0], costs[-1] = costs[0][:1], costs[-1][:, :, :1]
        if columns == 1:
            costs[0] = costs[0][:, :, :1]
        own = list(np.where(domain[:, states], noise[:, states], np.inf))
        chain = (cheapest_palindrome if symmetric else cheapest)(costs, own)
        return states[chain.states]

    def _centred(self, ring: Labels, centre: int, free: int, states: Labels) -> Costs:
        """[columns, states, states, states] energy of the windows about one row, of labels in row `free` of theirs."""
        patches = self.patches[centre]  # [columns, patches, 3, 3]
        columns, most = patches.shape[:2]
        known = np.zeros((columns, most), dtype=np.uint8)
        place = np.arange(columns)
        for up, right in np.ndindex(WINDOW, WINDOW):
            if up != free:
                wanted = patches[:, :, up, right]
                known += (ring[centre + up, place + right][:, None] != wanted) & (wanted != AWAY)
        wanted = patches[:, :, free, :, None]
        differ = ((wanted != states) & (wanted != AWAY)).astype(np.uint8)  # [columns, patches, 3, states]
        left = known[:, :, None] + differ[:, :, 0]
        pair = left[:, :, :, None] + differ[:, :, 1][:, :, None, :]
        return (pair[..., None] + differ[:, :, 2][:, :, None, None, :]).min(axis=1).astype(np.float64)
