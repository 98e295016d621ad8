"""Sizes of symbols and positions of letters: least squares under an alignment (paper 003, section 5.3).

Least squares under equations and lower bounds, solved to rounding accuracy.

If the optimum under the equations alone violates bounds, an interior-point method finds the active bounds. The
equations
are then solved with the active bounds as equations. Of all optima, the result is the one with sizes as equal as
possible.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import piqp
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from grammarlab.facade.tree import Floats, Ints
from grammarlab.layers.alignment.align import Alignment
from grammarlab.layers.alignment_equations import Equations, equations, is_gapped

_RANK = 1e-10
"""Singular values below this value, and below this fraction of the largest, are 0."""
_EXACT = 1e-10
"""Largest violation of equations and bounds, as a fraction of the scale."""
_SECOND = 1e-7
"""Weight of the equality of undetermined sizes, relative to that of the targets, if both are solved together."""


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
        found = self._under(none)
        if found is None or self._short(found) <= 0.0:
            return found
        near = self._interior_point()
        if near is None:
            return None
        for slack in (1e-9, 1e-8, 1e-7, 1e-6, 1e-5):
            found = self._pressed(near - self.least < slack * self.scale)
            if found is not None and self.optimality(found) <= _EXACT:
                return np.maximum(found, self.least)
        return None

    def _pressed(self, pressing: NDArray[np.bool_]) -> Floats | None:
        """[U] the optimum with these bounds active, and the bounds that it violates."""
        while True:
            found = self._under(pressing)
            if found is None:
                return None
            broken = (found < self.least - _EXACT * self.scale) & ~pressing
            if not broken.any():
                return found
            pressing = pressing | broken

    def optimality(self, x: Floats) -> float:
        """Residual of the Karush-Kuhn-Tucker conditions: the part of the gradient that no multipliers explain."""
        gradient = self._gradient(x)
        pressing = np.flatnonzero(x - self.least <= _EXACT * self.scale)
        forces = np.concatenate([self.matrix, np.eye(len(x))[pressing]]).T
        if not forces.size:
            return float(np.abs(gradient).max(initial=0.0))
        multiplier = np.linalg.lstsq(forces, gradient, rcond=_RANK)[0]
        if (multiplier[len(self.value) :] < 0.0).any():
            lowest = np.concatenate([np.full(len(self.value), -np.inf), np.zeros(len(pressing))])
            multiplier = lsq_linear(forces, gradient, (lowest, np.inf), method="bvls", tol=1e-14).x
        return float(np.abs(gradient - forces @ multiplier).max())

    def _gradient(self, x: Floats) -> Floats:
        gradient = np.zeros(len(x))
        np.add.at(gradient, self.index, 2.0 * (x[self.index] - self.target))
        return gradient

    def _short(self, x: Floats) -> float:
        return float((self.least - x).max(initial=0.0))

    def _under(self, pressing: NDArray[np.bool_]) -> Floats | None:
        """[U] the optimum under the equations and the active bounds; None if they contradict each other."""
        held = np.flatnonzero(pressing)
        rows = np.concatenate([self.matrix, np.eye(len(pressing))[held]])
        value = np.concatenate([self.value, np.full(len(held), self.least)])
        start, free = _solutions(rows, value)
        if np.abs(rows @ start - value).max(initial=0.0) > _EXACT * self.scale:
            return None
        wishes = free[self.index]
        step, open_ways = _solutions(wishes, self.target - start[self.index])
        found = start + free @ step
        open_ways = free @ open_ways
        found -= open_ways @ (open_ways.T @ found)
        # A second step (iterative refinement) restores digits that the first solution lost.
        return found - np.linalg.lstsq(rows, rows @ found - value, rcond=_RANK)[0] if len(rows) else found

    def _interior_point(self) -> Floats | None:
        num = self.matrix.shape[1]
        quadratic = _SECOND * np.eye(num)
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


def _solutions(rows: Floats, value: Floats) -> tuple[Floats, Floats]:
    """The shortest least-squares solution [U] and an orthonormal basis [U, F] of the null space of the rows."""
    if not rows.size:
        return np.zeros(rows.shape[1]), np.eye(rows.shape[1])
    left, size, right = np.linalg.svd(rows, full_matrices=True)
    # Rows are counts of letters, or part of a basis: values far below 1 are rounding errors.
    rank = int((size > _RANK * max(size[0], 1.0)).sum())
    start = right[:rank].T @ ((left[:, :rank].T @ value) / size[:rank])
    return start, right[rank:].T


_LEAST = 1e-6
"""Least size of a letter, as a fraction of the canvas."""


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
            002,
            section 3.4); otherwise they fill it.
    """
    canvases = [canvas for _, canvas in alignments]
    if not canvases:
        return SymbolSizes({}, (), 0.0, 0.0)
    system = equations(alignments, gaps=gaps)
    scale = max(canvases)
    squares = Squares(system.matrix, system.value, system.target_index, system.target, _LEAST * min(canvases), scale)
    size = squares.solve()
    if size is None:
        return None
    placed = tuple(
        _placed(system, size, number, alignment, canvas, gaps=gaps)
        for number, (alignment, canvas) in enumerate(alignments)
    )
    sizes = {name[1]: float(size[at]) for name, at in system.index.items() if name[0] == "symbol"}
    missed = max(_missed(one, each, sizes) for one, (each, _) in zip(placed, alignments, strict=True))
    error = float(np.square(size[system.target_index] - system.target).sum())
    return SymbolSizes(sizes, placed, error, max(missed, squares.optimality(size)))


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
        split = {at for element in elements for at, part in element if part}
        low, high = np.full(len(word), np.inf), np.zeros(len(word))
        for column, element in enumerate(elements):
            keys = [
                ("part", number, first[word], at, part) if at in split else ("symbol", word[at].symbol)
                for at, part in element
            ]
            edges = np.concatenate([[0.0], np.cumsum([size[system.index[key]] for key in keys])]) + ends[column]
            if is_gapped(alignment, row, element, gaps=gaps):
                edges += 0.5 * (ends[column + 1] - edges[-1])
            else:
                edges[-1] = ends[column + 1]
            for (at, _), begin, end in zip(element, edges, edges[1:], strict=False):
                low[at], high[at] = min(low[at], begin), end
        lower.append(low)
        upper.append(high)
    return PlacedAlignment(ends, tuple(lower), tuple(upper))


def _missed(placed: PlacedAlignment, alignment: Alignment, sizes: Mapping[str, float]) -> float:
    """Largest difference of a letter's length and the size of its symbol, metres."""
    return max(
        (
            abs(float(upper[at] - lower[at]) - sizes[letter.symbol])
            for word, lower, upper in zip(alignment.words, placed.lower, placed.upper, strict=True)
            for at, letter in enumerate(word)
        ),
        default=0.0,
    )
