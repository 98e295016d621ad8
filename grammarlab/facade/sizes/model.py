"""The quadratic programme of a facade under wishes: sizes with the least deviation (Equation 1 of paper 000).

The axes are independent unless a wish connects them: only with a wish for an aspect ratio, both are solved in one
programme. The unknowns are the positions of lines, so decomposition always holds. Lines with a constant distance by a
row are one unknown. The optimum under the equations alone is one solve of a factorised system, and usually it is the
optimum: only if a part would become too small, an interior-point method finds the active bounds, and the same system
with these bounds gives accurate values. The accuracy of results is measured; the status of a solver is not used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import piqp
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import SuperLU, splu

from grammarlab.arrays import Floats, Ints
from grammarlab.facade.sizes.constraints import Axis
from grammarlab.facade.sizes.lines import Sums, stacked
from grammarlab.facade.sizes.size_wishes import Aspect, Position, Size, Wish
from grammarlab.facade.tree import Facade, X, Y

SYMMETRY, ALIGNMENT, WISH = 0, 1, 2
"""Kinds of rows, in the order of relaxation."""
_EXACT_TOLERANCE = 1e-9
"""Largest violation of rows and bounds, as a fraction of the facade's size."""
_APPROXIMATE_TOLERANCE = 1e-8
"""Largest violation if no accurate solution was found."""
_REGULARISATION = 1e-8
"""Regularisation for linearly dependent rows; iterative refinement removes its effect."""
_MOST_REFINEMENTS = 30
"""Largest number of refinements of a solution."""
_ZERO_LENGTH = 1e-12
"""Largest distance, as a fraction of the facade's size, that counts as 0."""
_NO_SUMS = Sums(np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2)))
"""Sums without any row."""


