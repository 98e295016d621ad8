"""Contents of a rectangle of a facade: the part of its tree inside it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely

from grammarlab.arrays import Floats, Ints
from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import LEAF, Facade

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


ON_AREA = PictureWindow(-1, (0.0, 0.0), (1.0, 1.0))
"""What an element shows whose picture is projected on the area around it."""


class Cell(NamedTuple):
    """An element, or parts in a row."""

    label: str
    """Label of the element; empty for parts."""
    axis: int
    """Axis of the parts; -1 for an element."""
    parts: tuple[tuple[float, Cell], ...]
    """Size along the axis in metres, and content, of each part."""
    outline: tuple[tuple[float, float], ...] = ()
    """Corners of an element that is not a rectangle, as in `Facade`; none if the cell cuts the element."""
    shows: PictureWindow | None = None
    """Part of a picture on an element; None without a picture."""

    def can_stretch(self, axis: int) -> bool:
        """Whether it can be stretched along an axis with only walls changing."""
        if self.axis == LEAF:
            return look_of(self.label).is_flexible
        part_stretches = (part.can_stretch(axis) for _, part in self.parts)
        return any(part_stretches) if axis == self.axis else all(part_stretches)

    def things(self) -> Iterator[str]:
        """The labels of all elements in it."""
        if self.axis == LEAF:
            yield self.label
        for _, part in self.parts:
            yield from part.things()

    def on_area(self) -> Cell:
        """The cell with elements that show what is projected on the area around it."""
        return self._replace(
            shows=ON_AREA if self.axis == LEAF else None,
            parts=tuple((size, part.on_area()) for size, part in self.parts),
        )

    def is_split(self, axis: int) -> bool:
        """Whether parts follow each other along an axis."""
        return self.axis == axis or any(part.is_split(axis) for _, part in self.parts)


def picture_on(cell: Cell) -> PictureWindow | None:
    """The window of one picture that a cell shows as a whole; None if its elements show others, or none."""
    if cell.axis == LEAF:
        return cell.shows
    windows = [(size, picture_on(part)) for size, part in cell.parts]
    return window_over(windows, cell.axis)


def window_over(parts: Sequence[tuple[float, PictureWindow | None]], along: int) -> PictureWindow | None:
    """The window of parts that follow each other along an axis, with their sizes in metres.

    None if the picture does not go on from each to the next at the same scale.
    """
    whole = parts[0][1]
    for _, window in parts[1:]:
        whole = _over_both(whole, window, along)
    if whole is None:
        return None
    scale = (whole.high[along] - whole.low[along]) / sum(size for size, _ in parts)
    is_even = all(
        window is not None and abs(window.high[along] - window.low[along] - size * scale) <= _SAME_PLACE
        for size, window in parts
    )
    return whole if is_even else None


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
    cells: dict[int, Cell] = {}
    inner: dict[int, list[int]] = {}
    """Parts in the rectangle of nodes that are processed later."""
    for node in reversed(extents):
        along = int(facade.axis[node])
        parts = inner.pop(node, [])
        if along == LEAF:
            cells[node] = _leaf_cell(facade, node, np.asarray(low), np.asarray(high), np.asarray(least))
        elif parts:
            cells[node] = _joined_cell(along, [(extents[part][along], cells.pop(part)) for part in parts])
        if node in cells and node:
            inner.setdefault(int(facade.parent[node]), []).insert(0, node)
    return cells.get(0, Cell("", LEAF, ()))


def _leaf_cell(facade: Facade, leaf: int, low: Floats, high: Floats, least: Floats) -> Cell:
    """Content of a leaf between two corners."""
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


def _joined_cell(along: int, parts: list[tuple[float, Cell]]) -> Cell:
    """Parts in a row as one cell."""
    joined: list[tuple[float, Cell]] = []
    for size, part in parts:
        for length, cell in [(size, part)] if part.axis != along else _shares(size, part):
            before, last = joined[-1] if joined else (0.0, None)
            if (
                last
                and cell.axis == LEAF
                and _plain(last) == _plain(cell)
                and not cell.outline
                and cell.can_stretch(along)
            ):
                larger = last if before >= length else cell
                shows = _over_both(last.shows, cell.shows, along) or larger.shows
                joined[-1] = (before + length, cell._replace(shows=shows))
            else:
                joined.append((length, cell))
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
    whole = sum(length for length, _ in part.parts)
    return [(length * size / whole, cell) for length, cell in part.parts]


def alike(first: Cell, second: Cell, stretch: float) -> bool:
    """Whether two cells have the same contents, with relative differences of sizes and outlines up to this value."""
    return (
        (first.label, first.axis, len(first.parts)) == (second.label, second.axis, len(second.parts))
        and all(abs(a - b) <= stretch * max(a, b) for (a, _), (b, _) in zip(first.parts, second.parts, strict=True))
        and all(alike(a, b, stretch) for (_, a), (_, b) in zip(first.parts, second.parts, strict=True))
        and (first.outline == second.outline or _miss(first, second) <= stretch + _SAME_AREA)
    )


def _miss(first: Cell, second: Cell) -> float:
    """Part of a box in which the outlines of two things differ."""
    shape, another = (shapely.make_valid(shapely.Polygon(cell.outline or _UNIT)) for cell in (first, second))
    return shape.symmetric_difference(another).area
