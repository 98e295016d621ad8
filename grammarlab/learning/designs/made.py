"""The designs of a pool, made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Generic

import numpy as np

from grammarlab.learning.designs.design_space import AbstractDesignSpace, Designs, Floats, Ints
from grammarlab.learning.designs.pool import Pool

OnProgress = Callable[[int, int], None]
"""Told how many designs are made, of how many."""


@dataclass(frozen=True, eq=False)
class MadePool(Generic[Designs]):
    """A pool with its designs."""

    pool: Pool
    batches: tuple[Designs, ...]
    """In the order of the pool."""
    log_ratios: tuple[Floats, ...]
    """[n] of each batch: log of the space's density by that of the proposal."""

    @classmethod
    def of(
        cls,
        space: AbstractDesignSpace[Designs],
        pool: Pool,
        narrow: MadePool[Designs] | None = None,
        on_progress: OnProgress = lambda _done, _total: None,
    ) -> MadePool[Designs]:
        """Makes the designs.

        Args:
            space: of the designs.
            pool: which ones.
            narrow: the same before the pool was widened, where that has been made: it is the beginning.
            on_progress: told about designs.
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
        """[m] how much of the space's density each design stands for, at most 1 / (share of its own samples)."""
        return np.exp(self.pool.log_weights(np.concatenate([np.zeros(0), *self.log_ratios])))

    def select(self, space: AbstractDesignSpace[Designs], indices: Ints) -> tuple[Designs, ...]:
        """Some designs, by ascending index."""
        found, first = [], 0
        for designs, ratios in zip(self.batches, self.log_ratios, strict=True):
            inside = indices[(indices >= first) & (indices < first + len(ratios))] - first
            if len(inside):
                found.append(space.take(designs, inside))
            first += len(ratios)
        return tuple(found)
