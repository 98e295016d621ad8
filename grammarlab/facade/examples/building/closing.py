"""Pieces of a building to one surface: stitched, with common points along seams, closed where unlike units meet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.analysis.views import Plane, plane_of, seen_from
from grammarlab.facade.examples.building.assembly import Pieces, Tiling
from grammarlab.facade.examples.building.caps import capped
from grammarlab.facade.examples.building.conforming import conformed
from grammarlab.facade.examples.building.mending import mended
from grammarlab.facade.examples.building.stitching import Matches, matches, stitched
from grammarlab.facade.examples.building.surface import Floats, Ints, Surface, naked_edges, welded, without_slivers

TOLERANCE = 1e-5
"""Metres: of points on seams, and the width of T-junctions that may remain."""
_LEAST_REACH, _MOST_REACH, _NOISES = 0.005, 0.05, 4.0
"""Metres that stitching moves points at most, and multiples of the noise in between."""
_ROUNDS = 3


@dataclass(frozen=True, eq=False)
class Closed:
    """A building as one surface."""

    surface: Surface
    moved: int
    """Points that stitching has moved."""
    farthest: float
    """Metres, by which it has moved one at most: the widest gap that it has closed."""


def closed(pieces: Pieces, tilings: Sequence[Tiling], noise: float, *, was_closed: bool) -> Closed:
    """The surface of pieces that stand side by side.

    Args:
        pieces: the pieces.
        tilings: what tells where they meet.
        noise: metres by which points of the example deviate from their walls.
        was_closed: whether the example has no open edges, so that the building shall have none.
    """
    reach = min(max(_LEAST_REACH, _NOISES * noise), _MOST_REACH)
    planes = seams(tilings)
    points, moved = stitched(pieces.surface.points, list(_pairs(pieces, tilings, reach)))
    distance = np.linalg.norm(points - pieces.surface.points, axis=1)
    surface = welded(pieces.surface.moved(points), TOLERANCE)
    bend = max(TOLERANCE, min(2.0 * noise, _MOST_REACH) if noise > TOLERANCE else 0.0)
    surface = conformed(surface, planes, bend)
    for _ in range(_ROUNDS):
        if not len(naked_edges(surface)[0]):
            break
        surface = conformed(welded(capped(surface, planes, max(TOLERANCE, bend)), TOLERANCE), planes, TOLERANCE)
    surface = without_slivers(rounded(surface), TOLERANCE / 10.0)
    if was_closed:
        surface = mended(surface)
    return Closed(surface, int(moved.sum()), float(distance.max(initial=0.0)))


def seams(tilings: Sequence[Tiling]) -> list[Plane]:
    """The planes where the pieces of a building meet."""
    planes = []
    for tiling in tilings:
        side = tiling.region.side
        planes += [plane_of(side, 0, float(at)) for at in tiling.columns]
        planes += [plane_of(side, 1, float(at)) for at in tiling.rows]
        planes.append(plane_of(side, 2, tiling.region.back - tiling.region.plane + tiling.plane))
    order = {(each.axis, round(each.at, 6)): each for each in planes}
    return [order[key] for key in sorted(order)]


def rounded(surface: Surface) -> Surface:
    """The surface with coordinates that 32-bit floating point numbers have, as files keep them."""
    return welded(surface.moved(surface.points.astype(np.float32).astype(np.float64)), TOLERANCE / 10.0)


def _pairs(pieces: Pieces, tilings: Sequence[Tiling], reach: float) -> Iterator[Matches]:
    """Connection points of units side by side, or one above the other, that are no neighbours in the example."""
    points = pieces.surface.points
    piece = 1
    for tiling in tilings:
        rows, columns = tiling.grid.labels.shape
        number = piece + np.arange(rows * columns).reshape(rows, columns)
        piece += rows * columns
        seen = seen_from(tiling.region.side, points)
        for axis, (down, across) in ((0, (0, 1)), (1, (1, 0))):
            line = tiling.columns if axis == 0 else tiling.rows
            step = tiling.sources[down:, across:] - tiling.sources[: rows - down, : columns - across]
            for row, column in np.argwhere((step != [down, across]).any(axis=2)).tolist():
                at = float(line[(column if axis == 0 else row) + 1])
                ends = [
                    _on_line(seen, pieces.first, int(number[place]), axis, at)
                    for place in ((row, column), (row + down, column + across))
                ]
                yield matches(points, ends[0], ends[1], reach)


def _on_line(seen: Floats, first: Ints, piece: int, axis: int, at: float) -> Ints:
    """Points of a piece on a line between rows or columns."""
    start, end = first[piece : piece + 2].tolist()
    return start + np.flatnonzero(np.abs(seen[start:end, axis] - at) <= TOLERANCE)
