"""The quadratic programme of Equation 1 (paper 000): sizes that deviate least, under rows that hold.

Its unknowns are the places of lines, so nothing in it can break the decomposition. Lines that rows keep on each other
are one unknown. The optimum under the equations alone is one solve of a factorised system, and mostly it is the
optimum: only where a part would become too small does an interior-point method find out which bounds hold, and the
same system with these bounds gives the exact numbers. What is returned was measured; the status of a solver is never
asked for.
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
"""What rows and bounds may miss, as part of the facade's size."""
_NEAR = 1e-8
"""What they may miss where no exact answer was found."""
_REGULAR = 1e-8
"""Makes the system regular where rows depend on each other; refinement takes its effect out again."""
_MOST_REFINEMENTS = 30


@dataclass(frozen=True, eq=False)
class QuadraticProgram:
    """Minimise the sum of (weight (part - target))^2 over places of M lines.

    Subject to rows = value and bounds >= least. Lengths are parts of the facade's size.
    """

    num_lines: int
    """M"""
    parts: Sums
    """[P] sizes; they tie every line to a place that is fixed."""
    weight: Floats
    """[P] > 0"""
    target: Floats
    """[P] sizes that parts would like to have."""
    rows: Sums
    """[R] equations; they may depend on each other."""
    still: NDArray[np.bool_]
    """[R] those whose value is always 0."""
    bounds: Sums
    """[K] inequalities."""
    least: Floats
    """[K]"""

    def solve(self, value: Floats) -> Floats | None:
        """[M] the optimal places when the rows have these values [R]; None when none was found that holds them."""
        merged, line, row = self._merged
        place = merged._solved(value[row])
        if place is None or self.misses(place[line], value) > _NEAR:
            return None
        return place[line]

    def energy(self, place: Floats) -> float:
        """What is minimised, at these places [M]."""
        return float(np.square(self.weight * (self.parts.at(place) - self.target)).sum())

    def deviation(self, place: Floats) -> float:
        """By how much the worst size at these places [M] is not what it would like to be."""
        return float(np.abs(self.parts.at(place) - self.target).max())

    def misses(self, place: Floats, value: Floats) -> float:
        """By how much the worst row, of these values [R], or bound is missed; infinite for what is not a number."""
        rows = np.abs(self.rows.at(place) - value).max(initial=0.0)
        missed = float(max(rows, (self.least - self.bounds.at(place)).max(initial=0.0)))
        return missed if np.isfinite(place).all() else np.inf

    @cached_property
    def _merged(self) -> tuple[QuadraticProgram, Ints, Ints]:
        """The same over lines that rows do not keep on each other, [M] which of these each line is, and its rows."""
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
        """[M] as `solve`, without merging lines."""
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
        """[R, M] the rows."""
        return self.rows.matrix(self.num_lines)

    @cached_property
    def _scale(self) -> float:
        """By what the objective is divided, so that its numbers are about 1."""
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
        """The conditions of the optimum, factorised; they do not depend on the values of rows."""
        below = -_REGULAR * sparse.eye_array(len(self.rows))
        system = sparse.block_array([[self._quadratic, self._matrix.T], [self._matrix, below]], format="csc")
        # Quasi-definite: any order is stable without pivoting.
        return splu(system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def _under_rows(self, value: Floats) -> Floats | None:
        """[M] the optimum under the equations alone; None when they contradict each other."""
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
        """[M] the optimum to about eight digits, and [K] which bounds press on it."""
        solver = piqp.SparseSolver()
        solver.settings.eps_abs = solver.settings.eps_rel = 1e-10
        upper = np.full(len(self.least), np.inf)
        rows, bounds = _sorted(self._matrix), _sorted(self.bounds.matrix(self.num_lines))
        solver.setup(_sorted(self._quadratic), self._linear, rows, value, bounds, self.least, upper)
        solver.solve()
        place = np.asarray(solver.result.x)
        return place, np.asarray(solver.result.z_l) > self.bounds.at(place) - self.least


def _sorted(matrix: sparse.csr_array | sparse.csc_array) -> sparse.csc_matrix:
    """A matrix as the solver wants it, which gives wrong answers to columns whose rows are not in order."""
    columns = sparse.csc_matrix(matrix)
    columns.sum_duplicates()
    return columns
