"""Hits of rays by numpy alone: a hierarchy of boxes around the triangles, for machines without a package of Embree.

The boxes are a complete binary tree; each level halves its triangles along the longest side of their centres. Many rays
descend at once. A step pairs rays with boxes and keeps the pairs that meet, so that its cost is that of a few array
operations. Boxes near the beginning of a ray come first, and what is found there bounds the rest.

The intersection of ray and triangle is that of Moeller and Trumbore, Fast, Minimum Storage Ray/Triangle Intersection
(1997).
"""

from __future__ import annotations

import abc
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats

Singles = NDArray[np.float32]

_LEAF_SIZE = 4
"""Largest number of triangles in a box of the last level."""
_SORTED_LEVEL = 5
"""Level at which the boxes of each ray are sorted by distance."""
_NUM_RANKS = 4
"""Boxes of a ray that are searched one after the other; those behind them are searched together."""
BLOCK = 1 << 16
"""Rays, and pairs of a ray and a box, of one step: a budget of memory, few enough for the caches of a processor."""
_SMALLEST = np.float32(1e-30)
"""Replaces zeros in directions, whose inverse is needed."""
_SLACK = np.float32(1e-6)
"""Tolerance of weights at the sides of triangles, so that no ray slips through between two, and of boxes."""


@dataclass(frozen=True, slots=True)
class Hits:
    """The nearest hits of N rays."""

    triangle: NDArray[np.int32]
    """[N] triangle, -1 for none."""
    distance: AnyFloats
    """[N] distance along the ray; huge without a hit."""
    u: AnyFloats
    """[N] weight of the triangle's second corner."""
    v: AnyFloats
    """[N] weight of its third."""


class AbstractScene(abc.ABC):
    """At least one triangle for at least one ray; origins and directions are contiguous [N, 3], in single precision."""

    @abc.abstractmethod
    def first_hit(self, origins: AnyFloats, directions: AnyFloats) -> Hits:
        """The nearest triangle in front of each ray."""

    @abc.abstractmethod
    def is_blocked(self, origins: AnyFloats, directions: AnyFloats, reach: float | None) -> NDArray[np.bool_]:
        """[N] whether a triangle lies on each ray, no farther than `reach`."""


