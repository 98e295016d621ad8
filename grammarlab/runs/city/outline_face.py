"""Polygons with holes as faces of one ring."""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.triangulate import keyhole


def outline_face(polygon: shapely.Polygon) -> Floats:
    """Corners [n, 2] of a polygon, counter-clockwise, its holes joined by doubled edges."""
    outer, *holes = (shapely.get_coordinates(ring)[:-1] for ring in (polygon.exterior, *polygon.interiors))
    rings = [outer if polygon.exterior.is_ccw else outer[::-1]]
    rings += [hole[::-1] if ring.is_ccw else hole for hole, ring in zip(holes, polygon.interiors, strict=True)]
    return np.concatenate(rings)[keyhole(rings)]
