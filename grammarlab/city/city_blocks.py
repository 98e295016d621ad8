"""Blocks: what streets leave of their regions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from grammarlab.arrays import Floats, Ints, offsets_from_counts, row_of_value
from grammarlab.city.street_chords import DECIMALS, Ring
from grammarlab.city.streets import Region

_OPENING = 3.0
"""Tolerance: half of the narrowest width of a block in metres; narrower parts and sharp tips become street."""
_BEVEL = 1.7
"""Limit of mitres: corners sharper than 72 degrees are bevelled, as at real crossings."""
_SMOOTHING = 0.05
"""Tolerance: metres by which the outline of a block is simplified."""
LEAST_AREA = 150.0
"""Tolerance: square metres; smaller remainders become street."""
_OUTLINE_TOLERANCE = 0.1
"""Tolerance: metres from the outline of the area within which an edge of a block lies on it."""


@dataclass(frozen=True, slots=True, eq=False)
class BlockOutlines:
    """B blocks, ordered by path and part."""

    polygon: NDArray[np.object_]
    """[B] simple polygons without holes, coordinates rounded to millimetres, counter-clockwise."""
    path: Ints
    """[B] address of the region of each block."""
    part: Ints
    """[B] number of the block in its region, from 0."""

    def __len__(self) -> int:
        return len(self.polygon)

    @classmethod
    def concatenate(cls, parts: Sequence[BlockOutlines]) -> BlockOutlines:
        """The blocks of several areas, in their order."""
        return cls(
            np.concatenate([np.empty(0, dtype=object), *(part.polygon for part in parts)]),
            np.concatenate([np.empty(0, dtype=np.int64), *(part.path for part in parts)]),
            np.concatenate([np.empty(0, dtype=np.int64), *(part.part for part in parts)]),
        )


def block_outlines(regions: Sequence[Region], obstacles: BaseGeometry) -> BlockOutlines:
    """The blocks of regions.

    Args:
        regions: regions with the widths of the streets on their edges.
        obstacles: what else is no block: holes of the area with their streets, and places.
    """
    outline = np.array([shapely.Polygon(region.ring.corners) for region in regions], dtype=object)
    outline = shapely.difference(outline, _street_areas([region.ring for region in regions]))
    if not obstacles.is_empty:
        shapely.prepare(obstacles)
        touched = np.flatnonzero(shapely.intersects(obstacles, outline))
        outline[touched] = shapely.difference(outline[touched], obstacles)
    outline = _opened(outline)
    parts, row = shapely.get_parts(outline, return_index=True)
    is_large = shapely.area(parts) >= LEAST_AREA
    parts, row = _rounded(parts[is_large]), row[is_large]
    is_large = shapely.area(parts) >= LEAST_AREA
    parts, row = parts[is_large], row[is_large]
    place = shapely.get_coordinates(shapely.centroid(parts))
    order = np.lexsort((place[:, 1], place[:, 0], row))
    parts, row = parts[order], row[order]
    path = np.array([region.path for region in regions], dtype=np.int64)
    first = np.searchsorted(row, row)
    return BlockOutlines(parts, path[row], np.arange(len(row)) - first)


def street_edges(blocks: BlockOutlines, outline: BaseGeometry | None) -> NDArray[np.bool_]:
    """Flags of all edges of all blocks, in order: whether they are on a street.

    Args:
        blocks: B blocks.
        outline: the outline of the area as lines if there is no street along it; None if there is one.
    """
    corners, block = shapely.get_coordinates(blocks.polygon, return_index=True)
    is_edge = block[:-1] == block[1:]
    if outline is None:
        return np.ones(int(is_edge.sum()), dtype=np.bool_)
    middle = (corners[:-1] + corners[1:])[is_edge] / 2
    shapely.prepare(outline)
    on_outline = shapely.dwithin(outline, shapely.points(middle), _OUTLINE_TOLERANCE)
    has_street = np.zeros(len(blocks), dtype=np.bool_)
    has_street[block[:-1][is_edge][~on_outline]] = True
    return ~on_outline | ~has_street[block[:-1][is_edge]]


def _street_areas(rings: Sequence[Ring]) -> NDArray[np.object_]:
    """[R] the halves of streets inside each ring."""
    counts = np.array([len(ring.corners) for ring in rings], dtype=np.int64)
    if not counts.sum():
        return np.empty(0, dtype=object)
    row = row_of_value(counts)
    start = np.concatenate([ring.corners for ring in rings])
    end = np.concatenate([np.roll(ring.corners, -1, axis=0) for ring in rings])
    width = np.concatenate([ring.width for ring in rings])
    # Edges of one street in a row of a ring make one line, so that its corners are mitred.
    previous = np.concatenate([[-1.0], width[:-1]])
    is_first = np.r_[True, row[1:] != row[:-1]] | (width != previous)
    run = np.cumsum(is_first) - 1
    lengths = np.bincount(run)
    offsets = offsets_from_counts(lengths)
    points = np.empty((len(start) + len(lengths), 2))
    position = np.arange(len(start)) + run
    points[position] = start
    last = offsets[1:] - 1
    points[last + np.arange(len(lengths)) + 1] = end[last]
    lines = np.asarray(shapely.linestrings(points, indices=np.repeat(np.arange(len(lengths)), lengths + 1)))
    half = width[offsets[:-1]] / 2
    has_street = half > 0
    areas = shapely.buffer(lines[has_street], half[has_street], join_style="mitre", cap_style="square", mitre_limit=3.0)
    owner = row[offsets[:-1]][has_street]
    groups = np.full(len(rings), shapely.GeometryCollection(), dtype=object)
    bounds = np.searchsorted(owner, np.arange(len(rings) + 1))
    for ring in range(len(rings)):
        groups[ring] = shapely.union_all(areas[bounds[ring] : bounds[ring + 1]])
    return groups


def _opened(outline: NDArray[np.object_]) -> NDArray[np.object_]:
    """Polygons without narrow parts and sharp tips."""
    smaller = shapely.buffer(outline, -_OPENING, join_style="mitre", mitre_limit=10.0)
    opened = shapely.buffer(smaller, _OPENING, join_style="mitre", mitre_limit=_BEVEL)
    return shapely.simplify(shapely.intersection(opened, outline), _SMOOTHING)


def _rounded(polygons: NDArray[np.object_]) -> NDArray[np.object_]:
    """Valid polygons in a canonical order of their corners, rounded."""
    rounded = shapely.transform(polygons, lambda points: np.round(points, DECIMALS))
    rounded = rounded[shapely.is_valid(rounded)]
    return shapely.orient_polygons(shapely.normalize(rounded), exterior_cw=False)


def ring_of(polygon: shapely.Polygon, width: float) -> Ring:
    """The exterior of a polygon as a ring with streets of one width in metres."""
    corners: Floats = np.round(shapely.get_coordinates(shapely.orient_polygons(polygon).exterior)[:-1], DECIMALS)
    differs = (corners != np.roll(corners, -1, axis=0)).any(axis=1)
    corners = corners[differs]
    return Ring(corners, np.full(len(corners), width))
