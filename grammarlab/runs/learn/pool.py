"""Models of a grammar that a preference is looked at on: what is common, and what is rare."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest
from grammarlab.evaluation.flattening import flattened
from grammarlab.evaluation.pool import pool_log_weights, pool_sizes
from grammarlab.evaluation.preparation import pool_models
from grammarlab.evaluation.scenario import DEFAULT_MODELS
from grammarlab.features.stripping import without_geometry
from grammarlab.language.grammar import Grammar

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Pool:
    """Samples of a grammar, a part of them of the grammar with equal percentages."""

    forests: tuple[Forest, ...]
    """Without geometry."""
    log_ratios: Floats
    """[m] log of the grammar's density by that of the grammar with equal percentages."""
    sizes: tuple[int, int]
    """How many are samples of either."""

    @classmethod
    def of(
        cls,
        grammar: Grammar,
        assets: Path | None,
        seed: int = 0,
        size: int = DEFAULT_MODELS,
        *,
        wide: bool = False,
        known: Pool | None = None,
        on_progress: Callable[[int, int], None] = lambda _done, _total: None,
    ) -> Pool:
        """Derives the models.

        Args:
            grammar: the grammar.
            assets: folder of meshes and images.
            seed: 0 <= seed < 2**64.
            size: how many models, before the pool is widened.
            wide: whether it is widened for rare models (`grammarlab.evaluation.pool`).
            known: the same before it was widened, where that has been derived: the first models are taken from it.
            on_progress: told again and again how many models there are, of how many.
        """
        flat = flattened(grammar)
        sizes, known = pool_sizes(size, wide), known or cls((), np.zeros(0), (0, 0))
        forests, ratios, done = [*known.forests], [known.log_ratios], sum(known.sizes)
        for forest in pool_models(grammar, flat, sizes, seed, assets, known.sizes):
            forests.append(without_geometry(forest))
            ratios.append(flat.log_ratio(forest))
            done += forest.num_models
            on_progress(done, sum(sizes))
        return cls(tuple(forests), np.concatenate(ratios), sizes)

    @cached_property
    def weights(self) -> Floats:
        """[m] the grammar's density by the density that the models were drawn from, both parts together.

        The largest is at most 1 / (share of samples of the grammar itself).
        """
        return np.exp(pool_log_weights(self.log_ratios, self.sizes))
