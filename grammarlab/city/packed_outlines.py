"""Columns of outlines as arrays of coordinates: a tenth of the memory of as many polygons of shapely."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, offsets_from_counts, take_rows

Outlines: TypeAlias = NDArray[np.object_]
"""[N] polygons of shapely, with their holes."""
AT_ONCE = 4096
"""Outlines that are polygons of shapely at a time, a budget of memory: some 3 MB."""


@dataclass(frozen=True, eq=False)
class PackedOutlines:
    """N polygons without heights; rows of them become polygons of shapely when they are asked for."""

    points: Floats
    """[P, 2] corners of all rings, each of which ends where it begins."""
    ring_offsets: Ints
    """[R + 1] into `points`."""
    offsets: Ints
    """[N + 1] into rings; an empty polygon has none."""

    @classmethod
    def of(cls, outlines: Outlines) -> PackedOutlines:
        """The columns of polygons."""
        if not len(outlines):
            return cls(np.zeros((0, 2)), np.zeros(1, np.int64), np.zeros(1, np.int64))
        _, points, (ring_offsets, offsets) = shapely.to_ragged_array(outlines, include_z=False)
        return cls(points, ring_offsets.astype(np.int64), offsets.astype(np.int64))

    @classmethod
    def concatenate(cls, parts: Sequence[PackedOutlines]) -> PackedOutlines:
        """The outlines of all parts, in order."""
        none = np.zeros(0, np.int64)
        return cls(
            np.concatenate([np.zeros((0, 2)), *(part.points for part in parts)]),
            offsets_from_counts(np.concatenate([none, *(np.diff(part.ring_offsets) for part in parts)])),
            offsets_from_counts(np.concatenate([none, *(np.diff(part.offsets) for part in parts)])),
        )

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def __getitem__(self, rows: slice | NDArray[Any]) -> Outlines:
        """The polygons at some rows: a slice, indices or flags."""
        part = self.take(np.arange(len(self))[rows])
        kind = shapely.GeometryType.POLYGON
        return np.asarray(shapely.from_ragged_array(kind, part.points, (part.ring_offsets, part.offsets)), object)

    def take(self, rows: NDArray[np.integer]) -> PackedOutlines:
        """The outlines at these rows, in this order."""
        rings, offsets = take_rows(self.offsets, rows)
        points, ring_offsets = take_rows(self.ring_offsets, rings)
        return PackedOutlines(self.points[points], ring_offsets, offsets)

    def with_rows(self, rows: NDArray[np.integer], outlines: Outlines) -> PackedOutlines:
        """The same, with other polygons at some rows [K]."""
        if not len(rows):
            return self
        order = np.arange(len(self))
        order[rows] = len(self) + np.arange(len(rows))
        return PackedOutlines.concatenate([self, PackedOutlines.of(outlines)]).take(order)

    def blocks(self) -> Iterator[tuple[Ints, Outlines]]:
        """Consecutive rows with their polygons, `AT_ONCE` at a time."""
        return ((rows, self[rows]) for rows in row_blocks(len(self)))

    @property
    def point_offsets(self) -> Ints:
        """[N + 1] into `points`."""
        return self.ring_offsets[self.offsets]

    @property
    def area(self) -> Floats:
        """[N] square metres."""
        return np.concatenate([np.zeros(0), *(shapely.area(outlines) for _, outlines in self.blocks())])

    @property
    def bounds(self) -> Floats:
        """[N, 4] west, south, east and north; NaN for empty polygons."""
        starts = self.point_offsets
        rows = np.flatnonzero(np.diff(starts))
        bounds = np.full((len(self), 4), np.nan)
        if len(rows):
            bounds[rows, :2] = np.minimum.reduceat(self.points, starts[rows])
            bounds[rows, 2:] = np.maximum.reduceat(self.points, starts[rows])
        return bounds


def row_blocks(num: int) -> Iterator[Ints]:
    """The rows below a number, `AT_ONCE` at a time."""
    return (np.arange(start, min(start + AT_ONCE, num)) for start in range(0, num, AT_ONCE))
