"""Equal units of a wall: labels of cells by the boxes and depths of their elements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import ndimage

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.facade.lattice import Lattice
from grammarlab.synthesis.analysis.unit_names import NamedOpenings, may_be_doors, names_of
from grammarlab.synthesis.analysis.wall_elements import MIN_SIDE_M, WallElements, off_plane, slack_of
from grammarlab.synthesis.analysis.walls import Wall
from grammarlab.synthesis.label_grid import HOLE, LabelGrid

_SIZE_TOLERANCE_M, _NOISE_FACTOR = 0.03, 4.0
"""Largest difference of elements of equal units, in metres, and as a multiple of the noise."""
_MOST_EXAMPLES = 8
"""Largest number of cells of a kind that others are compared with."""
_CELL_TOLERANCE = 0.35
"""Largest relative difference of cells of equal units without elements, which are scaled to the size of their row and
column; elements keep their size."""
_DEPTH_TOLERANCE_M, _DEPTH_NOISE_FACTOR = 0.03, 5.0
"""Largest difference of depths of equal units, in metres, and as a multiple of the noise."""
_MAX_REVEAL_M = 0.3
"""Largest depth of the glass of a window behind the plane of its wall, metres: deeper ones are loggias."""
_EDGE_NOISE_FACTOR = 4.0
"""Largest error of sides beyond one pixel, as a multiple of the noise."""
_MAX_AREA_SHARE = 0.06
"""Share of the area off the plane from which differing depths make another unit."""
_MIN_AREA_M2 = 0.3
"""Least area of which that share is taken, square metres."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Cell:
    size: Floats
    """[2] metres; NaN along an axis at whose end it is, since such cells end with the wall, or along which an element
    is larger than the cell."""
    boxes: Floats
    """[K, 4] low and high corners of its elements, metres."""
    pieces: Floats
    """[P, 2] width and height of the piece of another cell's element at its centre, metres: negative if the element
    goes on below or to the left, 0 if on both sides. P is 0 or 1."""
    depth: Floats
    """[3, h, w] metres in front of the plane: at each pixel, and the least and the largest in its neighbourhood."""
    off: Flags
    """[h, w] whether it is off the plane, or in an element."""
    anchor: Ints
    """[2] row and column of the pixel in the centre of its elements."""
    step: float
    """Metres per pixel."""


def label_grid(wall: Wall, elements: WallElements, columns: Lattice, rows: Lattice) -> LabelGrid:
    """The label of each cell, with names by appearance."""
    cells = _cells(wall, elements, columns, rows)
    labels = np.full((len(rows), len(columns)), HOLE)
    # Inner cells come first: cells at an end are compared with them, since their own size is cut off by the wall.
    ends = [(row in (0, len(rows) - 1)) + (column in (0, len(columns) - 1)) for row, column in np.ndindex(labels.shape)]
    kinds = list[list[_Cell]]()
    for index in np.argsort(ends, kind="stable").tolist():
        row, column = divmod(index, len(columns))
        labels[row, column] = _joined(cells[row][column], kinds, labels, wall.noise, is_inner=ends[index] == 0)
    used, labels = np.unique(labels, return_inverse=True)
    labels = labels.reshape(len(rows), -1)
    openings = NamedOpenings(
        np.hstack([elements.low, elements.high]), labels[rows.member, columns.member], float(wall.low[1])
    )
    return LabelGrid.from_labels(labels, names_of(openings, [len(kinds[kind][0].boxes) for kind in used.tolist()]))


