"""Streets and pavements between parcels, and parcels on a terrain, as triangles for the page."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.city.map_squares import cut_by_squares, polygons_of

SURFACES = ("street", "pavement", "land")
_STREET, _PAVEMENT = 10.0, 2.0
"""Metres around parcels that are street, and pavement."""
_WIDEST = 32.0
"""Width in metres up to which what lies between parcels is a street."""
_CLOSING = 1.0
"""Gaps between parcels up to twice this width in metres are not streets."""
_STEP = 15.0
"""Longest edge in metres, so that streets follow the terrain."""
_AROUND = 80.0
"""Metres of land around parcels."""
_MOST_SQUARES = 40_000
"""Number of squares of land above which they are larger."""
_GRID = 0.01
"""Metres to which corners are rounded, since areas of nearly equal outlines are slow and fragile."""

Surfaces = tuple[NDArray[np.float64], NDArray[np.uint8]]
"""[T, 3, 2] corners of triangles, and [T] indices into `SURFACES`."""
NO_STREETS: Surfaces = (np.zeros((0, 3, 2)), np.zeros(0, np.uint8))
NO_SURFACES = (np.zeros((0, 3, 2)), np.zeros(0, np.int64))


def street_triangles(outlines: NDArray[np.object_], *, is_level: bool = True) -> Surfaces:
    """What lies between parcels and around them.

    Args:
        outlines: [N] polygons in metres; None for missing ones.
        is_level: whether there is no terrain that the triangles are to follow.
    """
    valid = shapely.make_valid(outlines[~shapely.is_missing(outlines)])
    parcels = shapely.union_all(valid, grid_size=_GRID)
    blocks = shapely.buffer(shapely.buffer(parcels, _CLOSING, join_style="mitre"), -_CLOSING, join_style="mitre")
    pavement = shapely.buffer(blocks, _PAVEMENT, join_style="mitre")
    wide = shapely.buffer(blocks, _WIDEST / 2, join_style="mitre")
    street = shapely.buffer(wide, _STREET - _WIDEST / 2, join_style="mitre")
    parts = [
        _triangles(_areas(shapely.difference(outer, inner, grid_size=_GRID), is_level=is_level))[0]
        for outer, inner in ((street, pavement), (pavement, blocks))
    ]
    kinds = np.repeat(np.arange(len(parts), dtype=np.uint8), [len(part) for part in parts])
    return np.concatenate(parts), kinds


def land_triangles(outlines: NDArray[np.object_]) -> Surfaces:
    """What is neither parcel nor street, around all parcels, in squares that follow a terrain.

    Args:
        outlines: [N] polygons in metres; None for missing ones.
    """
    parcels = shapely.make_valid(outlines[~shapely.is_missing(outlines)])
    near = shapely.union_all(shapely.buffer(parcels, _STREET, join_style="mitre"), grid_size=_GRID)
    whole = shapely.buffer(shapely.convex_hull(near), _AROUND)
    side = _STEP
    while whole.area > _MOST_SQUARES * side * side:
        side *= 2.0
    polygons, _ = polygons_of(np.array([shapely.difference(whole, near)], dtype=object))
    triangles, _ = _triangles(cut_by_squares(polygons, side)[0])
    return triangles, np.full(len(triangles), SURFACES.index("land"), np.uint8)


def parcel_triangles(outlines: NDArray[np.object_]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Parcels as triangles that follow a terrain.

    Args:
        outlines: [N] polygons in metres; None for missing ones.

    Returns:
        [T, 3, 2] corners of triangles, and [T] the row of the parcel of each.
    """
    polygons, row = polygons_of(shapely.make_valid(outlines))
    parts, part = cut_by_squares(polygons, _STEP)
    triangles, owner = _triangles(parts)
    return triangles, row[part[owner]]


def _areas(area: shapely.Geometry, *, is_level: bool) -> NDArray[np.object_]:
    """The area, in squares if it is not level."""
    if is_level:
        return np.array([area], dtype=object)
    return cut_by_squares(polygons_of(np.array([area], dtype=object))[0], _STEP)[0]


def _triangles(areas: NDArray[np.object_]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """[T, 3, 2] triangles of areas [n], counter-clockwise, and [T] the row of the area of each."""
    divided = shapely.constrained_delaunay_triangles(shapely.segmentize(areas, _STEP))
    parts, owner = shapely.get_parts(divided, return_index=True)
    corners = shapely.get_coordinates(shapely.orient_polygons(parts)).reshape(-1, 4, 2)[:, :3]
    return corners, owner.astype(np.int64)
