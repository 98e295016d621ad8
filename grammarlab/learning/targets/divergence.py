"""Divergence and correlation of a learned density and the target density over one set of models."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import rel_entr

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError


class Agreement(NamedTuple):
    """Comparison of two densities on a finite set."""

    js: float
    """Jensen-Shannon divergence in nats, 0 to ln 2."""
    correlation: float
    """Pearson correlation of the weights; 0 if one of the two is constant."""


@dataclass(frozen=True, slots=True)
class Measured:
    """A learned density compared with the target density."""

    after: Agreement
    """Comparison of the learned density with the target density."""
    before: Agreement
    """Comparison of the original grammar's density with the target density."""
    num_models: int
    """Number of models in the comparison."""
    effective_models: float
    """Effective number of models under the target density: (sum w)^2 / sum w^2."""
    acceptance: float
    """Share of the original grammar's models that rejection would accept, with the largest weight here as bound."""


def measured(target: Floats, learned: Floats, weights: Floats) -> Measured:
    """Compare densities on a set of models.

    Args:
        target: [n] target density divided by that of the original grammar, up to a factor, >= 0, not all 0.
        learned: [n] learned density divided by that of the original grammar, up to a factor, >= 0.
        weights: [n] importance weights under the original grammar, >= 0.
    """
    liked = weights * target
    return Measured(
        agreement(target, learned, weights),
        agreement(target, np.ones(len(target)), weights),
        len(target),
        float(liked.sum() ** 2 / (liked**2).sum()),
        float(liked.sum() / weights.sum() / target[weights > 0.0].max()),
    )


def correlation(p: ArrayLike, q: ArrayLike) -> float:
    """Pearson correlation of the weights of two densities (appendix B), -1 to 1; 0 if one of the two is constant.

    Args:
        p: [n] weights, finite and >= 0, not all 0.
        q: [n] weights, finite and >= 0, not all 0.

    Raises:
        UsageError: If weights are not a density.
    """
    first, second = _densities(p, q)
    first, second = first - first.mean(), second - second.mean()
    spread = float(np.sqrt((first @ first) * (second @ second)))
    # Densities sum to 1, so rounding errors of a constant are far below this.
    return float(np.clip(first @ second / spread, -1.0, 1.0)) if spread > 1e-24 else 0.0


def agreement(scores: Floats, predicted: Floats, weights: Floats) -> Agreement:
    """Compare two preferences on a labelled set.

    The densities are ``weights * scores`` and ``weights * predicted``, each divided by its sum over the set. If the
    learned preference is nowhere positive, the learned density is that of the weights only.

    Args:
        scores: [n] true scores, >= 0, one at least positive together with its weight.
        predicted: [n] predicted scores; negative ones count as 0.
        weights: [n] >= 0, importance weight of each model of the set: 1 for independent samples of the density that the
            preference multiplies (``base="grammar"``), 1 / p for ``base="uniform"``, p / (density it was drawn from)
            otherwise.
    """
    target = weights * scores
    current = weights * np.clip(predicted, 0.0, None)
    current = current if current.any() else weights
    return Agreement(jensen_shannon(target, current), correlation(target, current))


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
    first, second = _densities(p, q)
    mixture = 0.5 * (first + second)
    nats = 0.5 * float(rel_entr(first, mixture).sum() + rel_entr(second, mixture).sum())
    # Rounding may exceed the bounds by a few ulps.
    return min(max(nats, 0.0), float(np.log(2.0)))


def _densities(p: ArrayLike, q: ArrayLike) -> tuple[Floats, Floats]:
    first, second = _density(p), _density(q)
    if len(first) != len(second):
        raise UsageError(f"expected two densities over the same models, found {len(first)} and {len(second)} weights")
    return first, second


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
