"""One row of a grid chosen anew, exactly, while the others stay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.bounds.chains import Costs, cheapest
from grammarlab.facade.examples.labels.bounds.folding import cheapest_palindrome
from grammarlab.facade.examples.labels.energy import distances, votes
from grammarlab.facade.examples.labels.problem import AWAY, WINDOW, Problem

_LARGEST = 3e6
"""Sums of a row at most: where labels and patches make more, a cell has only the labels that most windows want."""


@dataclass(frozen=True, slots=True)
class RowWindows:
    """The patches of a problem, padded."""

    problem: Problem
    patches: NDArray[np.int64]
    """[kinds + 1, patches, 3, 3]; the first patch again where a kind has fewer than others; the last kind wants
    nothing."""

    @classmethod
    def of(cls, problem: Problem) -> RowWindows:
        most = max(len(patches) for patches in problem.patches)
        filled = [patches[np.arange(most) % len(patches)] for patches in problem.patches]
        filled.append(np.full((most, WINDOW, WINDOW), AWAY, dtype=np.int64))
        return cls(problem, np.array(filled))

    @property
    def work(self) -> float:
        """Sums that one row takes, about."""
        return self._sums * float(self._most**3)

    @property
    def _sums(self) -> float:
        return 3.0 * self.problem.columns * self.patches.shape[1]

    @property
    def _most(self) -> int:
        """Labels that a cell may choose from."""
        return max(2, min(self.problem.num_labels, int((_LARGEST / self._sums) ** (1 / 3))))

    def best_row(self, labels: Labels, row: int, domain: NDArray[np.bool_], noise: Costs, symmetric: bool) -> Labels:
        """The labels [columns] of a row that make the energy least when all other rows stay.

        Args:
            labels: [rows, columns] the grid.
            row: which row.
            domain: [columns, labels] labels that its cells may have.
            noise: [columns, labels] added to the energy, to choose among equals.
            symmetric: it reads the same from both sides.
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
        place = np.arange(columns)[:, None]
        own = list(np.where(domain[place, states], noise[place, states], np.inf))
        chain = (cheapest_palindrome if symmetric else cheapest)(costs, own)
        return states[place[:, 0], chain.states]

    def _states(self, labels: Labels, row: int, domain: NDArray[np.bool_], symmetric: bool) -> Labels:
        """[columns, states] labels that each cell chooses from: all that it may have, if they are not too many."""
        able = np.flatnonzero(domain.any(axis=0))
        if len(able) <= self._most:
            return np.broadcast_to(able, (self.problem.columns, len(able)))
        wanted = votes(self.problem, distances(self.problem, labels)[0])[row]
        wanted[np.arange(self.problem.columns), labels[row]] += 1
        if symmetric:
            wanted = wanted + wanted[::-1]
        return np.argsort(np.where(domain, -wanted, 1), axis=1, kind="stable")[:, : self._most]

    def _centred(self, ring: Labels, centre: int, free: int, states: Labels) -> Costs:
        """[columns, states, states, states] energy of the windows about one row, of labels in row `free` of theirs."""
        patches = self.patches[self.problem.kind[centre]]  # [columns, patches, 3, 3]
        columns, most = patches.shape[:2]
        known = np.zeros((columns, most), dtype=np.uint8)
        place = np.arange(columns)
        for up, right in np.ndindex(WINDOW, WINDOW):
            if up != free:
                wanted = patches[:, :, up, right]
                known += (ring[centre + up, place + right][:, None] != wanted) & (wanted != AWAY)
        wanted = patches[:, :, free, :, None]  # [columns, patches, 3, 1]
        beside = np.clip(place[:, None] + np.arange(-1, 2), 0, columns - 1)  # beyond a border nothing is wanted
        differ = ((wanted != states[beside][:, None]) & (wanted != AWAY)).astype(np.uint8)
        differ = np.ascontiguousarray(differ.transpose(1, 2, 0, 3))  # [patches, 3, columns, states]
        left = known.T[:, :, None] + differ[:, 0]
        size = states.shape[1]
        least = np.full((columns, size, size, size), 255, dtype=np.uint8)
        total = np.empty_like(least)
        for here, (_, middle, right) in zip(left, differ, strict=True):
            pair = here[:, :, None] + middle[:, None, :]
            np.add(pair[..., None], right[:, None, None, :], out=total)
            np.minimum(least, total, out=least)
        return least.astype(np.float64)
