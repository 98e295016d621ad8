"""Corners of outlines in the world, holes joined to them."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.geometry.meshes.keyhole import keyhole

TOLERANCE = 1e-6
"""Metres; corners nearer to each other are one, so that rounding gives no edge its direction."""


def corners_of(polygon: shapely.Polygon) -> NDArray[np.float64]:
    """The corners [n, 3] of a valid polygon in the world; holes are joined to the outline by doubled edges.

    A plan's x (east) becomes the world's x, its y (north) the world's -z, so a counter-clockwise ring looks up (+y).
    """
    rings = [_ring(polygon.exterior, counter_clockwise=True)]
    rings += [_ring(hole, counter_clockwise=False) for hole in polygon.interiors]
    walk = keyhole(rings)
    first_edge = np.flatnonzero((walk == 0) & (np.roll(walk, -1) == 1))[0]
    points = np.concatenate(rings)[np.roll(walk, -first_edge)]
    return np.column_stack([points[:, 0], np.zeros(len(points)), -points[:, 1]]) + 0.0


def _ring(ring: shapely.LinearRing, counter_clockwise: bool) -> NDArray[np.float64]:
    """Corners [n, 2] of a ring, reversed if necessary; the first edge stays first, since the scope is aligned to it."""
    corners = shapely.get_coordinates(shapely.remove_repeated_points(ring, TOLERANCE))[:-1]
    return corners if ring.is_ccw == counter_clockwise else np.roll(corners[::-1], 2, axis=0)
