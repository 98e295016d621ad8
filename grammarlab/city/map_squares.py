"""Polygons of a map cut by a grid of squares, so that surfaces over them can follow a terrain."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Ints
from grammarlab.city.packed_outlines import Outlines

SMALLEST = 0.01
"""Smallest area in square metres of a part."""


def polygons_of(shapes: NDArray[np.object_]) -> tuple[Outlines, Ints]:
    """All polygons of shapes [n] but the smallest, and [K] the row of the shape of each."""
    collections, row = shapely.get_parts(shapes, return_index=True)
    parts, collection = shapely.get_parts(collections, return_index=True)
    is_polygon = shapely.get_type_id(parts) == shapely.GeometryType.POLYGON
    chosen = np.flatnonzero(is_polygon & (shapely.area(parts) > SMALLEST))
    return parts[chosen], row[collection[chosen]].astype(np.int64)


def cut_by_squares(outlines: Outlines, side: float) -> tuple[Outlines, Ints]:
    """The parts of polygons in the squares of a grid through the origin.

    Args:
        outlines: [n] valid polygons.
        side: side of a square, in the unit of the polygons.

    Returns:
        [K] parts, and [K] the row of the polygon of each, ascending.
    """
    parts, row = outlines, np.arange(len(outlines))
    for axis in range(2):
        parts, part = _strips(parts, side, axis)
        row = row[part]
    order = np.argsort(row, kind="stable")
    return parts[order], row[order]


def _strips(outlines: Outlines, side: float, axis: int) -> tuple[Outlines, Ints]:
    """The parts of polygons in strips across an axis, and the row of the polygon of each."""
    bounds = shapely.bounds(outlines).reshape(-1, 4)
    first, last = np.floor(bounds[:, axis] / side), np.ceil(bounds[:, axis + 2] / side)
    is_within = last - first <= 1.0
    found, rows = [outlines[is_within]], [np.flatnonzero(is_within)]
    wide = np.flatnonzero(~is_within)
    box = [*bounds[wide].min(axis=0, initial=np.inf)[:2], *bounds[wide].max(axis=0, initial=-np.inf)[2:]]
    for strip in range(int(first[wide].min(initial=0)), int(last[wide].max(initial=0))):
        here = wide[(first[wide] <= strip) & (strip < last[wide])]
        box[axis], box[axis + 2] = strip * side, (strip + 1) * side
        parts, part = polygons_of(shapely.clip_by_rect(outlines[here], *box))
        found.append(parts)
        rows.append(here[part])
    return np.concatenate(found), np.concatenate(rows)
