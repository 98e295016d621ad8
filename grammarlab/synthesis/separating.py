"""Solids that touch in a line only, moved apart by less than a tenth of a millimetre.

A line where four triangles meet is closed, but no reader of meshes that joins points of equal coordinates can tell
which two belong together. Such an edge gets a point in its middle for each of the solids, a little inside of it: every
edge has two triangles then.
"""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.synthesis.mesh.surface import Surface, edge_table, split_triangles

_MIN_OFFSET_M = 2e-5
"""Metres by which points move, at least."""
_MIN_FLOAT_STEPS = 8
"""Steps between 32-bit numbers of the size of the coordinates by which they move, at least."""
_MERGE_DISTANCE_M = 1e-6
"""Metres; readers of meshes take points to be one that are much nearer."""
_ANGLE_TOLERANCE = 1e-6
"""Radians between triangles about an edge that count as one direction."""


def separated(surface: Surface) -> Surface:
    """The surface with two triangles at every edge that had an even number of them, half in each direction.

    Args:
        surface: surface with coordinates that are 32-bit numbers, as in files; the result has such coordinates.
    """
    edges, count, sign = edge_table(surface.triangles, len(surface.points))
    crowded = edges[(count > 2) & (sign == 0)]
    if not len(crowded):
        return surface
    number, first = len(surface.triangles), len(surface.points)
    edge, along, against = _paired(surface.points, surface.triangles, crowded)
    middle = _single(surface.points[crowded].mean(axis=1))
    points = np.concatenate([surface.points, middle])
    triangles, source = split_triangles(points, surface.triangles, crowded, first + np.arange(len(crowded)))
    # At a middle, a pair of triangles has a point of its own: what is left of both meets there.
    pair = np.arange(len(edge))
    key = np.concatenate([edge * number + along // 3, edge * number + against // 3])
    order = np.argsort(key)
    row, corner = np.nonzero(triangles >= first)
    lookup_key = (triangles[row, corner] - first) * number + source[row]
    copy = np.concatenate([pair, pair])[order][np.searchsorted(key[order], lookup_key)]
    triangles = triangles.copy()
    a, b, c = (points[triangles[row, k]] for k in range(3))
    inwards = np.zeros((len(edge), 3))
    np.subtract.at(inwards, copy, np.cross(b - a, c - a))
    length = np.linalg.norm(inwards, axis=1, keepdims=True)
    inwards = np.where(length > 0.0, inwards / np.maximum(length, 1e-300), [1.0, 0.0, 0.0])
    triangles[row, corner] = first + copy
    moved = _apart(surface.points, middle[edge], inwards)
    return Surface(np.concatenate([surface.points, moved]), triangles, surface.material[source])


def _apart(points: Floats, positions: Floats, inwards: Floats) -> Floats:
    """[M, 3] positions moved in directions [M, 3], so far that none is at a point or at another."""
    step = max(_MIN_OFFSET_M, _MIN_FLOAT_STEPS * float(np.spacing(np.float32(np.abs(points).max()))))
    times = np.ones(len(positions))
    while True:
        moved = _single(positions + (step * times)[:, None] * inwards)
        digits = np.rint(np.concatenate([points, moved]) / _MERGE_DISTANCE_M).astype(np.int64)
        _, site, count = np.unique(digits, axis=0, return_inverse=True, return_counts=True)
        site = site.ravel()[len(points) :]
        same = np.flatnonzero(count[site] > 1)
        if not len(same):
            return moved
        same = same[np.argsort(site[same], kind="stable")]
        times[same] += 1 + np.arange(len(same)) - np.searchsorted(site[same], site[same])


def _single(points: Floats) -> Floats:
    return points.astype(np.float32).astype(np.float64)


def _paired(points: Floats, triangles: Ints, crowded: Ints) -> tuple[Ints, Ints, Ints]:
    """Sides of triangles that bound one solid at an edge.

    Around an edge a solid begins at a triangle that runs downwards and ends at the next that runs upwards; where two
    solids touch in a face, one ends before the other begins.

    Args:
        points: [P, 3] metres.
        triangles: [T, 3] rows of `points`.
        crowded: [K, 2] edges in ascending order, the lower point first.

    Returns:
        [M] edges, ascending, [M] the sides (three times the triangle, and 0 to 2) that run upwards, and [M] downwards.
    """
    number = len(points)
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    keys = crowded[:, 0] * number + crowded[:, 1]
    side_keys = np.minimum(start, end) * number + np.maximum(start, end)
    edge_index = np.minimum(np.searchsorted(keys, side_keys), len(keys) - 1)
    sides = np.flatnonzero(keys[edge_index] == side_keys)
    edge_index = edge_index[sides]
    low, high = crowded[edge_index].T
    upwards = start[sides] == low
    along = points[high] - points[low]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(along, np.where(np.abs(along[:, [0]]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]]))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    third = points[triangles[:, [2, 0, 1]].ravel()[sides]] - points[low]
    angle = np.arctan2((third * np.cross(along, across)).sum(axis=1), (third * across).sum(axis=1))
    step, half = np.rint(angle / _ANGLE_TOLERANCE).astype(np.int64), round(np.pi / _ANGLE_TOLERANCE)
    step[step <= -half] = half
    order = np.lexsort((~upwards, step, edge_index))
    pairs = []
    for part in np.split(order, np.flatnonzero(np.diff(edge_index[order])) + 1):
        pairs += [(edge_index[part[0]], *pair) for pair in _matched(sides[part], upwards[part])]
    edge, up, down = np.array(pairs, dtype=np.int64).T
    return edge, up, down


def _matched(sides: Ints, upwards: Flags) -> list[tuple[int, int]]:
    """Pairs of an upward and a downward side of one edge, given by angle; like brackets, each with the nearest."""
    # Begin where no solid is open.
    turn = int(np.cumsum(np.where(upwards, -1, 1)).argmin()) + 1
    begun: list[int] = []
    pairs = []
    for side, ends in zip(np.roll(sides, -turn).tolist(), np.roll(upwards, -turn).tolist(), strict=True):
        if ends:
            pairs.append((side, begun.pop()))
        else:
            begun.append(side)
    return pairs
