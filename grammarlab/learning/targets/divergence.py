"""Divergence and correlation of two densities over the same set of models."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import rel_entr

from grammarlab.errors import UsageError

Floats = NDArray[np.float64]


def jensen_shannon(p: ArrayLike, q: ArrayLike) -> float:
    """Jensen-Shannon divergence of two densities, in nats.

    The mean of the relative entropies of both to their mean; the measure of section 4.7. It is symmetric, 0 if the two
    are proportional, and ln 2 if they have disjoint supports.

    Args:
        p: [n] weights, finite and >= 0, not all 0; divided by their sum here.
        q: [n] weights, finite and >= 0, not all 0; divided by their sum here.

    Raises:
        UsageError: If weights are not a density.

    >>> jensen_shannon([1, 1, 0, 0], [2, 2, 0, 0]), round(jensen_shannon([1, 0], [0, 1]), 4)
    (0.0, 0.6931)
    """
    left, right = _densities(p, q)
    middle = 0.5 * (left + right)
    nats = 0.5 * float(rel_entr(left, middle).sum() + rel_entr(right, middle).sum())
    # Rounding may exceed the bounds by a few ulps.
    return min(max(nats, 0.0), float(np.log(2.0)))


def correlation(p: ArrayLike, q: ArrayLike) -> float:
    """Pearson correlation of the weights of two densities (appendix B), -1 to 1; 0 if one of the two is constant.

    Args:
        p: [n] weights, finite and >= 0, not all 0.
        q: [n] weights, finite and >= 0, not all 0.

    Raises:
        UsageError: If weights are not a density.
    """
    left, right = _densities(p, q)
    left, right = left - left.mean(), right - right.mean()
    spread = float(np.sqrt((left @ left) * (right @ right)))
    # Densities sum to 1, so rounding errors of a constant are far below this.
    return float(np.clip(left @ right / spread, -1.0, 1.0)) if spread > 1e-24 else 0.0


def _densities(p: ArrayLike, q: ArrayLike) -> tuple[Floats, Floats]:
    left, right = _density(p), _density(q)
    if len(left) != len(right):
        raise UsageError(f"expected two densities over the same models, found {len(left)} and {len(right)} weights")
    return left, right


def _density(weights: ArrayLike) -> Floats:
    values = np.asarray(weights, dtype=np.float64)
    if values.ndim != 1:
        raise UsageError(f"expected one weight per model, found an array of shape {values.shape}")
    if not (np.isfinite(values).all() and (values >= 0).all() and (values > 0).any()):
        raise UsageError(
            "expected weights that are finite, at least 0 and not all 0: a density over models; found " + _fault(values)
        )
    # Twice, since the sum of large weights may overflow.
    values = values / values.max()
    return values / values.sum()


def _fault(values: Floats) -> str:
    if not len(values):
        return "no weights"
    wrong = values[~np.isfinite(values) | (values < 0)]
    return f"{len(wrong)} of {len(values)} that are not, {wrong[0]} first" if len(wrong) else "zeros only"
