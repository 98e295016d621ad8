"""Removal of a column: its elements, the parts of the wall without other contents, and the gap beside each."""

from __future__ import annotations

from collections.abc import Sequence, Set

from grammarlab.facade.variations.insertion import stretched
from grammarlab.facade.variations.parts import AxisView, FacadePart


def removed(wall: AxisView, gone: Set[int], *, last: bool) -> FacadePart | None:
    """The wall without some elements of its grids; None if nothing remains.

    A part of a row without other elements is removed whole, with the gap up to the next element: removal is the inverse
    of insertion. If a part contains other elements, only the removable pieces around the elements are removed;
    otherwise the wall closes over the place.

    Args:
        wall: the edited facade.
        gone: the elements to remove.
        last: whether they have the highest coordinates of their grids: then the gap before them is removed first.
    """
    return _reduced(wall, 0, gone, -1 if last else 1)


def _reduced(wall: AxisView, node: int, gone: Set[int], step: int) -> FacadePart | None:
    if node in gone:
        return None
    if not wall.has(node, gone):
        return wall.whole(node)
    children = wall.children[node]
    if wall.axis[node] != wall.along:
        return stretched(wall, node, children, [_reduced(wall, child, gone, step) for child in children], fresh=False)
    dropped = [wall.has(child, gone) and not _keeps(wall, child, gone) for child in children]
    gaps = [not wall.has_elements(child) for child in children]
    for place in [place for place, drop in enumerate(dropped) if drop]:
        for gap in _gap_beside(place, step, gaps, dropped):
            dropped[gap] = True
    kept = [child for child, drop in zip(children, dropped, strict=True) if not drop]
    return stretched(wall, node, kept, [_reduced(wall, child, gone, step) for child in kept], fresh=False)


def _keeps(wall: AxisView, node: int, gone: Set[int]) -> bool:
    """Whether a node contains elements that stay."""
    inside = wall.elements_before[wall.end[node]] - wall.elements_before[node]
    for each in gone:
        if node <= each < wall.end[node]:
            inside -= wall.elements_before[wall.end[each]] - wall.elements_before[each]
    return inside > 0


def _gap_beside(place: int, step: int, gaps: Sequence[bool], dropped: Sequence[bool]) -> list[int]:
    """The gap on one side of a removed part, up to the next element; on the other side, if there is no next element.

    Without any other element, only one of both gaps is removed, so that a wall remains.
    """
    first, second = _gap(place, step, gaps, dropped), _gap(place, -step, gaps, dropped)
    for gap, ends_at_element in (first, second):
        if ends_at_element:
            return gap
    return first[0] if second[0] else []


def _gap(place: int, step: int, gaps: Sequence[bool], dropped: Sequence[bool]) -> tuple[list[int], bool]:
    """The parts without elements next to a place, and whether another part follows them."""
    gap = []
    place += step
    while 0 <= place < len(gaps) and gaps[place] and not dropped[place]:
        gap.append(place)
        place += step
    return gap, 0 <= place < len(gaps)
