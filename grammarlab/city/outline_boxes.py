"""Search trees of the boxes around the outlines of a part of a map, so that their memory does not grow with the map."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.city.packed_outlines import row_blocks

_BAND = 500.0
"""Metres from south to north of a band of outlines that are looked at from west to east."""


class BoxTree:
    """Boxes that meet a part of a map.

    Args:
        bounds: [N, 4] west, south, east and north of boxes; NaN for those that are never found.
        rows: [M] rows of the boxes that may be found.
        part: [4] the part of the map: boxes outside are not found.
    """

    def __init__(self, bounds: Floats, rows: Ints, part: Floats) -> None:
        boxes = bounds[rows]
        is_near = (boxes[:, :2] <= part[2:]).all(axis=1) & (boxes[:, 2:] >= part[:2]).all(axis=1)
        self._rows = rows[is_near]
        # The box of a diagonal is the whole box, and a line takes half the memory of a polygon.
        self._tree = shapely.STRtree(np.asarray(shapely.linestrings(boxes[is_near].reshape(-1, 2, 2)), object))

    def query(self, shapes: NDArray[np.object_]) -> tuple[Ints, Ints]:
        """Pairs of the index of a shape [n] and the row of a box that meets the box around it."""
        shape, found = self._tree.query(shapes)
        return shape, self._rows[found]


def neighbourhoods(bounds: Floats) -> Iterator[Ints]:
    """Rows of boxes [N, 4] in groups of near ones, each in one group."""
    order = np.lexsort((bounds[:, 0], np.floor(bounds[:, 1] / _BAND)))
    return (order[places] for places in row_blocks(len(order)))


def around(bounds: Floats) -> Floats:
    """[4] the box around boxes [N, 4], at least one."""
    return np.concatenate([np.fmin.reduce(bounds[:, :2]), np.fmax.reduce(bounds[:, 2:])])
