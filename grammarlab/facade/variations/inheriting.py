"""Locks of a facade in its variations: copies of locked nodes are locked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grammarlab.facade.sizes.wishes import Position, Wish
from grammarlab.facade.tree import Facade
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


def lost(facade: Facade, locks: Sequence[Wish], variation: Variation) -> tuple[Wish, ...]:
    """Locks of parts of which neither a copy is left, nor a part of the same label with an equal lock.

    Args:
        facade: the original facade.
        locks: its locks; positions are not lost, since they do not apply to variations.
        variation: a variation of that facade.
    """
    left = {_alike(variation.facade, lock) for lock in inherited(locks, variation)}
    return tuple(
        lock for lock in locks if lock.node and not isinstance(lock, Position) and _alike(facade, lock) not in left
    )


def _alike(facade: Facade, lock: Wish) -> tuple[int, Wish]:
    """The label of a locked part, and its lock without the number of the node."""
    return int(facade.label[lock.node]), replace(lock, node=0)
