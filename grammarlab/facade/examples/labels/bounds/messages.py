"""Prices of labels that strips of windows pass on, so that conditions of one border reach the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.bounds.chains import Costs
from grammarlab.facade.examples.labels.bounds.strips import CellWants
from grammarlab.facade.examples.labels.problem import AWAY, WINDOW, Problem

_PART = 0.5
"""Share of its min-marginals that a strip passes on; with all of them, sweeps end at a worse bound."""


def swept(problem: Problem, start: Costs, sweeps: int) -> Costs:
    """Prices with a better bound of the strips: block coordinate ascent, upwards and downwards in turn.

    The price of a label is a strip's min-marginal of a cell, the additional cost if the cell has this label: half of it
    moves to the next strip over the same cell. No step lowers the bound.

    Args:
        problem: the windows and their patches.
        start: [strips, 3, columns, labels] initial prices.
        sweeps: number of sweeps over all strips.

    Returns:
        [strips, 3, columns, labels] prices; their sums over a cell do not change.
    """
    prices = start.copy()
    known: dict[tuple[int, int], _Wants] = {}
    cells: dict[tuple[int, ...], CellWants] = {}
    for sweep in range(sweeps):
        step = 1 if sweep % 2 == 0 else -1
        for row in range(problem.rows)[::step]:
            _Strip(problem, prices, row, known, cells).pass_on(step)
    return prices


@dataclass(frozen=True, slots=True)
class _Wants:
    """Labels that the patches of a list have in one of their columns."""

    label: Labels
    """[3, patches] labels."""
    order: Labels
    """[3, patches] patches sorted by their label."""
    starts: tuple[Labels, ...]
    """By row: first patch of each label in that order."""
    first: tuple[Labels, ...]
    """By row: these labels; one number above the last label means no label."""

    @classmethod
    def of(cls, patches: Labels, column: int, num_labels: int) -> _Wants:
        label = patches[:, :, column].T
        wanted = np.where(label == AWAY, num_labels, label)
        order = np.argsort(wanted, axis=1, kind="stable")
        sorts = [np.unique(each, return_index=True) for each in np.take_along_axis(wanted, order, axis=1)]
        return cls(label, order, tuple(start for _, start in sorts), tuple(label for label, _ in sorts))


class _Strip:
    """One row of windows, at the current prices."""

    def __init__(
        self,
        problem: Problem,
        prices: Costs,
        row: int,
        known: dict[tuple[int, int], _Wants],
        cells: dict[tuple[int, ...], CellWants],
    ) -> None:
        self.problem, self.prices, self.row, self.known, self.cells = problem, prices, row, known, cells
        self.inside = [up for up in range(WINDOW) if 0 <= row + up - 1 < problem.rows]
        differ = np.ones((problem.num_labels, problem.num_labels + 1))
        differ[np.arange(problem.num_labels), np.arange(problem.num_labels)] = 0.0
        differ[:, -1] = 0.0
        self.differ = differ
        """[labels, target labels] 0 for equal labels and for no target label, 1 otherwise."""

    def pass_on(self, step: int) -> None:
        """Moves prices to the strip above (1) or below (-1), cell by cell."""
        columns = self.problem.columns
        costs = [{up: self._cost(column, up) for up in self.inside} for column in range(columns)]
        after = [np.zeros((1, 1))] * columns
        after[-1] = np.zeros((len(self._wanted(columns - 1)[1].label[0]), 1))
        for column in range(columns - 1, 0, -1):
            after[column - 1] = (sum(costs[column].values()) + after[column][None]).min(axis=2)
        before = np.zeros((1, after[0].shape[0]))
        to = self.row + step
        shared = [up for up in (1 + step, 1) if up in self.inside] if 0 <= to < self.problem.rows else []
        for column in range(columns):
            for up in shared:
                others = sum((costs[column][other] for other in self.inside if other != up), np.zeros(()))
                rest = before[:, :, None] + after[column][None] + others
                marginals = self._marginals(rest, column, up)
                moved = _PART * np.where(np.isfinite(marginals), marginals - marginals.min(), 0.0)
                self.prices[self.row, up, column] -= moved
                self.prices[to, up - step, column] += moved
                costs[column][up] = self._cost(column, up)
            before = (before[:, :, None] + sum(costs[column].values())).min(axis=0)

    def _own(self, column: int, up: int) -> Costs:
        """[labels] price of each label of a cell; infinite if it is not allowed."""
        return np.where(self.problem.domain[self.row + up - 1, column], self.prices[self.row, up, column], np.inf)

    def _cost(self, column: int, up: int) -> Costs:
        """[before, here, after] least cost of a cell for given patches of three windows."""
        kinds = [
            int(self.problem.kind[self.row, k]) if 0 <= k < self.problem.columns else -2
            for k in range(column - 1, column + 2)
        ]
        key = (*kinds, up)
        if key not in self.cells:
            self.cells[key] = CellWants.of([wants.label[up][None] for wants in self._wanted(column)])
        return self.cells[key].costs(self._own(column, up)[None].astype(np.float32))[0].astype(np.float64)

    def _marginals(self, rest: Costs, column: int, up: int) -> Costs:
        """[labels] least cost of the strip for each label of a cell; `rest` is that of all other cells."""
        wanted = self._wanted(column)
        sorts = rest[np.ix_(*(wants.order[up] for wants in wanted))]
        for axis, wants in enumerate(wanted):
            sorts = np.minimum.reduceat(sorts, wants.starts[up], axis=axis)
        left, middle, right = (self.differ[:, wants.first[up]] for wants in wanted)
        differ = left[:, :, None, None] + middle[:, None, :, None] + right[:, None, None, :]
        return (sorts + differ).min(axis=(1, 2, 3)) + self._own(column, up)

    def _wanted(self, column: int) -> tuple[_Wants, _Wants, _Wants]:
        """Labels of the patches of the windows before, at and after a column, in its cells."""
        return self._of(column - 1, 2), self._of(column, 1), self._of(column + 1, 0)

    def _of(self, column: int, side: int) -> _Wants:
        """Labels of the patches of a window in one of their columns; none outside of the grid."""
        kind = int(self.problem.kind[self.row, column]) if 0 <= column < self.problem.columns else -1
        if (kind, side) not in self.known:
            patches = self.problem.patches[kind] if kind >= 0 else np.full((1, WINDOW, WINDOW), AWAY)
            self.known[kind, side] = _Wants.of(patches, side, self.problem.num_labels)
        return self.known[kind, side]
