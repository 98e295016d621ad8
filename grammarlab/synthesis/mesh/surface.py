"""Triangles of one building over shared points: properties of their edges, and cuts along planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from grammarlab.arrays import Flags, Floats, Ints

Color = tuple[float, float, float, float]
"""Red, green, blue and opacity of a material, 0 to 1."""


@dataclass(frozen=True, slots=True)
class Surface:
    """T triangles over P points."""

    points: Floats
    """[P, 3] points, metres."""
    triangles: Ints
    """[T, 3] rows of `points`."""
    material: Ints
    """[T] number of the material of each triangle."""

    def __len__(self) -> int:
        return len(self.triangles)

    def part(self, is_part: Flags) -> Surface:
        """Some of the triangles, with their points."""
        triangles = self.triangles[is_part]
        used = np.zeros(len(self.points), dtype=bool)
        used[triangles] = True
        index = np.cumsum(used) - 1
        return Surface(self.points[used], index[triangles], self.material[is_part])

    def moved(self, points: Floats) -> Surface:
        """The surface with other points [P, 3]."""
        return replace(self, points=points)

    def corners(self) -> Floats:
        """[T, 3, 3] the points of each triangle."""
        return self.points[self.triangles]


@dataclass(frozen=True, slots=True)
class EdgeNumbers:
    """Numbers of triangles at the edges of a surface."""

    boundary: int
    """Number of edges of only one triangle."""
    closed: bool
    """Whether every edge has an even number of triangles."""
    watertight: bool
    """Whether every edge has two triangles, as other programs define it."""


def joined(surfaces: Sequence[Surface]) -> Surface:
    """All surfaces as one; points are not shared between them."""
    firsts = np.cumsum([0, *(len(surface.points) for surface in surfaces)])
    return Surface(
        np.concatenate([np.zeros((0, 3)), *(surface.points for surface in surfaces)]),
        np.concatenate(
            [
                np.zeros((0, 3), np.int64),
                *(surface.triangles + first for surface, first in zip(surfaces, firsts, strict=False)),
            ]
        ),
        np.concatenate([np.zeros(0, np.int64), *(surface.material for surface in surfaces)]),
    )


def welded(surface: Surface, tolerance: float) -> Surface:
    """The surface with points within the tolerance merged, without the triangles that this makes empty."""
    points, index = merged_points(surface.points, tolerance)
    return without_empty(Surface(points, index[surface.triangles], surface.material))


def merged_points(points: Floats, tolerance: float) -> tuple[Floats, Ints]:
    """[Q, 3] points with distances above the tolerance, and [P] index of the merged point of each point."""
    _, first, index = np.unique(np.ascontiguousarray(points + 0.0), axis=0, return_index=True, return_inverse=True)
    index = index.ravel().astype(np.int64)
    chosen = points[first]
    pairs = KDTree(chosen).query_pairs(tolerance, output_type="ndarray") if len(chosen) else np.zeros((0, 2), int)
    if not len(pairs):
        return chosen, index
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(chosen), len(chosen)))
    count, group = connected_components(graph, directed=False)
    lowest = np.zeros(count, dtype=np.int64)
    lowest[group[::-1]] = np.arange(len(chosen))[::-1]
    return chosen[lowest], group[index].astype(np.int64)


def without_empty(surface: Surface) -> Surface:
    """The surface without triangles that have a point twice, and without unused points."""
    a, b, c = surface.triangles.T
    return surface.part((a != b) & (b != c) & (c != a))


def without_slivers(surface: Surface, tolerance: float) -> Surface:
    """The surface without triangles lower than the tolerance; neighbours along their long side get their points.

    A triangle of three collinear points cannot be removed alone: its neighbour along the long side gets the point in
    between, so that a closed surface stays closed.
    """
    for _ in range(20):
        surface = without_empty(surface)
        a, b, c = (surface.points[column] for column in surface.triangles.T)
        sides = (b - a, c - b, a - c)
        squares = [np.einsum("ij,ij->i", side, side) for side in sides]
        normal = np.cross(sides[0], sides[1])
        height = np.einsum("ij,ij->i", normal, normal)
        flat = np.flatnonzero(height <= tolerance**2 * np.maximum(np.maximum(*squares[:2]), squares[2]))
        if not flat.size:
            return surface
        side = np.stack([square[flat] for square in squares], axis=1).argmax(axis=1)
        start, end = surface.triangles[flat, side], surface.triangles[flat, (side + 1) % 3]
        via = surface.triangles[flat, (side + 2) % 3]
        # Slivers beside slivers would use one side twice in a round; the first of each side takes precedence.
        key = np.minimum(start, end) * len(surface.points) + np.maximum(start, end)
        _, first = np.unique(key, return_index=True)
        surface = split_edges(surface, start[first], end[first], via[first])
    return surface


def split_edges(surface: Surface, start: Ints, end: Ints, via: Ints) -> Surface:
    """The surface with additional points on edges, in all triangles at these edges.

    Args:
        surface: the surface.
        start: [K] start points of edges; in either direction, and no edge twice.
        end: [K] their end points.
        via: [K] the points between.
    """
    if not len(start):
        return surface
    triangles, rows = split_triangles(surface.points, surface.triangles, np.stack([start, end], axis=1), via)
    return without_empty(Surface(surface.points, triangles, surface.material[rows]))


def split_triangles(points: Floats, triangles: Ints, edges: Ints, via: Ints) -> tuple[Ints, Ints]:
    """Triangles with points on some of their edges: [S, 3] triangles, and [S] index of the original triangle of each.

    Args:
        points: [P, 3] metres.
        triangles: [T, 3] rows of `points`.
        edges: [K, 2] edges, each once, in either direction.
        via: [K] the point on each edge.
    """
    number = len(points)
    key = edges.min(axis=1) * number + edges.max(axis=1)
    order = np.argsort(key)
    key, via = key[order], via[order]
    at_edge = np.zeros(number, dtype=bool)
    at_edge[edges] = True
    a, b, c = (at_edge[column] for column in triangles.T)
    near = np.flatnonzero((a & b) | (b & c) | (c & a))  # the other triangles have none of the edges
    here, after = triangles[near], triangles[near][:, [1, 2, 0]]
    side_keys = np.minimum(here, after) * number + np.maximum(here, after)
    index = np.minimum(np.searchsorted(key, side_keys), len(key) - 1)
    middle = np.full(triangles.shape, -1)
    middle[near] = np.where(key[index] == side_keys, via[index], -1)
    count = np.zeros(len(triangles), dtype=np.int64)
    count[near] = (middle[near] >= 0).sum(axis=1)
    pieces, source = [triangles[count == 0]], [np.flatnonzero(count == 0)]
    for num in (1, 2, 3):
        rows = np.flatnonzero(count == num)
        if not rows.size:
            continue
        # One split side comes first; of two, the whole one comes last.
        is_split = middle[rows] >= 0
        turn = is_split.argmax(axis=1) if num == 1 else ((~is_split).argmax(axis=1) + 1) % 3 if num == 2 else 0 * rows
        pick = (turn[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(triangles[rows], pick, axis=1).T
        p, q, r = np.take_along_axis(middle[rows], pick, axis=1).T
        if num == 1:
            split = [(a, p, c), (p, b, c)]
        elif num == 2:
            near = _squared(points, a, q) <= _squared(points, p, c)
            split = [(p, b, q), (a, p, np.where(near, q, c)), (np.where(near, a, p), q, c)]
        else:
            split = [(a, p, r), (p, b, q), (r, q, c), (p, q, r)]
        pieces += [np.stack(corners, axis=1) for corners in split]
        source += [rows] * len(split)
    result, rows = np.concatenate(pieces), np.concatenate(source)
    order = np.argsort(rows, kind="stable")
    return result[order], rows[order]


def without_folds(surface: Surface, width: float = np.inf) -> Surface:
    """The surface without pairs of triangles over the same points that face away from each other.

    Args:
        surface: the surface.
        width: metres; sheets of triangles that are higher stay.
    """
    _, group = np.unique(np.sort(surface.triangles, axis=1), axis=0, return_inverse=True)
    kind = 2 * group.ravel() + turns(surface.triangles)
    count = np.bincount(kind, minlength=2 * len(surface)).reshape(-1, 2)
    order = np.argsort(kind, kind="stable")
    rank = np.empty(len(surface), dtype=np.int64)
    rank[order] = np.arange(len(surface)) - (np.cumsum(count.ravel()) - count.ravel())[kind[order]]
    fold = rank < count.min(axis=1)[kind // 2]
    a, b, c = surface.points[surface.triangles[fold]].swapaxes(0, 1)
    longest = np.max([((y - x) ** 2).sum(axis=1) for x, y in ((a, b), (b, c), (c, a))], axis=0, initial=0.0)
    fold[fold] = (np.cross(b - a, c - a) ** 2).sum(axis=1) <= width**2 * longest
    return surface.part(~fold)


def turns(triangles: Ints) -> Ints:
    """[T] 1 for triangles whose points are in ascending order, from one of them on, and 0 for others."""
    a, b, c = triangles.T
    return ((a < b).astype(np.int64) + (b < c) + (c < a)) // 2


def edge_numbers(surface: Surface) -> EdgeNumbers:
    """Summary of the numbers of triangles at edges."""
    count = edge_table(surface.triangles, len(surface.points))[1]
    has_edges = bool(len(count))
    return EdgeNumbers(
        int((count == 1).sum()), has_edges and not (count % 2).any(), has_edges and bool((count == 2).all())
    )


def edge_table(triangles: Ints, num_points: int) -> tuple[Ints, Ints, Ints]:
    """[E, 2] points of every undirected edge, the lower first; [E] triangles at it; [E] surplus of upward runs."""
    start = triangles.ravel()
    end = triangles[:, [1, 2, 0]].ravel()
    number = max(num_points, 1)
    # The last bit is the direction, so that one sort groups edges with their opposites.
    key = (np.minimum(start, end) * number + np.maximum(start, end)) * 2 + (start < end)
    key.sort()
    edge, upwards = key >> 1, key & 1
    first = np.flatnonzero(np.diff(edge, prepend=-1))
    count = np.diff(np.append(first, len(edge)))
    sign = 2 * np.add.reduceat(upwards, first) - count if len(first) else count
    unique = edge[first]
    return np.stack([unique // number, unique % number], axis=1), count, sign


def naked_edges(triangles: Ints, num_points: int) -> tuple[Ints, Ints]:
    """[E, 2] directed edges without an opposite, and [E] their multiplicities; closed surfaces have none."""
    edge, _, sign = edge_table(triangles, num_points)
    open_ = sign != 0
    edge, sign = edge[open_], sign[open_]
    return np.where(sign[:, None] > 0, edge, edge[:, ::-1]), np.abs(sign)


def sliced(surface: Surface, axis: int, position: float, snap: float) -> Surface:
    """The surface cut along a plane of constant coordinate.

    Args:
        surface: the surface.
        axis: 0, 1 or 2.
        position: coordinate of the plane, metres.
        snap: distance of points, metres, within which they are moved onto the plane, to avoid slivers.
    """
    distance = surface.points[:, axis] - position
    near = np.abs(distance) <= snap
    points = surface.points
    if near.any():
        points = points.copy()
        points[near, axis] = position
        distance = np.where(near, 0.0, distance)
    side = np.sign(distance).astype(np.int8)
    a, b, c = (side[column] for column in surface.triangles.T)
    crossing = (np.minimum(np.minimum(a, b), c) < 0) & (np.maximum(np.maximum(a, b), c) > 0)
    if not crossing.any():
        return surface.moved(points)
    rows = surface.triangles[crossing]
    start, end = rows.ravel(), np.roll(rows, -1, axis=1).ravel()
    across = side[start] * side[end] < 0
    edges = np.unique(np.sort(np.stack([start[across], end[across]], axis=1), axis=1), axis=0)
    low, high = points[edges[:, 0]], points[edges[:, 1]]  # ty: ignore[invalid-argument-type]
    part = (position - low[:, axis]) / (high[:, axis] - low[:, axis])
    middle = low + part[:, None] * (high - low)
    middle[:, axis] = position
    all_points = np.concatenate([points, middle])
    triangles, source = split_triangles(all_points, rows, edges, len(points) + np.arange(len(edges)))  # ty: ignore[invalid-argument-type]
    return Surface(
        all_points,
        np.concatenate([surface.triangles[~crossing], triangles]),
        np.concatenate([surface.material[~crossing], surface.material[crossing][source]]),
    )


def _squared(points: Floats, a: Ints, b: Ints) -> Floats:
    return ((points[a] - points[b]) ** 2).sum(axis=1)
