"""What a person edits: a facade, the sizes that it would like to have, and those that are locked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.axes import Origin
from grammarlab.facade.proposals import with_proposals
from grammarlab.facade.sizes import Resized, Sizing, prepare
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.facade.variations import Variation
from grammarlab.facade.wishes import Aspect, Size, Wish, checked

ASPECT = 2
"""What is locked of a node beside its width (`X`) and its height (`Y`)."""
_WHOLE = [0.0, 0.0, 1.0, 1.0]


@dataclass(frozen=True, eq=False)
class Document:
    """One state of what is edited; every change makes another one."""

    facade: Facade
    origin: Origin
    """From which deviations count: sizes before any side was dragged, so that a side dragged back undoes it."""
    locks: tuple[Wish, ...] = ()
    """Sizes and aspects that stay, at most one per node and axis."""

    def sizing(self) -> Sizing:
        """Ready to be solved for any width and height."""
        return prepare(self.facade, self.wishes(self.facade.width, self.facade.height), self.origin)

    def wishes(self, width: float, height: float) -> tuple[Wish, ...]:
        """What a facade of that size has to fulfil."""
        return (Size(0, X, width), Size(0, Y, height), *self.locks)

    def settled(self, resized: Resized) -> Document:
        """The facade with sizes that were solved for.

        Raises:
            FacadeError: when wishes contradict each other: which.
        """
        if resized.conflict:
            raise FacadeError(contradiction(resized.conflict))
        return replace(self, facade=resized.facade)


def opened(facade: Facade) -> Document:
    """A facade as it is in its file; grids are proposed where it has none."""
    facade = facade if facade.grids else with_proposals(facade)
    return Document(facade, Origin(facade.position, facade.size, facade.size[0]))


def contradiction(conflict: Sequence[str]) -> str:
    """Wishes that contradict each other as a sentence."""
    return f"These cannot all be met: {'; '.join(conflict)}."


def locked(document: Document, node: int, what: int) -> Document:
    """The size of a node, or its aspect, stays as it is from now on."""
    facade = document.facade
    checked([Aspect(node, 1.0, 1.0)], facade)
    if what == ASPECT:
        aspect = float(facade.size[node, X] / facade.size[node, Y])
        return _with_lock(document, Aspect(node, aspect, aspect))
    return _with_lock(document, Size(node, what, float(facade.size[node, what])))


def unlocked(document: Document, node: int, what: int) -> Document:
    """A node without a lock of this kind."""
    return replace(document, locks=tuple(lock for lock in document.locks if _key(lock) != (node, what)))


def sized(document: Document, node: int, axis: int, metres: float) -> Document:
    """A node that has a size, and keeps it; the facade as large as before.

    Raises:
        FacadeError: when that contradicts other locks, or what is alike and aligned: which.
    """
    wished = _with_lock(document, Size(node, axis, metres))
    checked(wished.locks, document.facade)
    return wished.settled(wished.sizing().resized(wished.wishes(document.facade.width, document.facade.height)))


def varied(document: Document, variation: Variation, along: int) -> tuple[Document, Resized]:
    """The document of a variation, as long along one axis as that makes it, and how its sizes were solved for."""
    size = document.facade.size[0]
    # Where it comes from is the facade as it is now: a column copies what a person sees.
    origin = Origin(document.facade.position[variation.source], variation.wanted, size)
    made = Document(variation.facade, origin, _inherited(document.locks, variation))
    wishes = (Size(0, 1 - along, float(size[1 - along])), *made.locks)
    resized = prepare(made.facade, wishes, origin).resized(wishes)
    return replace(made, facade=resized.facade), resized


def _inherited(locks: Sequence[Wish], variation: Variation) -> tuple[Wish, ...]:
    """Locks of what is still there, and of its copies; what was cut has none."""
    whole = np.isclose(variation.shown, _WHOLE).all(axis=1)
    inherited: list[Wish] = []
    for lock in locks:
        nodes = np.flatnonzero(whole & (variation.source == lock.node)).tolist() if lock.node else [0]
        inherited += [replace(lock, node=node) for node in nodes]
    return tuple(inherited)


def _with_lock(document: Document, lock: Wish) -> Document:
    return replace(unlocked(document, *_key(lock)), locks=(*unlocked(document, *_key(lock)).locks, lock))


def _key(lock: Wish) -> tuple[int, int]:
    return lock.node, ASPECT if isinstance(lock, Aspect) else lock.axis
