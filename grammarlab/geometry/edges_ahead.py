"""Edges of outlines that are seen from points: which edge a wall inside a lot looks at."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats, Ints, row_of_value, take_rows
from grammarlab.geometry.edges_behind import EdgeSets

_PARALLEL = 1e-9
"""Sine of the angle between a direction and an edge below which the edge is not hit."""
_END = 1e-9
"""Tolerance of hits at the ends of an edge, as a share of its length."""


def edges_ahead(
    points: Floats, directions: Floats, groups: Ints, edges: EdgeSets, least: Floats
) -> tuple[Ints, Floats]:
    """The first edge ahead of each point, -1 for none, and its distance [K] in metres, infinite for none.

    Args:
        points: [K, 2] x and z in metres.
        directions: [K, 2] unit vectors in which to look.
        groups: [K] the set of edges to look at.
        edges: the sets.
        least: [K] smallest distance in metres at which an edge counts.
    """
    edge, offsets = take_rows(edges.offsets, groups)
    point = row_of_value(np.diff(offsets))
    to_edge, along = edges.start[edge] - points[point], edges.end[edge] - edges.start[edge]
    direction = directions[point]
    turn = _cross(direction, along)
    is_hit = np.abs(turn) > _PARALLEL * np.hypot(along[:, 0], along[:, 1])
    divisor = np.where(is_hit, turn, 1.0)
    distance, share = _cross(to_edge, along) / divisor, _cross(to_edge, direction) / divisor
    is_hit &= (distance > least[point]) & (share >= -_END) & (share <= 1.0 + _END)
    rows = np.flatnonzero(is_hit)
    order = rows[np.lexsort((distance[rows], point[rows]))]
    first = order[np.diff(point[order], prepend=-1) != 0]
    nearest, nearest_distance = np.full(len(points), -1), np.full(len(points), np.inf)
    nearest[point[first]], nearest_distance[point[first]] = edge[first], distance[first]
    return nearest, nearest_distance


def _cross(a: Floats, b: Floats) -> Floats:
    """[K] vector products of vectors in the plane."""
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
