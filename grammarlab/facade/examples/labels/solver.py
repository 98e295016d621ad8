"""The synthesis problem for CP-SAT, which closes the gap of small grids; without it the gap is reported."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.demands import LabelDemands
from grammarlab.facade.examples.labels.problem import AWAY, WINDOW, Problem

if TYPE_CHECKING:
    from ortools.sat.python.cp_model import CpModel, IntVar

LARGEST = 400
"""Largest number of windows times patches for the solver: larger problems take longer than they gain."""

_TIME = 0.5
"""Deterministic time limit of the solver: about a second or two."""


@dataclass(frozen=True, slots=True)
class SolvedLabels:
    """Result of the solver."""

    labels: Labels | None
    """[rows, columns] labels; None if it found no grid."""
    bound: int
    """Lower bound of the energy of all grids."""
    impossible: bool
    """Whether it is proven that no grid satisfies the constraints."""


def suits(problem: Problem) -> bool:
    """Whether the solver is installed and the problem is small enough for it."""
    size = sum(int((problem.kind == kind).sum()) * len(patches) for kind, patches in enumerate(problem.patches))
    return size <= LARGEST and find_spec("ortools") is not None


def solve(
    problem: Problem, demands: LabelDemands, bound: int, hint: Labels | None, seed: int, effort: float
) -> SolvedLabels:
    """The grid of least energy, or a grid and a bound if the time limit is reached.

    Args:
        problem: the windows and their patches.
        demands: constraints of the grid.
        bound: known lower bound of the energy.
        hint: a grid that satisfies the constraints.
        seed: seed of the solver.
        effort: factor on the time limit.
    """
    from ortools.sat.python import cp_model  # noqa: PLC0415  an extra

    model = cp_model.CpModel()
    cells = _cells(model, demands)
    differ: list[cp_model.IntVar] = []
    for row, column in np.argwhere(problem.kind >= 0).tolist():
        _add_window(model, cells, problem.patches[problem.kind[row, column]], (row, column), differ)
    energy = cp_model.LinearExpr.sum(differ)
    model.add(energy >= bound)
    model.minimize(energy)
    if hint is not None:
        for (row, column, label), variable in cells.items():
            if not demands.symmetric or 2 * column < problem.columns:
                model.add_hint(variable, bool(hint[row, column] == label))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.random_seed = seed % 2**31
    solver.parameters.max_deterministic_time = _TIME * effort
    status = solver.solve(model)
    if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        return SolvedLabels(None, bound, status == cp_model.INFEASIBLE)
    labels = np.zeros((problem.rows, problem.columns), dtype=np.int64)
    for (row, column, label), variable in cells.items():
        if solver.value(variable):
            labels[row, column] = label
    return SolvedLabels(labels, max(bound, round(solver.best_objective_bound)), impossible=False)


def _cells(model: CpModel, demands: LabelDemands) -> dict[tuple[int, int, int], IntVar]:
    """By row, column and label, whether the cell has the label; a symmetric grid has one variable for both sides."""
    cells: dict[tuple[int, int, int], IntVar] = {}
    rows, columns, _ = demands.domain.shape
    for row, column in np.ndindex(rows, columns):
        mirror = min(column, columns - 1 - column) if demands.symmetric else column
        labels = np.flatnonzero(demands.domain[row, column]).tolist()
        for label in labels:
            if (row, mirror, label) not in cells:
                cells[row, mirror, label] = model.new_bool_var("")
            cells[row, column, label] = cells[row, mirror, label]
        model.add_exactly_one(cells[row, column, label] for label in labels)
    for label, least, most in demands.counts:
        often = sum(variable for (_, _, its), variable in cells.items() if its == label)
        model.add_linear_constraint(often, least, most)
    for row in demands.equal_ends:
        for label in np.flatnonzero(demands.domain[row, 0]).tolist():
            model.add(cells[row, 0, label] == cells[row, columns - 1, label])
    return cells


def _add_window(
    model: CpModel,
    cells: dict[tuple[int, int, int], IntVar],
    patches: Labels,
    centre: tuple[int, int],
    differ: list[IntVar],
) -> None:
    """One window: it is compared with one patch, and each differing label costs 1."""
    chosen = [model.new_bool_var("") for _ in patches]
    model.add_exactly_one(chosen)
    for up, right in np.ndindex(WINDOW, WINDOW):
        wants = patches[:, up, right]
        labels = np.unique(wants[wants != AWAY]).tolist()
        if labels:
            differ.append(model.new_bool_var(""))
        for label in labels:
            here = cells.get((centre[0] + up - 1, centre[1] + right - 1, label), 0)
            model.add(sum(chosen[k] for k in np.flatnonzero(wants == label).tolist()) - here <= differ[-1])