class BoxedTriangles(AbstractScene):
    """Triangles in a hierarchy of boxes."""

    def __init__(self, vertices: AnyFloats, triangles: NDArray[np.integer]) -> None:
        corners = np.asarray(vertices, np.float32).take(triangles, axis=0)
        self._depth = max(0, int(np.ceil(np.log2(len(triangles) / _LEAF_SIZE))))
        self._order = _halved(corners.mean(axis=1), self._depth)
        corners = corners.take(self._order, axis=0)
        self._levels = _boxes(corners, self._depth)
        first, second, third = corners.transpose(1, 2, 0)
        self._columns = np.ascontiguousarray(np.concatenate([first, second - first, third - first]))
        """[9, P] first corner and two sides of the triangles in their order."""

    def first_hit(self, origins: AnyFloats, directions: AnyFloats) -> Hits:
        """See `AbstractScene.first_hit`."""
        parts = [self._traced(*part, np.float32(np.inf), any_hit=False) for part in _parts(origins, directions)]
        triangle = np.concatenate([part.triangle for part in parts])
        return Hits(
            np.where(triangle < 0, np.int32(-1), self._order[triangle]),
            np.concatenate([part.limit for part in parts]),
            np.concatenate([part.u for part in parts]),
            np.concatenate([part.v for part in parts]),
        )

    def is_blocked(self, origins: AnyFloats, directions: AnyFloats, reach: float | None) -> NDArray[np.bool_]:
        """See `AbstractScene.is_blocked`."""
        limit = np.float32(np.inf if reach is None else reach)
        parts = [self._traced(*part, limit, any_hit=True) for part in _parts(origins, directions)]
        return np.concatenate([part.triangle for part in parts]) >= 0

    def _traced(self, origins: AnyFloats, directions: AnyFloats, limit: np.float32, *, any_hit: bool) -> _Rays:
        """Rays with their nearest hits, or with any hit."""
        rays = _rays(origins, directions, limit)
        sorted_level = min(_SORTED_LEVEL, self._depth)
        stack = [_Pairs(0, np.arange(len(origins)), np.zeros(len(origins), np.int64))]
        while stack:
            pairs = stack.pop()
            if len(pairs.ray) > BLOCK:
                half = len(pairs.ray) // 2
                stack.append(_Pairs(pairs.level, pairs.ray[half:], pairs.box[half:]))
                stack.append(_Pairs(pairs.level, pairs.ray[:half], pairs.box[:half]))
                continue
            intersected, near = self._met(rays, pairs)
            if pairs.level == self._depth:
                self._hit(rays, intersected, any_hit=any_hit)
            elif pairs.level == sorted_level:
                stack += [_children(rank) for rank in _by_rank(intersected, near)]
            else:
                stack.append(_children(intersected))
        return rays

    def _met(self, rays: _Rays, pairs: _Pairs) -> tuple[_Pairs, Singles]:
        """Pairs whose ray meets the box before its limit, and the distances of the boxes."""
        low, high = self._levels[pairs.level]
        near, far = np.zeros(len(pairs.ray), np.float32), rays.limit.take(pairs.ray)
        for axis in range(3):
            origin, inverse = rays.origin[axis].take(pairs.ray), rays.inverse[axis].take(pairs.ray)
            t_low = low[axis].take(pairs.box)
            t_low -= origin
            t_low *= inverse
            t_high = high[axis].take(pairs.box)
            t_high -= origin
            t_high *= inverse
            np.maximum(near, np.minimum(t_low, t_high), out=near)
            np.minimum(far, np.maximum(t_low, t_high), out=far)
        hit_rows = np.flatnonzero(near <= far)
        return _Pairs(pairs.level, pairs.ray.take(hit_rows), pairs.box.take(hit_rows)), near.take(hit_rows)

    def _hit(self, rays: _Rays, pairs: _Pairs, *, any_hit: bool) -> None:
        """Update the hits of rays by the triangles of their boxes of the last level."""
        size = self._columns.shape[1] >> self._depth
        for index in range(size):
            self._intersect(rays, pairs.ray, pairs.box * size + index, any_hit=any_hit)

    def _intersect(
        self, rays: _Rays, ray: NDArray[np.integer], triangle: NDArray[np.integer], *, any_hit: bool
    ) -> None:
        direction, columns = rays.direction.take(ray, axis=1), self._columns.take(triangle, axis=1)
        corner, side, other = columns[:3], columns[3:6], columns[6:]
        across = _cross(direction, other)
        scale = np.float32(1) / _nonzero(_dot(side, across))
        start = rays.origin.take(ray, axis=1) - corner
        u = _dot(start, across) * scale
        around = _cross(start, side)
        v = _dot(direction, around) * scale
        distance = _dot(other, around) * scale
        hit = (u >= -_SLACK) & (v >= -_SLACK) & (u + v <= 1 + _SLACK) & (distance >= 0) & (distance <= rays.limit[ray])
        rows = np.flatnonzero(hit)
        # Of several hits of one ray the last one written stays: the nearest.
        rows = rows[np.argsort(-distance[rows], kind="stable")]
        number = ray[rows]
        rays.limit[number] = -np.inf if any_hit else distance[rows]
        rays.triangle[number] = triangle[rows]
        rays.u[number], rays.v[number] = u[rows], v[rows]


