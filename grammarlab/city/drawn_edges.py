"""Where a map begins to draw outlines, which are kept drawn in one way: lists of maps by edge are in its order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import row_of_value, take_rows
from grammarlab.city.packed_outlines import Outlines, PackedOutlines


def first_edges(drawn: Outlines, outlines: PackedOutlines) -> NDArray[np.int32]:
    """[N] the edge of the outer ring that is drawn first, counted from 1; negative if the ring is drawn clockwise.

    Args:
        drawn: [N] polygons as they are drawn.
        outlines: [N] the same, their outer rings counter-clockwise from any corner.

    Returns:
        The edges, 0 for empty polygons.
    """
    first = np.zeros(len(drawn), np.int32)
    rows = np.flatnonzero(~shapely.is_empty(drawn))
    rings = shapely.get_exterior_ring(drawn[rows])
    is_clockwise = ~shapely.is_ccw(rings)
    begin, end = (shapely.get_coordinates(shapely.get_point(rings, index)) for index in (0, 1))
    begin[is_clockwise], end[is_clockwise] = end[is_clockwise], begin[is_clockwise]
    corners, _ = take_rows(outlines.ring_offsets, outlines.offsets[rows])
    counts = np.diff(outlines.ring_offsets)[outlines.offsets[rows]]
    ring = row_of_value(counts)[:-1]
    is_first = (outlines.points[corners[:-1]] == begin[ring]) & (outlines.points[corners[1:]] == end[ring])
    edge = np.flatnonzero(is_first.all(axis=1) & (np.diff(row_of_value(counts)) == 0))
    number = edge - (np.cumsum(counts) - counts)[ring[edge]] + 1
    first[rows[ring[edge]]] = np.where(is_clockwise[ring[edge]], -number, number)
    return first


def in_order(values: Sequence[float], first: int) -> list[float]:
    """Values of the edges of a ring in its own order, from those in the order in which it is drawn.

    Args:
        values: a value for each edge as it is drawn.
        first: the edge that is drawn first, as of `first_edges`, not 0.

    >>> in_order([7, 8, 9], 2), in_order([7, 8, 9], -2)
    ([9, 7, 8], [8, 7, 9])
    """
    step = 1 if first > 0 else -1
    return [values[step * (edge - abs(first) + 1) % len(values)] for edge in range(len(values))]
