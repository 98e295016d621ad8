"""Rectangles that tile a rectangle, as a decomposition tree: cut recursively along all lines that cross none.

Along an axis, the rectangles of a piece are intervals, and overlapping intervals stay together: the connected
components of the interval graph are the results of all possible cuts. So a part can only be cut along the other axis,
axes alternate, and the tree of a tiling is unique except for the first axis, which is y, floors before columns, if both
are possible. Rectangles that no line divides without crossing one of them are a pinwheel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.tree import LEAF, TOLERANCE, Facade, X, Y, check, plain

_MAX_LISTED = 8
"""Largest number of rectangles of a pinwheel in a message."""
MOST_LEVELS = 500
"""Largest depth of nested cuts; facades have about ten."""


def cut(low: Floats, high: Floats, names: Sequence[str]) -> tuple[Facade, Ints]:
    """The tree of a tiling, and the rectangle of each node: [nodes], -1 for inner nodes.

    Takes O(n log n) for each level of the tree.

    Args:
        low: [N, 2] lower left corners, metres; sides that touch have exactly equal coordinates.
        high: [N, 2] upper right corners.
        names: [N] label of each rectangle, empty for none.

    Raises:
        FacadeError: If the rectangles overlap or leave gaps, if some of them form a pinwheel, which no line cuts, or if
            there are more than `MOST_LEVELS` levels.
    """
    _check_area(low, high)
    ranks_low, ranks_high = _ranks(low, high)
    levels = [_Depth(np.zeros(1, np.int64), np.array([len(low)]), np.full(1, -1), LEAF)]
    order, active, piece = np.arange(len(low)), np.arange(len(low)), np.zeros(len(low), dtype=np.int64)
    along = Y
    while len(active) and len(low) > 1:
        new, sorted_boxes = _parts(
            ranks_low[order[active], along], ranks_high[order[active], along], piece, order[active]
        )
        whole = np.bincount(piece, weights=new) == 1
        if whole.any():
            if len(levels) == 1 and along == Y:  # the first axis is a choice
                along = X
                continue
            undivided = order[active][whole[piece]]
            undivided = undivided[: np.bincount(piece)[whole][0]]
            members = undivided[pinwheel(np.hstack([ranks_low, ranks_high])[undivided])]
            raise FacadeError(pinwheel_text(members, low, high, names, np.arange(len(low))))
        order[active] = sorted_boxes
        first = np.flatnonzero(new)
        counts = np.diff(np.append(first, len(active)))
        parents = np.flatnonzero(levels[-1].count > 1)[piece[first]]
        levels.append(_Depth(active[first], counts, parents, along))
        if len(levels) > MOST_LEVELS:
            raise FacadeError(f"These rectangles need more than {MOST_LEVELS} levels of cuts.")
        divisible = np.repeat(counts > 1, counts)
        piece = np.repeat(np.cumsum(counts > 1) - 1, counts)[divisible]
        active, along = active[divisible], 1 - along
    return _tree(levels, order, low, high, names)


def pinwheel(boxes: Ints) -> Ints:
    """Indices of rectangles that no line divides: a minimal set, and the rectangles between them.

    Args:
        boxes: [N, 4] left, bottom, right, top, as integers, that do not overlap and cannot be divided by cuts.
    """
    members = _undivided(boxes)
    assert members is not None, "these rectangles can be divided"  # noqa: S101  # the caller has tried
    size = max(1, len(members) // 2)
    while size:
        start = 0
        while start < len(members):
            fewer = np.delete(members, slice(start, start + size))
            smaller = _undivided(boxes[fewer])
            if smaller is None:
                start += size
            else:
                members, start = np.sort(fewer[smaller]), 0 if len(smaller) < len(fewer) else start
        size //= 2
    hull_low, hull_high = boxes[members, :2].min(axis=0), boxes[members, 2:].max(axis=0)
    inside = (boxes[:, :2] >= hull_low).all(axis=1) & (boxes[:, 2:] <= hull_high).all(axis=1)
    return np.flatnonzero(inside)


def pinwheel_text(members: Ints, low: Floats, high: Floats, names: Sequence[str], number: Ints) -> str:
    """Message on rectangles that no line divides.

    Args:
        members: rectangles of the pinwheel.
        low: [N, 2] lower left corners of all rectangles, metres.
        high: [N, 2] upper right corners.
        names: [N] labels.
        number: [N] numbers for the user.
    """
    descriptions = [
        f"{names[box] or 'rectangle'} {number[box]} at ({low[box, X]:.6g}, {low[box, Y]:.6g}) to "
        f"({high[box, X]:.6g}, {high[box, Y]:.6g})"
        for box in members.tolist()
    ]
    more = f"; and {len(descriptions) - _MAX_LISTED} more" if len(descriptions) > _MAX_LISTED else ""
    return (
        f"No straight cut divides these {len(descriptions)} rectangles, which form a pinwheel: "
        f"{'; '.join(descriptions[:_MAX_LISTED])}{more}. "
        "Change one of them so that a line from side to side crosses none of them."
    )


def _check_area(low: Floats, high: Floats) -> None:
    if not len(low):
        raise FacadeError("A facade needs at least one rectangle, found none.")
    covered, whole = (high - low).prod(axis=1).sum(), (high.max(axis=0) - low.min(axis=0)).prod()
    if not abs(covered - whole) <= 4.0 * TOLERANCE * whole:
        defect = "overlap" if covered > whole else "leave gaps"
        raise FacadeError(f"The rectangles {defect}: they cover {covered:.6g} of {whole:.6g} square metres.")


def _ranks(low: Floats, high: Floats) -> tuple[Ints, Ints]:
    """Ranks [N, 2] of low and high coordinates among all different ones of their axis."""
    ranks = [np.unique(np.concatenate([low[:, a], high[:, a]]), return_inverse=True)[1] for a in (X, Y)]
    both = np.stack(ranks, axis=1)
    return both[: len(low)], both[len(low) :]


@dataclass(frozen=True, slots=True)
class _Depth:
    """The K pieces at one depth of a tree."""

    start: Ints
    """[K] index of the first rectangle of each piece, in the order of the leaves."""
    count: Ints
    """[K] number of rectangles of each piece."""
    parent: Ints
    """[K] parent piece in the level above."""
    axis: int
    """Axis along which the pieces of the level above were cut."""


def _parts(low: Ints, high: Ints, piece: Ints, boxes: Ints) -> tuple[NDArray[np.bool_], Ints]:
    """Whether each box begins a new part [N], and the boxes [N] in the order of their parts."""
    order = np.lexsort((low, piece))
    shift = piece[order] * (int(high.max()) + 1)  # so that pieces do not overlap
    reach = np.maximum.accumulate(high[order] + shift)
    new = np.ones(len(low), dtype=bool)
    new[1:] = low[order][1:] + shift[1:] >= reach[:-1]
    return new, boxes[order]


def _undivided(boxes: Ints) -> Ints | None:
    """Indices of rectangles that cuts do not separate, if any."""
    pieces = [np.arange(len(boxes))]
    while pieces:
        piece = pieces.pop()
        if len(piece) < 2:
            continue
        for along in (Y, X):
            parts = _components(boxes[piece], along)
            if len(parts) > 1:
                pieces.extend(piece[part] for part in parts)
                break
        else:
            return piece
    return None


def _components(boxes: Ints, along: int) -> list[Ints]:
    """Indices of each connected group along an axis, from low to high.

    Args:
        boxes: [N, 4] left, bottom, right, top.
        along: the axis.
    """
    if not len(boxes):
        return []
    order = np.argsort(boxes[:, along], kind="stable")
    reach = np.maximum.accumulate(boxes[order, along + 2])
    return np.split(order, 1 + np.flatnonzero(boxes[order[1:], along] >= reach[:-1]))


def _tree(levels: list[_Depth], order: Ints, low: Floats, high: Floats, names: Sequence[str]) -> tuple[Facade, Ints]:
    """Nodes of all levels, in preorder."""
    sizes = np.array([len(level.start) for level in levels])
    begins = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    start = np.concatenate([level.start for level in levels])
    count = np.concatenate([level.count for level in levels])
    depth = np.repeat(np.arange(len(levels)), sizes)
    above = np.concatenate([levels[k].parent + (begins[k - 1] if k else 0) for k in range(len(levels))])
    axes = np.array([level.axis for level in levels[1:]] + [LEAF])
    preorder = np.lexsort((depth, start))
    number = np.empty(len(preorder), dtype=np.int64)
    number[preorder] = np.arange(len(preorder))
    start, count, depth = start[preorder], count[preorder], depth[preorder]
    parent = np.where(depth > 0, number[above[preorder]], -1)
    leaf = count == 1
    box = np.where(leaf, order[start], -1)
    position, size = _extents(order, start, count, low, high)
    labels = [str(names[rectangle]) if rectangle >= 0 else "" for rectangle in box.tolist()]
    axis = np.where(leaf, LEAF, axes[depth]).astype(np.int8)
    return check(plain(parent, axis, position - low.min(axis=0), size, labels)), box


def _extents(order: Ints, start: Ints, count: Ints, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Lower left corner and size [K, 2] of the union of the rectangles of each node."""
    lows, highs = low[order[start]], high[order[start]]
    for node in np.flatnonzero(count > 1).tolist():
        boxes = order[start[node] : start[node] + count[node]]
        lows[node], highs[node] = low[boxes].min(axis=0), high[boxes].max(axis=0)
    return lows, highs - lows
