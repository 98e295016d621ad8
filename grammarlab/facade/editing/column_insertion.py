"""Insertion of a column between two others, in all rows at once (paper 000, section 4).

A source S is inserted between two anchors of its row. As in the paper, the surroundings of the anchors are repeated
around S, rows whose anchors have the same common parent are widened together, and nodes that extend over both anchors
are stretched over S instead of repeated. The paper adds edges one by one to a neighbourhood graph and drops those that
contradict; here an edge is added for whole subtrees at once, by placing a copy beside a part of the common parent. So
the result is a decomposition tree at every step, nothing has to be undone, and only S and its surroundings are
repeated.

Rows are inserted like columns, along the other axis.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.pieces import NEW, AxisView, FacadePart
from grammarlab.facade.tree import LEAF

_OUTSIDE = -1
"""Represents a row around the whole facade, which is its only part."""


class Placement(Enum):
    """Position of a source."""

    BETWEEN = "between"
    BEFORE = "before"
    """Before the first of both anchors, at a distance equal to that of the anchors."""
    AFTER = "after"


@dataclass(frozen=True, slots=True)
class Insertion:
    """One element of a new column."""

    source: int
    """Node to copy."""
    low: int
    """The anchor with lower coordinates."""
    high: int
    """The other anchor; the same one if the row has only one."""
    placement: Placement


@dataclass(frozen=True, slots=True)
class _Slot:
    """Position of a copy of surroundings in a row of parts."""

    low: int
    """Part with the lower anchors."""
    high: int
    """Part with the higher anchors."""
    placement: Placement


def unreachable(wall: AxisView, insertion: Insertion) -> bool:
    """Whether no line separates the anchors of an insertion, so that nothing can be inserted between them."""
    parent = _common(wall, insertion)
    return parent != _OUTSIDE and wall.axis[parent] != wall.along


def inserted(wall: AxisView, insertions: Sequence[Insertion]) -> FacadePart:
    """The wall with copies of all sources, their surroundings and the gaps beside them.

    Args:
        wall: the edited facade.
        insertions: at most one for each source; none of them `unreachable`.

    Raises:
        FacadeError: If a copy does not fit in its place.
    """
    slots: dict[int, dict[_Slot, list[Insertion]]] = defaultdict(lambda: defaultdict(list))
    for insertion in insertions:
        parent = _common(wall, insertion)
        parts = [0] if parent == _OUTSIDE else wall.children[parent]
        low, high = (_part_with(wall, parts, anchor) for anchor in (insertion.low, insertion.high))
        slots[parent][_Slot(low, high, insertion.placement)].append(insertion)
    return _widened(wall, _OUTSIDE if _OUTSIDE in slots else 0, slots)


def _common(wall: AxisView, insertion: Insertion) -> int:
    """The row of parts that contains the anchors of an insertion; for a single one, the nearest row around it."""
    node = wall.parent[insertion.low]
    if insertion.low == insertion.high:
        while node != _OUTSIDE and wall.axis[node] != wall.along:
            node = wall.parent[node]
    else:
        while node != _OUTSIDE and not node <= insertion.high < wall.end[node]:
            node = wall.parent[node]
    return node


def _part_with(wall: AxisView, parts: Sequence[int], node: int) -> int:
    return next(index for index, part in enumerate(parts) if part <= node < wall.end[part])


def _widened(wall: AxisView, node: int, slots: Mapping[int, Mapping[_Slot, list[Insertion]]]) -> FacadePart:
    if node != _OUTSIDE and not wall.has(node, slots):
        return wall.whole(node)
    children = [0] if node == _OUTSIDE else wall.children[node]
    parts = [[_widened(wall, child, slots)] for child in children]
    for slot, insertions in slots.get(node, {}).items():
        new = _repeated(wall, children, slot, insertions)
        if slot.placement is Placement.BETWEEN:
            parts[slot.high] = new + parts[slot.high]
        elif slot.placement is Placement.BEFORE:
            parts[slot.low] = new + parts[slot.low]
        else:
            parts[slot.high] = parts[slot.high] + new
    axis = wall.along if node == _OUTSIDE else wall.axis[node]
    return wall.joined(NEW if node == _OUTSIDE else node, axis, [part for row in parts for part in row])


def _repeated(
    wall: AxisView, children: Sequence[int], slot: _Slot, insertions: Sequence[Insertion]
) -> list[FacadePart]:
    """The copy of the surroundings with the sources, and the gap between it and the next anchor."""
    gap = [part for child in _gap(wall, children, slot) if (part := _copied(wall, child, {})) is not None]
    block = _surroundings(wall, children, slot, insertions)
    return [*gap, block] if slot.placement is Placement.AFTER else [block, *gap]


def _gap(wall: AxisView, children: Sequence[int], slot: _Slot) -> Sequence[int]:
    """The parts between the anchors; for a single anchor a neighbour, if that contains no element."""
    if slot.low != slot.high:
        return children[slot.low + 1 : slot.high]
    adjacent = [*children[slot.high + 1 : slot.high + 2], *children[max(slot.low - 1, 0) : slot.low]]
    return [child for child in adjacent if not wall.has_elements(child)][:1]


def _surroundings(wall: AxisView, children: Sequence[int], slot: _Slot, insertions: Sequence[Insertion]) -> FacadePart:
    """A copy of the surroundings of the sources, if one part of the same row contains them all; otherwise the anchors.

    The surroundings of a source fit it, and are as high as the row.
    """
    swap = {insertion.source: insertion.source for insertion in insertions}
    holder = next((child for child in children if all(child <= node < wall.end[child] for node in swap)), None)
    if holder is None:
        holder = children[slot.high if slot.placement is Placement.AFTER else slot.low]
        swap = {
            insertion.high if slot.placement is Placement.AFTER else insertion.low: insertion.source
            for insertion in insertions
        }
    lead = min(wall.low[insertion.high] for insertion in insertions) - wall.low[children[slot.high]]
    trail = wall.high[children[slot.low]] - max(wall.high[insertion.low] for insertion in insertions)
    block = _copied(wall, holder, swap, _extent(wall, holder, swap, lead, trail))
    if len(swap) == 1 and (block is None or block.axis == wall.along):
        # Only the source is left of its surroundings.
        block = wall.whole(insertions[0].source, fresh=True)
    if block is None:
        raise FacadeError("Nothing is left of the surroundings of the sources.")
    return block


def _extent(wall: AxisView, holder: int, swap: Mapping[int, int], lead: float, trail: float) -> tuple[float, float]:
    """Start and end of the copy of a part: all of it, unless it contains other elements than those of the edit.

    Otherwise, gaps around these elements are as wide as between the anchors, but end at other elements.
    """
    low, high = min(wall.low[node] for node in swap), max(wall.high[node] for node in swap)
    others = [node for node in wall.element if holder <= node < wall.end[holder] and node not in swap]
    others = [node for node in others if not wall.has(node, swap) and not any(wall.end[s] > node >= s for s in swap)]
    neighbours = [node for node in others if wall.high[node] <= low or wall.low[node] >= high]
    if not neighbours:
        return wall.low[holder], wall.high[holder]
    start = max([wall.low[holder], low - lead, *(wall.high[node] for node in neighbours if wall.high[node] <= low)])
    stop = min([wall.high[holder], high + trail, *(wall.low[node] for node in neighbours if wall.low[node] >= high)])
    return start, stop


def _copied(
    wall: AxisView, node: int, swap: Mapping[int, int], extent: tuple[float, float] | None = None
) -> FacadePart | None:
    """A copy of an extent of a node; its elements are left out unless they are swapped for others.

    Grids that are not edited keep their elements, so the surroundings must not bring copies of these.
    """
    if node in swap:
        return wall.whole(swap[node], fresh=True)
    low, high = wall.low[node], wall.high[node]
    start, stop = extent or (low, high)
    slack = 1e-9 * (high - low)
    if node in wall.element and not wall.has(node, swap):
        return None
    inside = start <= low + slack and stop >= high - slack
    if inside and not wall.has_elements(node):
        return wall.whole(node, fresh=True)
    if wall.axis[node] == LEAF:
        part = wall.whole(node, fresh=True)
        cut = (max(start, low) - low) / (high - low), (min(stop, high) - low) / (high - low)
        return replace(part, low=cut[0], high=cut[1])
    children = wall.children[node]
    if wall.axis[node] == wall.along:
        children = [child for child in children if min(stop, wall.high[child]) - max(start, wall.low[child]) > slack]
    return stretched(wall, node, children, [_copied(wall, child, swap, extent) for child in children], fresh=True)


def stretched(
    wall: AxisView, node: int, children: Sequence[int], parts: Sequence[FacadePart | None], *, fresh: bool
) -> FacadePart | None:
    """The parts of a node without those that are None; across the edited axis, adjacent leaves fill their place."""
    filled = list(parts)
    if wall.axis[node] != wall.along and None in filled:
        # An element keeps its size.
        leaves = [
            index
            for index, part in enumerate(parts)
            if part is not None and part.axis == LEAF and part.source not in wall.element
        ]
        for removed in [index for index, part in enumerate(parts) if part is None and leaves]:
            nearest = min(leaves, key=lambda index: abs(index - removed))
            filled[nearest] = _grown(wall, filled[nearest], wall.height[children[removed]])
    row = [part for part in filled if part is not None]
    return wall.joined(node, wall.axis[node], row, fresh=fresh) if row else None


def _grown(wall: AxisView, part: FacadePart | None, more: float) -> FacadePart | None:
    return None if part is None else replace(part, scale=part.scale + more / wall.height[part.source])
