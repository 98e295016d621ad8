"""Holes joined to their outline by a doubled edge, so that a face with holes is one ring of corners."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.geometry.meshes.mesh import Floats, Indices


def keyhole(rings: Sequence[Floats]) -> Indices:
    """One cycle around an outline and all its holes.

    Holes are joined in descending order of their largest x; each is joined from its corner of largest x to the nearest
    visible corner.

    Args:
        rings: [n, 2] corners of the outline, counter-clockwise, then of each hole, clockwise.

    Returns:
        Indices into the corners of all rings, one after the other; both ends of every bridge appear twice.
    """
    points = np.concatenate(rings)
    starts = np.cumsum([0, *map(len, rings)])
    edges = np.concatenate(
        [np.column_stack((ring, np.roll(ring, -1))) for ring in (np.arange(a, b) for a, b in _spans(starts))]
    )
    walk = np.arange(starts[1])
    for hole in sorted(range(1, len(rings)), key=lambda k: -float(rings[k][:, 0].max())):
        tip = int(starts[hole] + np.argmax(rings[hole][:, 0]))
        ring = np.roll(np.arange(starts[hole], starts[hole + 1]), -(tip - starts[hole]))
        at = _visible(points, walk, edges, tip)
        walk = np.concatenate((walk[: at + 1], ring, [tip], walk[at:]))
        edges = np.vstack((edges, [[walk[at], tip]]))
    return walk


def contains(outline: Floats, inner: Floats) -> bool:
    """Whether most corners of a ring [m, 2] lie inside another ring [n, 2] that it does not cross."""
    a, b = outline, np.roll(outline, -1, axis=0)
    x, y = inner[:, :1], inner[:, 1:]
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
    crossing = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / rise
    odd = np.count_nonzero(spans & (x < crossing), axis=1) % 2 == 1
    return bool(2 * np.count_nonzero(odd) > len(inner))


def _spans(starts: NDArray[np.integer]) -> list[tuple[int, int]]:
    return list(zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True))


def _visible(points: Floats, walk: Indices, edges: Indices, tip: int) -> int:
    """Index in the walk of the nearest corner to which a bridge from the tip crosses no edge."""
    distance = np.hypot(*(points[walk] - points[tip]).T)
    order = np.argsort(distance, kind="stable")
    for at in order.tolist():
        if _in_corner(points, walk, at, tip) and not _is_blocked(points, edges, int(walk[at]), tip):
            return at
    return int(order[0])


def _in_corner(points: Floats, walk: Indices, at: int, tip: int) -> bool:
    """Whether the tip lies within the interior angle of the walk at this index."""
    before, here, after = (points[walk[(at + k) % len(walk)]] for k in (-1, 0, 1))
    left_of_out = _turn(here, after, points[tip]) > 0.0
    left_of_in = _turn(before, here, points[tip]) > 0.0
    if _turn(before, here, after) > 0.0:
        return bool(left_of_out and left_of_in)
    return bool(left_of_out or left_of_in)


def _is_blocked(points: Floats, edges: Indices, corner: int, tip: int) -> bool:
    """Whether an edge that does not end at the corner or at the tip meets the bridge between them."""
    p, q = points[corner], points[tip]
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    ends_here = np.zeros(len(edges), bool)
    for end in (p, q):
        ends_here |= (a == end).all(axis=1) | (b == end).all(axis=1)
    sides = _turn(p, q, a) * _turn(p, q, b) <= 0.0
    ends = _turn(a, b, p) * _turn(a, b, q) <= 0.0
    # Collinear edges always pass both tests; only those that overlap the bridge block it.
    low, high = np.minimum(p, q), np.maximum(p, q)
    overlaps = ((np.minimum(a, b) <= high) & (np.maximum(a, b) >= low)).all(axis=1)
    return bool((sides & ends & overlaps & ~ends_here).any())


def _turn(a: Floats, b: Floats, c: Floats) -> Floats:
    """Twice the signed area of triangles: positive if c lies to the left of the line from a to b."""
    return (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
