"""Contents of a rectangle of a facade: the part of its tree inside it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import LEAF, Facade, Ints


class Cell(NamedTuple):
    """An element, or parts in a row."""

    label: str
    """Label of the element; empty for parts."""
    axis: int
    """Axis of the parts; -1 for an element."""
    parts: tuple[tuple[float, Cell], ...]
    """For each part, its size along the axis, metres, and its content."""

    def gives(self, axis: int) -> bool:
        """Whether it can be stretched along an axis with only walls changing."""
        if self.axis == LEAF:
            return look_of(self.label).gives
        found = (part.gives(axis) for _, part in self.parts)
        return any(found) if axis == self.axis else all(found)

    def things(self) -> Iterator[str]:
        """The labels of all elements in it."""
        if self.axis == LEAF:
            yield self.label
        for _, part in self.parts:
            yield from part.things()


def nodes_between(facade: Facade, axis: int, low: float, high: float, least: float) -> Ints:
    """[K] nodes that overlap a range along an axis by more than this many metres, ascending."""
    start = facade.position[:, axis] - facade.position[0, axis]
    return np.flatnonzero(np.minimum(start + facade.size[:, axis], high) - np.maximum(start, low) > least)


def cell_of(facade: Facade, nodes: Ints, low: Sequence[float], high: Sequence[float], least: Sequence[float]) -> Cell:
    """The content between two corners; equal adjacent walls are merged.

    Args:
        facade: the facade.
        nodes: [K] nodes that may overlap the rectangle, ascending.
        low: [2] lower left corner, metres.
        high: [2] upper right corner, metres.
        least: [2] least size of a slice, metres; thinner ones are left out.
    """
    start = facade.position[nodes] - facade.position[0]
    extent = np.minimum(start + facade.size[nodes], high) - np.maximum(start, low)
    inside = (extent > least).all(axis=1)
    extents = dict(zip(nodes[inside].tolist(), extent[inside].tolist(), strict=True))
    made: dict[int, Cell] = {}
    inner: dict[int, list[int]] = {}
    """Parts in the rectangle of nodes that are processed later."""
    for node in reversed(extents):
        along = int(facade.axis[node])
        parts = inner.pop(node, [])
        if along == LEAF:
            made[node] = Cell(facade.name_of(node), LEAF, ())
        elif parts:
            made[node] = _together(along, [(extents[part][along], made.pop(part)) for part in parts])
        if node in made and node:
            inner.setdefault(int(facade.parent[node]), []).insert(0, node)
    return made.get(0, Cell("", LEAF, ()))


def _together(along: int, parts: list[tuple[float, Cell]]) -> Cell:
    """Parts in a row as one cell."""
    joined: list[tuple[float, Cell]] = []
    for size, part in parts:
        for each in [(size, part)] if part.axis != along else _shares(size, part):
            if joined and joined[-1][1] == each[1] and each[1].axis == LEAF and each[1].gives(along):
                joined[-1] = (joined[-1][0] + each[0], each[1])
            else:
                joined.append(each)
    return joined[0][1] if len(joined) == 1 else Cell("", along, tuple(joined))


def _shares(size: float, part: Cell) -> list[tuple[float, Cell]]:
    """The parts of a part that is divided along the axis of its parent."""
    whole = sum(each for each, _ in part.parts)
    return [(each * size / whole, cell) for each, cell in part.parts]


def alike(one: Cell, other: Cell, stretch: float) -> bool:
    """Whether two cells have the same contents, with relative differences of sizes up to this value."""
    return (
        (one.label, one.axis, len(one.parts)) == (other.label, other.axis, len(other.parts))
        and all(abs(a - b) <= stretch * max(a, b) for (a, _), (b, _) in zip(one.parts, other.parts, strict=True))
        and all(alike(a, b, stretch) for (_, a), (_, b) in zip(one.parts, other.parts, strict=True))
    )
