"""Elements that repeat: shallow parts of equal size in rows and columns, and places where a row and a column lack one.

Rows and columns are translations of a facade that move elements onto each other (paper 001, chapter 3). A shallow part
is an element only if such translations repeat it; a partly hidden element is found at the place to which the others of
its row and of its column are moved.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage
from scipy.sparse.csgraph import connected_components

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.facade.lattice import lattice
from grammarlab.matching.scans.wall_cells import Cells

_MIN_REPEATS = 4
"""Least number of parts that repeat."""
_MAX_BOXES = 2_000
"""Largest number of parts; a wall with more is divided evenly."""
_CHUNK_BOXES = 200
"""Number of boxes that are compared with others together."""
_TOLERANCE_CELLS = 2.0
"""Largest distance of sides that agree, in cells."""
_MIN_ELEMENTS = 3
"""Least number of elements of a row and a column that lack one: translations complete a parallelogram."""
_MIN_POINTS, _MIN_RELIEF_SDS = 3.0, 5.0
"""Least mean number of points of cells that show an outline by themselves, and least relief, in standard deviations."""
_MARGIN_CELLS = 3
"""Width of the surroundings of a part, in cells."""
_MIN_CELL_SHARE = 0.25
"""Least share of the cells of a part with a kind of difference, such as relief, that marks its outline."""
_EXTENSION_RATIO, _MIN_EXTENSION_SHARE = 0.25, 0.8
"""Part of a box, beyond its side, in which an opening goes on, and least visible part of its outline there."""
_MIN_VISIBLE_SHARE = 0.25
"""Least visible part of the outline of an element that was not found by itself."""


def repeated(boxes: Floats, side: float) -> Flags:
    """[N] whether a box [N, 4] is one of at least four of its size that follow each other along rows and columns.

    Args:
        boxes: left, bottom, right, top, metres.
        side: side of the cells of the boxes, metres.
    """
    if not _MIN_REPEATS <= len(boxes) <= _MAX_BOXES:
        return np.zeros(len(boxes), dtype=bool)
    differs = np.abs(boxes[:, None] - boxes) > _TOLERANCE_CELLS * side
    size = boxes[:, 2:] - boxes[:, :2]
    equal = (np.abs(size[:, None] - size) <= _TOLERANCE_CELLS * side).all(axis=2)
    in_line = ~differs[:, :, [0, 2]].any(axis=2) | ~differs[:, :, [1, 3]].any(axis=2)
    label = connected_components(equal & in_line, directed=False)[1]
    return np.bincount(label)[label] >= _MIN_REPEATS


def completed(boxes: Floats, blocked: Floats, off: Flags, cells: Cells) -> tuple[Floats, Floats]:
    """Boxes with sides aligned along rows and columns, and further boxes where a row and a column lack an element.

    Sides that nearly agree with those of their row or column become equal. An element is lacking if a fourth of its
    outline is visible and nothing else is there.

    Args:
        boxes: [N, 4] left, bottom, right, top, metres.
        blocked: [B, 4] boxes of other parts with sides of their own.
        off: [W, H] cells that are not part of the wall.
        cells: the wall.

    Returns:
        The boxes [N, 4], and the further ones [M, 4].
    """
    if not len(boxes):
        return boxes, boxes
    lines, aligned = [], boxes.copy()
    for axis in (0, 1):
        ends = boxes[:, [axis, axis + 2]]
        member = lattice(ends[:, 0], ends[:, 1], float(cells.low[axis]), float(cells.high[axis])).member
        usual, count = _usual(ends, member, _TOLERANCE_CELLS * cells.side)
        near = np.abs(ends - usual[member]) <= _TOLERANCE_CELLS * cells.side
        aligned[:, [axis, axis + 2]] = np.where(near, usual[member], ends)
        lines.append((usual, count))
    (column, of_column), (row, of_row) = lines
    across, up = (index.ravel() for index in np.nonzero(of_column[:, None] + of_row >= _MIN_ELEMENTS))
    candidates = np.stack([column[across, 0], row[up, 0], column[across, 1], row[up, 1]], axis=1)
    free = candidates[~overlapping(candidates, np.vstack([aligned, blocked]))]
    return aligned, np.array([box for box in free if _is_lacking(box, off, cells)]).reshape(-1, 4)


def _usual(ends: Floats, member: Ints, near: float) -> tuple[Floats, Ints]:
    """Start and end [K, 2] of each row or column, by interpolation for empty ones, and how many elements [K] agree.

    Args:
        ends: [N, 2] start and end of each element, metres.
        member: [N] row or column of each element.
        near: largest difference of sides that agree, metres.
    """
    usual = np.zeros((int(member.max()) + 1, 2))
    count = np.zeros(len(usual), dtype=np.int64)
    for line in np.unique(member).tolist():
        members = ends[member == line]
        members = members[(np.abs(members - np.median(members, axis=0)) <= near).all(axis=1)]
        usual[line], count[line] = (
            (np.median(members, axis=0), len(members)) if len(members) else (np.nan, -len(member))
        )
    filled_lines = np.flatnonzero(count > 0)
    lacking = np.setdiff1d(np.arange(len(usual)), member)
    if not len(filled_lines):
        count[lacking] = -len(member)
        return usual, count
    for end in (0, 1):
        usual[lacking, end] = np.interp(lacking, filled_lines, usual[filled_lines, end])
    return usual, count


def overlapping(boxes: Floats, others: Floats) -> Flags:
    """[N] whether a box and one of the others share more than a tenth of the smaller one's area."""
    parts = [np.zeros(0, dtype=bool)]
    other = (others[:, 2:] - others[:, :2]).prod(axis=1)
    # In parts, since thousands of boxes have millions of pairs.
    for part in np.array_split(boxes, len(boxes) // _CHUNK_BOXES + 1):
        low = np.maximum(part[:, None, :2], others[:, :2])
        shared = np.maximum(np.minimum(part[:, None, 2:], others[:, 2:]) - low, 0.0).prod(axis=2)
        area = (part[:, 2:] - part[:, :2]).prod(axis=1)
        parts.append((shared > 0.1 * np.minimum(area[:, None], other)).any(axis=1))
    return np.concatenate(parts)


def visible_part(box: Floats, off: Flags, cells: Cells) -> float:
    """Part of the outline of a box [4] at which the wall ends."""
    return float(np.concatenate(_sides(box, off, cells)).mean())


def _sides(box: Floats, off: Flags, cells: Cells) -> list[Flags]:
    """Whether the wall ends, at each place of the left, right, lower and upper side: wall outside, no wall inside."""
    low, high = box[:2], box[2:]
    sides = []
    for axis in (0, 1):
        count = max(round((high - low)[1 - axis] / cells.side) - 1, 1)
        along = np.linspace(low[1 - axis] + cells.side, high[1 - axis] - cells.side, count)
        for end, outward in ((low, -1.0), (high, 1.0)):
            is_off = []
            for away in (-2.0, -1.0, 1.5, 2.5):
                points = np.empty((len(along), 2))
                points[:, axis], points[:, 1 - axis] = end[axis] + outward * away * cells.side, along
                is_off.append(off[cells.indices(points)])
            sides.append((is_off[0] | is_off[1]) & ~(is_off[2] & is_off[3]))
    return sides


def _is_lacking(box: Floats, off: Flags, cells: Cells) -> bool:
    """Whether enough of the outline of a box is visible, and no opening goes on beyond a side, as a door does."""
    sides = _sides(box, off, cells)
    if np.concatenate(sides).mean() < _MIN_VISIBLE_SHARE:
        return False
    for side, (axis, sign) in zip(sides, ((0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)), strict=True):
        beyond = box.copy()
        length = max(_EXTENSION_RATIO * (box[axis + 2] - box[axis]), 5.0 * cells.side)
        if sign < 0.0:
            beyond[axis], beyond[axis + 2] = box[axis] - length, box[axis]
        else:
            beyond[axis], beyond[axis + 2] = box[axis + 2], box[axis + 2] + length
        jambs = _sides(beyond, off, cells)[2 - 2 * axis : 4 - 2 * axis]
        if side.mean() < _MIN_VISIBLE_SHARE and np.concatenate(jambs).mean() > _MIN_EXTENSION_SHARE:
            return False
    return True


def borders(boxes: Floats, shallow: Flags, cells: Cells) -> Floats:
    """[Q, 2] points on the outlines of shallow parts, where relief or lack of points falls to half of the part's own.

    Args:
        boxes: [N, 4] left, bottom, right, top of the parts, metres.
        shallow: [W, H] cells of shallow parts.
        cells: the wall.
    """
    points = [np.zeros((0, 2))]
    ends = np.stack([np.stack(cells.indices(boxes[:, columns]), axis=1) for columns in ([0, 1], [2, 3])], axis=1)
    for low, high in ends.tolist():
        around = tuple(
            slice(max(first - _MARGIN_CELLS, 0), last + _MARGIN_CELLS + 1)
            for first, last in zip(low, high, strict=True)
        )
        within = tuple(slice(first, last + 1) for first, last in zip(low, high, strict=True))
        inside = np.zeros_like(shallow[around])
        start = np.array([span.start for span in around])
        inside[
            tuple(slice(span.start - first, span.stop - first) for span, first in zip(within, start, strict=True))
        ] = shallow[within]
        strength = _strength(inside, around, cells)
        points.append(cells.low + cells.side * (start + 0.5 + _crossings(strength - 0.5)))
    return np.vstack(points)


def _strength(inside: Flags, around: tuple[slice, ...], cells: Cells) -> Floats:
    """[w, h] relief or lack of points near a part [w, h], as a fraction of the part's own."""
    strength = np.zeros(inside.shape)
    relief, weak, lack, count = (values[around] for values in (cells.relief, cells.smooth, cells.lack, cells.count))
    raised, sparse = inside & cells.raised[around] & (count > 0), inside & cells.sparse[around]
    for mask, sharp, smooth in ((raised, relief, weak), (sparse, lack, lack)):
        if mask.sum() > _MIN_CELL_SHARE * (raised | sparse).sum():
            middle = mask & (np.abs(smooth) >= np.median(np.abs(smooth[mask])))
            number = max(float(count[middle].mean()), 1e-9)
            # Mean values over nine cells blur narrow frames, so they are used only where single cells are too noisy.
            min_relief = _MIN_RELIEF_SDS * cells.noise / np.sqrt(number)
            is_clear = number >= _MIN_POINTS and np.abs(sharp[middle]).mean() >= min_relief
            field = sharp if is_clear else smooth
            part_mean = float((field * np.sign(smooth))[middle].mean())
            strength = np.maximum(strength, np.abs(field) / max(part_mean, 1e-9))
    strength = np.where(ndimage.binary_dilation(_filled(inside), iterations=2), strength, 0.0)
    within = strength > 0.5
    return np.where(np.logical_and(ndimage.binary_erosion(_filled(within)), ~within), 1.0, strength)


def _filled(part: Flags) -> Flags:
    """[w, h] cells of a part [w, h], and cells that have some of them on three of four sides: a frame may have gaps."""
    sides = np.zeros(part.shape, dtype=np.int64)
    for axis in (0, 1):
        sides += np.logical_or.accumulate(part, axis)
        sides += np.flip(np.logical_or.accumulate(np.flip(part, axis), axis), axis)
    return part | (sides >= 3)


def _crossings(values: Floats) -> Floats:
    """[Q, 2] places between neighbours of different sign where linear interpolation is 0, in cells."""
    crossings = []
    for axis in (0, 1):
        before, after = (np.take(values, np.arange(k, values.shape[axis] - 1 + k), axis) for k in (0, 1))
        position = np.argwhere((before > 0.0) != (after > 0.0)).astype(np.float64)
        start, end = (side[tuple(position.astype(np.int64).T)] for side in (before, after))
        position[:, axis] += start / (start - end)
        crossings.append(position)
    return np.vstack(crossings)
