"""Sets of tags, the names of faces, by number; and the queries that select tags."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]

Names = tuple[str, ...]
"""A set of tags in alphabetical order."""


class TagTable:
    """The different sets of tags of one derivation, by number; 0 is the empty one."""

    def __init__(self) -> None:
        self._ids: dict[Names, int] = {(): 0}
        self._sets: list[Names] = [()]

    def __getitem__(self, number: int) -> Names:
        return self._sets[number]

    def id(self, names: Iterable[str]) -> int:
        """Number of a set, new or known."""
        key = tuple(sorted(set(names)))
        if key not in self._ids:
            self._ids[key] = len(self._sets)
            self._sets.append(key)
        return self._ids[key]

    def changed(self, ids: NDArray[np.integer], change: Callable[[Names], Iterable[str]]) -> NDArray[np.int32]:
        """Numbers of what a change makes of sets."""
        different, inverse = np.unique(ids, return_inverse=True)
        return np.array([self.id(change(self[number])) for number in different.tolist()], dtype=np.int32)[inverse]

    def united(self, ids: NDArray[np.integer], groups: Indices, count: int) -> NDArray[np.int32]:
        """[count] numbers of the unions of sets [K] by their groups [K]."""
        unions: list[set[str]] = [set() for _ in range(count)]
        for number, group in np.unique(np.column_stack((ids, groups)), axis=0).tolist():
            unions[group].update(self[number])
        return np.array([self.id(names) for names in unions], dtype=np.int32)


def matches(query: str, tag: str) -> bool:
    """Whether a query names a tag or a part of the hierarchy that it is in; ``?`` is one subtag, ``*`` one or more.

    >>> matches("roof.side", "roof.side.outer"), matches("*.outer", "roof.side.outer"), matches("?.outer", "roof.outer")
    (True, True, True)
    >>> matches("roof.*", "roof"), matches("roof", "roofs")
    (False, False)
    """
    subtags = tag.split(".")
    reached = {0}
    for part in query.split("."):
        if part == "*":
            reached = set(range(min(reached) + 1, len(subtags) + 1)) if reached else reached
        else:
            reached = {at + 1 for at in reached if at < len(subtags) and part in ("?", subtags[at])}
    return bool(reached)
