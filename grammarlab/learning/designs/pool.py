"""The pool of designs to ask about: which designs of which seeds it holds.

Most are samples of the space; the others are samples of its proposal, since what is rare would otherwise never be asked
about. Once liked designs have turned out to be rare, a wider pool holds many more of these.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.settings import POOL_SIZE
from grammarlab.randomness import derived_seed

PROPOSAL_PART = 5
"""One design in 5 is a sample of the proposal."""
WIDER = 10
"""How many times as many samples of the proposal a wide pool holds."""
MOST_WIDER = 50_000
"""At most as many of these, unless the pool held more before: memory and time are bounded."""
_LANES = 1, 2
"""Places below a seed that both parts have their seeds from."""


@dataclass(frozen=True, slots=True)
class Pool:
    """Names of designs: samples of a space first, then samples of its proposal."""

    seed: int = 0
    """0 <= seed < 2**64; the seeds of both parts follow from it."""
    size: int = POOL_SIZE
    """Designs before the pool is widened."""
    wide: bool = False
    """Whether it is widened for rare designs, which come last: the others stay where they are."""

    @property
    def sizes(self) -> tuple[int, int]:
        """How many designs are samples of the space, and how many of the proposal."""
        flat = self.size // PROPOSAL_PART
        return self.size - flat, max(flat, min(WIDER * flat, MOST_WIDER)) if self.wide else flat

    @property
    def seeds(self) -> tuple[int, int]:
        """The seeds of both parts."""
        own, flat = (derived_seed(self.seed, lane) for lane in _LANES)
        return own, flat

    def __len__(self) -> int:
        return sum(self.sizes)

    def __iter__(self) -> Iterator[Address]:
        """All addresses in order."""
        for flat, (num, seed) in enumerate(zip(self.sizes, self.seeds, strict=True)):
            yield from (Address(bool(flat), seed, model) for model in range(num))

    def log_weights(self, log_ratios: NDArray[np.float64]) -> NDArray[np.float64]:
        """[m] log of the space's density by the density that the pool is drawn from, both parts together.

        Args:
            log_ratios: [m] log of the space's density by that of the proposal, of each design.
        """
        share = self.sizes[1] / len(self)
        with np.errstate(divide="ignore"):
            return -np.logaddexp(np.log1p(-share), np.log(share) - log_ratios)
