"""Lower bounds of the energy: strips that choose labels independently, with prices that make them agree."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.bounds.chains import Costs
from grammarlab.facade.examples.labels.bounds.messages import swept
from grammarlab.facade.examples.labels.bounds.strips import WindowStrips
from grammarlab.facade.examples.labels.demands import LabelDemands
from grammarlab.facade.examples.labels.problem import WINDOW, Problem

_ROUNDING = 0.01
"""Largest rounding error of a bound; it is subtracted before a bound is rounded up to an integer energy."""
_LARGEST = 1e8
"""Largest number of additions to solve all different strips."""
_PATIENCE = 3
"""Steps without a better bound before steps become smaller."""
_SHRINK = 0.7


def least_work(problem: Problem) -> float:
    """Additions for one bound: for three rows of all strips, three consecutive patches at every column."""
    most = max(len(patches) for patches in problem.patches)
    return float(most) ** 3 * problem.rows * problem.columns * WINDOW


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
    if least_work(problem) * len(first) / problem.rows > _LARGEST:
        return 0
    strips = WindowStrips.of(problem, list(first.values()))
    shape = (len(first), WINDOW, problem.columns, problem.num_labels)
    energies = dict(zip(first.values(), strips.least(np.zeros(shape))[0].tolist(), strict=True))
    return ceil(sum(energies[row] for row in same) - _ROUNDING)


@dataclass
class Dual:
    """Prices by subgradient steps (Lagrangian decomposition): the sum of the strips' energies bounds the grid's."""

    problem: Problem
    demands: LabelDemands
    bound: float = -np.inf

    def __post_init__(self) -> None:
        self.strips = WindowStrips.of(self.problem, range(self.problem.rows))
        self.prices = np.zeros((self.problem.rows, WINDOW, self.problem.columns, self.problem.num_labels))
        self.tolls: Costs = np.zeros(len(self.demands.counts))
        self.copies = self._gathered(self.strips.inside[:, :, None].repeat(self.problem.columns, axis=2).astype(float))

    @property
    def whole(self) -> int:
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
            value, slopes, toll_slopes, wanted = self._evaluated()
            waited = 0 if value > self.bound + 1e-6 else waited + 1
            self.bound = max(self.bound, value)
            yield wanted
            if waited >= _PATIENCE:
                scale, waited = scale * _SHRINK, 0
            norm = float((slopes**2).sum() + (toll_slopes**2).sum())
            if norm < 1e-9 or target <= self.whole:
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
            often = float(mean[..., label].sum())
            wished = most if toll > 0 else least if toll < 0 else min(max(often, least), most)
            value -= toll * wished
            toll_slopes[index] = often - wished
        return value, slopes, toll_slopes, mean.argmax(axis=2)

    def _tolls(self) -> Costs:
        """[strips, 3, columns, labels] additional cost of each counted label."""
        found = np.zeros_like(self.prices)
        share = self._spread(1.0 / self.copies)
        for (label, _, _), toll in zip(self.demands.counts, self.tolls, strict=True):
            found[..., label] += toll * share
        return found

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
