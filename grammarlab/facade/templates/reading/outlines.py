"""Points on the outlines of elements of a scan: the borders of the wall."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay, QhullError

from grammarlab.facade.templates.elements import Floats, Ints
from grammarlab.facade.templates.reading.cells import Bools

_WITHIN = 0.36
"""Distance of the border from the outermost points of the wall, in point distances: 0.32 to 0.40 in simulated scans."""
_FEWEST = 4
"""Least number of points of a triangulation."""


def outlines(wall: Floats, other: Floats, reach: float, is_hole: Callable[[Floats], Bools]) -> Floats:
    """[R, 2] points on the outlines of elements.

    An outline runs halfway between two points that are nearest to each other, of which one is on the wall and one is
    not, and, at holes without points, a little beyond the outermost points of the wall. Other pairs of neighbours are
    left out: they are farther from the outline, and errors of pairs that share a point are not independent. Points off
    the wall that are not connected with a hole are noise.

    Args:
        wall: [P, 2] points of the wall, metres.
        other: [Q, 2] points behind or in front of it.
        reach: largest distance of neighbours on a wall, metres.
        is_hole: whether places [N, 2] are in a hole of the wall; it may miss places near the border of a hole.
    """
    points = np.vstack([wall, other])
    if len(points) < _FEWEST:
        return np.zeros((0, 2))
    # Qhull loses digits far from the origin.
    origin = points.mean(axis=0)
    try:
        net = Delaunay(points - origin)
    except QhullError:  # all points are on one line
        return np.zeros((0, 2))
    simplices = net.simplices.astype(np.int64)
    corners, edge = points[simplices], np.sort(simplices[:, [[1, 2], [2, 0], [0, 1]]], axis=2)
    step = points[edge[..., 1]] - points[edge[..., 0]]
    length = np.linalg.norm(step, axis=2)
    area = np.abs(step[:, 0, 0] * step[:, 1, 1] - step[:, 0, 1] * step[:, 1, 0]) / 2.0
    hollow = length.prod(axis=1) > 4.0 * reach * area
    spacing = np.sqrt(2.0 * area[~hollow].mean()) if not hollow.all() else 0.0
    of_wall = np.arange(len(points)) < len(wall)
    num_wall = of_wall[edge].sum(axis=2)
    near = length < reach
    by_hole = _connected(edge[near & (num_wall == 0)], ~of_wall & is_hole(points))
    across = near & (num_wall == 1) & by_hole[edge].any(axis=2)
    rim = (num_wall == 2) & ~hollow[:, None] & ((net.neighbors < 0) | hollow[net.neighbors])
    middle = points[edge].mean(axis=2)
    normal = np.stack([step[..., 1], -step[..., 0]], axis=2)
    normal *= np.sign(((middle - corners) * normal).sum(axis=2, keepdims=True))
    normal /= np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-12)
    pairs = _mutual(edge[across], length[across], len(points))
    return np.vstack([points[pairs].mean(axis=1), (middle + _WITHIN * spacing * normal)[rim]])


def _mutual(pairs: Ints, length: Floats, number: int) -> Ints:
    """[M, 2] the pairs [L, 2] of points that are nearest to each other."""
    shortest = np.full(number, np.inf)
    np.minimum.at(shortest, pairs, length[:, None])
    return np.unique(pairs[(length[:, None] <= shortest[pairs]).all(axis=1)], axis=0)


def _connected(links: Ints, is_start: Bools) -> Bools:
    """[N] whether links [L, 2] connect a node with one of the starts [N]."""
    number = len(is_start)
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(number, number))
    label = connected_components(graph, directed=False)[1]
    return np.isin(label, label[is_start])
