"""The pool of models to ask about: which models of which seeds it holds."""

from __future__ import annotations

from grammarlab.evaluation.seeds import derived_seed

FLATTENED_PART = 5
"""One model of so many is a sample of the flattened grammar, the others are samples of the grammar."""
_LANES = 1, 2
"""Places below a seed that both parts have their seeds from."""


def pool_sizes(size: int) -> tuple[int, int]:
    """How many models of a pool are samples of the grammar, and how many of the flattened grammar."""
    return size - size // FLATTENED_PART, size // FLATTENED_PART


def pool_seeds(seed: int) -> tuple[int, int]:
    """The seeds of both parts.

    Args:
        seed: of the pool, 0 <= seed < 2**64.
    """
    grammar, flat = (derived_seed(seed, lane) for lane in _LANES)
    return grammar, flat
