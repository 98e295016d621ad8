"""The pool of models to ask about: which models of which seeds it holds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.evaluation.seeds import derived_seed

FLATTENED_PART = 5
"""One model of so many is a sample of the flattened grammar, the others are samples of the grammar."""
WIDER = 10
"""How many times as many samples of the flattened grammar a pool holds where liked models are rare."""
MOST_WIDER = 50_000
"""So many of these at most, unless the pool holds more before it is widened: memory and time are bounded."""
_LANES = 1, 2
"""Places below a seed that both parts have their seeds from."""


def pool_sizes(size: int, wide: bool = False) -> tuple[int, int]:
    """How many models of a pool are samples of the grammar, and how many of the flattened grammar.

    Args:
        size: both together, before the pool is widened.
        wide: whether it is widened for rare models; the first ones are those of the pool that is not.
    """
    flat = size // FLATTENED_PART
    return size - flat, max(flat, min(WIDER * flat, MOST_WIDER)) if wide else flat


def pool_log_weights(log_ratios: NDArray[np.float64], sizes: tuple[int, int]) -> NDArray[np.float64]:
    """[m] log of the grammar's density by the density that the models of a pool were drawn from, both parts together.

    Args:
        log_ratios: [m] log of the grammar's density by that of the flattened grammar, of each model.
        sizes: as of `pool_sizes`.
    """
    share = sizes[1] / sum(sizes)
    with np.errstate(divide="ignore"):
        return -np.logaddexp(np.log1p(-share), np.log(share) - log_ratios)


def pool_seeds(seed: int) -> tuple[int, int]:
    """The seeds of both parts.

    Args:
        seed: of the pool, 0 <= seed < 2**64.
    """
    grammar, flat = (derived_seed(seed, lane) for lane in _LANES)
    return grammar, flat
