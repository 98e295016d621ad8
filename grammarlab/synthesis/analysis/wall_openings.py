"""Openings of a wall: the holes of the flat patches that it consists of, whatever fills them or stands before them.

A window in a hole of its wall is found though its pane lies in the plane of the wall, a balcony hides it, or frames
divide it; and a piece of wall between two windows is none. Where a file keeps no wall apart from its windows there are
no holes, and what is in relief (`grammarlab.synthesis.analysis.wall_elements`) or often repeated
(`grammarlab.synthesis.analysis.panes`) tells.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from itertools import islice
from typing import Any

import numpy as np
from scipy import ndimage

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.synthesis.analysis.wall_elements import (
    MIN_AREA_M2,
    MIN_SIDE_M,
    NEAR,
    WallElements,
    coordinates_of,
    exact,
    is_too_long,
)
from grammarlab.synthesis.analysis.walls import (
    BEFORE,
    BEHIND,
    FACING,
    MAX_TILT_M,
    DepthMap,
    Wall,
    covered,
    filled_above_ground,
    normals_of,
)

_MOST_OPENINGS = 5_000
"""Largest number of openings of a wall; with more it is a grille, and the time to compare them all grows."""
_MOST_TILTED = 50
"""Number of patches, those of most triangles, that a building may be turned to."""
_MIN_TRIANGLES = 6
"""Least number of triangles around a hole, or around a door that reaches the ground."""
_MIN_VISIBLE_SHARE = 0.1
"""Least visible share of a patch: others are inside of the building or behind it."""
_MIN_LOGGIA_M = 0.5
"""Least depth of a wall with openings behind an opening, metres; what is nearer is a frame."""
_NOISE_FACTOR = 4.0
"""Largest distance of the corners of an opening from its pixels, beyond one pixel, as a multiple of the noise."""
_MIN_FILLED_SHARE = 0.5
"""Least share of its box that an opening fills; others are gaps between parts of a wall."""


def openings_of(walls: Sequence[Wall], corners: Floats, patches: Ints) -> list[WallElements]:
    """The openings of each wall of a side, within its extent.

    Of openings inside of each other the outer one counts, as a window with panes does, unless one can stand between
    them, as in a loggia.

    Args:
        walls: the walls.
        corners: [T, 3, 3] of all triangles of the building, in the coordinates of the view.
        patches: [K, T] number of the patch of each triangle, in each of K divisions of the building into patches, the
            most trusted one first.
    """
    normals = normals_of(corners)
    found = [_patches(walls, normals, patch) for patch in patches]
    return [
        reduce(_with_further, (_openings(wall, corners, rows) for rows in parts))
        for wall, *parts in zip(walls, *found, strict=True)
    ]


def tilt_of(wall: Wall, corners: Floats, patches: Ints) -> float:
    """Rotation about the vertical axis that makes the patch with most openings square to the view, radians.

    0 if it has no effect. Arguments as in `openings_of`.
    """
    normals = normals_of(corners)
    parts = [rows for patch in patches for rows in _patches([wall], normals, patch)[0]]
    parts = sorted(parts, key=len)[-_MOST_TILTED:]
    numbers = [sum(1 for _ in _holes(wall, corners[rows])) for rows in parts]
    if not any(numbers):
        return 0.0
    rows = parts[int(np.argmax(numbers))]
    normal = normals[:, rows]
    across, _, towards = (normal * np.sign(normal[2])).sum(axis=1).tolist()
    width = float(np.ptp(corners[rows, :, 0]))
    return float(np.arctan2(across, towards)) if abs(across) * width > MAX_TILT_M * towards else 0.0


def _with_further(first: WallElements, second: WallElements) -> WallElements:
    """Some openings, and those of others that overlap none of them."""
    apart = (second.low[:, None] >= first.high) | (second.high[:, None] <= first.low)
    return first + second.take(np.all(np.any(apart, axis=2), axis=1))


def _openings(wall: Wall, corners: Floats, patches: Sequence[Ints]) -> WallElements:
    depths = [float(np.median(corners[rows, :, 2])) for rows in patches]
    holes = ((box, depth) for rows, depth in zip(patches, depths, strict=True) for box in _holes(wall, corners[rows]))
    found = list(islice(holes, _MOST_OPENINGS + 1))
    if len(found) > _MOST_OPENINGS:
        found = []
    boxes = np.array([box for box, _ in found]).reshape(-1, 2, 2)
    depth = np.array([value for _, value in found])
    middle = boxes.mean(axis=1)
    within = ((middle > wall.low) & (middle < wall.high)).all(axis=1)
    boxes, depth = boxes[within], depth[within]
    low, high = boxes[:, 0], boxes[:, 1]
    around = np.all((low[:, None] < low + NEAR) & (high < high[:, None] + NEAR), axis=2)
    around &= (high - low).prod(axis=1)[:, None] > (high - low).prod(axis=1)
    counts = ~(around & (depth[:, None] - depth < _MIN_LOGGIA_M)).any(axis=0)
    counts &= ~(around & counts).any(axis=1)
    return WallElements.of(boxes[counts])


def _patches(walls: Sequence[Wall], normals: Floats, patch: Ints) -> list[list[Ints]]:
    """The triangles of each patch that faces the viewer and is visible, for the wall that shows most of it."""
    num = int(patch.max(initial=-1)) + 1
    area = np.array([_visible(wall, patch, num) for wall in walls]).reshape(len(walls), num)
    across, up, towards = normals
    parts = np.abs(towards), np.sqrt(across * across + up * up + towards * towards)
    facing, size = (np.bincount(patch, part / 2.0, num) for part in parts)
    enough = area.max(axis=0, initial=0.0) >= np.maximum(_MIN_VISIBLE_SHARE * facing, MIN_AREA_M2)
    order, count = np.argsort(patch, kind="stable"), np.bincount(patch, minlength=num)
    ends = np.cumsum(count)
    found: list[list[Ints]] = [[] for _ in walls]
    for number in np.flatnonzero(enough & (facing >= FACING * size) & (count >= _MIN_TRIANGLES)).tolist():
        found[int(area[:, number].argmax())].append(order[ends[number] - count[number] : ends[number]])
    return found


def _visible(wall: Wall, patch: Ints, num: int) -> Floats:
    """[num] visible area of each patch in a wall, square metres."""
    map_ = wall.map
    inside = wall.mask & (map_.triangle >= 0)
    inside &= (map_.depth >= wall.depth - BEHIND) & (map_.depth <= wall.depth + BEFORE)
    return np.bincount(patch[map_.triangle[inside]], minlength=num).astype(np.float64) * map_.step**2


def _holes(wall: Wall, corners: Floats) -> Iterator[Floats]:
    """[2, 2] low and high corner of each opening in a patch of triangles [T, 3, 3]; none in a frame."""
    map_ = wall.map
    mask, origin = _pixels(map_, corners)
    holes = filled_above_ground(mask) & ~mask
    if not holes.any() or _is_frame(mask, map_.step):
        return
    points = corners[..., :2].reshape(-1, 2)
    points = points[np.argsort(points[:, 0], kind="stable")]
    labelled: Any = ndimage.label(holes)
    for number, extent in enumerate(ndimage.find_objects(*labelled), start=1):
        hole = labelled[0][extent] == number
        low, high = (
            map_.low + (origin + np.array([end(extent[1]), end(extent[0])])) * map_.step
            for end in (lambda span: span.start, lambda span: span.stop)
        )
        near = coordinates_of(_around(points, low, high, map_.step + _NOISE_FACTOR * wall.noise))
        low, high = (exact(side, near, map_.step, wall.noise) for side in (low, high))
        is_large = (high - low).min() >= MIN_SIDE_M and hole.sum() * map_.step**2 >= MIN_AREA_M2
        if is_large and hole.mean() >= _MIN_FILLED_SHARE and not is_too_long(low, high, wall):
            yield np.stack([low, high])


def _around(points: Floats, low: Floats, high: Floats, reach: float) -> Floats:
    """[P, 2] those of some points, in ascending order of x, that are in a box or near it: its own corners.

    Other openings have corners of nearly the same height or position, which say nothing about this one.
    """
    first, last = np.searchsorted(points[:, 0], [low[0] - reach, high[0] + reach])
    inside = points[first:last]
    return inside[(inside[:, 1] >= low[1] - reach) & (inside[:, 1] <= high[1] + reach)]


def _pixels(map_: DepthMap, corners: Floats) -> tuple[Flags, Ints]:
    """[h, w] pixels of the map that triangles cover, as a part of the map, and column and row of its first pixel."""
    height, width = map_.depth.shape
    mask = np.zeros(height * width, dtype=bool)
    for _, pixel, _ in covered(corners, map_.low, map_.step, width, height):
        mask[pixel] = True
    mask = mask.reshape(height, width)
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return mask[:0, :0], np.zeros(2, dtype=np.int64)
    return mask[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1], np.array([columns[0], rows[0]])


def _is_frame(mask: Flags, step: float) -> bool:
    """Whether a patch is nowhere as wide as an element: the frame of a window is no wall."""
    wide = np.pad(mask, 1)
    distance: Any = ndimage.distance_transform_edt(wide)
    return float(distance.max()) * 2.0 * step < MIN_SIDE_M
