"""The edited document: a facade, target sizes, and locks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.grid_proposals import with_proposals
from grammarlab.facade.editing.variations import Variation, inherited
from grammarlab.facade.size_locks import LENGTHS, kind_of
from grammarlab.facade.sizes.constraints import LineOrigin
from grammarlab.facade.sizes.size_wishes import Aspect, Size, Wish, checked
from grammarlab.facade.sizes.solve import Resized, Sizing, prepare
from grammarlab.facade.tree import Facade, X, Y

LockValue = float | tuple[float, float]
"""Metres; of an aspect the least and the most of width / height."""


@dataclass(frozen=True, eq=False)
class Document:
    """One state of the document; every change returns a new one."""

    facade: Facade
    origin: LineOrigin
    """Origin of deviations: the sizes before any side was dragged, so that dragging it back undoes the change."""
    locks: tuple[Wish, ...] = ()
    """Locks, each at most once per node."""

    def sizing(self) -> Sizing:
        """The programme, prepared for any metres of these locks and of the whole."""
        return prepare(self.facade, self.wishes(self.facade.width, self.facade.height), self.origin)

    def wishes(self, width: float, height: float) -> tuple[Wish, ...]:
        """The wishes for a facade of that size."""
        return (Size(0, X, width), Size(0, Y, height), *self.locks)

    def settled(self, resized: Resized) -> Document:
        """The facade with solved sizes.

        Raises:
            FacadeError: If wishes contradict each other; with the wishes.
        """
        if resized.conflict:
            raise FacadeError(contradiction(resized.conflict))
        return replace(self, facade=resized.facade)


def opened(facade: Facade, locks: tuple[Wish, ...] = ()) -> Document:
    """The facade of a file; if it has no grids, they are proposed."""
    facade = facade if facade.grids else with_proposals(facade)
    return Document(facade, LineOrigin(facade.position, facade.size, facade.size[0], shares_lines=True), locks)


def is_possible(sizing: Sizing, wishes: Sequence[Wish]) -> bool:
    """Whether wishes do not contradict each other, without an explanation, which would take longer."""
    return all(model.program.solve(model.row_values(wishes)) is not None for model in sizing.models)


def contradiction(conflict: Sequence[str]) -> str:
    """Contradictory wishes as a sentence."""
    return f"These cannot all be met: {'; '.join(conflict)}."


def locked(document: Document, node: int, what: str) -> Document:
    """The document with the current value of a property in `locks.KINDS` locked for a node."""
    return with_locks(document, node, {what: _value(document.facade, node, what)})


def unlocked(document: Document, node: int, what: str) -> Document:
    """The document without this lock of a node."""
    return replace(document, locks=tuple(lock for lock in document.locks if (lock.node, kind_of(lock)) != (node, what)))


def with_locks(document: Document, node: int, values: Mapping[str, LockValue]) -> Document:
    """The document with these locks of a node; sizes are not solved for.

    Raises:
        FacadeError: If no node can have such a value.
    """
    for what, value in values.items():
        document = unlocked(document, node, what)
        document = replace(document, locks=(*document.locks, _lock(node, what, value)))
    checked(document.locks, document.facade)
    return document


def arranged(document: Document, node: int, values: Mapping[str, LockValue]) -> Document:
    """The document with a size or position of a node set and locked; the size of the facade is preserved.

    Raises:
        FacadeError: If that contradicts other locks, alignments or equal sizes; with the contradiction.
    """
    wished = with_locks(document, node, values)
    return wished.settled(wished.sizing().resized(wished.wishes(document.facade.width, document.facade.height)))


def varied(document: Document, variation: Variation, along: int, *, in_line: bool = False) -> tuple[Document, Resized]:
    """The document of a variation, with the resulting length along one axis, and the solution of its sizes.

    Args:
        document: the document before.
        variation: a variation of its facade.
        along: X or Y.
        in_line: whether the variation is laid out without deformation, so that its shared lines stay.
    """
    size = document.facade.size[0]
    # Its origin is the current facade: a column copies the visible one.
    position = variation.facade.position if in_line else document.facade.position[variation.source]
    origin = LineOrigin(position, variation.target, size, shares_lines=in_line)
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
