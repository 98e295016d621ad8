"""Distance of a learned density from the target density, on a set of designs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.learning.targets.agreement import Agreement, agreement

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Measured:
    """A learned density compared with the target density."""

    after: Agreement
    before: Agreement
    """The same of the original grammar."""
    num_models: int
    """Number of models in the comparison."""
    effective_models: float
    """Effective number of models under the target density: (sum w)^2 / sum w^2."""
    acceptance: float
    """Share of the original grammar's models that rejection would accept, with the largest found weight as bound."""


def measured(wanted: Floats, learned: Floats, weights: Floats) -> Measured:
    """Compare densities on a set of models.

    Args:
        wanted: [n] target density divided by that of the original grammar, up to a factor, >= 0, not all 0.
        learned: [n] the same for the learned density.
        weights: [n] importance weights under the original grammar, >= 0.
    """
    liked = weights * wanted
    return Measured(
        agreement(wanted, learned, weights),
        agreement(wanted, np.ones(len(wanted)), weights),
        len(wanted),
        float(liked.sum() ** 2 / (liked**2).sum()),
        float(liked.sum() / weights.sum() / wanted[weights > 0.0].max()),
    )
