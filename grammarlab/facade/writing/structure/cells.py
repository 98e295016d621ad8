"""What stands in a rectangle of a facade: the part of its tree that lies in there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import LEAF, Facade, Ints


class Cell(NamedTuple):
    """A thing, or parts that follow each other."""

    label: str
    """What the thing is called; empty for parts."""
    axis: int
    """-1 for a thing."""
    parts: tuple[tuple[float, Cell], ...]
    """Of each part its metres along the axis, and what it is."""

    def gives(self, axis: int) -> bool:
        """Whether it can be stretched along an axis while only walls change."""
        if self.axis == LEAF:
            return look_of(self.label).gives
        found = (part.gives(axis) for _, part in self.parts)
        return any(found) if axis == self.axis else all(found)

    def things(self) -> Iterator[str]:
        """The labels of all things in it."""
        if self.axis == LEAF:
            yield self.label
        for _, part in self.parts:
            yield from part.things()


def nodes_between(facade: Facade, axis: int, low: float, high: float, least: float) -> Ints:
    """[K] the nodes that reach between two places along an axis by more than so many metres, ascending."""
    start = facade.position[:, axis] - facade.position[0, axis]
    return np.flatnonzero(np.minimum(start + facade.size[:, axis], high) - np.maximum(start, low) > least)


def cell_of(facade: Facade, nodes: Ints, low: Sequence[float], high: Sequence[float], least: Sequence[float]) -> Cell:
    """What stands between two corners; equal walls side by side are one.

    Args:
        facade: the facade.
        nodes: [K] those that may reach into the rectangle, ascending.
        low: [2] metres from its lower left corner.
        high: [2] metres.
        least: [2] metres; thinner slices are left out.
    """
    start = facade.position[nodes] - facade.position[0]
    extent = np.minimum(start + facade.size[nodes], high) - np.maximum(start, low)
    inside = (extent > least).all(axis=1)
    extents = dict(zip(nodes[inside].tolist(), extent[inside].tolist(), strict=True))
    made: dict[int, Cell] = {}
    inner: dict[int, list[int]] = {}
    """Of nodes that are still to come, their parts in the rectangle."""
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
    """Parts that follow each other as one cell."""
    joined: list[tuple[float, Cell]] = []
    for size, part in parts:
        for each in [(size, part)] if part.axis != along else _shares(size, part):
            if joined and joined[-1][1] == each[1] and each[1].axis == LEAF and each[1].gives(along):
                joined[-1] = (joined[-1][0] + each[0], each[1])
            else:
                joined.append(each)
    return joined[0][1] if len(joined) == 1 else Cell("", along, tuple(joined))


def _shares(size: float, part: Cell) -> list[tuple[float, Cell]]:
    """The parts of a part that is divided along the axis of what it is a part of."""
    whole = sum(each for each, _ in part.parts)
    return [(each * size / whole, cell) for each, cell in part.parts]


def alike(one: Cell, other: Cell, stretch: float) -> bool:
    """Whether two cells hold the same, in sizes that differ by no more than this part."""
    return (
        (one.label, one.axis, len(one.parts)) == (other.label, other.axis, len(other.parts))
        and all(abs(a - b) <= stretch * max(a, b) for (a, _), (b, _) in zip(one.parts, other.parts, strict=True))
        and all(alike(a, b, stretch) for (_, a), (_, b) in zip(one.parts, other.parts, strict=True))
    )
