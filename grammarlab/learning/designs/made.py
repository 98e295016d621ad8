"""Designs made from the addresses of a pool."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Generic

import numpy as np

from grammarlab.learning.designs.design_space import AbstractDesignSpace, Designs, Floats, Ints
from grammarlab.learning.designs.pool import Pool

OnProgress = Callable[[int, int], None]
"""Function called with the number of finished designs and the number of all designs."""


@dataclass(frozen=True, eq=False)
class MadePool(Generic[Designs]):
    """A pool with its designs."""

    pool: Pool
    batches: tuple[Designs, ...]
    """Batches in the order of the pool."""
    log_ratios: tuple[Floats, ...]
    """[n] for each batch: log of the space's density divided by that of the proposal."""

    @classmethod
    def of(
        cls,
        space: AbstractDesignSpace[Designs],
        pool: Pool,
        narrow: MadePool[Designs] | None = None,
        on_progress: OnProgress = lambda _done, _total: None,
    ) -> MadePool[Designs]:
        """Make the designs.

        Args:
            space: the design space.
            pool: the addresses.
            narrow: the designs before the pool was widened, if they exist: they come first.
            on_progress: called with the number of finished designs.
        """
        batches, ratios = ([], []) if narrow is None else ([*narrow.batches], [*narrow.log_ratios])
        known = (0, 0) if narrow is None else narrow.pool.sizes
        done = sum(known)
        for flat, (size, first, seed) in enumerate(zip(pool.sizes, known, pool.seeds, strict=True)):
            for designs in space.sample(bool(flat), size - first, seed, first):
                batches.append(designs)
                ratios.append(space.log_ratio(designs))
                done += len(ratios[-1])
                on_progress(done, len(pool))
        return cls(pool, tuple(batches), tuple(ratios))

    @cached_property
    def weights(self) -> Floats:
        """[m] importance weight of each design under the space's density, at most 1 / (share of its own samples)."""
        return np.exp(self.pool.log_weights(np.concatenate([np.zeros(0), *self.log_ratios])))

    def select(self, space: AbstractDesignSpace[Designs], indices: Ints) -> tuple[Designs, ...]:
        """Selected designs, by ascending index."""
        found, first = [], 0
        for designs, ratios in zip(self.batches, self.log_ratios, strict=True):
            inside = indices[(indices >= first) & (indices < first + len(ratios))] - first
            if len(inside):
                found.append(space.take(designs, inside))
            first += len(ratios)
        return tuple(found)
