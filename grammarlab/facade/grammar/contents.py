"""Contents of a rectangle of a facade: the part of its tree inside it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely

from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import LEAF, Facade, Floats, Ints

_UNIT = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
_SAME_AREA = 1e-9
"""Part of a box by which equal outlines may differ."""
_SAME_PLACE = 1e-7
"""Part of a picture by which neighbours may miss each other and still show it as one."""
_DIGITS = 12
"""Decimals of windows of pictures, so that equal leaves are equal cells."""


class PictureWindow(NamedTuple):
    """The part of a picture that a thing shows."""

    picture: int
    """Index into the pictures of the facade."""
    low: tuple[float, float]
    """Left and bottom, as parts of the picture."""
    high: tuple[float, float]
    """Right and top."""


class Cell(NamedTuple):
    """An element, or parts in a row."""

    label: str
    """Label of the element; empty for parts."""
    axis: int
    """Axis of the parts; -1 for an element."""
    parts: tuple[tuple[float, Cell], ...]
    """For each part, its size along the axis, metres, and its content."""
    outline: tuple[tuple[float, float], ...] = ()
    """Corners of an element that is not a rectangle, as in `Facade`; none if the cell cuts the element."""
    shows: PictureWindow | None = None
    """Part of a picture on an element; None without a picture."""

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

    Such a wall shows what both do where the picture goes on, else what the larger one does.

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
            made[node] = _thing(facade, node, np.asarray(low), np.asarray(high), np.asarray(least))
        elif parts:
            made[node] = _together(along, [(extents[part][along], made.pop(part)) for part in parts])
        if node in made and node:
            inner.setdefault(int(facade.parent[node]), []).insert(0, node)
    return made.get(0, Cell("", LEAF, ()))


def _thing(facade: Facade, leaf: int, low: Floats, high: Floats, least: Floats) -> Cell:
    """What a leaf is between two corners."""
    picture = int(facade.picture[leaf])
    if picture < 0 and not len(facade.outline(leaf)):
        return Cell(facade.name_of(leaf), LEAF, ())
    size, start = facade.size[leaf], facade.position[leaf] - facade.position[0]
    first, last = np.maximum(low - start, 0.0) / size, np.minimum(high - start, size) / size
    whole = ((first <= least / size) & (last >= 1.0 - least / size)).all()
    outline = facade.outline(leaf).tolist() if whole else []
    shows = None
    if picture >= 0:
        origin, extent = facade.window[leaf, :2], facade.window[leaf, 2:] - facade.window[leaf, :2]
        (left, bottom), (right, top) = (
            (origin + part * extent).round(_DIGITS).tolist() for part in ((0.0, 1.0) if whole else (first, last))
        )
        shows = PictureWindow(picture, (left, bottom), (right, top))
    return Cell(facade.name_of(leaf), LEAF, (), tuple((x, y) for x, y in outline), shows)


def _together(along: int, parts: list[tuple[float, Cell]]) -> Cell:
    """Parts in a row as one cell."""
    joined: list[tuple[float, Cell]] = []
    for size, part in parts:
        for length, each in [(size, part)] if part.axis != along else _shares(size, part):
            before, last = joined[-1] if joined else (0.0, None)
            if last and each.axis == LEAF and _plain(last) == _plain(each) and not each.outline and each.gives(along):
                larger = last if before >= length else each
                shows = _over_both(last.shows, each.shows, along) or larger.shows
                joined[-1] = (before + length, each._replace(shows=shows))
            else:
                joined.append((length, each))
    return joined[0][1] if len(joined) == 1 else Cell("", along, tuple(joined))


def _plain(cell: Cell) -> Cell:
    """A thing without its picture."""
    return cell._replace(shows=None)


def _over_both(before: PictureWindow | None, after: PictureWindow | None, along: int) -> PictureWindow | None:
    """The window of two walls that follow each other along an axis, if one picture goes on in both."""
    if before is None or after is None or before.picture != after.picture:
        return None
    across = 1 - along
    misses = (
        before.high[along] - after.low[along],
        before.low[across] - after.low[across],
        before.high[across] - after.high[across],
    )
    return PictureWindow(before.picture, before.low, after.high) if max(map(abs, misses)) <= _SAME_PLACE else None


def _shares(size: float, part: Cell) -> list[tuple[float, Cell]]:
    """The parts of a part that is divided along the axis of its parent."""
    whole = sum(each for each, _ in part.parts)
    return [(each * size / whole, cell) for each, cell in part.parts]


def alike(one: Cell, other: Cell, stretch: float) -> bool:
    """Whether two cells have the same contents, with relative differences of sizes and outlines up to this value."""
    return (
        (one.label, one.axis, len(one.parts)) == (other.label, other.axis, len(other.parts))
        and all(abs(a - b) <= stretch * max(a, b) for (a, _), (b, _) in zip(one.parts, other.parts, strict=True))
        and all(alike(a, b, stretch) for (_, a), (_, b) in zip(one.parts, other.parts, strict=True))
        and (one.outline == other.outline or _miss(one, other) <= stretch + _SAME_AREA)
    )


def _miss(one: Cell, other: Cell) -> float:
    """Part of a box in which the outlines of two things differ."""
    shape, another = (shapely.make_valid(shapely.Polygon(cell.outline or _UNIT)) for cell in (one, other))
    return shape.symmetric_difference(another).area
