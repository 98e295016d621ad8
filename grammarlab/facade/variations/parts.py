"""Pieces of a facade that an edit puts together to a new tree."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import LEAF, Facade
from grammarlab.facade.variations.copies import NEW

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class FacadePart:
    """A node with everything in it: a subtree of the wall as it is, or other parts in a row."""

    source: int
    """Node of the wall that it is or copies; `NEW` for none."""
    axis: int
    """Along which it is divided."""
    parts: tuple[FacadePart, ...] | None = None
    """What it is divided into; None for the subtree of the source as it is."""
    fresh: bool = False
    """Whether it is a copy: the source itself stays where it is."""
    low: float = 0.0
    high: float = 1.0
    """Of a leaf: from where to where, along the edited axis, it shows its source; as parts of its extent."""
    scale: float = 1.0
    """Of a leaf: how many times larger than its source it would like to be across the edited axis."""
    instead: tuple[int, ...] = ()
    """Nodes of the wall that had this part as their only one left; it is now what they were."""


@dataclass(frozen=True)
class AxisView:
    """A facade as an edit along one axis sees it."""

    facade: Facade
    along: int
    """X to edit columns, Y to edit rows."""

    @cached_property
    def axis(self) -> list[int]:
        """[N] along which each node is divided."""
        return self.facade.axis.tolist()

    @cached_property
    def parent(self) -> list[int]:
        """[N] node that each is a part of."""
        return self.facade.parent.tolist()

    @cached_property
    def children(self) -> list[list[int]]:
        """[N] parts of each node."""
        return [parts.tolist() for parts in self.facade.children]

    @cached_property
    def end(self) -> list[int]:
        """[N] the node after the subtree of each."""
        return self.facade.end.tolist()

    @cached_property
    def low(self) -> list[float]:
        """[N] metres, where each node begins along the axis."""
        return self.facade.position[:, self.along].tolist()

    @cached_property
    def high(self) -> list[float]:
        """[N] metres, where each node ends along the axis."""
        return (self.facade.position + self.facade.size)[:, self.along].tolist()

    @cached_property
    def height(self) -> list[float]:
        """[N] metres, size of each node across the axis."""
        return self.facade.size[:, 1 - self.along].tolist()

    @cached_property
    def element(self) -> frozenset[int]:
        """The nodes that are elements of any grid."""
        return frozenset(node for grid in self.facade.grids for node in grid.node.tolist())

    @cached_property
    def elements_before(self) -> list[int]:
        """[N + 1] elements of grids among the nodes before each."""
        marked = np.zeros(len(self.facade), dtype=np.int64)
        marked[list(self.element)] = 1
        return np.append(0, marked.cumsum()).tolist()

    def has(self, node: int, others: Iterable[int]) -> bool:
        """Whether any of the others lies within a node, or is it."""
        return any(node <= other < self.end[node] for other in others)

    def has_elements(self, node: int) -> bool:
        """Whether any element of a grid lies within a node, or is it."""
        return self.elements_before[self.end[node]] > self.elements_before[node]

    def whole(self, node: int, *, fresh: bool = False) -> FacadePart:
        """The subtree of a node as it is."""
        return FacadePart(source=node, axis=self.axis[node], fresh=fresh)

    def joined(self, source: int, axis: int, parts: Iterable[FacadePart], *, fresh: bool = False) -> FacadePart:
        """Parts in a row; what is divided along the same axis is opened, and one alone needs no row.

        Raises:
            FacadeError: when an element of a grid would have to be opened.
        """
        row = [inner for part in parts for inner in (self._opened(part) if part.axis == axis else [part])]
        if len(row) > 1:
            return FacadePart(source=source, axis=axis, parts=tuple(row), fresh=fresh)
        return row[0] if fresh or source == NEW else replace(row[0], instead=(*row[0].instead, source))

    def _opened(self, part: FacadePart) -> list[FacadePart]:
        # A copy of an element is an element to be: it stands on its own like an original.
        if part.source in self.element or self.element & set(part.instead):
            raise FacadeError(
                f"Node {part.source} is an element of a grid and divided along the same axis as the wall that it would "
                "stand in; a copy of it does not fit there."
            )
        if part.parts is not None:
            return list(part.parts)
        return [self.whole(child, fresh=part.fresh) for child in self.children[part.source]]


@dataclass(frozen=True, slots=True)
class JoinedParts:
    """A tree made from parts, as columns of its N nodes."""

    parent: Ints
    axis: NDArray[np.int8]
    source: Ints
    """[N] node of the wall, or `NEW`."""
    fresh: NDArray[np.bool_]
    """[N] whether it is a copy."""
    shown: Floats
    """[N, 2] from where to where it shows its source along the edited axis."""
    scale: Floats
    """[N] as in `FacadePart`."""
    changed: NDArray[np.bool_]
    """[N] whether something within it came or went."""
    kept: Ints
    """[M] of each node of the wall what it is now; -1 for what is gone."""


def assembled(wall: AxisView, top: FacadePart) -> JoinedParts:
    """The columns of a part and everything in it."""
    rows: list[tuple[int, int, int, bool, float, float, float, bool]] = []
    kept = np.full(len(wall.facade), -1, dtype=np.int64)

    def emit(part: FacadePart, above: int) -> None:
        here = len(rows)
        rows.append(
            (above, part.axis, part.source, part.fresh, part.low, part.high, part.scale, part.parts is not None)
        )
        kept[list(part.instead)] = here
        if part.parts is not None:
            if part.source != NEW and not part.fresh:
                kept[part.source] = here
            for inner in part.parts:
                emit(inner, here)
            return
        inside = range(part.source + 1, wall.end[part.source])
        shift = here - part.source
        rows.extend(
            (wall.parent[each] + shift, wall.axis[each], each, part.fresh, 0.0, 1.0, 1.0, False) for each in inside
        )
        if not part.fresh:
            kept[part.source : wall.end[part.source]] = np.arange(here, len(rows))

    emit(top, -1)
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    parent, axis, source, fresh, low, high, scale, changed = columns
    shown = np.stack([low, high], axis=1).astype(np.float64)
    return JoinedParts(
        parent=parent,
        axis=axis.astype(np.int8),
        source=source,
        fresh=fresh,
        shown=shown,
        scale=scale,
        changed=changed,
        kept=kept,
    )


def reaching(wall: AxisView, tree: JoinedParts, wanted: Floats) -> Floats:
    """[N] sizes along the edited axis, where what reaches over a change is as large as what was changed.

    A band over a row of windows would like to be as long as the row, however many windows that gets. Where a band holds
    elements, it would like to keep its size, as they do.

    Args:
        wall: What is edited.
        tree: The edited wall.
        wanted: [N] metres, sizes along the edited axis of the sources of all leaves.
    """
    parent, axis = tree.parent.tolist(), tree.axis.tolist()
    natural = np.where(tree.axis == LEAF, wanted, 0.0).tolist()
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
        keeps = changed[node] or tree.fresh[node] or wall.has_elements(int(tree.source[node]))
        if axis[above] != wall.along and target[above] and not keeps:
            factor[node] *= target[above] / natural[node]
    return wanted * factor
