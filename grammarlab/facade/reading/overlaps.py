"""Overlapping boxes: the front box of each pair, and the visible rest of the other.

A box inside another one is in front of it, as a window in a molding. Otherwise the front box is the one whose label
is usually in front on buildings (`FRONT`), then the smaller one, then the first in the file. The visible rest of the
other box is divided into rectangles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import Ints

FRONT = ("deco", "shop", "balcony", "door", "blind", "sill", "window", "pillar", "cornice", "molding", "facade", "wall")
"""Labels from the front to the back; all others are level with `window`."""

BANDS = ("pillar", "cornice", "molding", "sill")
"""Labels of elements along a wall, which may be cut."""

MOST_OVERLAPS = 2_000_000
"""Largest number of pairs of boxes that overlap."""
_MOST_CELLS = 20_000_000
"""Largest number of cells of all boxes with hidden parts."""
_AT_ONCE = 200
"""Number of boxes whose overlaps are found together, since all boxes of a file may overlap."""


@dataclass(frozen=True, slots=True)
class VisiblePieces:
    """Visible parts of boxes: M rectangles that do not overlap."""

    boxes: Ints
    """[M, 4] lines of left, bottom, right and top."""
    source: Ints
    """[M] source box of each piece."""
    whole: NDArray[np.bool_]
    """[M] whether it must stay whole: an entire box that is not a band."""


def uncovered(boxes: Ints, names: Sequence[str]) -> VisiblePieces:
    """Visible parts of overlapping boxes.

    Args:
        boxes: [N, 4] lines of left, bottom, right and top.
        names: [N] labels, in lower case.

    Raises:
        FacadeError: If more than `MOST_OVERLAPS` pairs overlap.
    """
    front, behind = _overlaps(boxes, names)
    kept = np.setdiff1d(np.arange(len(boxes)), behind)
    pieces, sources, cells = [boxes[kept]], [kept], 0
    order = np.argsort(behind, kind="stable")
    losers, first = np.unique(behind[order], return_index=True)
    for loser, hiding in zip(losers.tolist(), np.split(front[order], first)[1:], strict=True):
        rest, taken = _rest(boxes[loser], boxes[hiding])
        cells += taken
        if cells > _MOST_CELLS:
            raise FacadeError(f"The box {names[loser]!r} and others have too many visible pieces: leave them out.")
        pieces.append(rest)
        sources.append(np.full(len(rest), loser))
    whole = np.zeros(sum(map(len, pieces)), dtype=bool)
    whole[: len(kept)] = [names[each] not in BANDS for each in kept.tolist()]
    return VisiblePieces(np.vstack(pieces), np.concatenate(sources), whole)


def _overlaps(boxes: Ints, names: Sequence[str]) -> tuple[Ints, Ints]:
    """Pairs of overlapping boxes: those in front, and those behind."""
    inner = shapely.box(boxes[:, 0] + 0.25, boxes[:, 1] + 0.25, boxes[:, 2] - 0.25, boxes[:, 3] - 0.25)
    tree, pairs, count = shapely.STRtree(inner), [np.zeros((2, 0), dtype=np.int64)], 0
    for start in range(0, len(boxes), _AT_ONCE):
        found = tree.query(inner[start : start + _AT_ONCE])
        found[0] += start
        found = found[:, found[0] < found[1]]
        pairs.append(found)
        count += found.shape[1]
        if count > MOST_OVERLAPS:
            raise FacadeError(f"More than {MOST_OVERLAPS:,} pairs of boxes overlap; facades have few such pairs.")
    a, b = np.hstack(pairs)
    beside = FRONT.index("window")
    depth = np.array([FRONT.index(name) if name in FRONT else beside for name in names], dtype=np.int64)
    area = (boxes[:, 2:] - boxes[:, :2]).prod(axis=1)
    first = (depth[a] < depth[b]) | ((depth[a] == depth[b]) & (area[a] <= area[b]))
    a_in_b, b_in_a = _lies_in(boxes[a], boxes[b]), _lies_in(boxes[b], boxes[a])
    first = np.where(a_in_b == b_in_a, first, a_in_b)
    return np.where(first, a, b), np.where(first, b, a)


def _lies_in(inner: Ints, outer: Ints) -> NDArray[Any]:
    return np.all((inner[:, :2] >= outer[:, :2]) & (inner[:, 2:] <= outer[:, 2:]), axis=1)


def _rest(box: Ints, hiding: Ints) -> tuple[Ints, int]:
    """[M, 4] rectangles of the visible parts of a box, and the number of cells examined."""
    clipped = np.clip(hiding, np.tile(box[:2], 2), np.tile(box[2:], 2))
    columns = np.unique(np.concatenate([box[[0, 2]], clipped[:, 0], clipped[:, 2]]))
    rows = np.unique(np.concatenate([box[[1, 3]], clipped[:, 1], clipped[:, 3]]))
    cells = (len(columns) - 1) * (len(rows) - 1)
    if cells > _MOST_CELLS:
        return np.zeros((0, 4), dtype=np.int64), cells
    seen = np.ones((len(columns) - 1, len(rows) - 1), dtype=bool)
    left, right = (np.searchsorted(columns, clipped[:, side]).tolist() for side in (0, 2))
    bottom, top = (np.searchsorted(rows, clipped[:, side]).tolist() for side in (1, 3))
    for place in range(len(clipped)):
        seen[left[place] : right[place], bottom[place] : top[place]] = False
    across, upright = _runs(seen.T)[:, [1, 0, 3, 2]], _runs(seen)
    best = across if len(across) <= len(upright) else upright
    return np.stack([columns[best[:, 0]], rows[best[:, 1]], columns[best[:, 2]], rows[best[:, 3]]], axis=1), cells


def _runs(seen: NDArray[np.bool_]) -> Ints:
    """[M, 4] cells as rectangles: runs along the second axis, merged with equal runs of neighbours."""
    found: list[list[int]] = []
    open_runs: dict[tuple[int, int], list[int]] = {}
    for place, line in enumerate(seen):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], line, [False]]).astype(np.int8)))
        runs = [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
        still = {run: open_runs.get(run) or [place, run[0], place, run[1]] for run in runs}
        found.extend(rectangle for run, rectangle in still.items() if run not in open_runs)
        for rectangle in still.values():
            rectangle[2] = place + 1
        open_runs = still
    return np.array(found, dtype=np.int64).reshape(-1, 4)
