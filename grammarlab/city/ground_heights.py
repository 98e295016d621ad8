"""Heights of the ground below footprints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from grammarlab.arrays import Floats, index_in_row, row_of_value
from grammarlab.city.lot_edges import LotEdges

_STEP = 5.0
"""Largest distance in metres between points of an outline whose heights are read."""
_MILLIMETRES = 3
"""Decimals of heights."""


class HeightField(Protocol):
    """A function of the place, such as a terrain."""

    def heights(self, east_north: Floats, /) -> Floats:
        """[n] values at points [n, 2] in metres from the frame's origin; NaN where they are unknown."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class GroundHeights:
    """Heights of the ground of S footprints in metres."""

    base: Floats
    """[S] at the middle of the first edge: floors count from there."""
    lowest: Floats
    """[S] lowest point of the outline; NaN if unknown."""
    highest: Floats
    """[S] highest point of the outline; NaN if unknown."""
    mean: Floats
    """[S] mean of the outline; NaN if unknown."""

    @property
    def plinth(self) -> Floats:
        """[S] metres from the base down to the lowest point of the outline; 0 where it is unknown."""
        return np.nan_to_num(np.maximum(_rounded(self.base - self.lowest), 0.0))


def ground_heights(edges: LotEdges, elevation: Floats, terrain: HeightField | None) -> GroundHeights:
    """Heights of the ground of footprints.

    Args:
        edges: edges of S footprints, each beginning with its first edge.
        elevation: [S] heights of parcels where there is no terrain, NaN if unknown; then the ground is at 0.
        terrain: the terrain, if there is one.
    """
    flat = np.nan_to_num(elevation)
    if terrain is None or not len(edges):
        unknown = np.full(len(edges), np.nan)
        return GroundHeights(flat, unknown, unknown, unknown)
    counts = np.maximum(np.ceil(edges.length / _STEP), 1.0).astype(np.int64)
    corner = row_of_value(counts)
    share = index_in_row(counts) / counts[corner]
    heights = np.asarray(terrain.heights(edges.points[corner] + share[:, None] * edges.along[corner]), np.float64)
    lot = edges.outline[corner]
    lowest, highest = np.full(len(edges), np.inf), np.full(len(edges), -np.inf)
    np.fmin.at(lowest, lot, heights)
    np.fmax.at(highest, lot, heights)
    total = np.bincount(lot, np.nan_to_num(heights), minlength=len(edges))
    number = np.bincount(lot, ~np.isnan(heights), minlength=len(edges))
    mean = np.where(number > 0, total / np.maximum(number, 1), np.nan)
    first = edges.ring_offsets[edges.outline_offsets[:-1]]
    front = np.asarray(terrain.heights(edges.points[first] + 0.5 * edges.along[first]), np.float64)
    base = np.where(np.isnan(front), np.where(np.isnan(mean), flat, mean), front)
    is_known = number > 0
    return GroundHeights(
        base=_rounded(base),
        lowest=_rounded(np.where(is_known, lowest, np.nan)),
        highest=_rounded(np.where(is_known, highest, np.nan)),
        mean=_rounded(mean),
    )


def _rounded(heights: Floats) -> Floats:
    return np.asarray(np.round(heights, _MILLIMETRES), np.float64)
