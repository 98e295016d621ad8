"""Pieces of a building as one surface: stitched, with common points along seams, capped where different units meet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.building.assembly import Tiling, UnstitchedPieces
from grammarlab.facade.examples.building.surface.caps import capped
from grammarlab.facade.examples.building.surface.conforming import conformed, seam_edges
from grammarlab.facade.examples.building.surface.mending import mended
from grammarlab.facade.examples.building.surface.stitching import Matches, matches, nearest_pairs, stitched
from grammarlab.facade.examples.mesh.surface import (
    Bools,
    Floats,
    Ints,
    Surface,
    one_per_place,
    welded,
    without_empty,
    without_slivers,
)
from grammarlab.facade.examples.mesh.views import Plane, plane_of, seen_from

TOLERANCE = 1e-5
"""Tolerance of points on seams, and width of T-junctions that may remain, metres."""
_LEAST_REACH, _MOST_REACH, _NOISES = 0.005, 0.05, 4.0
"""Largest move of a point by stitching: bounds in metres, and a multiple of the noise between them."""
_ROUNDS = 3
"""Number of searches for nearest points."""
_WORTH = 0.7
"""Largest share of open edges left by a round of caps that makes another round worthwhile."""


@dataclass(frozen=True, eq=False)
class Closed:
    """A building as one surface."""

    surface: Surface
    moved: int
    """Number of points that stitching has moved."""
    farthest: float
    """Largest move of a point by stitching, metres: the widest gap that it has closed."""


def closed(pieces: UnstitchedPieces, tilings: Sequence[Tiling], noise: float, *, was_closed: bool) -> Closed:
    """The surface of adjacent pieces.

    Args:
        pieces: the pieces.
        tilings: tilings that determine where pieces meet.
        noise: deviation of points of the example from their walls, metres.
        was_closed: whether the example has no open edges, so that the result must have none.
    """
    reach = min(max(_LEAST_REACH, _NOISES * noise), _MOST_REACH)
    planes = seams(tilings)
    points, place = one_per_place(pieces.surface.points, TOLERANCE)
    connected, moved = stitched(points, list(_pairs(points, place, pieces.first, tilings, reach)))
    distance = np.linalg.norm(connected - points, axis=1)
    surface = Surface(connected, place[pieces.surface.triangles], pieces.surface.material)
    surface = welded(surface, TOLERANCE)
    bend = max(TOLERANCE, min(_NOISES * noise, _MOST_REACH))
    for _ in range(_ROUNDS if bend > TOLERANCE else 0):
        surface = _nearer(surface, planes, bend)
    surface = conformed(surface, planes, bend)
    before = np.inf
    while 0 < (left := len(seam_edges(surface, planes, bend)[0])) < _WORTH * before:
        surface, before = conformed(welded(capped(surface, planes, bend), TOLERANCE), planes, TOLERANCE), left
    surface = without_slivers(rounded(surface), TOLERANCE / 10.0)
    if was_closed:
        surface = without_slivers(mended(surface), TOLERANCE / 10.0)
    return Closed(surface, int(moved.sum()), float(distance.max(initial=0.0)))


def _nearer(surface: Surface, planes: Sequence[Plane], reach: float) -> Surface:
    """The surface with mutually nearest open points of seams merged."""
    edges = seam_edges(surface, planes, TOLERANCE)[0]
    pairs = nearest_pairs(surface.points, np.unique(edges), edges, reach)
    place = np.arange(len(surface.points))
    place[pairs.moved] = pairs.kept
    return without_empty(Surface(surface.points, place[surface.triangles], surface.material))


def seams(tilings: Sequence[Tiling]) -> list[Plane]:
    """The planes where the pieces of a building meet."""
    planes = []
    for tiling in tilings:
        side = tiling.region.side
        planes += [plane_of(side, 0, float(at)) for at in tiling.columns]
        planes += [plane_of(side, 1, float(at)) for at in tiling.rows]
        used = np.unique(tiling.sources[..., 0]).tolist()
        planes += [plane_of(side, 2, tiling.plane + tiling.walls[k].back - tiling.walls[k].plane) for k in used]
    order = {(each.axis, round(each.at, 6)): each for each in planes}
    return [order[key] for key in sorted(order)]


def rounded(surface: Surface) -> Surface:
    """The surface with coordinates rounded to 32-bit floating point numbers, as in files."""
    return welded(surface.moved(surface.points.astype(np.float32).astype(np.float64)), TOLERANCE / 10.0)


def _pairs(points: Floats, place: Ints, first: Ints, tilings: Sequence[Tiling], reach: float) -> Iterator[Matches]:
    """Connection points of adjacent units that are not adjacent in the example.

    Args:
        points: [Q, 3] different points of all pieces.
        place: [P] index of the different point for each point of a piece.
        first: [N + 1] first point of each piece.
        tilings: tilings of the pieces.
        reach: largest move of a point, metres.
    """
    piece = 1
    for tiling in tilings:
        rows, columns = tiling.grid.labels.shape
        own = [np.unique(place[first[k] : first[k + 1]]) for k in range(piece, piece + rows * columns)]
        piece += rows * columns
        seen = seen_from(tiling.region.side, points)
        rest = np.unique(place[: first[1]])
        for axis, (down, across), line in ((0, (0, 1), tiling.columns), (1, (1, 0), tiling.rows)):
            step = tiling.sources[down:, across:] - tiling.sources[: rows - down, : columns - across]
            for row, column in np.argwhere((step != [0, down, across]).any(axis=2)).tolist():
                at = float(line[(column if axis == 0 else row) + 1])
                here, there = own[row * columns + column], own[(row + down) * columns + column + across]
                here, there = (each[np.abs(seen[each, axis] - at) <= TOLERANCE] for each in (here, there))
                yield matches(points, here, there, reach)
            within = _beside(seen[rest], tiling, axis, reach)
            for at in (float(line[0]), float(line[-1])):
                ends = [
                    each[np.abs(seen[each, axis] - at) <= TOLERANCE] for each in (np.concatenate(own), rest[within])
                ]
                yield matches(points, np.unique(ends[0]), ends[1], reach)


def _beside(seen: Floats, tiling: Tiling, axis: int, reach: float) -> Bools:
    """[K] whether points are beside a region along an axis, and at the depth of its units."""
    line = tiling.rows if axis == 0 else tiling.columns
    depth, (back, front) = seen[:, 2] - tiling.plane, tiling.depths
    return (
        (seen[:, 1 - axis] >= line[0] - reach)
        & (seen[:, 1 - axis] <= line[-1] + reach)
        & (depth >= back - reach)
        & (depth <= front + reach)
    )
