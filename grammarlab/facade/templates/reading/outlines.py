"""Points on the outlines of elements of a scan: the borders of the wall."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay, QhullError

from grammarlab.facade.templates.elements import Floats

_WITHIN = 0.36
"""Distance of the border from the outermost points of the wall, in point distances: 0.32 to 0.40 in simulated scans."""
_FEWEST = 4
"""Least number of points of a triangulation."""


def outlines(wall: Floats, other: Floats, reach: float) -> tuple[Floats, Floats]:
    """Points on the outlines of elements.

    An outline runs halfway between neighbours of which one is on the wall and one is not, and, at holes without points,
    a little beyond the outermost points of the wall.

    Args:
        wall: [P, 2] points of the wall, metres.
        other: [Q, 2] points behind or in front of it.
        reach: largest distance of neighbours on a wall, metres.

    Returns:
        The points [R, 2], and for each the unit vector [R, 2] away from the wall.
    """
    points = np.vstack([wall, other])
    none = np.zeros((0, 2))
    if len(points) < _FEWEST:
        return none, none
    # Qhull loses digits far from the origin.
    origin = points.mean(axis=0)
    points = points - origin
    try:
        net = Delaunay(points)
    except QhullError:  # all points are on one line
        return none, none
    corners = points[net.simplices]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2.0
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    hollow = sides.prod(axis=1) > 4.0 * reach * area
    of_wall = net.simplices < len(wall)
    spacing = np.sqrt(2.0 * area[~hollow].mean()) if not hollow.all() else 0.0
    found, outward = [], []
    for side in range(3):
        start, end = (side + 1) % 3, (side + 2) % 3
        middle = (corners[:, start] + corners[:, end]) / 2.0
        step = corners[:, end] - corners[:, start]
        neighbour = net.neighbors[:, side]
        once = (neighbour < 0) | (neighbour > np.arange(len(corners)))
        across = once & (of_wall[:, start] != of_wall[:, end]) & (sides[:, start] < reach)
        found.append(middle[across])
        outward.append(np.where(of_wall[:, start, None], step, -step)[across])
        rim = of_wall[:, start] & of_wall[:, end] & ~hollow & ((neighbour < 0) | hollow[neighbour])
        normal = np.stack([step[:, 1], -step[:, 0]], axis=1)
        normal *= np.sign(((middle - corners[:, side]) * normal).sum(axis=1))[:, None]
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        found.append((middle + _WITHIN * spacing * normal)[rim])
        outward.append(normal[rim])
    directions = np.vstack(outward)
    return np.vstack(found) + origin, directions / np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-12)
