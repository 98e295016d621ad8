"""What a person edits: a facade, the sizes that it would like to have, and those that are locked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from grammarlab.errors import FacadeError
from grammarlab.facade.grids.proposals import with_proposals
from grammarlab.facade.locks import LENGTHS, kind_of
from grammarlab.facade.sizes.axes import LineOrigin
from grammarlab.facade.sizes.solve import Resized, Sizing, prepare
from grammarlab.facade.sizes.wishes import Aspect, Size, Wish, checked
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.facade.variations.inheriting import inherited
from grammarlab.facade.variations.single import Variation

LockValue = float | tuple[float, float]
"""Metres; of an aspect the least and the most of width / height."""


@dataclass(frozen=True, eq=False)
class Document:
    """One state of what is edited; every change makes another one."""

    facade: Facade
    origin: LineOrigin
    """From which deviations count: sizes before any side was dragged, so that a side dragged back undoes it."""
    locks: tuple[Wish, ...] = ()
    """What stays, each at most once per node."""

    def sizing(self) -> Sizing:
        """Ready to be solved for any metres of these locks and of the whole."""
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


def opened(facade: Facade, locks: tuple[Wish, ...] = ()) -> Document:
    """A facade as it is in its file; grids are proposed where it has none."""
    facade = facade if facade.grids else with_proposals(facade)
    return Document(facade, LineOrigin(facade.position, facade.size, facade.size[0]), locks)


def is_possible(sizing: Sizing, wishes: Sequence[Wish]) -> bool:
    """Whether wishes do not contradict each other; sooner known than why they do."""
    return all(model.program.solve(model.wanted(wishes)) is not None for model in sizing.models)


def contradiction(conflict: Sequence[str]) -> str:
    """Wishes that contradict each other as a sentence."""
    return f"These cannot all be met: {'; '.join(conflict)}."


def locked(document: Document, node: int, what: str) -> Document:
    """What one of `locks.KINDS` says of a node stays as it is from now on."""
    return with_locks(document, node, {what: _value(document.facade, node, what)})


def unlocked(document: Document, node: int, what: str) -> Document:
    """A node without this lock."""
    return replace(document, locks=tuple(lock for lock in document.locks if (lock.node, kind_of(lock)) != (node, what)))


def with_locks(document: Document, node: int, values: Mapping[str, LockValue]) -> Document:
    """A node with these locks; sizes are not solved for.

    Raises:
        FacadeError: for what no node can have.
    """
    for what, value in values.items():
        document = unlocked(document, node, what)
        document = replace(document, locks=(*document.locks, _lock(node, what, value)))
    checked(document.locks, document.facade)
    return document


def arranged(document: Document, node: int, values: Mapping[str, LockValue]) -> Document:
    """A node that is so large, or lies there, and stays so; the facade as large as before.

    Raises:
        FacadeError: when that contradicts other locks, or what is alike and aligned: which.
    """
    wished = with_locks(document, node, values)
    return wished.settled(wished.sizing().resized(wished.wishes(document.facade.width, document.facade.height)))


def varied(document: Document, variation: Variation, along: int) -> tuple[Document, Resized]:
    """The document of a variation, as long along one axis as that makes it, and how its sizes were solved for."""
    size = document.facade.size[0]
    # Where it comes from is the facade as it is now: a column copies what a person sees.
    origin = LineOrigin(document.facade.position[variation.source], variation.wanted, size)
    made = Document(variation.facade, origin, inherited(document.locks, variation))
    wishes = (Size(0, 1 - along, float(size[1 - along])), *made.locks)
    resized = prepare(made.facade, wishes, origin).resized(wishes)
    return replace(made, facade=resized.facade), resized


def _lock(node: int, what: str, value: LockValue) -> Wish:
    if isinstance(value, tuple):
        return Aspect(node, *value)
    kind, axis = LENGTHS[what]
    return kind(node, axis, value)


def _value(facade: Facade, node: int, what: str) -> LockValue:
    left, bottom = (facade.position[node] - facade.position[0]).tolist()
    width, height = facade.size[node].tolist()
    if what == "aspect":
        return width / height, width / height
    return {"width": width, "height": height, "left": left, "bottom": bottom}[what]
