"""Lower bounds of the energy: strips that choose labels independently, with prices that make them agree.

Strips also pass prices on to the next one, so that conditions of one border reach the other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from grammarlab.synthesis.label_grid import Labels
from grammarlab.synthesis.labels.demands import LabelDemands
from grammarlab.synthesis.labels.problem import AWAY, WINDOW, Problem
from grammarlab.synthesis.labels.strips import CellTargets, Costs, WindowStrips

_MESSAGE_SHARE = 0.5
"""Share of its min-marginals that a strip passes on; with all of them, sweeps end at a worse bound."""
_ROUNDING = 0.01
"""Largest rounding error of a bound; it is subtracted before a bound is rounded up to an integer energy."""
_MAX_ADDITIONS = 1e8
"""Largest number of additions to solve all different strips."""
_MAX_IDLE_STEPS = 3
"""Steps without a better bound before steps become smaller."""
_STEP_FACTOR = 0.7
"""Factor on the step size after `_MAX_IDLE_STEPS` steps without a better bound."""


@dataclass
class Dual:
    """Prices by subgradient steps (Lagrangian decomposition): the sum of the strips' energies bounds the grid's."""

    problem: Problem
    demands: LabelDemands
    bound: float = -np.inf

    def __post_init__(self) -> None:
        self.strips = WindowStrips.from_problem(self.problem, range(self.problem.rows))
        self.prices = np.zeros((self.problem.rows, WINDOW, self.problem.columns, self.problem.num_labels))
        self.tolls: Costs = np.zeros(len(self.demands.counts))
        self.copies = self._gathered(self.strips.inside[:, :, None].repeat(self.problem.columns, axis=2).astype(float))

    @property
    def integer_bound(self) -> int:
        """The bound, rounded up to an integer."""
        return ceil(self.bound - _ROUNDING) if np.isfinite(self.bound) else 0

    def sweep(self, sweeps: int) -> None:
        """Improves the prices by message passing between strips."""
        tolls = self._tolls()
        self.prices = swept(self.problem, self.prices + tolls, sweeps) - tolls

    def steps(self, target: float, most: int) -> Iterator[Labels]:
        """Improves the bound; yields after each step the labels that most strips choose.

        Args:
            target: energy of a known grid; steps become small as the bound approaches it.
            most: largest number of steps.
        """
        scale, waited = 1.0, 0
        for _ in range(most):
            value, slopes, toll_slopes, labels = self._evaluated()
            waited = 0 if value > self.bound + 1e-6 else waited + 1
            self.bound = max(self.bound, value)
            yield labels
            if waited >= _MAX_IDLE_STEPS:
                scale, waited = scale * _STEP_FACTOR, 0
            norm = float((slopes**2).sum() + (toll_slopes**2).sum())
            if norm < 1e-9 or target <= self.integer_bound:
                return
            step = scale * max(target - value, 1e-3) / norm
            self.prices += step * slopes
            self.tolls += step * toll_slopes

    def _evaluated(self) -> tuple[float, Costs, Costs, Labels]:
        """The bound at these prices, its subgradients by prices and tolls, and the labels that most strips choose."""
        energies, labels = self.strips.least(self.prices + self._tolls())
        chosen = (labels[..., None] == np.arange(self.problem.num_labels)).astype(float)
        mean = self._gathered(chosen) / self.copies[..., None]
        if self.demands.symmetric:
            mean = (mean + mean[:, ::-1]) / 2
        slopes = chosen - self._spread(mean)
        slopes[~self.strips.inside] = 0.0
        value = float(energies.sum())
        toll_slopes = np.zeros(len(self.tolls))
        for index, (label, least, most) in enumerate(self.demands.counts):
            toll = float(self.tolls[index])
            count = float(mean[..., label].sum())
            target = most if toll > 0 else least if toll < 0 else min(max(count, least), most)
            value -= toll * target
            toll_slopes[index] = count - target
        return value, slopes, toll_slopes, mean.argmax(axis=2)

    def _tolls(self) -> Costs:
        """[strips, 3, columns, labels] additional cost of each counted label."""
        costs = np.zeros_like(self.prices)
        share = self._spread(1.0 / self.copies)
        for (label, _, _), toll in zip(self.demands.counts, self.tolls, strict=True):
            costs[..., label] += toll * share
        return costs

    def _gathered(self, values: NDArray[np.float64]) -> Costs:
        """[rows, columns, ...] sums over the strips that cover a cell, of [strips, 3, columns, ...]."""
        rows = self.problem.rows
        total = np.zeros((rows + 2, *values.shape[2:]))
        for step in range(WINDOW):
            total[step : step + rows] += values[:, step]
        return total[1:-1]

    def _spread(self, values: NDArray[np.float64]) -> Costs:
        """[strips, 3, columns, ...] of [rows, columns, ...]: each strip's part; 0 outside of the grid."""
        rows = self.problem.rows
        ring = np.zeros((rows + 2, *values.shape[1:]))
        ring[1:-1] = values
        return np.stack([ring[step : step + rows] for step in range(WINDOW)], axis=1)


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
    cache: dict[tuple[int, int], _ColumnTargets] = {}
    cells: dict[tuple[int, ...], CellTargets] = {}
    for sweep in range(sweeps):
        step = 1 if sweep % 2 == 0 else -1
        for row in range(problem.rows)[::step]:
            _Strip(problem, prices, row, cache, cells).pass_on(step)
    return prices