def _joined(cell: _Cell, kinds: list[list[_Cell]], labels: Ints, noise: float, *, is_inner: bool) -> int:
    """The kind of a cell, the most similar and frequent one of several.

    Sizes that a person measured differ a little, so an inner cell between two kinds joins them.

    Args:
        cell: the cell.
        kinds: some cells of each kind so far; it is changed.
        labels: the kinds of all cells so far; those of joined kinds are changed.
        noise: deviation of points, metres.
        is_inner: whether the cell is at no end of the wall.
    """
    shares = [_least_difference(cell, members, noise) for members in kinds]
    equal = [number for number, share in enumerate(shares) if share <= _MAX_AREA_SHARE]
    if not equal:
        kinds.append([cell])
        return len(kinds) - 1
    if is_inner:
        kind, *others = equal
        for number in others:
            labels[labels == number] = kind
            kinds[kind] += kinds[number]
            kinds[number] = []
    else:
        kind = min(equal, key=lambda number: (shares[number], -int((labels == number).sum())))
    kinds[kind] = [*kinds[kind], cell][:_MOST_EXAMPLES]
    return kind


def _are_equal(sizes: Floats, others: Floats, tolerance: float) -> bool:
    """Whether two arrays of sizes [K, 2] are equal within a tolerance, metres."""
    return sizes.shape == others.shape and bool((np.abs(sizes - others) <= tolerance).all())


def _sizes(cell: _Cell) -> Floats:
    """[K, 2] width and height of its elements, metres."""
    return cell.boxes[:, 2:] - cell.boxes[:, :2]


def _cells(wall: Wall, elements: WallElements, columns: Lattice, rows: Lattice) -> list[list[_Cell]]:
    off, map_ = off_plane(wall), wall.map
    depth = np.clip(np.where(np.isfinite(map_.depth), map_.depth - wall.depth, -1.0), -1.0, 2.0)
    around = 1 + 2 * int(np.ceil(1.0 + (_SIZE_TOLERANCE_M + _EDGE_NOISE_FACTOR * wall.noise) / map_.step))
    all_boxes = np.hstack([elements.low, elements.high])
    for low, high, is_door in zip(
        elements.low, elements.high, may_be_doors(all_boxes, float(wall.low[1])), strict=True
    ):
        box = map_.rows(low[1], high[1]), map_.columns(low[0], high[0])
        off[box] = True
        if not is_door:
            depth[box] = _levelled(depth[box], slack_of(wall))
    depths = np.stack([depth, ndimage.minimum_filter(depth, around), ndimage.maximum_filter(depth, around)])
    # Noise can move an element beyond the line where it ends.
    inside = _EDGE_NOISE_FACTOR * wall.noise
    cells = []
    for row in range(len(rows)):
        cells.append([])
        for column in range(len(columns)):
            low = np.array([columns.line[column], rows.line[row]])
            high = np.array([columns.line[column + 1], rows.line[row + 1]])
            members = np.flatnonzero((columns.member == column) & (rows.member == row))
            boxes = all_boxes[members]
            boxes = boxes[np.lexsort(boxes.T[::-1])]
            part = map_.rows(low[1] + inside, high[1] - inside), map_.columns(low[0] + inside, high[0] - inside)
            size = high - low
            size[[column in (0, len(columns) - 1), row in (0, len(rows) - 1)]] = np.nan
            size[((boxes[:, :2] < low) | (boxes[:, 2:] > high)).any(axis=0)] = np.nan
            middle = (boxes[:, :2].min(axis=0) + boxes[:, 2:].max(axis=0)) / 2.0 if len(boxes) else (low + high) / 2.0
            first = np.array([part[0].start, part[1].start])
            anchor = np.rint((middle - map_.low) / map_.step - 0.5)[::-1].astype(np.int64) - first
            cells[-1].append(
                _Cell(
                    size=size,
                    boxes=boxes,
                    pieces=_pieces(np.delete(all_boxes, members, axis=0), low, high),
                    depth=depths[:, *part],
                    off=off[part],
                    anchor=anchor,
                    step=map_.step,
                )
            )
    return cells