@dataclass(frozen=True, eq=False)
class QuadraticProgram:
    """Minimise the sum of (weight (part - target))^2 over positions of M lines.

    Subject to rows = value and bounds >= least. Lengths are fractions of the facade's size.
    """

    num_lines: int
    """Number M of lines."""
    parts: Sums
    """[P] sizes; they connect every line to a fixed position."""
    weight: Floats
    """[P] weights, > 0."""
    target: Floats
    """[P] target sizes of parts."""
    rows: Sums
    """[R] equations; they may be linearly dependent."""
    is_zero: NDArray[np.bool_]
    """[R] whether the value is always 0."""
    bounds: Sums
    """[K] left-hand sides of inequalities."""
    least: Floats
    """[K] right-hand sides of inequalities."""

    def solve(self, value: Floats) -> Floats | None:
        """[M] the optimal positions for values [R] of the rows; None if no valid solution was found."""
        merged, line, row = self._merged
        position = merged._solved(value[row])
        if position is None or self.max_violation(position[line], value) > _APPROXIMATE_TOLERANCE:
            return None
        return position[line]

    def energy(self, position: Floats) -> float:
        """The objective at these positions [M]."""
        return float(np.square(self.weight * (self.parts.evaluate(position) - self.target)).sum())

    def deviation(self, position: Floats) -> float:
        """Largest difference of a size from its target at these positions [M]."""
        return float(np.abs(self.parts.evaluate(position) - self.target).max())

    def max_violation(self, position: Floats, value: Floats) -> float:
        """Largest violation of the rows, with these values [R], and of bounds; infinite for NaN."""
        rows = np.abs(self.rows.evaluate(position) - value).max(initial=0.0)
        violation = float(max(rows, (self.least - self.bounds.evaluate(position)).max(initial=0.0)))
        return violation if np.isfinite(position).all() else np.inf

    @cached_property
    def _merged(self) -> tuple[QuadraticProgram, Ints, Ints]:
        """The programme with lines of constant distance merged, [M] merged line of each line, and its rows."""
        line = np.arange(self.num_lines)
        fixed = Sums(self.rows.line[self.is_zero], self.rows.factor[self.is_zero])
        while True:
            first, second = fixed.over(line).equal_pairs()
            if not first.size:
                break
            graph = sparse.coo_array((np.ones(len(first)), (first, second)), shape=(self.num_lines, self.num_lines))
            line = connected_components(graph, directed=False)[1][line].astype(np.int64)
        rows = self.rows.over(line)
        row = np.flatnonzero(~self.is_zero | (rows.factor != 0.0).any(axis=1))
        merged = replace(
            self,
            num_lines=int(line.max()) + 1,
            parts=self.parts.over(line),
            rows=Sums(rows.line[row], rows.factor[row]),
            is_zero=self.is_zero[row],
            bounds=self.bounds.over(line),
        )
        return merged, line, row

    def _solved(self, value: Floats) -> Floats | None:
        """[M] see `solve`, without merging lines."""
        position = self._under_rows(value)
        if position is None or self.max_violation(position, value) <= _EXACT_TOLERANCE:
            return position
        approximate, active = self._interior_point(value)
        violation = self.max_violation(approximate, value)
        if violation > _APPROXIMATE_TOLERANCE:
            return None
        rows = stacked([self.rows, Sums(self.bounds.line[active], self.bounds.factor[active])])
        exact = replace(self, rows=rows)._under_rows(np.concatenate([value, self.least[active]]))
        if exact is None or self.max_violation(exact, value) > max(_EXACT_TOLERANCE, violation):
            return approximate
        return exact if self.energy(exact) <= (1.0 + _EXACT_TOLERANCE) * self.energy(approximate) else approximate

    @cached_property
    def _matrix(self) -> sparse.csr_array:
        """[R, M] matrix of the rows."""
        return self.rows.matrix(self.num_lines)

    @cached_property
    def _scale(self) -> float:
        """Divisor of the objective, so that its values are about 1."""
        return float(np.square(self.weight).max())

    @cached_property
    def _quadratic(self) -> sparse.csc_array:
        """[M, M] quadratic part of the objective."""
        weighted = self.parts.times(self.weight / np.sqrt(self._scale)).matrix(self.num_lines)
        return sparse.csc_array(weighted.T @ weighted)

    @cached_property
    def _linear(self) -> Floats:
        """[M] linear part of the objective."""
        return -(self.parts.matrix(self.num_lines).T @ (self.weight**2 * self.target)) / self._scale

    @cached_property
    def _factor(self) -> SuperLU:
        """The factorised optimality conditions; they do not depend on the values of rows."""
        below = -_REGULARISATION * sparse.eye_array(len(self.rows))
        system = sparse.block_array([[self._quadratic, self._matrix.T], [self._matrix, below]], format="csc")
        # Quasi-definite: any order is stable without pivoting.
        return splu(system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def _under_rows(self, value: Floats) -> Floats | None:
        """[M] the optimum under the equations alone; None if they contradict each other."""
        num = self.num_lines
        solution, error = np.zeros(num + len(value)), np.inf
        for _ in range(_MOST_REFINEMENTS):
            position, multiplier = solution[:num], solution[num:]
            stationarity = -self._linear - self._quadratic @ position - self._matrix.T @ multiplier
            residual = np.concatenate([stationarity, value - self._matrix @ position])
            previous_error, error = error, np.abs(residual).max()
            if error <= 1e-16 or error > 0.5 * previous_error:
                break
            solution = solution + self._factor.solve(residual)
        position = solution[:num]
        return position if np.abs(self._matrix @ position - value).max(initial=0.0) <= _EXACT_TOLERANCE else None

    def _interior_point(self, value: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """[M] the optimum to about eight digits, and [K] the active bounds."""
        solver = piqp.SparseSolver()
        solver.settings.eps_abs = solver.settings.eps_rel = 1e-10
        upper = np.full(len(self.least), np.inf)
        rows, bounds = _sorted(self._matrix), _sorted(self.bounds.matrix(self.num_lines))
        solver.setup(_sorted(self._quadratic), self._linear, rows, value, bounds, self.least, upper)
        solver.solve()
        position = np.asarray(solver.result.x)
        return position, np.asarray(solver.result.z_l) > self.bounds.evaluate(position) - self.least


@dataclass(frozen=True, eq=False)
class SizeModel:
    """R equations and K bounds over the M lines of one axis, or of both, with their sources."""

    axes: tuple[Axis, ...]
    program: QuadraticProgram
    scale: float
    """Unit of length, metres."""
    value: Floats
    """[R] values of the programme's rows."""
    kind: Ints
    """[R] `SYMMETRY`, `ALIGNMENT` or `WISH`."""
    along: Ints
    """[R] axis of the grid; 0 for wishes."""
    source: Ints
    """[R] index of the grid, or of the wish."""
    bound_source: Ints
    """[K] index of the wish for the bounds of an aspect ratio; -1 for least sizes of leaves."""

    def lines(self, position: Floats) -> list[Floats]:
        """[M] for each axis, positions of its lines, metres, the first at 0."""
        axis_positions = np.split(position, np.cumsum([axis.lines.num for axis in self.axes])[:-1])
        return [(lines - lines[0]) * self.scale for lines in axis_positions]

    def line_positions(self, facade: Facade) -> Floats:
        """[M] positions of the lines of a facade of the same tree."""
        sides = [(axis.lines, facade.position[:, axis.along], facade.size[:, axis.along]) for axis in self.axes]
        return np.concatenate([lines.positions(position, size) for lines, position, size in sides]) / self.scale

    def row_values(self, wishes: Sequence[Wish]) -> Floats:
        """[R] values of the rows for wishes that differ from those of the model only in lengths."""
        value, is_wish = self.value.copy(), self.kind == WISH
        value[is_wish] = _values([wishes[index] for index in self.source[is_wish]], self.scale)
        return value


def build_model(axes: Sequence[Axis], wishes: Sequence[Wish], scale: float) -> SizeModel:
    """The programme of these axes under the wishes for them.

    Args:
        axes: one of them, or both if a wish connects them.
        wishes: all wishes.
        scale: unit of length, metres.
    """
    firsts = np.cumsum([0, *(axis.lines.num for axis in axes)]).tolist()
    ties = [(SYMMETRY, axis.symmetry, axis.along, first) for axis, first in zip(axes, firsts, strict=False)]
    ties += [(ALIGNMENT, axis.alignment, axis.along, first) for axis, first in zip(axes, firsts, strict=False)]
    lengths = [
        (index, _length(axis, wish).shifted(first))
        for axis, first in zip(axes, firsts, strict=False)
        for index, wish in enumerate(wishes)
        if isinstance(wish, Size | Position) and wish.axis == axis.along
    ]
    aspects = [(index, wish) for index, wish in enumerate(wishes) if isinstance(wish, Aspect) and len(axes) > 1]
    ranges = [_aspect(axes, firsts, wish) for _, wish in aspects]
    sizes = stacked([axis.extent.shifted(first) for axis, first in zip(axes, firsts, strict=False)])
    weight = np.concatenate([axis.weight for axis in axes]) * scale
    # Sizes do not determine the position of a facade; a target of 0 for the start of each axis does, at no cost.
    pins = Sums(np.array(firsts[:-1])[:, None], np.ones((len(axes), 1)))
    counts = [*(len(tie.value) for _, tie, _, _ in ties), len(lengths)]
    kind = np.repeat([*(kind for kind, *_ in ties), WISH], counts)
    value = np.concatenate(
        [*(tie.value for _, tie, _, _ in ties), _values([wishes[index] for index, _ in lengths], scale)]
    )
    rows = stacked([_NO_SUMS, *(tie.sums.shifted(first) for _, tie, _, first in ties), *(row for _, row in lengths)])
    program = QuadraticProgram(
        num_lines=firsts[-1],
        parts=stacked([sizes, pins]),
        weight=np.append(weight, np.full(len(axes), weight.max())),
        target=np.append(np.concatenate([axis.target for axis in axes]), np.zeros(len(axes))),
        rows=rows,
        is_zero=(np.abs(value) <= _ZERO_LENGTH) & (kind != WISH),
        bounds=stacked([sizes, *ranges]),
        least=np.concatenate([*(axis.least for axis in axes), np.zeros(2 * len(aspects))]),
    )
    return SizeModel(
        axes=tuple(axes),
        program=program,
        scale=scale,
        value=np.where(program.is_zero, 0.0, value),
        kind=kind,
        along=np.repeat([*(along for _, _, along, _ in ties), X], counts),
        source=np.concatenate([*(tie.grid for _, tie, _, _ in ties), [index for index, _ in lengths]]).astype(np.int64),
        bound_source=np.repeat([-1, *(index for index, _ in aspects)], [len(sizes), *(2 for _ in aspects)]),
    )


def _sorted(matrix: sparse.csr_array | sparse.csc_array) -> sparse.csc_matrix:
    """A matrix with sorted row indices, without which the solver returns wrong results."""
    columns = sparse.csc_matrix(matrix)
    columns.sum_duplicates()
    return columns


def _values(wishes: Sequence[Wish], scale: float) -> list[float]:
    """Values of the rows of wishes for sizes and positions."""
    return [wish.metres / scale for wish in wishes if not isinstance(wish, Aspect)]


def _length(axis: Axis, wish: Size | Position) -> Sums:
    """[1] the size or the position that a wish fixes."""
    node, start = np.array([wish.node]), np.zeros(1)
    if isinstance(wish, Size):
        return axis.lines.extent(node)
    return axis.lines.reach(node, start).minus(axis.lines.reach(np.zeros(1, dtype=np.int64), start))


def _aspect(axes: Sequence[Axis], firsts: Sequence[int], wish: Aspect) -> Sums:
    """[2] width - least * height and most * height - width, which must be at least 0."""
    node, order = np.array([wish.node, wish.node]), [axis.along for axis in axes]
    width, height = (
        axes[order.index(along)].lines.extent(node).shifted(firsts[order.index(along)]) for along in (X, Y)
    )
    return width.times(np.array([1.0, -1.0])).minus(height.times(np.array([wish.least, -wish.most])))