def strips_alone(problem: Problem) -> int:
    """Lower bound of the energy of every grid: the sum of the independent optima of all strips.

    Equal strips are solved once. The bound is 0 if it would take too long.
    """
    first: dict[bytes, int] = {}
    same = []
    for row in range(problem.rows):
        around = problem.domain[max(0, row - 1) : row + 2]
        key = problem.kind[row].tobytes() + around.tobytes() + bytes([row == 0, row == problem.rows - 1])
        same.append(first.setdefault(key, row))
    if least_work(problem) * len(first) / problem.rows > _MAX_ADDITIONS:
        return 0
    strips = WindowStrips.from_problem(problem, list(first.values()))
    shape = (len(first), WINDOW, problem.columns, problem.num_labels)
    energies = dict(zip(first.values(), strips.least(np.zeros(shape))[0].tolist(), strict=True))
    return ceil(sum(energies[row] for row in same) - _ROUNDING)


def least_work(problem: Problem) -> float:
    """Additions for one bound: for three rows of all strips, three consecutive patches at every column."""
    most = max(len(patches) for patches in problem.patches)
    return float(most) ** 3 * problem.rows * problem.columns * WINDOW


@dataclass(frozen=True, slots=True)
class _ColumnTargets:
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
    def from_patches(cls, patches: Labels, column: int, num_labels: int) -> _ColumnTargets:
        label = patches[:, :, column].T
        padded = np.where(label == AWAY, num_labels, label)
        order = np.argsort(padded, axis=1, kind="stable")
        sorts = [np.unique(row, return_index=True) for row in np.take_along_axis(padded, order, axis=1)]
        return cls(label, order, tuple(start for _, start in sorts), tuple(label for label, _ in sorts))


class _Strip:
    """One row of windows, at the current prices."""

    def __init__(
        self,
        problem: Problem,
        prices: Costs,
        row: int,
        cache: dict[tuple[int, int], _ColumnTargets],
        cells: dict[tuple[int, ...], CellTargets],
    ) -> None:
        self.problem, self.prices, self.row, self.cache, self.cells = problem, prices, row, cache, cells
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
        after[-1] = np.zeros((len(self._targets(columns - 1)[1].label[0]), 1))
        for column in range(columns - 1, 0, -1):
            after[column - 1] = (sum(costs[column].values()) + after[column][None]).min(axis=2)
        before = np.zeros((1, after[0].shape[0]))
        next_row = self.row + step
        shared = [up for up in (1 + step, 1) if up in self.inside] if 0 <= next_row < self.problem.rows else []
        for column in range(columns):
            for up in shared:
                others = sum((costs[column][other] for other in self.inside if other != up), np.zeros(()))
                rest = before[:, :, None] + after[column][None] + others
                marginals = self._marginals(rest, column, up)
                moved = _MESSAGE_SHARE * np.where(np.isfinite(marginals), marginals - marginals.min(), 0.0)
                self.prices[self.row, up, column] -= moved
                self.prices[next_row, up - step, column] += moved
                costs[column][up] = self._cost(column, up)
            before = (before[:, :, None] + sum(costs[column].values())).min(axis=0)

    def _label_prices(self, column: int, up: int) -> Costs:
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
            self.cells[key] = CellTargets.from_targets([target.label[up][None] for target in self._targets(column)])
        return self.cells[key].costs(self._label_prices(column, up)[None].astype(np.float32))[0].astype(np.float64)

    def _marginals(self, rest: Costs, column: int, up: int) -> Costs:
        """[labels] least cost of the strip for each label of a cell; `rest` is that of all other cells."""
        targets = self._targets(column)
        sorts = rest[np.ix_(*(target.order[up] for target in targets))]
        for axis, target in enumerate(targets):
            sorts = np.minimum.reduceat(sorts, target.starts[up], axis=axis)
        before, here, after = (self.differ[:, target.first[up]] for target in targets)
        differ = before[:, :, None, None] + here[:, None, :, None] + after[:, None, None, :]
        return (sorts + differ).min(axis=(1, 2, 3)) + self._label_prices(column, up)

    def _targets(self, column: int) -> tuple[_ColumnTargets, _ColumnTargets, _ColumnTargets]:
        """Labels of the patches of the windows before, at and after a column, in its cells."""
        return self._column_targets(column - 1, 2), self._column_targets(column, 1), self._column_targets(column + 1, 0)

    def _column_targets(self, column: int, side: int) -> _ColumnTargets:
        """Labels of the patches of a window in one of their columns; none outside of the grid."""
        kind = int(self.problem.kind[self.row, column]) if 0 <= column < self.problem.columns else -1
        if (kind, side) not in self.cache:
            patches = self.problem.patches[kind] if kind >= 0 else np.full((1, WINDOW, WINDOW), AWAY)
            self.cache[kind, side] = _ColumnTargets.from_patches(patches, side, self.problem.num_labels)
        return self.cache[kind, side]
