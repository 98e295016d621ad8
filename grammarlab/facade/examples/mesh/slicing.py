"""Surfaces cut along planes, so that no triangle lies on both sides."""

from __future__ import annotations

import numpy as np

from grammarlab.facade.examples.mesh.surface import Surface, split_triangles


def sliced(surface: Surface, axis: int, at: float, snap: float) -> Surface:
    """The surface cut along a plane of constant coordinate.

    Args:
        surface: the surface.
        axis: 0, 1 or 2.
        at: coordinate of the plane, metres.
        snap: distance of points, metres, within which they are moved onto the plane, to avoid slivers.
    """
    distance = surface.points[:, axis] - at
    near = np.abs(distance) <= snap
    points = surface.points
    if near.any():
        points = points.copy()
        points[near, axis] = at
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
    low, high = points[edges[:, 0]], points[edges[:, 1]]
    part = (at - low[:, axis]) / (high[:, axis] - low[:, axis])
    middle = low + part[:, None] * (high - low)
    middle[:, axis] = at
    all_points = np.concatenate([points, middle])
    triangles, source = split_triangles(all_points, rows, edges, len(points) + np.arange(len(edges)))
    return Surface(
        all_points,
        np.concatenate([surface.triangles[~crossing], triangles]),
        np.concatenate([surface.material[~crossing], surface.material[crossing][source]]),
    )