def _pieces(boxes: Floats, low: Floats, high: Floats) -> Floats:
    """[P, 2] signed width and height of the piece of a box at the centre of a cell, as in `_Cell`.

    Args:
        boxes: [K, 4] low and high corners, metres.
        low: [2] lower left corner of the cell.
        high: [2] upper right corner.
    """
    begin, end = np.maximum(boxes[:, :2], low), np.minimum(boxes[:, 2:], high)
    middle = (low + high) / 2.0
    inside = ((begin < middle) & (middle < end)).all(axis=1)
    goes_on = np.stack([boxes[:, :2] < low, boxes[:, 2:] > high])
    sign = np.where(goes_on.all(axis=0), 0.0, np.where(goes_on[0], -1.0, 1.0))
    return (sign * (end - begin))[inside][:1]


def _least_difference(cell: _Cell, members: list[_Cell], noise: float) -> float:
    """The least share of a cell that differs from one of the members of a kind; infinite if there are none."""
    least = np.inf
    for member in members:
        least = min(least, _difference(cell, member, noise))
        if least == 0.0:  # no share is smaller
            break
    return least


def _difference(a: _Cell, b: _Cell, noise: float) -> float:
    """Share of two cells whose depths differ; infinite if their elements do."""
    tolerance = _SIZE_TOLERANCE_M + _NOISE_FACTOR * noise
    if len(a.boxes) != len(b.boxes) or not _are_equal(a.pieces, b.pieces, tolerance):
        return np.inf
    if not len(a.boxes) and not a.off.any() and not b.off.any():
        return 0.0  # a flat wall has any size
    if not len(a.boxes) and (np.abs(a.size - b.size) > _CELL_TOLERANCE * np.maximum(a.size, b.size)).any():
        return np.inf
    if not _are_equal(_sizes(a), _sizes(b), tolerance):
        return np.inf
    before = np.minimum(a.anchor, b.anchor)
    after = np.minimum(a.off.shape - a.anchor, b.off.shape - b.anchor)
    if (before + after <= 0).any():
        return 0.0
    slices_a, slices_b = (
        (slice(*ends) for ends in np.stack([cell.anchor - before, cell.anchor + after]).T) for cell in (a, b)
    )
    slices_a, slices_b = tuple(slices_a), tuple(slices_b)
    slack = _DEPTH_TOLERANCE_M + _DEPTH_NOISE_FACTOR * noise
    # A depth may be in the same pixel of the other cell or in one beside it, since cells begin within pixels.
    differs = _beyond(a.depth[:, *slices_a], b.depth[:, *slices_b], slack) | _beyond(
        b.depth[:, *slices_b], a.depth[:, *slices_a], slack
    )
    differs = _without_details(differs, a.step)
    area = max(float((a.off[slices_a] | b.off[slices_b]).sum()), _MIN_AREA_M2 / a.step**2)
    return float(differs.sum()) / area


def _without_details(differs: Flags, step: float) -> Flags:
    """[h, w] pixels that differ, without parts that are narrower than an element: single bars, or frames.

    Bars side by side, as of a railing, are one wide part.
    """
    if not differs.any():
        return differs
    pixels = int(np.ceil(MIN_SIDE_M / step))
    wide: Any = np.pad(differs, pixels)
    # A closing and an opening by a square, which is the sum of two lines.
    for change in (ndimage.binary_dilation, ndimage.binary_erosion, ndimage.binary_erosion, ndimage.binary_dilation):
        for line in ((pixels, 1), (1, pixels)):
            wide = change(wide, structure=np.ones(line, dtype=bool))
    return wide[pixels:-pixels, pixels:-pixels] & differs


def _levelled(depth: Floats, slack: float) -> Floats:
    """[h, w] depths in a window with its glass in the plane of the wall: how thick a wall is makes no other unit.

    Args:
        depth: [h, w] metres in front of the plane.
        slack: largest distance from the plane of points in it, metres.
    """
    behind = depth <= slack
    glass = float(np.median(depth[behind])) if behind.any() else 0.0
    return np.where(behind, depth - glass, depth) if glass >= -_MAX_REVEAL_M else depth


def _beyond(depth: Floats, reference: Floats, slack: float) -> Flags:
    """[h, w] whether a depth is outside the range around the same pixel of the other cell."""
    return (depth[0] < reference[1] - slack) | (depth[0] > reference[2] + slack)
