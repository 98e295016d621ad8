"""Rectangles that no line divides without crossing one of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammarlab.facade.tree import Floats, Ints, X, Y

_NAMED = 8
"""Largest number of rectangles of a pinwheel in a message."""


def components(boxes: Ints, along: int) -> list[Ints]:
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


def pinwheel(boxes: Ints) -> Ints:
    """Indices of rectangles that no line divides: a minimal set, and the rectangles between them.

    Args:
        boxes: [N, 4] left, bottom, right, top, as integers, that do not overlap and cannot be divided by cuts.
    """
    left = _undivided(boxes)
    assert left is not None, "these rectangles can be divided"  # noqa: S101  # the caller has tried
    size = max(1, len(left) // 2)
    while size:
        start = 0
        while start < len(left):
            fewer = np.delete(left, slice(start, start + size))
            smaller = _undivided(boxes[fewer])
            if smaller is None:
                start += size
            else:
                left, start = np.sort(fewer[smaller]), 0 if len(smaller) < len(fewer) else start
        size //= 2
    hull_low, hull_high = boxes[left, :2].min(axis=0), boxes[left, 2:].max(axis=0)
    inside = (boxes[:, :2] >= hull_low).all(axis=1) & (boxes[:, 2:] <= hull_high).all(axis=1)
    return np.flatnonzero(inside)


def pinwheel_text(found: Ints, low: Floats, high: Floats, names: Sequence[str], number: Ints) -> str:
    """Message on rectangles that no line divides.

    Args:
        found: rectangles of the pinwheel.
        low: [N, 2] lower left corners of all rectangles, metres.
        high: [N, 2] upper right corners.
        names: [N] labels.
        number: [N] numbers for the user.
    """
    shown = [
        f"{names[each] or 'rectangle'} {number[each]} at ({low[each, X]:.6g}, {low[each, Y]:.6g}) to "
        f"({high[each, X]:.6g}, {high[each, Y]:.6g})"
        for each in found.tolist()
    ]
    more = f"; and {len(shown) - _NAMED} more" if len(shown) > _NAMED else ""
    return (
        f"No straight cut divides these {len(shown)} rectangles, which form a pinwheel: "
        f"{'; '.join(shown[:_NAMED])}{more}. Change one of them so that a line from side to side crosses none of them."
    )


def _undivided(boxes: Ints) -> Ints | None:
    """Indices of rectangles that cuts do not separate, if any."""
    pieces = [np.arange(len(boxes))]
    while pieces:
        piece = pieces.pop()
        if len(piece) < 2:
            continue
        for along in (Y, X):
            parts = components(boxes[piece], along)
            if len(parts) > 1:
                pieces.extend(piece[part] for part in parts)
                break
        else:
            return piece
    return None
