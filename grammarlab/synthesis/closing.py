"""Pieces of a building as one surface: stitched, with common points along seams, capped where units differ.

Remaining open edges are closed without regard to shape: walks along them are filled with triangles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.synthesis.assembly import Tiling, UnstitchedPieces
from grammarlab.synthesis.caps import capped
from grammarlab.synthesis.mesh.surface import (
    Surface,
    merged_points,
    naked_edges,
    welded,
    without_empty,
    without_folds,
    without_slivers,
)
from grammarlab.synthesis.mesh.views import Plane, plane_of, seen_from
from grammarlab.synthesis.rims import smoothed
from grammarlab.synthesis.separating import separated
from grammarlab.synthesis.stitching import Matches, conformed, matches, nearest_pairs, seam_edges, stitched

TOLERANCE = 1e-5
"""Tolerance of points on seams, and width of T-junctions that may remain, metres."""
_MAX_OPEN_EDGES = 20_000
"""Largest number of open edges; surfaces with more have large gaps, and stay open."""
_MIN_REACH_M, _MAX_REACH_M, _NOISE_FACTOR = 0.005, 0.05, 4.0
"""Largest move of a point by stitching: bounds in metres, and a multiple of the noise between them."""
_FOLD_WIDTH_M = 0.001
"""Metres: where the example has sheets, what is less wide is none of them."""
_ROUNDS = 3
"""Number of searches for nearest points."""
_MAX_OPEN_RATIO = 0.7
"""Largest share of open edges left by a round of caps that makes another round worthwhile."""


@dataclass(frozen=True, eq=False)
class Closed:
    """A building as one surface."""

    surface: Surface
    moved: int
    """Number of points that stitching has moved."""
    farthest: float
    """Largest move of a point by stitching, metres: the widest gap that it has closed."""
    sheets: bool
    """The example has faces with two sides."""


def closed(pieces: UnstitchedPieces, tilings: Sequence[Tiling], noise: float, *, was_closed: bool) -> Closed:
    """The surface of adjacent pieces.

    Args:
        pieces: the pieces.
        tilings: tilings that determine where pieces meet.
        noise: deviation of points of the example from their walls, metres.
        was_closed: whether the example has no open edges, so that the result must have none.
    """
    reach = min(max(_MIN_REACH_M, _NOISE_FACTOR * noise), _MAX_REACH_M)
    planes = seams(tilings)
    points, index = merged_points(pieces.surface.points, TOLERANCE)
    connected, moved = stitched(points, list(_pairs(points, index, pieces.first, tilings, reach)))
    distance = np.linalg.norm(connected - points, axis=1)
    surface = Surface(connected, index[pieces.surface.triangles], pieces.surface.material)
    surface = welded(surface, TOLERANCE)
    sheets = len(without_folds(surface)) < len(surface)
    bend = max(TOLERANCE, min(_NOISE_FACTOR * noise, _MAX_REACH_M))
    for _ in range(_ROUNDS if bend > TOLERANCE else 0):
        surface = _nearer(surface, planes, bend)
    surface = conformed(surface, planes, bend)
    previous = np.inf
    while 0 < (num_open := len(seam_edges(surface, planes, bend)[0])) < _MAX_OPEN_RATIO * previous:
        surface, previous = conformed(welded(capped(surface, planes, bend), TOLERANCE), planes, TOLERANCE), num_open
    if not was_closed:
        surface = smoothed(surface, planes, TOLERANCE)
    surface = rounded(surface, was_closed=was_closed, sheets=sheets)
    return Closed(surface, int(moved.sum()), float(distance.max(initial=0.0)), sheets)


def seams(tilings: Sequence[Tiling]) -> list[Plane]:
    """The planes where the pieces of a building meet."""
    planes = []
    for tiling in tilings:
        side = tiling.region.side
        planes += [plane_of(side, 0, float(position)) for position in tiling.columns]
        planes += [plane_of(side, 1, float(position)) for position in tiling.rows]
        used = np.unique(tiling.sources[..., 0]).tolist()
        planes += [plane_of(side, 2, tiling.plane + tiling.walls[k].back - tiling.walls[k].plane) for k in used]
    order = {(plane.axis, round(plane.position, 6)): plane for plane in planes}
    return [order[key] for key in sorted(order)]


def rounded(surface: Surface, *, was_closed: bool, sheets: bool) -> Surface:
    """The surface with coordinates rounded to 32-bit floating point numbers, as in files.

    Args:
        surface: the surface.
        was_closed: whether all that is open shall be closed.
        sheets: whether faces with two sides shall stay.
    """
    surface = welded(surface.moved(surface.points.astype(np.float32).astype(np.float64)), TOLERANCE / 10.0)
    surface = without_slivers(surface, TOLERANCE / 10.0)
    if was_closed:
        surface = without_slivers(_mended(surface), TOLERANCE / 10.0)
    return separated(without_folds(surface, _FOLD_WIDTH_M if sheets else np.inf))


def _pairs(points: Floats, index: Ints, first: Ints, tilings: Sequence[Tiling], reach: float) -> Iterator[Matches]:
    """Connection points of adjacent units that are not adjacent in the example.

    Args:
        points: [Q, 3] different points of all pieces.
        index: [P] index of the different point for each point of a piece.
        first: [N + 1] first point of each piece.
        tilings: tilings of the pieces.
        reach: largest move of a point, metres.
    """
    piece = 1
    for tiling in tilings:
        rows, columns = tiling.grid.labels.shape
        members = [np.unique(index[first[k] : first[k + 1]]) for k in range(piece, piece + rows * columns)]
        piece += rows * columns
        projected = seen_from(tiling.region.side, points)
        rest = np.unique(index[: first[1]])
        for axis, (down, across), line in ((0, (0, 1), tiling.columns), (1, (1, 0), tiling.rows)):
            step = tiling.sources[down:, across:] - tiling.sources[: rows - down, : columns - across]
            for row, column in np.argwhere((step != [0, down, across]).any(axis=2)).tolist():
                position = float(line[(column if axis == 0 else row) + 1])
                here, there = members[row * columns + column], members[(row + down) * columns + column + across]
                here, there = (
                    rows_of_side[np.abs(projected[rows_of_side, axis] - position) <= TOLERANCE]
                    for rows_of_side in (here, there)
                )
                yield matches(points, here, there, reach)
            within = _is_adjacent(projected[rest], tiling, axis, reach)
            for position in (float(line[0]), float(line[-1])):
                ends = [
                    rows_of_side[np.abs(projected[rows_of_side, axis] - position) <= TOLERANCE]
                    for rows_of_side in (np.concatenate(members), rest[within])
                ]
                yield matches(points, np.unique(ends[0]), ends[1], reach)


def _is_adjacent(points: Floats, tiling: Tiling, axis: int, reach: float) -> Flags:
    """[K] whether points are beside a region along an axis, and at the depth of its units."""
    line = tiling.rows if axis == 0 else tiling.columns
    depth, (back, front) = points[:, 2] - tiling.plane, tiling.depths
    return (
        (points[:, 1 - axis] >= line[0] - reach)
        & (points[:, 1 - axis] <= line[-1] + reach)
        & (depth >= back - reach)
        & (depth <= front + reach)
    )


def _nearer(surface: Surface, planes: Sequence[Plane], reach: float) -> Surface:
    """The surface with mutually nearest open points of seams merged."""
    edges = seam_edges(surface, planes, TOLERANCE)[0]
    pairs = nearest_pairs(surface.points, np.unique(edges), edges, reach)
    index = np.arange(len(surface.points))
    index[pairs.moved] = pairs.target
    return without_empty(Surface(surface.points, index[surface.triangles], surface.material))


def _mended(surface: Surface) -> Surface:
    """The surface without open edges, if it has few: each closed walk along them becomes a fan of triangles.

    Open edges always form closed walks, since they are the boundary of a sum of triangles.
    """
    edges, times = naked_edges(surface.triangles, len(surface.points))
    if not len(edges) or times.sum() > _MAX_OPEN_EDGES:
        return surface
    fans = [_fan(walk) for walk in _walks(np.repeat(edges, times, axis=0))]
    rows = np.concatenate(fans)
    of_point = np.zeros(len(surface.points), dtype=np.int64)
    of_point[surface.triangles.ravel()] = np.repeat(surface.material, 3)
    return without_empty(
        Surface(
            surface.points,
            np.concatenate([surface.triangles, rows]),
            np.concatenate([surface.material, of_point[rows[:, 0]]]),
        )
    )


def _fan(walk: list[int]) -> Ints:
    """Triangles whose edges are opposite to those of a walk."""
    first, rest = walk[0], walk[1:]
    return np.array([(first, b, a) for a, b in pairwise(rest)], dtype=np.int64).reshape(-1, 3)


def _walks(edges: Ints) -> list[list[int]]:
    """Closed walks without repeated points that use every directed edge once."""
    following: dict[int, list[int]] = {}
    for start, end in edges.tolist():
        following.setdefault(start, []).append(end)
    walks = []
    for start in sorted(following):
        while following[start]:
            walk, index = [start], {start: 0}
            while True:
                point = following[walk[-1]].pop()
                if point in index:
                    first = index[point]
                    walks.append(walk[first:])
                    for visited in walk[first + 1 :]:
                        del index[visited]
                    walk = walk[: first + 1]
                    if first == 0 and not following[start]:
                        break
                    if first == 0:
                        continue
                else:
                    index[point] = len(walk)
                    walk.append(point)
    return walks
