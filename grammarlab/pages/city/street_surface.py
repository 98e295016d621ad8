"""Streets and pavements between parcels, as triangles for the page."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

SURFACES = ("street", "pavement")
_STREET, _PAVEMENT = 10.0, 2.0
"""Metres around parcels that are street, and pavement."""
_WIDEST = 32.0
"""Width in metres up to which what lies between parcels is a street."""
_CLOSING = 1.0
"""Gaps between parcels up to twice this width in metres are not streets."""
_STEP = 15.0
"""Longest edge in metres, so that streets follow the terrain."""
_GRID = 0.01
"""Metres to which corners are rounded, since areas of nearly equal outlines are slow and fragile."""

Surfaces = tuple[NDArray[np.float64], NDArray[np.uint8]]
"""[T, 3, 2] corners of triangles, and [T] indices into `SURFACES`."""
NO_STREETS: Surfaces = (np.zeros((0, 3, 2)), np.zeros(0, np.uint8))


def street_triangles(outlines: NDArray[np.object_]) -> Surfaces:
    """What lies between parcels and around them.

    Args:
        outlines: [N] polygons in metres; None for missing ones.
    """
    valid = shapely.make_valid(outlines[~shapely.is_missing(outlines)])
    parcels = shapely.union_all(valid, grid_size=_GRID)
    blocks = shapely.buffer(shapely.buffer(parcels, _CLOSING, join_style="mitre"), -_CLOSING, join_style="mitre")
    pavement = shapely.buffer(blocks, _PAVEMENT, join_style="mitre")
    wide = shapely.buffer(blocks, _WIDEST / 2, join_style="mitre")
    street = shapely.buffer(wide, _STREET - _WIDEST / 2, join_style="mitre")
    parts = [
        _triangles(shapely.difference(outer, inner, grid_size=_GRID))
        for outer, inner in ((street, pavement), (pavement, blocks))
    ]
    kinds = np.repeat(np.arange(len(parts), dtype=np.uint8), [len(part) for part in parts])
    return np.concatenate(parts), kinds


def _triangles(area: shapely.Geometry) -> NDArray[np.float64]:
    """[T, 3, 2] triangles of an area, counter-clockwise."""
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.segmentize(area, _STEP)))
    return shapely.get_coordinates(shapely.orient_polygons(parts)).reshape(-1, 4, 2)[:, :3]
