"""Models of a grammar that a preference is looked at on: what is common, and what is rare."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest
from grammarlab.evaluation.flattening import flattened
from grammarlab.evaluation.pool import pool_log_weights, pool_sizes
from grammarlab.evaluation.preparation import pool_models, without_geometry
from grammarlab.evaluation.scenario import DEFAULT_MODELS
from grammarlab.language.grammar import Grammar

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Pool:
    """Samples of a grammar, a part of them of the grammar with equal percentages."""

    forests: tuple[Forest, ...]
    """Without geometry."""
    log_weights: Floats
    """[m] log of the grammar's density by the density that the models were drawn from, both parts together."""

    @classmethod
    def of(cls, grammar: Grammar, assets: Path | None, seed: int = 0, size: int = DEFAULT_MODELS) -> Pool:
        """Derives the models.

        Args:
            grammar: the grammar.
            assets: folder of meshes and images.
            seed: 0 <= seed < 2**64.
            size: how many models.
        """
        flat = flattened(grammar)
        sizes = pool_sizes(size)
        forests, ratios = [], []
        for forest in pool_models(grammar, flat, sizes, seed, assets):
            forests.append(without_geometry(forest))
            ratios.append(flat.log_ratio(forest))
        return cls(tuple(forests), pool_log_weights(np.concatenate(ratios), sizes))

    @cached_property
    def weights(self) -> Floats:
        """[m] the same not as a logarithm; the largest is at most 1 / (share of samples of the grammar itself)."""
        return np.exp(self.log_weights)
