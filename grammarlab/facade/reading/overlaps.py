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

from grammarlab.arrays import Ints
from grammarlab.errors import FacadeError

FRONT = ("deco", "shop", "balcony", "door", "blind", "sill", "window", "pillar", "cornice", "molding", "facade", "wall")
"""Labels from the front to the back; all others are level with `window`."""

BANDS = ("pillar", "cornice", "molding", "sill")
"""Labels of elements along a wall, which may be cut."""

MOST_OVERLAPS = 2_000_000
"""Largest number of pairs of boxes that overlap."""
_MOST_CELLS = 20_000_000
"""Largest number of cells of all boxes with hidden parts."""
_BOXES_PER_QUERY = 200
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
    visible = np.setdiff1d(np.arange(len(boxes)), behind)
    pieces, sources, cells = [boxes[visible]], [visible], 0
    order = np.argsort(behind, kind="stable")
    hidden, first = np.unique(behind[order], return_index=True)
    for hidden_box, covers in zip(hidden.tolist(), np.split(front[order], first)[1:], strict=True):
        rest, num_cells = _rest(boxes[hidden_box], boxes[covers])
        cells += num_cells
        if cells > _MOST_CELLS:
            raise FacadeError(f"The box {names[hidden_box]!r} and others have too many visible pieces: leave them out.")
        pieces.append(rest)
        sources.append(np.full(len(rest), hidden_box))
    whole = np.zeros(sum(map(len, pieces)), dtype=bool)
    whole[: len(visible)] = [names[box] not in BANDS for box in visible.tolist()]
    return VisiblePieces(np.vstack(pieces), np.concatenate(sources), whole)


def _overlaps(boxes: Ints, names: Sequence[str]) -> tuple[Ints, Ints]:
    """Pairs of overlapping boxes: those in front, and those behind."""
    inner = shapely.box(boxes[:, 0] + 0.25, boxes[:, 1] + 0.25, boxes[:, 2] - 0.25, boxes[:, 3] - 0.25)
    tree, pairs, count = shapely.STRtree(inner), [np.zeros((2, 0), dtype=np.int64)], 0
    for start in range(0, len(boxes), _BOXES_PER_QUERY):
        hits = tree.query(inner[start : start + _BOXES_PER_QUERY])
        hits[0] += start
        hits = hits[:, hits[0] < hits[1]]
        pairs.append(hits)
        count += hits.shape[1]
        if count > MOST_OVERLAPS:
            raise FacadeError(f"More than {MOST_OVERLAPS:,} pairs of boxes overlap; facades have few such pairs.")
    a, b = np.hstack(pairs)
    window_depth = FRONT.index("window")
    depth = np.array([FRONT.index(name) if name in FRONT else window_depth for name in names], dtype=np.int64)
    area = (boxes[:, 2:] - boxes[:, :2]).prod(axis=1)
    first = (depth[a] < depth[b]) | ((depth[a] == depth[b]) & (area[a] <= area[b]))
    a_in_b, b_in_a = _is_inside(boxes[a], boxes[b]), _is_inside(boxes[b], boxes[a])
    first = np.where(a_in_b == b_in_a, first, a_in_b)
    return np.where(first, a, b), np.where(first, b, a)


def _is_inside(inner: Ints, outer: Ints) -> NDArray[Any]:
    return np.all((inner[:, :2] >= outer[:, :2]) & (inner[:, 2:] <= outer[:, 2:]), axis=1)


def _rest(box: Ints, covers: Ints) -> tuple[Ints, int]:
    """[M, 4] rectangles of the visible parts of a box, and the number of cells examined."""
    clipped = np.clip(covers, np.tile(box[:2], 2), np.tile(box[2:], 2))
    columns = np.unique(np.concatenate([box[[0, 2]], clipped[:, 0], clipped[:, 2]]))
    rows = np.unique(np.concatenate([box[[1, 3]], clipped[:, 1], clipped[:, 3]]))
    cells = (len(columns) - 1) * (len(rows) - 1)
    if cells > _MOST_CELLS:
        return np.zeros((0, 4), dtype=np.int64), cells
    visible = np.ones((len(columns) - 1, len(rows) - 1), dtype=bool)
    left, right = (np.searchsorted(columns, clipped[:, side]).tolist() for side in (0, 2))
    bottom, top = (np.searchsorted(rows, clipped[:, side]).tolist() for side in (1, 3))
    for index in range(len(clipped)):
        visible[left[index] : right[index], bottom[index] : top[index]] = False
    across, upright = _runs(visible.T)[:, [1, 0, 3, 2]], _runs(visible)
    best = across if len(across) <= len(upright) else upright
    return np.stack([columns[best[:, 0]], rows[best[:, 1]], columns[best[:, 2]], rows[best[:, 3]]], axis=1), cells


def _runs(visible: NDArray[np.bool_]) -> Ints:
    """[M, 4] cells as rectangles: runs along the second axis, merged with equal runs of neighbours."""
    rectangles: list[list[int]] = []
    open_runs: dict[tuple[int, int], list[int]] = {}
    for row, line in enumerate(visible):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], line, [False]]).astype(np.int8)))
        runs = [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
        current = {run: open_runs.get(run) or [row, run[0], row, run[1]] for run in runs}
        rectangles.extend(rectangle for run, rectangle in current.items() if run not in open_runs)
        for rectangle in current.values():
            rectangle[2] = row + 1
        open_runs = current
    return np.array(rectangles, dtype=np.int64).reshape(-1, 4)
