"""Heights of the outlines of 3D maps."""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city.packed_outlines import Outlines

_MAX_TILT = np.cos(np.radians(30.0))
"""Smallest vertical part of the normal of an outline."""
_HEIGHTS = (-500.0, 9_000.0)
"""Metres between which land lies."""


def heights_of(polygons: Outlines, flat: Outlines, height_unit: float) -> tuple[Floats, Flags, bool]:
    """Heights of polygons, whether they are inclined, and whether any corner has another height than 0.

    Args:
        polygons: polygons of a map.
        flat: the same in metres, without heights.
        height_unit: metres per unit of heights.
    """
    elevation, is_tilted = np.full(len(flat), np.nan), np.zeros(len(flat), dtype=np.bool_)
    rows = np.flatnonzero(shapely.has_z(polygons))
    if len(rows) == 0:
        return elevation, is_tilted, False
    heights = shapely.get_coordinates(shapely.get_exterior_ring(polygons[rows]), include_z=True)[:, 2] * height_unit
    points, ring = shapely.get_coordinates(shapely.get_exterior_ring(flat[rows]), return_index=True)
    with np.errstate(invalid="ignore", over="ignore"):
        is_plausible = np.ones(len(rows), dtype=np.bool_)
        np.logical_and.at(is_plausible, ring, (heights >= _HEIGHTS[0]) & (heights <= _HEIGHTS[1]))
        normal = _normals(np.column_stack([points, heights]), ring, len(rows))
        length = np.linalg.norm(normal, axis=1)
        is_tilted[rows] = is_plausible & (np.abs(normal[:, 2]) < _MAX_TILT * length)
        counts = np.bincount(ring, minlength=len(rows))
        mean = np.bincount(ring, heights, minlength=len(rows)) / counts
    elevation[rows[is_plausible]] = mean[is_plausible]
    return elevation, is_tilted, bool(heights.any())


def _normals(points: Floats, ring: Ints, num_rings: int) -> Floats:
    """[R, 3] normals of rings by Newell's method, twice as long as their areas."""
    starts = np.searchsorted(ring, np.arange(num_rings))
    local = points - points[starts][ring]
    is_edge = ring[:-1] == ring[1:]
    cross = np.cross(local[:-1], local[1:])[is_edge]
    normals = np.zeros((num_rings, 3))
    for axis in range(3):
        normals[:, axis] = np.bincount(ring[:-1][is_edge], cross[:, axis], minlength=num_rings)
    return normals
