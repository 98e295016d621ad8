"""Stitching of units that are not neighbours in the example, by merging points (paper 004, section 4.2).

The connection points of a side are the points of a unit on its seam. Of two sides, each point of the smaller set is
matched with the nearest point of the larger one (Eq. 3). If the distances are similar, the largest at most `CLOSE`
times the smallest, all pairs are merged; otherwise only pairs up to the mean of the smallest and the largest distance.
The paper does not define similar. No point moves further than a reach, which depends on the noise of the example:
separate features near each other stay separate, and caps close the gap between them.

Edges along seams conform: adjacent pieces share all points of their seam.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.synthesis.mesh.surface import Surface, naked_edges, split_edges
from grammarlab.synthesis.mesh.views import Plane

CLOSE = 1.5
"""Ratio of the largest to the smallest distance up to which all points of a side are merged."""
_MAX_ROUNDS = 40
"""Budget of rounds; each splits open edges at the point nearest to their middle."""


@dataclass(frozen=True, slots=True)
class Matches:
    """M pairs of points to merge."""

    target: Ints
    """[M] rows of the points that stay."""
    moved: Ints
    """[M] rows of the points that move onto them."""


def conformed(surface: Surface, planes: Sequence[Plane], tolerance: float) -> Surface:
    """The surface without T-junctions on seams: points on open edges become corners of the triangles.

    Args:
        surface: a welded surface.
        planes: planes of the seams; T-junctions elsewhere are part of the example, and stay.
        tolerance: largest distance between an edge and a point on it, metres.
    """
    for _ in range(_MAX_ROUNDS):
        edges = seam_edges(surface, planes, tolerance)[0]
        edge, via = _on_edges(surface.points, edges, tolerance)
        if not len(edge):
            return surface
        chosen = edges[edge]
        # An edge of isolated triangles may occur in both directions; its points are then found twice.
        key = chosen.min(axis=1) * len(surface.points) + chosen.max(axis=1)
        _, first = np.unique(key, return_index=True)
        surface = split_edges(surface, chosen[first, 0], chosen[first, 1], via[first])
    return surface


def seam_edges(surface: Surface, planes: Sequence[Plane], tolerance: float) -> tuple[Ints, Ints]:
    """[E, 2] directed edges on one of the planes without an opposite edge, and [E] their multiplicities."""
    points = surface.points
    positions = [np.unique([plane.position for plane in planes if plane.axis == axis]) for axis in range(3)]
    near = np.zeros(len(points), dtype=bool)
    for axis, coordinates in enumerate(positions):
        near |= np.abs(points[:, axis] - _next_position(points[:, axis], coordinates, tolerance)) <= tolerance
    # Only triangles with two points near planes have such edges, and all edges between such points are theirs.
    edges, times = naked_edges(surface.triangles[near[surface.triangles].sum(axis=1) >= 2], len(points))
    on = np.zeros(len(edges), dtype=bool)
    for axis, coordinates in enumerate(positions):
        start, end = points[edges[:, 0], axis], points[edges[:, 1], axis]
        nearest = _next_position(start, coordinates, tolerance)
        on |= (np.abs(start - nearest) <= tolerance) & (np.abs(end - nearest) <= tolerance)
    return edges[on], times[on]


def matches(points: Floats, first: Ints, second: Ints, reach: float) -> Matches:
    """The pairs of two sides to merge; the same for both orders of the sides.

    Args:
        points: [P, 3] metres.
        first: [A] rows of the connection points of one side.
        second: [B] rows of those of the adjacent side.
        reach: largest move of a point, metres.
    """
    empty = np.zeros(0, dtype=np.int64)
    if not len(first) or not len(second):
        return Matches(empty, empty)
    # Of sets of equal size, the one with lexicographically smaller coordinates stays, whatever the order of arguments.
    if (len(second), _first(points[second])) < (len(first), _first(points[first])):
        first, second = second, first
    neighbours = KDTree(points[second]).query(points[first])
    distance, nearest = (np.asarray(column) for column in neighbours)
    low, high = float(distance.min()), float(distance.max())
    limit = high if high <= CLOSE * low or high == 0.0 else (low + high) / 2.0
    within = distance <= min(limit, reach)
    return Matches(first[within], second[nearest[within]])


def nearest_pairs(points: Floats, rows: Ints, edges: Ints, reach: float) -> Matches:
    """Pairs of points that are mutually nearest, within reach, and not on a common edge.

    Points closer than the noise of the example are not separate features.

    Args:
        points: [P, 3] metres.
        rows: [K] rows of the points to pair.
        edges: [E, 2] pairs of points that must stay separate.
        reach: largest distance, metres.
    """
    empty = np.zeros(0, dtype=np.int64)
    pairs = KDTree(points[rows]).query_pairs(reach, output_type="ndarray") if len(rows) else empty
    if not len(pairs):
        return Matches(empty, empty)
    pairs = np.sort(rows[pairs], axis=1)
    number = len(points)
    is_separate = ~np.isin(pairs[:, 0] * number + pairs[:, 1], edges.min(axis=1) * number + edges.max(axis=1))
    pairs = pairs[is_separate]
    distance = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0], distance))]
    rank = np.arange(len(pairs))
    best = np.full(number, len(pairs))
    np.minimum.at(best, pairs[:, 0], rank)
    np.minimum.at(best, pairs[:, 1], rank)
    mutual = (best[pairs[:, 0]] == rank) & (best[pairs[:, 1]] == rank)
    return Matches(pairs[mutual, 0], pairs[mutual, 1])


def stitched(points: Floats, pairs: Sequence[Matches]) -> tuple[Floats, Flags]:
    """[P, 3] points after all pairs are merged at once, in any order, and [P] whether each has moved.

    Points connected by several pairs move to the one that most of the pairs keep.
    """
    target = np.concatenate([np.zeros(0, np.int64), *(match.target for match in pairs)])
    moved = np.concatenate([np.zeros(0, np.int64), *(match.moved for match in pairs)])
    if not len(target):
        return points, np.zeros(len(points), dtype=bool)
    graph = coo_matrix((np.ones(len(target)), (target, moved)), shape=(len(points), len(points)))
    group = connected_components(graph, directed=False)[1]
    times = np.bincount(target, minlength=len(points)) - np.bincount(moved, minlength=len(points))
    order = np.lexsort((*points.T[::-1], -times, group))
    first = np.append(True, np.diff(group[order]) != 0)
    chosen = order[first][group]
    merged = points[chosen]
    return merged, (merged != points).any(axis=1)


def _next_position(values: Floats, positions: Floats, tolerance: float) -> Floats:
    """[N] the lowest of some ascending positions not below each value; infinite if there are none."""
    if not len(positions):
        return np.full(len(values), np.inf)
    return positions[np.minimum(np.searchsorted(positions, values - tolerance), len(positions) - 1)]


def _on_edges(points: Floats, edges: Ints, tolerance: float) -> tuple[Ints, Ints]:
    """Edges with points between their ends, and for each the point nearest to its middle."""
    empty = np.zeros(0, dtype=np.int64)
    if not len(edges):
        return empty, empty
    candidates = np.unique(edges)
    tree = KDTree(points[candidates])
    start, end = points[edges[:, 0]], points[edges[:, 1]]
    length = np.linalg.norm(end - start, axis=1)
    near = tree.query_ball_point((start + end) / 2.0, length / 2.0 + tolerance, return_sorted=False)
    count = np.array([len(neighbours) for neighbours in near])
    edge = np.repeat(np.arange(len(edges)), count)
    via = candidates[np.concatenate([np.asarray(neighbours, dtype=np.int64) for neighbours in near])]
    other = (via != edges[edge, 0]) & (via != edges[edge, 1])
    edge, via = edge[other], via[other]
    along = end[edge] - start[edge]
    part = ((points[via] - start[edge]) * along).sum(axis=1) / length[edge] ** 2
    miss = np.linalg.norm(points[via] - start[edge] - part[:, None] * along, axis=1)
    inside = np.minimum(part, 1.0 - part) * length[edge] > tolerance
    on = (miss <= tolerance) & inside
    edge, via, part = edge[on], via[on], part[on]
    order = np.lexsort((via, np.abs(part - 0.5), edge))
    first = np.append(True, np.diff(edge[order]) != 0) if len(order) else np.zeros(0, dtype=bool)
    return edge[order][first], via[order][first]


def _first(points: Floats) -> tuple[float, ...]:
    return tuple(points[np.lexsort(points.T[::-1])][0].tolist())
