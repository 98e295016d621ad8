"""Wall between boxes: rectangles with gaps become a tiling that straight cuts divide.

A piece of the facade is cut along all lines that cross no box, and gaps between the parts are wall; then along the
other axis, until each piece is one box or all wall. So wall never prevents a cut. If every line crosses a box, the cut
is the line that crosses the fewest of the boxes that may be cut: bands, and boxes that are partly hidden. All other
boxes stay whole, unless cuts through them are allowed as a last resort.
"""

from __future__ import annotations

from operator import itemgetter

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.reading.cutting import MOST_LEVELS, pinwheel
from grammarlab.facade.reading.overlaps import VisiblePieces
from grammarlab.facade.tree import X, Y

WALL = -1
"""Source of areas without a box."""

Box = tuple[int, int, int, int, int, bool]
"""Left, bottom, right, top, source, and whether it must stay whole."""
Rectangle = tuple[int, int, int, int]


class PinwheelError(FacadeError):
    """Boxes that no straight line divides, with their sources."""

    def __init__(self, sources: Ints) -> None:
        super().__init__(f"No straight cut divides the boxes {sources.tolist()}.")
        self.sources = sources


def fill(pieces: VisiblePieces, frame: Rectangle, *, split: bool = False) -> tuple[Ints, Ints]:
    """A tiling of the frame [K, 4], and the source [K] of each rectangle: a box, or `WALL`.

    Args:
        pieces: rectangles inside the frame that do not overlap.
        frame: left, bottom, right and top.
        split: whether boxes that should stay whole may be cut if every line crosses one.

    Raises:
        PinwheelError: If every line crosses a box that must stay whole.
        FacadeError: If cuts are nested too deep.
    """
    rows = np.column_stack([pieces.boxes, pieces.source]).tolist()
    boxes: list[Box] = [(*row, bool(whole)) for row, whole in zip(rows, pieces.whole.tolist(), strict=True)]
    tiles: list[tuple[int, int, int, int, int]] = []
    pending: list[tuple[Rectangle, list[Box]]] = [(frame, boxes)]
    levels = 0
    while pending:
        levels += 1
        if levels > MOST_LEVELS:
            raise FacadeError(f"These boxes need more than {MOST_LEVELS} levels of cuts.")
        level_pieces, pending = pending, []
        for around, inside in level_pieces:
            if not inside:
                tiles.append((*around, WALL))  # ty: ignore[invalid-argument-type]
            elif len(inside) == 1 and inside[0][:4] == around:
                tiles.append((*around, inside[0][4]))  # ty: ignore[invalid-argument-type]
            else:
                pending += _divided(around, inside, Y) or _divided(around, inside, X) or _forced(around, inside, split)
    table = np.array(tiles, dtype=np.int64)
    return table[:, :4], table[:, 4]


def _divided(around: Rectangle, inside: list[Box], along: int) -> list[tuple[Rectangle, list[Box]]]:
    """Parts of a piece and the gaps between them; empty if no line divides it."""
    inside.sort(key=itemgetter(along))
    parts: list[tuple[int, int, list[Box]]] = []
    reach = around[along]
    for box in inside:
        if parts and box[along] < reach:
            parts[-1][2].append(box)
        else:
            if box[along] > reach:
                parts.append((reach, box[along], []))
            parts.append((box[along], 0, [box]))
        reach = max(reach, box[along + 2])
    if reach < around[along + 2]:
        parts.append((reach, around[along + 2], []))
    if len(parts) == 1:
        return []
    ends = [start for start, _, _ in parts[1:]] + [around[along + 2]]
    return [
        (_between(around, along, start, end), members) for (start, _, members), end in zip(parts, ends, strict=True)
    ]


def _between(around: Rectangle, along: int, low: int, high: int) -> Rectangle:
    x_low, y_low, x_high, y_high = around
    return (low, y_low, high, y_high) if along == X else (x_low, low, x_high, high)


def _forced(around: Rectangle, inside: list[Box], split: bool) -> list[tuple[Rectangle, list[Box]]]:
    """Both sides of the line that crosses the fewest boxes that should stay whole, then the fewest others."""
    table = np.array([box[:4] for box in inside])
    whole = np.array([box[5] for box in inside])
    options: list[tuple[int, int, int, int, int]] = []  # whole ones crossed, all crossed, imbalance, axis, line
    for along in (Y, X):
        low, high = table[:, along], table[:, along + 2]
        lines = np.unique(np.concatenate([low, high]))
        lines = lines[(lines > around[along]) & (lines < around[along + 2])]
        if len(lines):
            crossed, below = _crossed(low, high, lines)
            imbalance = np.abs(2 * below + crossed - len(table))
            whole_crossed, _ = _crossed(low[whole], high[whole], lines)
            first = int(np.lexsort((lines, imbalance, crossed, whole_crossed))[0])
            options.append(
                (int(whole_crossed[first]), int(crossed[first]), int(imbalance[first]), -along, int(lines[first]))
            )
    best = min(options, default=None)
    if best is None or (best[0] and not split):
        sources = np.array([box[4] for box in inside])
        raise PinwheelError(np.unique(sources[pinwheel(table)]))
    along, line = -best[3], best[4]
    sides = [(around[along], line), (line, around[along + 2])]
    return [(_between(around, along, *side), _clipped(inside, along, *side)) for side in sides]


def _crossed(low: Ints, high: Ints, lines: Ints) -> tuple[Ints, Ints]:
    """Number of intervals that each line crosses, and number that end before it."""
    below = np.searchsorted(np.sort(high), lines, side="right")
    return np.searchsorted(np.sort(low), lines, side="left") - below, below


def _clipped(inside: list[Box], along: int, low: int, high: int) -> list[Box]:
    """Boxes between two lines of an axis, clipped."""
    clipped: list[Box] = []
    for box in inside:
        start, end = max(box[along], low), min(box[along + 2], high)
        if start < end:
            clipped.append((*_between(box[:4], along, start, end), box[4], box[5]))
    return clipped
