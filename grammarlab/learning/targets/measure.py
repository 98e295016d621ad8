"""How near a learned density comes to another one, on a set of designs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.learning.targets.agreement import Agreement, agreement

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Measured:
    """A learned density beside the wanted one."""

    after: Agreement
    before: Agreement
    """The same of the original grammar."""
    num_models: int
    """How many models they were compared on."""
    effective_models: float
    """Of how many of these the wanted density is made: (sum w)^2 / sum w^2."""
    acceptance: float
    """Share of the original grammar's models that rejection would accept, with the largest weight met as the bound."""


def measured(wanted: Floats, learned: Floats, weights: Floats) -> Measured:
    """Compares densities on a set of models.

    Args:
        wanted: [n] density by that of the original grammar, up to a factor, >= 0, one at least above 0.
        learned: [n] likewise.
        weights: [n] what each model stands for under the original grammar, >= 0.
    """
    liked = weights * wanted
    return Measured(
        agreement(wanted, learned, weights),
        agreement(wanted, np.ones(len(wanted)), weights),
        len(wanted),
        float(liked.sum() ** 2 / (liked**2).sum()),
        float(liked.sum() / weights.sum() / wanted[weights > 0.0].max()),
    )
