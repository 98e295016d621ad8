"""Chords of rings: streets from one side of a region to the other, along a direction field.

A ring is a simple polygon without holes: corners [n, 2] in metres, counter-clockwise, the first not repeated. A chord
divides it into two rings that share its points to the last bit. New points are rounded to `GRAIN`, so that the last
bits of a traced line do not reach later splits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.city.direction_field import Directions

DECIMALS = 3
"""Decimal places of all coordinates: millimetres."""
_STEP = 12.0
"""Tolerance: step of traced lines in metres; at a radius of 100 m the error of a step is below a millimetre."""
_FLATNESS = 0.2
"""Tolerance: distance in metres of a line with few points from the traced one."""
_MAX_LENGTH = 8.0
"""Budget: length of a traced line by the diagonal of its ring; a circle that never leaves its region ends here."""
_STEPS_AT_ONCE = 16
"""Steps of a traced line before it is compared with its ring."""
_CLEARANCE = 0.5
"""Tolerance: metres behind the start on a ring where its own edge does not count as a hit."""


@dataclass(frozen=True, slots=True, eq=False)
class Ring:
    """A region that streets surround."""

    corners: Floats
    """[n, 2] corners in metres, counter-clockwise."""
    width: Floats
    """[n] width in metres of the street along the edge that leaves each corner; 0 without a street."""

    @property
    def area(self) -> float:
        """Square metres."""
        return ring_area(self.corners)

    @property
    def length(self) -> float:
        """Metres along the ring."""
        return float(np.hypot(*(following(self.corners) - self.corners).T).sum())


@dataclass(frozen=True, slots=True, eq=False)
class Chord:
    """A line through a ring from edge to edge."""

    points: Floats
    """[k, 2] points, k >= 2; the ends are on the ring."""
    edges: tuple[int, int]
    """Indices of the edges of the ring at both ends."""

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


def following(values: Floats) -> Floats:
    """The values [n] or [n, 2] at the next corner of each one of a ring."""
    return np.concatenate([values[1:], values[:1]])


def ring_area(corners: Floats) -> float:
    """Signed area of a ring [n, 2], positive if it is counter-clockwise."""
    x, y = (corners - corners[0]).T
    return float((x * following(y) - following(x) * y).sum() / 2)


def traced_both_ways(ring: Floats, directions: Directions, start: Floats, heading: float) -> Chord | None:
    """The chord through a point [2] inside a ring [n, 2], along the direction nearest to a heading in radians.

    None if the line does not leave the ring.
    """
    behind = _traced(ring, directions, start, heading + np.pi, 0.0)
    before = _traced(ring, directions, start, heading, 0.0)
    if behind is None or before is None:
        return None
    (back, first), (ahead, last) = behind, before
    if directions.is_straight:
        return Chord(np.stack([back[-1], ahead[-1]]), (first, last))
    return Chord(np.concatenate([_flattened(back)[::-1], _flattened(ahead)[1:]]), (first, last))


def traced_inwards(ring: Floats, directions: Directions, start: Floats, edge: int, heading: float) -> Chord | None:
    """The chord from a point [2] on an edge of a ring [n, 2], along the direction nearest to a heading in radians.

    None if the line does not leave the ring.
    """
    end = _traced(ring, directions, start, heading, _CLEARANCE)
    if end is None:
        return None
    points, last = end
    return Chord(_flattened(points), (edge, last))


def bent(chord: Chord, end: int, target: Floats, edge: int) -> Chord:
    """A chord whose first (0) or last (1) point is moved to a point [2] on an edge; all points move in proportion."""
    steps = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(chord.points, axis=0), axis=1))])
    share = steps / steps[-1] if end else 1.0 - steps / steps[-1]
    shift = target - chord.points[-1 if end else 0]
    points = np.round(chord.points + share[:, None] * shift, DECIMALS)
    points[-1 if end else 0] = target
    edges = (chord.edges[0], edge) if end else (edge, chord.edges[1])
    return Chord(points, edges)


def divided(ring: Ring, chord: Chord, width: float) -> tuple[Ring, Ring]:
    """The two parts of a ring: from the first end of a chord counter-clockwise to the last, and the rest.

    Args:
        ring: the ring.
        chord: a chord that touches it with its ends only.
        width: width of the street along the chord in metres.
    """
    first, last = chord.edges
    start, end = chord.points[0], chord.points[-1]
    return (
        _part(ring, first, last, start, end, chord.points[-2:0:-1], width),
        _part(ring, last, first, end, start, chord.points[1:-1], width),
    )


def nearest_edge(ring: Floats, points: Floats) -> tuple[Floats, Floats, Floats]:
    """Nearest points of a ring [n, 2] to points [m, 2].

    Returns:
        [m] indices of the edges (as integers), [m] distances in metres, [m, 2] nearest points.
    """
    along = following(ring) - ring
    offset = points[:, None] - ring
    share = np.clip((offset * along).sum(axis=2) / np.maximum((along**2).sum(axis=1), 1e-12), 0.0, 1.0)
    nearest = ring + share[:, :, None] * along
    distance = np.linalg.norm(points[:, None] - nearest, axis=2)
    edge = distance.argmin(axis=1)
    rows = np.arange(len(points))
    return edge, distance[rows, edge], nearest[rows, edge]


def contains(ring: Floats, point: Floats) -> bool:
    """Whether a point [2] is inside a ring [n, 2]."""
    x, y = (ring - point).T
    next_x, next_y = following(x), following(y)
    crosses = np.flatnonzero((y > 0) != (next_y > 0))
    east = x[crosses] - y[crosses] * (next_x[crosses] - x[crosses]) / (next_y[crosses] - y[crosses]) > 0
    return bool(east.sum() % 2)


def _part(ring: Ring, first: int, last: int, start: Floats, end: Floats, inner: Floats, width: float) -> Ring:
    """The ring from a point on its edge `first` to one on its edge `last`, closed by the inner points of a chord."""
    num = len(ring.corners)
    steps = (last - first) % num
    corner = ring.corners[first]
    if steps == 0 and ((end - corner) ** 2).sum() < ((start - corner) ** 2).sum():
        steps = num
    between = (first + 1 + np.arange(steps)) % num
    corners = np.concatenate([start[None], ring.corners[between], end[None], inner])
    widths = np.concatenate([[ring.width[first]], ring.width[between], np.full(1 + len(inner), width)])
    differs = (corners != following(corners)).any(axis=1)
    return Ring(corners[differs], widths[differs])


def _traced(
    ring: Floats, directions: Directions, start: Floats, heading: float, clearance: float
) -> tuple[Floats, int] | None:
    """Points from a start to the first hit of a ring, and the edge that is hit."""
    if directions.is_straight:
        angle = _nearest_direction(directions, float(start[0]), float(start[1]), heading)
        step = np.array([math.cos(angle), math.sin(angle)])
        hit = _first_hit(ring, start, step, clearance)
        return None if hit is None else (np.stack([start, np.round(start + hit[0] * step, DECIMALS)]), hit[1])
    pieces, ahead = [start[None]], following(ring)
    diagonal = float(np.hypot(*np.ptp(ring, axis=0)))
    for _ in range(int(_MAX_LENGTH * diagonal / (_STEP * _STEPS_AT_ONCE)) + 1):
        points, heading = _walk(directions, pieces[-1][-1], heading)
        hit = _first_crossing(ring, ahead, points, clearance)
        if hit is not None:
            segment, edge, point = hit
            return np.concatenate([*pieces, points[1 : segment + 1], point[None]]), edge
        pieces.append(points[1:])
        clearance = 0.0
    return None


def _walk(directions: Directions, start: Floats, heading: float) -> tuple[Floats, float]:
    """[s + 1, 2] points of a line through a field from a start, by the midpoint rule, and its last heading."""
    x, y = start.tolist()
    points = [(x, y)]
    for _ in range(_STEPS_AT_ONCE):
        heading = _nearest_direction(directions, x, y, heading)
        half_x, half_y = x + 0.5 * _STEP * math.cos(heading), y + 0.5 * _STEP * math.sin(heading)
        heading = _nearest_direction(directions, half_x, half_y, heading)
        x, y = x + _STEP * math.cos(heading), y + _STEP * math.sin(heading)
        points.append((x, y))
    return np.array(points), heading


def _nearest_direction(directions: Directions, x: float, y: float, heading: float) -> float:
    """Radians of that of the four ways of the cross at a point which is nearest to a heading."""
    angle = directions.at(x, y)
    quarter = math.pi / 2
    return angle + quarter * round((heading - angle) / quarter)


def _first_hit(ring: Floats, start: Floats, step: Floats, least: float) -> tuple[float, int] | None:
    """Distance to the nearest edge that a ray crosses, more than `least`, and that edge."""
    offset = ring - start
    side = step[0] * offset[:, 1] - step[1] * offset[:, 0]
    ahead = offset @ step
    next_side, next_ahead = following(side), following(ahead)
    crosses = np.flatnonzero((side >= 0) != (next_side >= 0))
    if not len(crosses):
        return None
    share = side[crosses] / (side[crosses] - next_side[crosses])
    distance = ahead[crosses] + share * (next_ahead[crosses] - ahead[crosses])
    if not (distance > least).any():
        return None
    nearest = np.where(distance > least, distance, np.inf).argmin()
    return float(distance[nearest]), int(crosses[nearest])


def _first_crossing(ring: Floats, ahead: Floats, points: Floats, least: float) -> tuple[int, int, Floats] | None:
    """The first segment of a line [s + 1, 2] that crosses a ring [n, 2], the edge, and the point, rounded.

    Args:
        ring: the ring.
        ahead: [n, 2] the next corner of each one.
        points: the line.
        least: metres along the first segment where a crossing does not count.
    """
    start, step = points[:-1, None], np.diff(points, axis=0)[:, None]
    offset, next_offset = ring - start, ahead - start
    side = step[..., 0] * offset[..., 1] - step[..., 1] * offset[..., 0]
    next_side = step[..., 0] * next_offset[..., 1] - step[..., 1] * next_offset[..., 0]
    segment, edge = np.nonzero((side >= 0) != (next_side >= 0))
    share = side[segment, edge] / (side[segment, edge] - next_side[segment, edge])
    hit = ring[edge] + share[:, None] * (ahead[edge] - ring[edge])
    along = ((hit - points[segment]) * step[segment, 0]).sum(axis=1) / _STEP
    is_hit = (along > np.where(segment == 0, least, 0.0)) & (along <= _STEP)
    if not is_hit.any():
        return None
    order = np.lexsort((along[is_hit], segment[is_hit]))
    first = np.flatnonzero(is_hit)[order[0]]
    return int(segment[first]), int(edge[first]), np.round(hit[first], DECIMALS)


def _flattened(points: Floats) -> Floats:
    """A line with fewer points, rounded."""
    kept = np.zeros(len(points), dtype=np.bool_)
    kept[[0, -1]] = True
    pending = [(0, len(points) - 1)]
    while pending:  # Douglas and Peucker
        first, last = pending.pop()
        if last - first < 2:
            continue
        chord = points[last] - points[first]
        inner = points[first + 1 : last] - points[first]
        distance = np.abs(chord[0] * inner[:, 1] - chord[1] * inner[:, 0]) / max(float(np.hypot(*chord)), 1e-9)
        farthest = int(distance.argmax())
        if distance[farthest] > _FLATNESS:
            middle = first + 1 + farthest
            kept[middle] = True
            pending += [(first, middle), (middle, last)]
    return np.round(points[kept], DECIMALS)
