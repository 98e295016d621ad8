"""Pieces of a facade, and the new tree of copied nodes that an edit assembles from them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, take_rows
from grammarlab.errors import FacadeError
from grammarlab.facade.tree import LEAF, Facade, laid_out

NEW = -1
"""Source of an inner node without a counterpart in the other facade."""
WHOLE = (0.0, 0.0, 1.0, 1.0)
"""Left, bottom, right, top of the visible part of a source that is not cut."""


@dataclass(frozen=True, slots=True)
class FacadePart:
    """A node with its contents: an unchanged subtree of the wall, or other parts in a row."""

    source: int
    """Node of the wall that it is or copies; `NEW` for none."""
    axis: int
    """Axis along which it is divided."""
    parts: tuple[FacadePart, ...] | None = None
    """Its parts; None for the unchanged subtree of the source."""
    fresh: bool = False
    """Whether it is a copy: the source itself stays in place."""
    low: float = 0.0
    """For a leaf: start of the visible part of its source along the edited axis, as a fraction of its extent."""
    high: float = 1.0
    """For a leaf: end of the visible part of its source along the edited axis, as a fraction of its extent."""
    scale: float = 1.0
    """For a leaf: target size across the edited axis, as a multiple of the size of its source."""
    instead: tuple[int, ...] = ()
    """Nodes of the wall whose only remaining part this is, and which it replaces."""


@dataclass(frozen=True)
class AxisView:
    """A facade with the columns that an edit along one axis needs."""

    facade: Facade
    along: int
    """X to edit columns, Y to edit rows."""

    @cached_property
    def axis(self) -> list[int]:
        """[N] axis along which each node is divided."""
        return self.facade.axis.tolist()

    @cached_property
    def parent(self) -> list[int]:
        """[N] parent of each node."""
        return self.facade.parent.tolist()

    @cached_property
    def children(self) -> list[list[int]]:
        """[N] parts of each node."""
        return [parts.tolist() for parts in self.facade.children]

    @cached_property
    def end(self) -> list[int]:
        """[N] the node after the subtree of each node."""
        return self.facade.end.tolist()

    @cached_property
    def low(self) -> list[float]:
        """[N] start of each node along the axis, metres."""
        return self.facade.position[:, self.along].tolist()

    @cached_property
    def high(self) -> list[float]:
        """[N] end of each node along the axis, metres."""
        return (self.facade.position + self.facade.size)[:, self.along].tolist()

    @cached_property
    def height(self) -> list[float]:
        """[N] size of each node across the axis, metres."""
        return self.facade.size[:, 1 - self.along].tolist()

    @cached_property
    def element(self) -> frozenset[int]:
        """The nodes that are elements of any grid."""
        return frozenset(node for grid in self.facade.grids for node in grid.node.tolist())

    @cached_property
    def elements_before(self) -> list[int]:
        """[N + 1] number of elements of grids among the nodes before each."""
        marked = np.zeros(len(self.facade), dtype=np.int64)
        marked[list(self.element)] = 1
        return np.append(0, marked.cumsum()).tolist()

    def has(self, node: int, others: Iterable[int]) -> bool:
        """Whether any of the others is inside a node, or is the node itself."""
        return any(node <= other < self.end[node] for other in others)

    def has_elements(self, node: int) -> bool:
        """Whether any element of a grid is inside a node, or is the node itself."""
        return self.elements_before[self.end[node]] > self.elements_before[node]

    def whole(self, node: int, *, fresh: bool = False) -> FacadePart:
        """The unchanged subtree of a node."""
        return FacadePart(source=node, axis=self.axis[node], fresh=fresh)

    def joined(self, source: int, axis: int, parts: Iterable[FacadePart], *, fresh: bool = False) -> FacadePart:
        """Parts in a row; parts divided along the same axis are opened, and a single part needs no row.

        Raises:
            FacadeError: If an element of a grid would have to be opened.
        """
        row = [inner for part in parts for inner in (self._opened(part) if part.axis == axis else [part])]
        if len(row) > 1:
            return FacadePart(source=source, axis=axis, parts=tuple(row), fresh=fresh)
        return row[0] if fresh or source == NEW else replace(row[0], instead=(*row[0].instead, source))

    def _opened(self, part: FacadePart) -> list[FacadePart]:
        # A copy of an element becomes an element: it needs a node of its own, like the original.
        if part.source in self.element or self.element & set(part.instead):
            raise FacadeError(
                f"Node {part.source} is an element of a grid and divided along the same axis as the wall around its "
                "copy; so a copy of it does not fit there."
            )
        if part.parts is not None:
            return list(part.parts)
        return [self.whole(child, fresh=part.fresh) for child in self.children[part.source]]


@dataclass(frozen=True, slots=True)
class JoinedParts:
    """A tree made from parts, as columns of its N nodes."""

    parent: Ints
    """[N] parent of each node; -1 for the root."""
    axis: NDArray[np.int8]
    """[N] axis along which each node is divided."""
    source: Ints
    """[N] node of the wall, or `NEW`."""
    fresh: NDArray[np.bool_]
    """[N] whether it is a copy."""
    visible: Floats
    """[N, 2] start and end of the visible part of its source along the edited axis."""
    scale: Floats
    """[N] target size across the edited axis, as a multiple of the size of its source."""
    changed: NDArray[np.bool_]
    """[N] whether something inside it was added or removed."""
    new_node: Ints
    """[M] new node of each node of the wall; -1 for removed ones."""


def take(
    facade: Facade,
    parent: Ints,
    axis: NDArray[np.int8],
    source: Ints,
    target: Floats | None = None,
    visible: Floats | None = None,
) -> Facade:
    """A tree with the look of its sources: their labels, outlines and parts of pictures; it has no grids.

    Args:
        facade: the facade of the sources.
        parent: [N] parent of each node, as in `Facade`; -1 for the root.
        axis: [N] axis along which each node is divided, as in `Facade`.
        source: [N] node of the other facade, or `NEW`.
        target: [N, 2] target sizes of leaves, metres; those of the sources by default.
        visible: [N, 4] left, bottom, right, top of the visible part of its source; all of it by default.
    """
    node = np.where(source >= 0, source, 0)
    new = source < 0
    target = facade.size[node] if target is None else target
    position, size = laid_out(parent, axis, target)
    window = facade.window[node]
    if visible is not None:
        window = part_of(window, visible)
    # New nodes have an outline without points.
    counts = np.append(np.diff(facade.outline_offsets), 0)
    offsets = np.append(facade.outline_offsets, facade.outline_offsets[-1])
    points, outline_offsets = take_rows(offsets, np.where(new, len(counts) - 1, node))
    return Facade(
        parent=parent,
        axis=axis,
        position=position,
        size=size,
        label=np.where(new, -1, facade.label[node]),
        labels=facade.labels,
        outline_offsets=outline_offsets,
        outline_points=facade.outline_points[points],
        pictures=facade.pictures,
        picture=np.where(new, -1, facade.picture[node]),
        window=np.where(new[:, None], WHOLE, window),
    )


def part_of(rectangle: Floats, visible: Floats) -> Floats:
    """[N, 4] left, bottom, right, top of visible parts, given relative to rectangles [N, 4]."""
    low, extent = rectangle[:, :2], rectangle[:, 2:] - rectangle[:, :2]
    return np.hstack([low + visible[:, :2] * extent, low + visible[:, 2:] * extent])


def assembled(wall: AxisView, top: FacadePart) -> JoinedParts:
    """The columns of a part and its contents."""
    rows: list[tuple[int, int, int, bool, float, float, float, bool]] = []
    new_node = np.full(len(wall.facade), -1, dtype=np.int64)

    def emit(part: FacadePart, above: int) -> None:
        index = len(rows)
        rows.append(
            (above, part.axis, part.source, part.fresh, part.low, part.high, part.scale, part.parts is not None)
        )
        new_node[list(part.instead)] = index
        if part.parts is not None:
            if part.source != NEW and not part.fresh:
                new_node[part.source] = index
            for inner in part.parts:
                emit(inner, index)
            return
        inside = range(part.source + 1, wall.end[part.source])
        shift = index - part.source
        rows.extend(
            (wall.parent[node] + shift, wall.axis[node], node, part.fresh, 0.0, 1.0, 1.0, False) for node in inside
        )
        if not part.fresh:
            new_node[part.source : wall.end[part.source]] = np.arange(index, len(rows))

    emit(top, -1)
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    parent, axis, source, fresh, low, high, scale, changed = columns
    visible = np.stack([low, high], axis=1).astype(np.float64)
    return JoinedParts(
        parent=parent,
        axis=axis.astype(np.int8),
        source=source,
        fresh=fresh,
        visible=visible,
        scale=scale,
        changed=changed,
        new_node=new_node,
    )


def stretched_targets(wall: AxisView, tree: JoinedParts, source_target: Floats) -> Floats:
    """[N] target sizes along the edited axis; nodes that extend over a change grow with it.

    The target length of a band over a row of windows is that of the row, for any number of windows. A band that
    contains elements has its old size as target, as they do.

    Args:
        wall: the edited facade.
        tree: the result of the edit.
        source_target: [N] target sizes of the sources of all leaves along the edited axis, metres.
    """
    parent, axis = tree.parent.tolist(), tree.axis.tolist()
    natural = np.where(tree.axis == LEAF, source_target, 0.0).tolist()
    changed = (tree.changed & ~tree.fresh).tolist()
    target = [0.0] * len(parent)
    for node in range(len(parent) - 1, -1, -1):
        if target[node]:
            natural[node] = target[node]
        above = parent[node]
        if axis[above] == wall.along:
            natural[above] += natural[node]
        else:
            natural[above] = max(natural[above], natural[node])
            target[above] = max(target[above], natural[node] if changed[node] else 0.0)
    factor = [1.0] * len(parent)
    for node in range(1, len(parent)):
        above = parent[node]
        factor[node] = factor[above]
        is_fixed = changed[node] or tree.fresh[node] or wall.has_elements(int(tree.source[node]))
        if axis[above] != wall.along and target[above] and not is_fixed:
            factor[node] *= target[above] / natural[node]
    return source_target * factor
