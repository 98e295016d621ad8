"""L-BFGS for a smooth function of a few hundred variables, within bounds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from grammarlab.preference.base import Floats

Evaluate = Callable[[Floats], tuple[float, Floats]]
"""Function from a point [d] to its value and gradient [d]."""


@dataclass(frozen=True, slots=True)
class Minimum:
    """Result of a search."""

    point: Floats
    """[d] the best point."""
    value: float
    iterations: int
    evaluations: int
    converged: bool
    """Whether it converged before the limit of iterations."""


def minimise(
    evaluate: Evaluate,
    start: Floats,
    low: Floats,
    high: Floats,
    *,
    max_iterations: int,
    relative_gain: float = 1e-7,
) -> Minimum:
    """A local minimum, or the best evaluated point, within low <= point <= high, by SciPy's L-BFGS-B.

    Args:
        evaluate: the function; a point with a value that is not finite counts as very bad.
        start: [d] initial point.
        low: [d] lower bounds.
        high: [d] upper bounds.
        max_iterations: largest number of iterations.
        relative_gain: stop when an iteration gains less than this share of the value's size.
    """
    first = np.clip(start, low, high)
    visited = _Visited(evaluate, first)
    result = minimize(
        visited,
        first,
        jac=True,
        method="L-BFGS-B",
        bounds=np.stack((low, high), axis=1),
        options={"maxiter": max_iterations, "maxfun": 2 * max_iterations + 20, "ftol": relative_gain, "gtol": 1e-4},
    )
    # Near cliffs the line search may step up and report convergence; then the search continues from the best point.
    rose = result.fun > visited.value
    return Minimum(
        visited.point, visited.value, int(result.nit), int(result.nfev), converged=bool(result.success) and not rose
    )


class _Visited:
    """A function that records its best point; values that are not finite count as very bad."""

    def __init__(self, evaluate: Evaluate, start: Floats) -> None:
        self.point, self.value = start, np.inf
        self._evaluate, self._worst = evaluate, 0.0

    def __call__(self, point: Floats) -> tuple[float, Floats]:
        value, gradient = self._evaluate(point)
        if not (np.isfinite(value) and np.isfinite(gradient).all()):
            return 10.0 * self._worst + 1e6, np.zeros_like(point)
        if value < self.value:
            self.point, self.value = point.copy(), value
        self._worst = max(self._worst, abs(value))
        return value, gradient
