"""Sizes of symbols and positions of letters: least squares under an alignment (paper 003, section 5.3).

Equations and lower bounds are satisfied to rounding accuracy. If the optimum under the equations alone violates bounds,
an interior-point method finds the active bounds. The equations are then solved with the active bounds as equations. Of
all optima, the result is the one with sizes as equal as possible.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import piqp
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from grammarlab.arrays import Floats, Ints
from grammarlab.layers.alignment.align import Alignment
from grammarlab.layers.alignment_equations import Equations, equations, is_gapped

_RANK_TOLERANCE = 1e-10
"""Singular values below this value, and below this fraction of the largest, are 0."""
_TOLERANCE = 1e-10
"""Largest violation of equations and bounds, as a fraction of the scale."""
_EQUALITY_WEIGHT = 1e-7
"""Weight of the equality of undetermined sizes, relative to that of the targets, if both are solved together."""
_LEAST_SIZE_RATIO = 1e-6
"""Least size of a letter, as a fraction of the canvas."""


@dataclass(frozen=True)
class Squares:
    """Minimise the sum of (x[index] - target)^2 subject to matrix x = value and x >= least, for U unknowns x."""

    matrix: Floats
    """[R, U] coefficients."""
    value: Floats
    """[R] right-hand sides."""
    index: Ints
    """[P] index of the unknown of each target."""
    target: Floats
    """[P] targets."""
    least: float
    scale: float
    """Magnitude of the unknowns."""

    def solve(self) -> Floats | None:
        """[U] the optimum; None if there is none."""
        none = np.zeros(self.matrix.shape[1], dtype=np.bool_)
        solution = self._under_equations(none)
        if solution is None or self._bound_violation(solution) <= 0.0:
            return solution
        approximate = self._interior_point()
        if approximate is None:
            return None
        for slack in (1e-9, 1e-8, 1e-7, 1e-6, 1e-5):
            solution = self._with_active_bounds(approximate - self.least < slack * self.scale)
            if solution is not None and self.optimality(solution) <= _TOLERANCE:
                return np.maximum(solution, self.least)
        return None

    def _with_active_bounds(self, active: NDArray[np.bool_]) -> Floats | None:
        """[U] the optimum with these bounds active, and the bounds that it violates."""
        while True:
            solution = self._under_equations(active)
            if solution is None:
                return None
            violated = (solution < self.least - _TOLERANCE * self.scale) & ~active
            if not violated.any():
                return solution
            active = active | violated

    def optimality(self, x: Floats) -> float:
        """Residual of the Karush-Kuhn-Tucker conditions: the part of the gradient that no multipliers explain."""
        gradient = self._gradient(x)
        active = np.flatnonzero(x - self.least <= _TOLERANCE * self.scale)
        forces = np.concatenate([self.matrix, np.eye(len(x))[active]]).T
        if not forces.size:
            return float(np.abs(gradient).max(initial=0.0))
        multiplier = np.linalg.lstsq(forces, gradient, rcond=_RANK_TOLERANCE)[0]
        if (multiplier[len(self.value) :] < 0.0).any():
            lowest = np.concatenate([np.full(len(self.value), -np.inf), np.zeros(len(active))])
            multiplier = lsq_linear(forces, gradient, (lowest, np.inf), method="bvls", tol=1e-14).x
        return float(np.abs(gradient - forces @ multiplier).max())

    def _gradient(self, x: Floats) -> Floats:
        gradient = np.zeros(len(x))
        np.add.at(gradient, self.index, 2.0 * (x[self.index] - self.target))
        return gradient

    def _bound_violation(self, x: Floats) -> float:
        return float((self.least - x).max(initial=0.0))

    def _under_equations(self, active: NDArray[np.bool_]) -> Floats | None:
        """[U] the optimum under the equations and the active bounds; None if they contradict each other."""
        active_index = np.flatnonzero(active)
        rows = np.concatenate([self.matrix, np.eye(len(active))[active_index]])
        value = np.concatenate([self.value, np.full(len(active_index), self.least)])
        start, free = _solutions(rows, value)
        if np.abs(rows @ start - value).max(initial=0.0) > _TOLERANCE * self.scale:
            return None
        target_rows = free[self.index]
        step, null_space = _solutions(target_rows, self.target - start[self.index])
        solution = start + free @ step
        null_space = free @ null_space
        solution -= null_space @ (null_space.T @ solution)
        # A second step (iterative refinement) restores digits that the first solution lost.
        return (
            solution - np.linalg.lstsq(rows, rows @ solution - value, rcond=_RANK_TOLERANCE)[0]
            if len(rows)
            else solution
        )

    def _interior_point(self) -> Floats | None:
        num = self.matrix.shape[1]
        quadratic = _EQUALITY_WEIGHT * np.eye(num)
        np.add.at(quadratic, (self.index, self.index), 2.0)
        linear = np.zeros(num)
        np.add.at(linear, self.index, -2.0 * self.target)
        solver = piqp.DenseSolver()
        solver.settings.eps_abs = solver.settings.eps_rel = 1e-11
        bounds = np.full(num, self.least), np.full(num, np.inf)
        solver.setup(quadratic, linear, self.matrix, self.value, None, None, None, *bounds)
        status = solver.solve()
        x = np.asarray(solver.result.x)
        return x if status == piqp.PIQP_SOLVED and np.isfinite(x).all() else None


@dataclass(frozen=True)
class PlacedAlignment:
    """An alignment with positions, in metres from the start of the canvas."""

    ends: Floats
    """[n + 1] borders of columns: the first is 0, the last is the canvas."""
    lower: tuple[Floats, ...]
    """[m][letters] start of each letter of each row."""
    upper: tuple[Floats, ...]
    """[m][letters] end of each letter of each row."""


@dataclass(frozen=True)
class SymbolSizes:
    """Sizes with the least deviation from preferred sizes."""

    sizes: Mapping[str, float]
    """Size of each symbol, metres, the same at all occurrences; in the order of first use."""
    placed: tuple[PlacedAlignment, ...]
    """Positions for each alignment."""
    error: float
    """Sum of squared deviations from preferred sizes, square metres."""
    residual: float
    """Largest violation of the equations and of optimality, measured on the positions, metres."""


def size_letters(alignments: Sequence[tuple[Alignment, float]], *, gaps: bool = False) -> SymbolSizes | None:
    """The best sizes for alignments of both axes and all groups, each with its canvas; None if there are none.

    Args:
        alignments: each with the length of its canvas, metres.
        gaps: whether elements with letters that are not opaque keep their size, centred in their column (supplement
            002, section 3.4); otherwise they fill it.
    """
    canvases = [canvas for _, canvas in alignments]
    if not canvases:
        return SymbolSizes({}, (), 0.0, 0.0)
    system = equations(alignments, gaps=gaps)
    scale = max(canvases)
    squares = Squares(
        system.matrix, system.value, system.target_index, system.target, _LEAST_SIZE_RATIO * min(canvases), scale
    )
    size = squares.solve()
    if size is None:
        return None
    placed = tuple(
        _placed(system, size, number, alignment, canvas, gaps=gaps)
        for number, (alignment, canvas) in enumerate(alignments)
    )
    sizes = {name[1]: float(size[index]) for name, index in system.index.items() if name[0] == "symbol"}
    violation = max(
        _max_violation(positions, alignment, sizes)
        for positions, (alignment, _) in zip(placed, alignments, strict=True)
    )
    error = float(np.square(size[system.target_index] - system.target).sum())
    return SymbolSizes(sizes, placed, error, max(violation, squares.optimality(size)))


def _solutions(rows: Floats, value: Floats) -> tuple[Floats, Floats]:
    """The shortest least-squares solution [U] and an orthonormal basis [U, F] of the null space of the rows."""
    if not rows.size:
        return np.zeros(rows.shape[1]), np.eye(rows.shape[1])
    u, singular, vt = np.linalg.svd(rows, full_matrices=True)
    # Rows are counts of letters, or part of a basis: values far below 1 are rounding errors.
    rank = int((singular > _RANK_TOLERANCE * max(singular[0], 1.0)).sum())
    start = vt[:rank].T @ ((u[:, :rank].T @ value) / singular[:rank])
    return start, vt[rank:].T


def _placed(
    system: Equations, size: Floats, number: int, alignment: Alignment, canvas: float, *, gaps: bool
) -> PlacedAlignment:
    """Positions of the letters of an alignment."""
    widths = [size[system.index["column", number, column]] for column in range(alignment.num_columns)]
    ends = np.concatenate([[0.0], np.cumsum(widths)])
    ends[-1] = canvas
    lower, upper = [], []
    first = {word: row for row, word in enumerate(alignment.words)}
    for row, (word, elements) in enumerate(zip(alignment.words, alignment.cells, strict=True)):
        split = {index for element in elements for index, part in element if part}
        low, high = np.full(len(word), np.inf), np.zeros(len(word))
        for column, element in enumerate(elements):
            keys = [
                ("part", number, first[word], index, part) if index in split else ("symbol", word[index].symbol)
                for index, part in element
            ]
            edges = np.concatenate([[0.0], np.cumsum([size[system.index[key]] for key in keys])]) + ends[column]
            if is_gapped(alignment, row, element, gaps=gaps):
                edges += 0.5 * (ends[column + 1] - edges[-1])
            else:
                edges[-1] = ends[column + 1]
            for (index, _), begin, end in zip(element, edges, edges[1:], strict=False):
                low[index], high[index] = min(low[index], begin), end
        lower.append(low)
        upper.append(high)
    return PlacedAlignment(ends, tuple(lower), tuple(upper))


def _max_violation(placed: PlacedAlignment, alignment: Alignment, sizes: Mapping[str, float]) -> float:
    """Largest difference of a letter's length and the size of its symbol, metres."""
    return max(
        (
            abs(float(upper[index] - lower[index]) - sizes[letter.symbol])
            for word, lower, upper in zip(alignment.words, placed.lower, placed.upper, strict=True)
            for index, letter in enumerate(word)
        ),
        default=0.0,
    )
