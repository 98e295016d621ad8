"""Locks of a facade in its variations: copies of locked nodes are locked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grammarlab.facade.sizes.wishes import Position, Wish
from grammarlab.facade.variations.single import Variation

_WHOLE = [0.0, 0.0, 1.0, 1.0]


def inherited(locks: Sequence[Wish], variation: Variation) -> tuple[Wish, ...]:
    """Locks of remaining nodes, and of their copies.

    Cut nodes have no locks. Positions have changed, so locks of positions are dropped.

    Args:
        locks: locks of the original facade.
        variation: a variation of that facade.
    """
    whole = np.isclose(variation.shown, _WHOLE).all(axis=1)
    found: list[Wish] = []
    for lock in locks:
        if isinstance(lock, Position):
            continue
        nodes = np.flatnonzero(whole & (variation.source == lock.node)).tolist() if lock.node else [0]
        found += [replace(lock, node=node) for node in nodes]
    return tuple(found)
