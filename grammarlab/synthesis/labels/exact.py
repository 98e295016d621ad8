"""Grids of least energy, or near it, with a lower bound.

CP-SAT closes the gap of small grids; without it the gap is reported.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import FacadeError
from grammarlab.synthesis.label_grid import LabelGrid, Labels
from grammarlab.synthesis.labels.demands import LabelDemands
from grammarlab.synthesis.labels.dual_bounds import Dual, least_work, strips_alone
from grammarlab.synthesis.labels.grid_search import GridSearch, expectation_maximization
from grammarlab.synthesis.labels.problem import AWAY, WINDOW, Problem

if TYPE_CHECKING:
    from ortools.sat.python.cp_model import CpModel, IntVar

_MAX_SOLVER_SIZE = 400
"""Largest number of windows times patches for the solver: larger problems take longer than they gain."""
_TIME_LIMIT = 0.5
"""Deterministic time limit of the solver: about a second or two."""
_DUAL_WORK = 4e7
"""Largest number of additions for all steps of the dual together: some tenths of a second."""
_MAX_STEPS = 40
"""Largest number of steps of the dual."""
_SWEEPS = 4
"""Number of sweeps of the dual."""
_FIRST_STEPS = 12
"""Steps of the dual before sweeps are worthwhile."""
_STEPS_PER_GRID = 4
"""Steps of the dual between two grids made of the strips' labels."""
_TRIES_PER_GRID = 4
"""Largest number of grids to try for each requested grid, to find different ones."""
_RUN_LINES = 3
"""Number of consecutive lines taken from an example."""
_MAX_CANDIDATES = 40
"""Number of columns to recombine."""


@dataclass(frozen=True, slots=True)
class SolvedLabels:
    """Result of the solver."""

    labels: Labels | None
    """[rows, columns] labels; None if it found no grid."""
    bound: int
    """Lower bound of the energy of all grids."""
    impossible: bool
    """Whether it is proven that no grid satisfies the constraints."""


@dataclass(frozen=True, slots=True)
class Bounded:
    """Grids, best first, and a lower bound of the energy of all grids."""

    grids: tuple[tuple[int, Labels], ...]
    """Energy and labels."""
    bound: int


def least_energy(
    problem: Problem, demands: LabelDemands, examples: Sequence[LabelGrid], seed: int, count: int, effort: float
) -> Bounded:
    """Grids of small energy that satisfy the constraints.

    An example of this size is the first grid, if it satisfies the constraints. The next ones consist of whole rows and
    columns of an example, each improved by changes of single lines. The last ones come from the labels of the strips of
    the dual, whose bound rises meanwhile. Small grids are finally solved with CP-SAT. The search ends as soon as a
    grid's energy equals the bound.

    Args:
        problem: the windows and their patches.
        demands: constraints of the grids.
        examples: examples for the first grids.
        seed: seed of all random choices.
        count: number of requested grids.
        effort: factor on the usual amount of work before a gap is accepted.

    Raises:
        FacadeError: If no grid satisfies the constraints, or none was found.
    """
    problem = problem.within(demands.domain)
    search = GridSearch(
        problem=problem,
        demands=demands,
        generator=np.random.default_rng(seed),
        dissimilarity=_dissimilarity(problem, examples),
        effort=effort,
    )
    bound, turned = _alone(problem, demands)
    for example in examples:
        if example.labels.shape == problem.kind.shape and (example.labels >= 0).all():
            search.keep(example.labels)
    if not _done(search, bound):
        _try(search, _in_order(search, examples), bound)
    if not _done(search, bound):
        bound = _dual(search, bound, turned, effort)
    if not _done(search, bound):
        _try(search, _others(search, examples, seed), bound)
        search.recombined(_MAX_CANDIDATES)
    if not _done(search, bound) and suits(problem):
        bound = _solved(search, bound, seed, effort)
    if search.best is None:
        raise FacadeError("wishes: no grid that keeps all of them was found; remove some, or use a larger grid.")
    for turn in range(_TRIES_PER_GRID * count):
        if len(search.solutions) >= count:
            break
        search.settle(_scattered(search, examples[turn % len(examples)]))
    return Bounded(tuple(search.ranked()[:count]), bound)


def _dissimilarity(problem: Problem, examples: Sequence[LabelGrid]) -> NDArray[np.float64]:
    """[rows, columns, labels] share of the examples, stretched over the grid, that have another label there."""
    rows, columns, labels = problem.domain.shape
    dissimilarity = np.ones((rows, columns, labels))
    for example in examples:
        across, up = (
            np.round(np.linspace(0, size - 1, num)).astype(np.int64)
            for size, num in ((example.columns, columns), (example.rows, rows))
        )
        row, column = np.indices((rows, columns))
        dissimilarity[row, column, _whole(example)[np.ix_(up, across)]] -= 1.0 / len(examples)
    return dissimilarity


