"""Panes: windows in or near the plane of their wall, recognised by the division of the mesh.

City models have windows as rectangles that fill holes of a wall and are recessed by only a few centimetres. Pieces of
wall
between them are rectangles too, but windows are the most frequent ones, and do not touch each other.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.synthesis.analysis.wall_elements import LONGEST, NEAR, WallElements, band_of
from grammarlab.synthesis.analysis.walls import FACING, Wall

_MAX_RECTANGLES = 2_000
"""Largest number of rectangles of one wall; with more, the mesh is evenly divided."""
_MIN_FREQUENCY = 4
"""Least number of rectangles of the most frequent size."""
_TOLERANCE_M, _NOISE_FACTOR = 0.01, 4.0
"""Largest error of corners of a rectangle and of equal sizes, in metres, and as a multiple of the noise."""
_MIN_SIDE_M = 0.15
"""Least side of a pane, metres."""
_MAX_COVERAGE = 0.9
"""Part of a wall that rectangles cover from which they are a division of it, not windows."""
_MAX_DEPTH_M = 0.06
"""Largest distance between a pane and its wall, metres."""


def panes_of(wall: Wall, corners: Floats, triangles: Ints, relief: WallElements) -> WallElements:
    """The panes of a wall: rectangles of two triangles, of the most frequent sizes, that do not touch.

    Parts of one window, such as a pane and the transom light above it, become one element.

    Args:
        wall: the wall.
        corners: [T, 3, 3] of all triangles of the building, in the coordinates of the view.
        triangles: [T, 3] indices of their points.
        relief: elements in relief: rectangles beside them are pieces of wall.
    """
    slack = _TOLERANCE_M + _NOISE_FACTOR * wall.noise
    boxes = _rectangles(wall, corners, triangles, slack)
    if len(boxes) <= _MAX_RECTANGLES:
        # Both faces of a pane are merged.
        same = (np.abs(boxes[:, None] - boxes[None]) <= slack).all(axis=(2, 3))
        boxes = boxes[~np.tril(same, -1).any(axis=1)]
        middle = boxes.mean(axis=1)[:, None]
        centre = (relief.low + relief.high) / 2.0
        within = ((middle > relief.low) & (middle < relief.high)).all(axis=2)
        within |= ((centre > boxes[:, None, 0]) & (centre < boxes[:, None, 1])).all(axis=2)
        near = (boxes[:, None, 0] <= relief.high + 2.0 * NEAR) & (boxes[:, None, 1] >= relief.low - 2.0 * NEAR)
        boxes = boxes[~(near.all(axis=2) & ~within).any(axis=1)]
    if not _MIN_FREQUENCY <= len(boxes) <= _MAX_RECTANGLES:
        return WallElements.of(np.zeros((0, 2, 2)))
    size = boxes[:, 1] - boxes[:, 0]
    equal = np.all(np.abs(size[:, None] - size[None]) <= slack, axis=2)
    adjacent = _within(boxes, 2.0 * NEAR) & ~_parts(boxes, slack)
    remaining = np.ones(len(boxes), dtype=bool)
    chosen = np.zeros(len(boxes), dtype=bool)
    while remaining.any():
        frequency = np.where(remaining, (equal & remaining).sum(axis=1), 0)
        members = equal[frequency.argmax()] & remaining
        if not chosen.any() and frequency.max() < _MIN_FREQUENCY:
            break
        remaining &= ~members
        if not adjacent[np.ix_(members, members)].any():
            chosen |= members
            remaining &= ~adjacent[members].any(axis=0)
    return _parts_joined(boxes[chosen])


def _rectangles(wall: Wall, corners: Floats, triangles: Ints, slack: float) -> Floats:
    """[R, 2, 2] low and high corners of pairs of visible triangles that form a rectangle parallel to the axes."""
    visible = np.zeros(len(triangles) + 1, dtype=bool)
    visible[wall.map.triangle[wall.mask]] = True
    candidates = np.flatnonzero(visible[:-1])
    depth = corners[candidates, :, 2] - wall.depth
    planes = np.array([0.0, band_of(wall) - wall.depth])
    near = np.all(np.abs(depth[:, :, None] - planes) <= _MAX_DEPTH_M + slack, axis=1)
    candidates = candidates[np.any(near, axis=1)]
    normal = np.cross(corners[candidates, 1] - corners[candidates, 0], corners[candidates, 2] - corners[candidates, 0])
    is_facing = np.abs(normal[:, 2]) >= FACING * np.linalg.norm(normal, axis=1)
    rows = candidates[is_facing]
    # Two triangles of a rectangle share their longest sides.
    ends = np.roll(corners[rows], -1, axis=1) - corners[rows]
    longest = (ends**2).sum(axis=2).argmax(axis=1)
    start = triangles[rows, longest]
    end = triangles[rows, (longest + 1) % 3]
    third = corners[rows, (longest + 2) % 3, :2]
    side = np.minimum(start, end) * (int(triangles.max()) + 1) + np.maximum(start, end)
    _, key, count = np.unique(side, return_inverse=True, return_counts=True)
    order = np.argsort(key, kind="stable")
    pairs = order[count[key[order]] == 2].reshape(-1, 2)
    first = pairs[:, 0]
    flat = corners[rows[first]][..., :2]
    index = np.arange(len(first))
    outline = np.stack(
        [flat[index, longest[first]], third[first], flat[index, (longest[first] + 1) % 3], third[pairs[:, 1]]], axis=1
    )
    ordered = np.sort(outline, axis=1)
    low, high = ordered[:, :2].mean(axis=1), ordered[:, 2:].mean(axis=1)
    upper = np.abs(outline - high[:, None]) <= slack
    square = (upper | (np.abs(outline - low[:, None]) <= slack)).all(axis=(1, 2))
    # All its corners differ: neighbours share one coordinate, opposite corners none.
    square &= (upper[:, 0] != upper[:, 2]).all(axis=1) & (upper[:, 1] != upper[:, 3]).all(axis=1)
    square &= (upper[:, 0] == upper[:, 1]).sum(axis=1) == 1
    size = high - low
    if size[square].prod(axis=1).sum() >= _MAX_COVERAGE * np.abs(normal[is_facing, 2]).sum() / 2.0:
        square[:] = False  # regular grid: no rectangle is distinct
    square &= (size >= _MIN_SIDE_M).all(axis=1) & (size <= LONGEST * (wall.high - wall.low)).all(axis=1)
    square &= (low >= wall.low - slack).all(axis=1) & (high <= wall.high + slack).all(axis=1)
    return np.stack([low, high], axis=1)[square]


def _within(boxes: Floats, reach: float) -> Flags:
    """[R, R] whether the distance of two different boxes is below a limit."""
    low, high = boxes[:, 0], boxes[:, 1]
    near = (low[:, None] <= high[None] + reach).all(axis=2)
    return near & near.T & ~np.eye(len(boxes), dtype=bool)


def _parts(boxes: Floats, slack: float) -> Flags:
    """[R, R] whether two boxes are parts of one window: they do not touch, but have equal ends along an axis."""
    ends = np.all(np.abs(boxes[:, None] - boxes[None]) <= slack, axis=2)
    return np.any(ends, axis=2) & ~_within(boxes, slack)


def _parts_joined(boxes: Floats) -> WallElements:
    """Boxes of elements, with nearby parts merged."""
    group = _groups(np.argwhere(_within(boxes, 2.0 * NEAR)), len(boxes))
    num = int(group.max(initial=-1)) + 1
    low, high = np.full((num, 2), np.inf), np.full((num, 2), -np.inf)
    np.minimum.at(low, group, boxes[:, 0])
    np.maximum.at(high, group, boxes[:, 1])
    return WallElements.of(np.stack([low, high], axis=1))


def _groups(pairs: Ints, num: int) -> Ints:
    """[N] the group of each item: the connected components of the pairs."""
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(num, num))
    return connected_components(graph, directed=False)[1].astype(np.int64)
