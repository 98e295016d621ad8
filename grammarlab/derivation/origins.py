"""Local origins of models that are far from the origin of the world.

A 32-bit number has steps of 0.25 m at 2,683,000 m, and a 64-bit one has lost its nanometres. So far models are
derived, written and drawn relative to a local origin, and only the origin is a large number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NEAR = 1024.0
"""Largest coordinate in metres without a local origin; below it, 32-bit coordinates are accurate to 0.03 mm."""
_GRID = 1000.0
"""Steps of shared origins in metres."""


def origins_of(low: Floats, high: Floats) -> Floats:
    """Origin [N, 3] in the world for the coordinates of each object.

    An object that is farther than `NEAR` along some axis has the lowest corner of its bounding box as origin; others
    have the origin of the world. So an origin depends only on the object, and equal objects at different places have
    the same local coordinates.

    Args:
        low: [N, 3] smallest world coordinates of each object.
        high: [N, 3] largest world coordinates of each object.

    >>> low = np.array([[0.0, 0.0, -5.0], [2683000.0, 0.0, -5.0]])
    >>> origins_of(low, low + 9.0).tolist()
    [[0.0, 0.0, 0.0], [2683000.0, 0.0, -5.0]]
    """
    far = np.any((low > NEAR) | (high < -NEAR), axis=1, keepdims=True)
    return np.where(far, low, 0.0)


def shared_origin(low: Floats, high: Floats) -> Floats | None:
    """Origin [3] in the world that several objects share; None if no object is far, so that all have the world's.

    It is in whole kilometres near the middle of the objects, so that another object hardly ever moves it, unless their
    common bounding box is near the origin of the world.

    Args:
        low: [N, 3] smallest world coordinates of each object, at least one.
        high: [N, 3] largest world coordinates of each object.

    >>> low = np.array([[2683000.13, 0.0, -1247010.37], [2683040.13, 0.0, -1247010.37]])
    >>> shared_origin(low, low + 9.0).tolist()
    [2683000.0, 0.0, -1247000.0]
    """
    if not origins_of(low, high).any():
        return None
    low, high = low.min(axis=0), high.max(axis=0)
    if not origins_of(low[None], high[None]).any():
        return np.zeros(3)
    return np.round((low + high) / 2 / _GRID) * _GRID + 0.0


def origins_of_polygons(points: Floats, offsets: NDArray[np.int64]) -> Floats:
    """Origins [F, 3] of polygons; for the arguments see `brought_near`."""
    starts = offsets[:-1]
    return origins_of(np.minimum.reduceat(points, starts, axis=0), np.maximum.reduceat(points, starts, axis=0))


def brought_near(points: Floats, offsets: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Origins [F, 3] of footprints, and their corners [P, 3] relative to the origins.

    Far corners are rounded to the decimals that numbers of their size have, so that rounding errors do not change the
    lengths of sides.

    Args:
        points: [P, 3] the corners of all footprints in the world, at least one for each.
        offsets: [F + 1] offsets of the corners of each footprint.

    >>> corners = np.array([[2683000.13, 0, 0], [2683018.4, 0, 0], [2683018.4, 0, 9]])
    >>> origins, near = brought_near(corners, np.array([0, 3]))
    >>> origins.tolist(), near.tolist()
    ([[2683000.13, 0.0, 0.0]], [[0.0, 0.0, 0.0], [18.27, 0.0, 0.0], [18.27, 0.0, 9.0]])
    """
    origins = origins_of_polygons(points, offsets)
    near = points.copy()
    for index in np.flatnonzero(origins.any(axis=1)).tolist():
        corners = slice(*offsets[index : index + 2])
        step = np.spacing(np.abs(points[corners]).max())
        near[corners] = np.round(points[corners] - origins[index], int(-np.log10(4.0 * step))) + 0.0
    return origins, near