def _halved(centres: Singles, depth: int) -> NDArray[np.int32]:
    """[P] triangles in the order of their boxes, as many in each; some occur twice so that P is 2**depth times that."""
    num_triangles = len(centres)
    size = -(-num_triangles // (1 << depth)) << depth
    order = (np.arange(size) * num_triangles // size)[None]
    for _ in range(depth):
        positions = centres.take(order, axis=0)
        axis = np.ptp(positions, axis=1).argmax(axis=1)
        along = np.take_along_axis(positions, axis[:, None, None], axis=2)[..., 0]
        order = np.take_along_axis(order, along.argsort(axis=1, kind="stable"), axis=1)
        order = order.reshape(2 * len(order), -1)
    return order.ravel().astype(np.int32)


def _boxes(corners: Singles, depth: int) -> list[tuple[Singles, Singles]]:
    """Lowest and highest coordinates [3, 2**level] of the boxes of each level, from the root."""
    points = corners.reshape(1 << depth, -1, 3)
    low, high = points.min(axis=1), points.max(axis=1)
    slack = _SLACK * np.abs(points).max()
    levels = [(low - slack, high + slack)]
    for _ in range(depth):
        low, high = levels[-1]
        levels.append((np.minimum(low[::2], low[1::2]), np.maximum(high[::2], high[1::2])))
    return [(np.ascontiguousarray(low.T), np.ascontiguousarray(high.T)) for low, high in reversed(levels)]


def _parts(origins: AnyFloats, directions: AnyFloats) -> Iterator[tuple[AnyFloats, AnyFloats]]:
    for start in range(0, len(origins), BLOCK):
        yield origins[start : start + BLOCK], directions[start : start + BLOCK]


@dataclass(frozen=True, slots=True)
class _Rays:
    """Columns [3, N] of rays, and what was found on them, which is updated."""

    origin: Singles
    direction: Singles
    inverse: Singles
    limit: Singles
    """[N] distance of the nearest hit, or of the end of the ray."""
    triangle: NDArray[np.int32]
    """[N] position of the triangle, -1 for none."""
    u: Singles
    v: Singles


def _rays(origins: AnyFloats, directions: AnyFloats, limit: np.float32) -> _Rays:
    direction = np.ascontiguousarray(directions.T, np.float32)
    zeros = np.zeros(len(origins), np.float32)
    return _Rays(
        origin=np.ascontiguousarray(origins.T, np.float32),
        direction=direction,
        inverse=np.float32(1) / _nonzero(direction),  # ty: ignore[invalid-argument-type]
        limit=np.full(len(origins), limit, np.float32),
        triangle=np.full(len(origins), -1, np.int32),
        u=zeros,
        v=zeros.copy(),
    )


def _nonzero(values: Singles) -> Singles:
    return np.where(np.abs(values) < _SMALLEST, _SMALLEST, values)


@dataclass(frozen=True, slots=True)
class _Pairs:
    """Rays and boxes of one level that may meet."""

    level: int
    ray: NDArray[np.integer]
    box: NDArray[np.integer]


def _children(pairs: _Pairs) -> _Pairs:
    box = np.repeat(2 * pairs.box, 2)
    box[1::2] += 1
    return _Pairs(pairs.level + 1, np.repeat(pairs.ray, 2), box)


def _by_rank(pairs: _Pairs, near: Singles) -> list[_Pairs]:
    """Pairs by the rank of the box among those of its ray, from the last rank to the nearest boxes."""
    order = np.lexsort((near, pairs.ray))
    ray, box = pairs.ray[order], pairs.box[order]
    position = np.arange(len(ray))
    first = np.maximum.accumulate(np.where(np.diff(ray, prepend=-1) != 0, position, 0))
    rank = np.minimum(position - first, _NUM_RANKS)
    return [_Pairs(pairs.level, ray[rank == number], box[rank == number]) for number in range(_NUM_RANKS, -1, -1)]


def _cross(a: Singles, b: Singles) -> tuple[Singles, Singles, Singles]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a: Singles, b: tuple[Singles, Singles, Singles]) -> Singles:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
