"""Independent rows of windows: their least energies, over all labels of the three rows that each covers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.bounds.chains import Costs
from grammarlab.facade.examples.labels.problem import AWAY, WINDOW, Problem

_PAIRS = ((0, 1), (0, 2), (1, 2))
_Kind = TypeVar("_Kind", bound=np.generic)


@dataclass(frozen=True, slots=True)
class WindowStrips:
    """Rows of windows of a problem."""

    problem: Problem
    rows: NDArray[np.int64]
    """[strips] row of the centres of each strip."""
    wants: Labels
    """[strips, columns + 2, patches, 3, 3] labels of the patches of each window; the places before and after have no
    labels, and the first patch is repeated in windows with fewer patches."""
    allowed: NDArray[np.bool_]
    """[strips, 3, columns, labels] labels that the cells may have."""
    inside: NDArray[np.bool_]
    """[strips, 3] whether each row of a strip is in the grid."""
    known: dict[bytes, list[CellWants]] = field(default_factory=dict)
    """Cached tables from `wants`."""

    @classmethod
    def of(cls, problem: Problem, rows: Sequence[int]) -> WindowStrips:
        most = max(len(patches) for patches in problem.patches)
        filled = [patches[np.arange(most) % len(patches)] for patches in problem.patches]
        filled.append(np.full((most, WINDOW, WINDOW), AWAY, dtype=np.int64))
        chosen = np.asarray(rows, dtype=np.int64)
        kinds = np.full((len(chosen), problem.columns + 2), -1, dtype=np.int64)
        kinds[:, 1:-1] = problem.kind[chosen]
        around = chosen[:, None] + np.arange(-1, 2)
        inside = (around >= 0) & (around < problem.rows)
        allowed = problem.domain[np.clip(around, 0, problem.rows - 1)]
        return cls(problem, chosen, np.array(filled)[kinds], allowed, inside)

    def least(self, prices: Costs) -> tuple[Costs, Labels]:
        """The least energy of each strip, and its labels.

        The chain is of patches: three consecutive patches determine the best label of each cell between them. The
        result is exact.

        Args:
            prices: [strips, 3, columns, labels] added for each label of each cell.

        Returns:
            energies [strips] and labels [strips, 3, columns]; -1 outside of the grid.
        """
        own = np.where(self.allowed, prices, np.inf)
        own[~self.inside] = 0.0
        size = self.wants.shape[2]
        value = np.zeros((len(self.rows), 1, size))
        choices = []
        columns = self.problem.columns
        for column in range(columns):
            through = value[:, :, :, None] + self._cost(own, column)
            choice = through.argmin(axis=1)
            value = np.take_along_axis(through, choice[:, None], axis=1)[:, 0]
            choices.append(choice)
        # The place after the last column has one state; so has the one before the first.
        last = value[:, :, 0]
        place = np.arange(len(self.rows))
        after, here = np.zeros(len(self.rows), dtype=np.int64), last.argmin(axis=1)
        energies = last[place, here]
        labels = np.empty((len(self.rows), WINDOW, columns), dtype=np.int64)
        for column in range(columns - 1, -1, -1):
            before = choices[column][place, here, after]
            labels[:, :, column] = self._labels(own, column, (before, here, after))
            here, after = before, here
        labels[~self.inside] = -1
        return energies, labels

    def _wanted(self, column: int) -> tuple[Labels, Labels, Labels]:
        """[strips, states, 3 rows] labels of the patches of the windows before, at and after a column, in its cells."""
        before, here, after = (self.wants[:, column + step] for step in range(3))
        before = before[:, :1] if column == 0 else before
        after = after[:, :1] if column == self.problem.columns - 1 else after
        return before[..., 2], here[..., 1], after[..., 0]

    def _cost(self, own: Costs, column: int) -> NDArray[np.float32]:
        """[strips, before, here, after] least cost of the cells of a column for given patches of three windows."""
        wants = self._cells(column)
        total = wants[0].costs(own[:, 0, column].astype(np.float32))
        for row in range(1, WINDOW):
            total += wants[row].costs(own[:, row, column].astype(np.float32))
        return total

    def _cells(self, column: int) -> list[CellWants]:
        """Target labels of the three cells of each strip in a column; columns with equal neighbours share them."""
        kinds = self.problem.kind[self.rows]
        key = kinds[:, max(0, column - 1) : column + 2].tobytes() + bytes([column == 0])
        if key not in self.known:
            wanted = self._wanted(column)
            self.known[key] = [CellWants.of([each[:, :, row] for each in wanted]) for row in range(WINDOW)]
        return self.known[key]

    def _labels(self, own: Costs, column: int, states: Sequence[NDArray[np.int64]]) -> Labels:
        """[strips, 3] the best label of each cell of a column for given patches of three windows."""
        place = np.arange(len(self.rows))
        cost = own[:, :, column].copy()
        for wanted, state in zip(self._wanted(column), states, strict=True):
            want = wanted[place, state][:, :, None]
            cost += (np.arange(cost.shape[2]) != want) & (want != AWAY)
        return cost.argmin(axis=2)


@dataclass(frozen=True, slots=True)
class CellWants:
    """Labels of a cell in the patches of the windows before, at and after it: all data that do not depend on prices."""

    wanted: tuple[Labels, ...]
    """Three arrays [strips, states]."""
    others: tuple[NDArray[np.float32], ...]
    """For each of the three: [strips, before, here, after] how many of the three have the same label."""
    number: NDArray[np.float32]
    """[strips, before, here, after] how many have a label."""

    @classmethod
    def of(cls, wanted: Sequence[Labels]) -> CellWants:
        wants = [_axis(each, axis) for axis, each in enumerate(wanted)]
        agree = [(wants[one] == wants[other]).astype(np.float32) for one, other in _PAIRS]
        others = []
        for axis in range(WINDOW):
            one, other = (pair for pair, both in zip(agree, _PAIRS, strict=True) if axis in both)
            others.append(one + other + np.float32(1.0))
        number = sum(((want != AWAY).astype(np.float32) for want in wants), np.zeros((1, 1, 1, 1), np.float32))
        return cls(tuple(wanted), tuple(others), number)

    def costs(self, prices: NDArray[np.float32]) -> NDArray[np.float32]:
        """[strips, before, here, after] least cost of the cell: a label's price plus 1 for each window that differs.

        Args:
            prices: [strips, labels] prices of its labels.
        """
        strips = np.arange(len(prices))[:, None]
        least = prices.min(axis=1)[:, None, None, None]
        wished = [
            np.where(want != AWAY, prices[strips, np.maximum(want, 0)], np.float32(np.inf)) for want in self.wanted
        ]
        best, middle, after = (
            _axis(price, axis) - others for axis, (price, others) in enumerate(zip(wished, self.others, strict=True))
        )
        for found in (middle, after, least):
            np.minimum(best, found, out=best)
        best += self.number
        return best


def _axis(values: NDArray[_Kind], axis: int) -> NDArray[_Kind]:
    """[strips, states] along one of the three axes of states."""
    shape = [len(values), 1, 1, 1]
    shape[axis + 1] = values.shape[1]
    return values.reshape(shape)
