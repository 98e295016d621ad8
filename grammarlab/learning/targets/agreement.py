"""Agreement of learned weights with target weights on a labelled set."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.learning.targets.divergence import correlation, jensen_shannon

Floats = NDArray[np.float64]


class Agreement(NamedTuple):
    """Comparison of two densities on a finite set."""

    js: float
    """Jensen-Shannon divergence in nats, 0 to ln 2."""
    correlation: float
    """Pearson correlation of the weights; 0 if one of the two is constant."""


def agreement(wanted: Floats, learned: Floats, weights: Floats) -> Agreement:
    """Compare two preferences on a labelled set.

    The densities are ``weights * wanted`` and ``weights * learned``, each divided by its sum over the set. If the
    learned preference is nowhere positive, the learned density is that of the weights only.

    Args:
        wanted: [n] true scores, >= 0, one at least positive together with its weight.
        learned: [n] predicted scores; negative ones count as 0.
        weights: [n] >= 0, importance weight of each model of the set: 1 for independent samples of the density that the
            preference multiplies (``base="grammar"``), 1 / p for ``base="uniform"``, p / (density it was drawn from)
            otherwise.
    """
    target = weights * wanted
    current = weights * np.clip(learned, 0.0, None)
    current = current if current.any() else weights
    return Agreement(jensen_shannon(target, current), correlation(target, current))
