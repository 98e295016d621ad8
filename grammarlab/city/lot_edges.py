"""Edges of parcels as columns: their corners without those that a footprint does not need.

Outlines of maps have many corners on straight lines and edges of a few centimetres. Corners that change the outline
by less than `SIMPLIFIED` are left out. The first corner of a ring is its westernmost (then southernmost) one, so that a
map that draws an outline from another corner, or clockwise, has the same buildings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints, connected, offsets_from_counts, row_of_value, take_rows
from grammarlab.city.packed_outlines import Outlines

SIMPLIFIED = 0.1
"""Largest distance in metres between an outline and its simplified one."""


@dataclass(frozen=True, eq=False, kw_only=True)
class LotEdges:
    """Rings of N outlines, outer rings counter-clockwise, holes clockwise, as ragged lists."""

    points: Floats
    """[P, 2] corners, x to the east and y to the north in metres; the ring is not closed."""
    ring_offsets: Ints
    """[R + 1] into `points`."""
    outline_offsets: Ints
    """[N + 1] into rings; the first ring of an outline is the outer one, the others are holes."""

    def __len__(self) -> int:
        return len(self.outline_offsets) - 1

    @classmethod
    def of(cls, outlines: Outlines) -> LotEdges:
        """Corners of N valid polygons; no corners are left out."""
        rings, outline = shapely.get_rings(outlines, return_index=True)
        is_outer = np.diff(outline, prepend=-1) > 0
        points, ring = shapely.get_coordinates(rings, return_index=True)
        is_closing = np.diff(ring, append=-1) != 0
        points, ring = points[~is_closing], ring[~is_closing]
        offsets = offsets_from_counts(np.bincount(ring, minlength=len(rings)))
        index = np.arange(len(points))
        start, end = offsets[ring], offsets[ring + 1]
        # A ring that is turned around keeps its first corner.
        turned = np.where(index == start, start, start + end - index)
        is_turned = (shapely.is_ccw(rings) != is_outer)[ring]
        return cls(
            points=points[np.where(is_turned, turned, index)],
            ring_offsets=offsets,
            outline_offsets=offsets_from_counts(np.bincount(outline, minlength=len(outlines))),
        )

    @classmethod
    def concatenate(cls, parts: Sequence[LotEdges]) -> LotEdges:
        """The outlines of all parts, in order."""
        sizes = [np.diff(part.ring_offsets) for part in parts]
        holes = [np.diff(part.outline_offsets) for part in parts]
        none = np.zeros(0, np.int64)
        return cls(
            points=np.concatenate([np.zeros((0, 2)), *(part.points for part in parts)]),
            ring_offsets=offsets_from_counts(np.concatenate([none, *sizes])),
            outline_offsets=offsets_from_counts(np.concatenate([none, *holes])),
        )

    @cached_property
    def ring(self) -> Ints:
        """[P] ring of each corner."""
        return row_of_value(np.diff(self.ring_offsets))

    @cached_property
    def outline(self) -> Ints:
        """[P] outline of each corner."""
        return row_of_value(np.diff(self.outline_offsets))[self.ring]

    @cached_property
    def is_hole(self) -> Flags:
        """[P] whether a corner belongs to a hole."""
        return self.ring != self.outline_offsets[:-1][self.outline]

    @cached_property
    def next_corner(self) -> Ints:
        """[P] the corner at the other end of the edge that leaves each corner."""
        return self.shifted(1)

    def shifted(self, step: int) -> Ints:
        """[P] the corner that many steps further along its ring."""
        start = self.ring_offsets[:-1][self.ring]
        size = np.diff(self.ring_offsets)[self.ring]
        return start + (np.arange(len(self.points)) - start + step) % size

    def starting_at(self, corners: Ints) -> Ints:
        """[P] order of the corners in which the outer rings begin with other corners.

        Args:
            corners: [N] one corner of the outer ring of each outline.
        """
        start = self.ring_offsets[:-1][self.ring]
        size = np.diff(self.ring_offsets)[self.ring]
        step = np.where(self.is_hole, 0, corners[self.outline] - start)
        return start + (np.arange(len(self.points)) - start + step) % size

    def take(self, rows: Ints) -> tuple[LotEdges, Ints]:
        """The outlines at these rows, in this order, and the rows of their corners."""
        rings, outline_offsets = take_rows(self.outline_offsets, rows)
        corners, ring_offsets = take_rows(self.ring_offsets, rings)
        return LotEdges(
            points=self.points[corners], ring_offsets=ring_offsets, outline_offsets=outline_offsets
        ), corners

    def polygons(self, points: Floats) -> Outlines:
        """[N] polygons with other corners [P, 2]."""
        if not len(self):
            return np.zeros(0, object)
        rings = np.asarray(shapely.linearrings(points, indices=self.ring), dtype=object)
        row = row_of_value(np.diff(self.outline_offsets))
        return np.asarray(shapely.polygons(rings, indices=row), dtype=object)

    def reordered(self, order: Ints) -> LotEdges:
        """The same rings with their corners in another order; see `starting_at`."""
        return LotEdges(points=self.points[order], ring_offsets=self.ring_offsets, outline_offsets=self.outline_offsets)

    @cached_property
    def along(self) -> Floats:
        """[P, 2] the edge that leaves each corner."""
        return self.points[self.next_corner] - self.points

    @cached_property
    def length(self) -> Floats:
        """[P] length of each edge in metres."""
        return np.hypot(*self.along.T)

    @cached_property
    def direction(self) -> Floats:
        """[P, 2] unit vector along each edge."""
        return self.along / np.maximum(self.length, np.finfo(float).tiny)[:, None]

    @cached_property
    def normal(self) -> Floats:
        """[P, 2] unit normal of each edge, out of the outline."""
        x, y = self.direction.T
        return np.column_stack([y, -x])


def simplified(outlines: Outlines) -> Outlines:
    """[N] outlines in a canonical order of their corners, without corners that change them by less than `SIMPLIFIED`.

    Args:
        outlines: [N] valid polygons.
    """
    return shapely.simplify(shapely.normalize(outlines), SIMPLIFIED, preserve_topology=True)


def merged_edges(edges: LotEdges, key: NDArray[np.integer], most_turn: float) -> Ints:
    """[P] chain of each edge: consecutive edges of one key that turn by little belong to one chain, numbered from 0.

    Args:
        edges: P edges.
        key: [P] edges of different keys are never merged.
        most_turn: largest turn between consecutive edges in degrees.
    """
    after = edges.next_corner
    cross = edges.normal[:, 0] * edges.normal[after, 1] - edges.normal[:, 1] * edges.normal[after, 0]
    dot = (edges.normal * edges.normal[after]).sum(axis=1)
    turn = np.abs(np.arctan2(cross, dot))
    joined = np.flatnonzero((turn < np.radians(most_turn)) & (key == key[after]))
    return connected(len(after), joined, after[joined])
