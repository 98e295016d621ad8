"""The quadratic programme of Equation 1 (paper 000): sizes with the least deviation, subject to rows.

Its unknowns are the positions of lines, so decomposition always holds. Lines with a constant distance by a row are one
unknown. The optimum under the equations alone is one solve of a factorised system, and usually it is the optimum: only
if a part would become too small, an interior-point method finds the active bounds, and the same system with these
bounds gives accurate values. The accuracy of results is measured; the status of a solver is not used.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import piqp
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import SuperLU, splu

from grammarlab.facade.sizes.lines import Sums, stacked
from grammarlab.facade.tree import Floats, Ints

EXACT = 1e-9
"""Largest violation of rows and bounds, as a fraction of the facade's size."""
_NEAR = 1e-8
"""Largest violation if no accurate solution was found."""
_REGULAR = 1e-8
"""Regularisation for linearly dependent rows; iterative refinement removes its effect."""
_MOST_REFINEMENTS = 30


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
    still: NDArray[np.bool_]
    """[R] whether the value is always 0."""
    bounds: Sums
    """[K] left-hand sides of inequalities."""
    least: Floats
    """[K] right-hand sides of inequalities."""

    def solve(self, value: Floats) -> Floats | None:
        """[M] the optimal positions for values [R] of the rows; None if no valid solution was found."""
        merged, line, row = self._merged
        place = merged._solved(value[row])
        if place is None or self.misses(place[line], value) > _NEAR:
            return None
        return place[line]

    def energy(self, place: Floats) -> float:
        """The objective at these positions [M]."""
        return float(np.square(self.weight * (self.parts.at(place) - self.target)).sum())

    def deviation(self, place: Floats) -> float:
        """Largest difference of a size from its target at these positions [M]."""
        return float(np.abs(self.parts.at(place) - self.target).max())

    def misses(self, place: Floats, value: Floats) -> float:
        """Largest violation of the rows, with these values [R], and of bounds; infinite for NaN."""
        rows = np.abs(self.rows.at(place) - value).max(initial=0.0)
        missed = float(max(rows, (self.least - self.bounds.at(place)).max(initial=0.0)))
        return missed if np.isfinite(place).all() else np.inf

    @cached_property
    def _merged(self) -> tuple[QuadraticProgram, Ints, Ints]:
        """The programme with lines of constant distance merged, [M] merged line of each line, and its rows."""
        line = np.arange(self.num_lines)
        fixed = Sums(self.rows.line[self.still], self.rows.factor[self.still])
        while True:
            one, other = fixed.over(line).equal_pairs()
            if not one.size:
                break
            graph = sparse.coo_array((np.ones(len(one)), (one, other)), shape=(self.num_lines, self.num_lines))
            line = connected_components(graph, directed=False)[1][line].astype(np.int64)
        rows = self.rows.over(line)
        row = np.flatnonzero(~self.still | (rows.factor != 0.0).any(axis=1))
        merged = replace(
            self,
            num_lines=int(line.max()) + 1,
            parts=self.parts.over(line),
            rows=Sums(rows.line[row], rows.factor[row]),
            still=self.still[row],
            bounds=self.bounds.over(line),
        )
        return merged, line, row

    def _solved(self, value: Floats) -> Floats | None:
        """[M] see `solve`, without merging lines."""
        place = self._under_rows(value)
        if place is None or self.misses(place, value) <= EXACT:
            return place
        near, pressed = self._interior_point(value)
        missed = self.misses(near, value)
        if missed > _NEAR:
            return None
        rows = stacked([self.rows, Sums(self.bounds.line[pressed], self.bounds.factor[pressed])])
        exact = replace(self, rows=rows)._under_rows(np.concatenate([value, self.least[pressed]]))
        if exact is None or self.misses(exact, value) > max(EXACT, missed):
            return near
        return exact if self.energy(exact) <= (1.0 + EXACT) * self.energy(near) else near

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
        below = -_REGULAR * sparse.eye_array(len(self.rows))
        system = sparse.block_array([[self._quadratic, self._matrix.T], [self._matrix, below]], format="csc")
        # Quasi-definite: any order is stable without pivoting.
        return splu(system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def _under_rows(self, value: Floats) -> Floats | None:
        """[M] the optimum under the equations alone; None if they contradict each other."""
        num = self.num_lines
        solution, miss = np.zeros(num + len(value)), np.inf
        for _ in range(_MOST_REFINEMENTS):
            place, multiplier = solution[:num], solution[num:]
            pull = -self._linear - self._quadratic @ place - self._matrix.T @ multiplier
            residual = np.concatenate([pull, value - self._matrix @ place])
            before, miss = miss, np.abs(residual).max()
            if miss <= 1e-16 or miss > 0.5 * before:
                break
            solution = solution + self._factor.solve(residual)
        place = solution[:num]
        return place if np.abs(self._matrix @ place - value).max(initial=0.0) <= EXACT else None

    def _interior_point(self, value: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """[M] the optimum to about eight digits, and [K] the active bounds."""
        solver = piqp.SparseSolver()
        solver.settings.eps_abs = solver.settings.eps_rel = 1e-10
        upper = np.full(len(self.least), np.inf)
        rows, bounds = _sorted(self._matrix), _sorted(self.bounds.matrix(self.num_lines))
        solver.setup(_sorted(self._quadratic), self._linear, rows, value, bounds, self.least, upper)
        solver.solve()
        place = np.asarray(solver.result.x)
        return place, np.asarray(solver.result.z_l) > self.bounds.at(place) - self.least


def _sorted(matrix: sparse.csr_array | sparse.csc_array) -> sparse.csc_matrix:
    """A matrix with sorted row indices, without which the solver returns wrong results."""
    columns = sparse.csc_matrix(matrix)
    columns.sum_duplicates()
    return columns