def suits(problem: Problem) -> bool:
    """Whether the solver is installed and the problem is small enough for it."""
    size = sum(int((problem.kind == kind).sum()) * len(patches) for kind, patches in enumerate(problem.patches))
    return size <= _MAX_SOLVER_SIZE and find_spec("ortools") is not None


def _alone(problem: Problem, demands: LabelDemands) -> tuple[int, bool]:
    """The better bound of independent strips, of rows or of columns, and whether it is that of columns."""
    rows, columns = strips_alone(problem), strips_alone(problem.transposed())
    return max(rows, columns), columns > rows and not demands.symmetric


def _done(search: GridSearch, bound: int) -> bool:
    return search.best is not None and search.best <= bound


def _try(search: GridSearch, starts: Iterator[Labels], bound: int) -> None:
    """Settle the starts one by one, until a grid is good enough or the budget is spent."""
    for start in starts:
        search.settle(start)
        if _done(search, bound) or search.spent > search.budget:
            return


def _in_order(search: GridSearch, examples: Sequence[LabelGrid]) -> Iterator[Labels]:
    """Grids of lines of an example, stretched over the new grid or repeated."""
    for example in examples:
        across = np.round(np.linspace(0, example.columns - 1, search.problem.columns)).astype(np.int64)
        yield search.factored(_whole(example), across)
    for example in examples:
        yield _drawn(search, example)


def _whole(example: LabelGrid) -> Labels:
    """The labels of an example, with its most frequent label in place of holes."""
    labels = example.labels
    return np.where(labels < 0, np.bincount(labels[labels >= 0]).argmax(), labels)


def _drawn(search: GridSearch, example: LabelGrid) -> Labels:
    """Lines of an example in its order from a random start, repeated."""
    size, columns = example.columns, search.problem.columns
    inner = np.arange(1, size - 1) if size > 2 else np.arange(size)
    across = np.resize(np.roll(inner, -int(search.generator.integers(len(inner)))), columns)
    if columns > 1:
        across[0], across[-1] = 0, size - 1
    return search.factored(_whole(example), across)


def _dual(search: GridSearch, bound: int, turned: bool, effort: float) -> int:
    """A better bound; grids are made of the strips' labels meanwhile: a few steps first, then sweeps and more steps."""
    steps = int(min(_MAX_STEPS * effort, _DUAL_WORK * effort / least_work(search.problem)))
    problem, demands = search.problem, search.demands
    if turned:
        problem = problem.transposed()
        demands = LabelDemands(np.ascontiguousarray(problem.domain), demands.counts, symmetric=False)
    if steps < 1:
        return bound
    dual = Dual(problem, demands)
    for sweeps, most in ((0, min(_FIRST_STEPS, steps)), (_SWEEPS, steps - _FIRST_STEPS)):
        if most < 1 or _done(search, bound):
            break
        dual.sweep(sweeps)
        target = search.best if search.best is not None else 2 * bound + 9
        for step, labels in enumerate(dual.steps(target, most)):
            bound = max(bound, dual.integer_bound)
            if step % _STEPS_PER_GRID == _STEPS_PER_GRID - 1:
                search.settle(np.ascontiguousarray(labels.T if turned else labels))
            if _done(search, bound):
                break
    return bound


def _others(search: GridSearch, examples: Sequence[LabelGrid], seed: int) -> Iterator[Labels]:
    """Grids of the paper's method, with borders, and of lines from random positions."""
    for turn in range(2):
        yield expectation_maximization(search.problem, seed + turn).labels
    for example in examples:
        yield _drawn(search, example)


def _solved(search: GridSearch, bound: int, seed: int, effort: float) -> int:
    """The bound that CP-SAT proves, and its grid."""
    best = search.ranked()
    solved = _solve(search.problem, search.demands, bound, best[0][1] if best else None, seed, effort)
    if solved.impossible:
        raise FacadeError("wishes: no grid of this size satisfies all of them.")
    if solved.labels is not None:
        search.keep(solved.labels)
    return solved.bound


def _solve(
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
    solver.parameters.max_deterministic_time = _TIME_LIMIT * effort
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
        count = sum(variable for (_, _, cell_label), variable in cells.items() if cell_label == label)
        model.add_linear_constraint(count, least, most)
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


def _scattered(search: GridSearch, example: LabelGrid) -> Labels:
    """Short runs of lines of an example from random positions: these grids differ most from the previous ones."""
    lines = []
    for num_lines, size in ((search.problem.rows, example.rows), (search.problem.columns, example.columns)):
        starts = search.generator.integers(size, size=num_lines)
        lines.append(((starts[:, None] + np.arange(_RUN_LINES)) % size).ravel()[:num_lines])
    return _whole(example)[np.ix_(*lines)]
