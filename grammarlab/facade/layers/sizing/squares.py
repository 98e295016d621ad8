"""Least squares under equations and lower bounds, solved to the last digits.

Which bounds press comes from an interior-point method, and only where the optimum under the equations alone breaks
some. The numbers come from solving the equations with these bounds exactly. What the wishes leave open is as equal as
it can be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import piqp
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from grammarlab.facade.tree import Floats, Ints

_RANK = 1e-10
"""Singular values below this part of the largest, and below it, are 0."""
_EXACT = 1e-10
"""What equations and bounds may miss, as part of the scale."""
_SECOND = 1e-7
"""How much less the equality of what is open counts than the wishes, where both are solved for at once."""


@dataclass(frozen=True)
class Squares:
    """Minimise the sum of (x[index] - target)^2 subject to matrix x = value and x >= least, for U unknowns x."""

    matrix: Floats
    """[R, U]"""
    value: Floats
    """[R]"""
    index: Ints
    """[P]"""
    target: Floats
    """[P]"""
    least: float
    scale: float
    """About how large unknowns are."""

    def solve(self) -> Floats | None:
        """[U] the optimum; None when there is none."""
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
        """[U] the optimum where these bounds press, and those that would be broken then."""
        while True:
            found = self._under(pressing)
            if found is None:
                return None
            broken = (found < self.least - _EXACT * self.scale) & ~pressing
            if not broken.any():
                return found
            pressing = pressing | broken

    def optimality(self, x: Floats) -> float:
        """By how much no multipliers of equations and of pressing bounds explain the gradient (conditions of KKT)."""
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
        """[U] the optimum under the equations and some bounds as equations; None when they contradict each other."""
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
        # Once more, for the digits that the first solution lost.
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
    """The shortest least-squares solution [U] and an orthonormal basis [U, F] of what rows leave open."""
    if not rows.size:
        return np.zeros(rows.shape[1]), np.eye(rows.shape[1])
    left, size, right = np.linalg.svd(rows, full_matrices=True)
    # Rows are counts of letters, or come from a basis: what is far below 1 is round-off.
    rank = int((size > _RANK * max(size[0], 1.0)).sum())
    start = right[:rank].T @ ((left[:, :rank].T @ value) / size[:rank])
    return start, right[rank:].T
