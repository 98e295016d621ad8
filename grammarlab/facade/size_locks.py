"""Locks in the file of a facade: sizes, positions and aspect ratios of nodes that must not change."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from grammarlab.errors import FacadeError
from grammarlab.facade.sizes.size_wishes import Aspect, Position, Size, Wish, checked
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.facade.values import a_list, a_number, a_whole_number, an_object, numbers

LENGTHS = {"width": (Size, X), "height": (Size, Y), "left": (Position, X), "bottom": (Position, Y)}
KINDS = (*LENGTHS, "aspect")
"""Lockable properties: lengths and positions from the left or the bottom of the facade, metres; width by height."""


def kind_of(lock: Wish) -> str:
    """The kind of a lock, one of `KINDS`."""
    if isinstance(lock, Aspect):
        return "aspect"
    names = ("width", "height") if isinstance(lock, Size) else ("left", "bottom")
    return names[lock.axis]


def lock_values(locks: Sequence[Wish]) -> list[dict[str, Any]]:
    """Locks as values of JSON, one object for each node, in the order in which nodes first occur."""
    values: dict[int, dict[str, Any]] = {}
    for lock in locks:
        value = [lock.least, lock.most] if isinstance(lock, Aspect) else lock.metres
        values.setdefault(lock.node, {"node": lock.node})[kind_of(lock)] = value
    return list(values.values())


def parsed_locks(value: Any, facade: Facade) -> tuple[Wish, ...]:
    """Locks from JSON values that a stranger may have written.

    Raises:
        FacadeError: If a value is not a lock, a node is locked twice, or no node can have the locked value.
    """
    locks: list[Wish] = []
    nodes: set[int] = set()
    for index, entry in enumerate(a_list(value, "locks", len(facade))):
        where = f"Lock {index}"
        values = an_object(entry, where)
        node = a_whole_number(values.get("node"), f"{where}, node", 0, len(facade))
        if node in nodes:
            raise FacadeError(f"{where}: node {node} has several entries; expected one with all its locks.")
        nodes.add(node)
        locks += [
            kind(node, axis, a_number(values[name], f"{where}, {name}"))
            for name, (kind, axis) in LENGTHS.items()
            if name in values
        ]
        if "aspect" in values:
            locks.append(Aspect(node, *numbers(values["aspect"], f"{where}, aspect", 2)))
    return checked(locks, facade)
