"""Repair of outlines that cross themselves."""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.arrays import Floats

MAX_AREA_CHANGE = 0.05
"""Largest change of the area of an outline by a repair, as a share."""
_MIN_PIECE = 0.01
"""Share of the area of a repaired outline below which a piece is left out."""
_MAX_CROSSINGS = 500_000
"""Most pairs of edges of an outline that is repaired whose boxes meet: each may be a crossing."""
_SAMPLE = 100
"""Edges whose neighbours are counted to estimate all such pairs."""


def valid_parts(polygon: shapely.Polygon) -> list[shapely.Polygon]:
    """Valid polygons with the area of an invalid one; none if that changes the area."""
    if _num_meeting(polygon) > _MAX_CROSSINGS:
        return []
    parts = shapely.get_parts(shapely.get_parts(shapely.make_valid(polygon)))  # polygons may be in two levels
    polygons = [part for part in parts if isinstance(part, shapely.Polygon)]
    area = sum(part.area for part in polygons)
    drawn = _drawn_area(polygon)
    if area == 0.0 or abs(area - drawn) > MAX_AREA_CHANGE * drawn:
        return []
    return [part for part in polygons if part.area >= _MIN_PIECE * area]


def _num_meeting(polygon: shapely.Polygon) -> float:
    """About the number of pairs of edges of a polygon whose boxes meet."""
    points, ring = shapely.get_coordinates(shapely.get_rings(polygon), return_index=True)
    is_edge = ring[:-1] == ring[1:]
    lines = shapely.linestrings(np.stack([points[:-1][is_edge], points[1:][is_edge]], axis=1))
    edges = np.asarray(lines, dtype=object)
    sample = edges[:: max(len(edges) // _SAMPLE, 1)]
    pairs = shapely.STRtree(edges).query(sample)
    return pairs.shape[1] * len(edges) / (2 * max(len(sample), 1))


def _drawn_area(polygon: shapely.Polygon) -> float:
    """The area that the rings of a polygon go around, less what they go around in the other direction."""
    outer, *holes = (_ring_area(shapely.get_coordinates(ring)) for ring in (polygon.exterior, *polygon.interiors))
    return outer - sum(holes)


def _ring_area(ring: Floats) -> float:
    x, y = (ring - ring[0]).T
    return abs(float(x[:-1] @ y[1:] - x[1:] @ y[:-1])) / 2
