"""Pool of designs to ask about: their seeds and numbers, and the designs made from these.

Most are samples of the space; the others are samples of its proposal, since rare designs would otherwise never be asked
about. If liked designs are rare, a wider pool has many more samples of the proposal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import AbstractDesignSpace, Designs
from grammarlab.learning.settings import POOL_SIZE
from grammarlab.randomness import derived_seed

OnProgress = Callable[[int, int], None]
"""Function called with the number of finished designs and the number of all designs."""
WIDE_FACTOR = 10
"""Factor of the number of samples of the proposal in a wide pool."""
MAX_WIDE = WIDE_FACTOR * POOL_SIZE
"""Largest number of samples of the proposal in a wide pool, unless the pool had more; it bounds memory and time."""
_PROPOSAL_STRIDE = 5
"""One design in 5 is a sample of the proposal."""
_LANES = 1, 2
"""Lanes below a seed (`derived_seed`) for the seeds of both parts."""


@dataclass(frozen=True, slots=True)
class Pool:
    """Addresses of designs: samples of a space first, then samples of its proposal."""

    seed: int = 0
    """0 <= seed < 2**64; the seeds of both parts follow from it."""
    size: int = POOL_SIZE
    """Number of designs before the pool is widened."""
    wide: bool = False
    """Whether it is widened for rare designs; these come last, so that the order of the others does not change."""

    @classmethod
    def usual(cls, space: AbstractDesignSpace[Designs], seed: int = 0) -> Pool:
        """The pool of a space, unless something else is asked for."""
        return cls(seed, space.pool_size)

    @property
    def sizes(self) -> tuple[int, int]:
        """Number of samples of the space, and of the proposal."""
        flat = self.size // _PROPOSAL_STRIDE
        return self.size - flat, max(flat, min(WIDE_FACTOR * flat, MAX_WIDE)) if self.wide else flat

    @property
    def seeds(self) -> tuple[int, int]:
        """The seeds of both parts."""
        space_seed, proposal_seed = (derived_seed(self.seed, lane) for lane in _LANES)
        return space_seed, proposal_seed

    def __len__(self) -> int:
        return sum(self.sizes)

    def __iter__(self) -> Iterator[Address]:
        """All addresses in order."""
        for flat, (num, seed) in enumerate(zip(self.sizes, self.seeds, strict=True)):
            yield from (Address(bool(flat), seed, model) for model in range(num))

    def log_weights(self, log_ratios: NDArray[np.float64]) -> NDArray[np.float64]:
        """[m] log of the space's density divided by the density of the pool, both parts together.

        Args:
            log_ratios: [m] log of the space's density divided by that of the proposal, for each design.
        """
        share = self.sizes[1] / len(self)
        with np.errstate(divide="ignore"):
            return -np.logaddexp(np.log1p(-share), np.log(share) - log_ratios)


@dataclass(frozen=True, eq=False)
class PoolDesigns(Generic[Designs]):
    """A pool with its designs."""

    pool: Pool
    batches: tuple[Designs, ...]
    """Batches in the order of the pool."""
    log_ratios: tuple[Floats, ...]
    """Log-ratios [n] of each batch: log of the space's density divided by that of the proposal."""

    @classmethod
    def of(
        cls,
        space: AbstractDesignSpace[Designs],
        pool: Pool,
        narrow: PoolDesigns[Designs] | None = None,
        on_progress: OnProgress = lambda _done, _total: None,
    ) -> PoolDesigns[Designs]:
        """Make the designs.

        Args:
            space: the design space.
            pool: the addresses.
            narrow: the designs before the pool was widened, if they exist: they come first.
            on_progress: called with the number of finished designs.
        """
        batches, ratios = ([], []) if narrow is None else ([*narrow.batches], [*narrow.log_ratios])
        old_sizes = (0, 0) if narrow is None else narrow.pool.sizes
        done = sum(old_sizes)
        for flat, (size, first, seed) in enumerate(zip(pool.sizes, old_sizes, pool.seeds, strict=True)):
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
        selected, first = [], 0
        for designs, ratios in zip(self.batches, self.log_ratios, strict=True):
            inside = indices[(indices >= first) & (indices < first + len(ratios))] - first
            if len(inside):
                selected.append(space.take(designs, inside))
            first += len(ratios)
        return tuple(selected)
