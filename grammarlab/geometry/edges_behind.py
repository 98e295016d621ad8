"""Edges of outlines behind segments and ahead of points: which edge a wall is on or looks at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints, row_of_value, take_rows

TIE = 1e-6
"""Tolerance for equal cosines of angles between directions."""
_LEAST_TURN = 1e-6
"""Tolerance: a smaller component of an outward vector across its segment comes from rounding."""
_PARALLEL = 1e-9
"""Sine of the angle between a direction and an edge below which the edge is not hit."""
_END = 1e-9
"""Tolerance of hits at the ends of an edge, as a share of its length."""


@dataclass(frozen=True, slots=True)
class EdgeSets:
    """O sets of directed edges in the plane, each with its label; their outer side is that of `lot_sides`."""

    start: Floats
    """[S, 2] x and z in metres."""
    end: Floats
    """[S, 2] x and z in metres."""
    label: NDArray[np.int8]
    """[S] label of each edge, above 0."""
    offsets: Ints
    """[O + 1] edges of each set."""


@dataclass(frozen=True, slots=True)
class OutwardSegments:
    """K segments in the plane, each in front of the edges of one set; a segment without a length is a point."""

    start: Floats
    """[K, 2] x and z in metres."""
    end: Floats
    """[K, 2] x and z in metres."""
    outward: Floats
    """[K, 2] vectors towards the outer side of each segment; zero where it has none."""
    outline: Ints
    """[K] its set of edges."""
    tolerance: Floats
    """[K] metres by which points may miss an edge."""

    def is_point(self) -> Flags:
        """[K] whether a segment has no length."""
        return _length(self.end - self.start) <= self.tolerance

    def normals(self) -> Floats:
        """[K, 2] unit normals on the outer sides, of points the outward directions; zero without an outer side."""
        across = across_edges(self.end - self.start)
        turn = _dot(across, self.outward)
        sign = np.where(np.abs(turn) > _LEAST_TURN, np.sign(turn), 0.0)
        outward = self.outward / np.maximum(_length(self.outward), _LEAST_TURN)[:, None]
        return np.where(self.is_point()[:, None], outward, across * sign[:, None])


@dataclass(frozen=True, slots=True)
class EdgesBehind:
    """Edges behind K segments."""

    label: NDArray[np.int8]
    """[K] label of the edge, 0 for none."""
    distance: Floats
    """[K] metres from the edge to the segment in front of it, 0 on the edge; infinite for none."""
    overlap: Floats
    """[K] metres of the edge that the segment is in front of; 0 for a point."""


def edges_behind(segments: OutwardSegments, outlines: EdgeSets) -> EdgesBehind:
    """For each segment the nearest edge behind it that is parallel to it and looks in the same direction.

    Of edges at the same distance, the one that it is in front of for the greatest length is taken, then the first.
    """
    edge, offsets = take_rows(outlines.offsets, segments.outline)
    segment = row_of_value(np.diff(offsets))
    origin = outlines.start[edge]
    normal = across_edges(outlines.end[edge] - origin)
    along = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    length = _dot(along, outlines.end[edge] - origin)
    tolerance, is_point = segments.tolerance[segment], segments.is_point()[segment]
    first, second = segments.start[segment] - origin, segments.end[segment] - origin
    near, far = _dot(normal, first), _dot(normal, second)
    a, b = _dot(along, first), _dot(along, second)
    overlap = np.minimum(np.maximum(a, b), length) - np.maximum(np.minimum(a, b), 0.0)
    cosine = _dot(normal, segments.normals()[segment])
    fits = (np.abs(near - far) <= tolerance) & (near >= -tolerance)
    fits &= np.where(is_point, (cosine > 1.0 - TIE) & (overlap >= -tolerance), (cosine > 0.0) & (overlap > tolerance))
    rows = np.flatnonzero(fits)
    distance = np.where(near[rows] <= tolerance[rows], 0.0, near[rows])
    overlap = np.where(is_point[rows], 0.0, overlap[rows])
    best = _best(segment[rows], np.rint(distance / tolerance[rows]), overlap)
    count = len(segments.start)
    result = EdgesBehind(np.zeros(count, np.int8), np.full(count, np.inf), np.zeros(count))
    where = segment[rows[best]]
    result.label[where] = outlines.label[edge[rows[best]]]
    result.distance[where] = distance[best]
    result.overlap[where] = overlap[best]
    return result


def best_of_groups(behind: EdgesBehind, group: Ints, num_groups: int) -> NDArray[np.int8]:
    """[G] the label of the nearest edge behind a segment of each group, then of the greatest overlap; 0 for none.

    Args:
        behind: edges behind K segments; points do not count.
        group: [K] the group of each segment.
        num_groups: G.
    """
    rows = np.flatnonzero((behind.label > 0) & (behind.overlap > 0.0))
    labels = np.zeros(num_groups, np.int8)
    best = rows[_best(group[rows], behind.distance[rows], behind.overlap[rows])]
    labels[group[best]] = behind.label[best]
    return labels


def edges_that_look_alike(
    normals: Floats, outline: Ints, outlines: EdgeSets, least_cosine: float = -1.0
) -> NDArray[np.int8]:
    """[K] the label of the edge whose outward normal is nearest to a direction, of equal ones the first; 0 for none.

    Args:
        normals: [K, 2] unit vectors, or zero.
        outline: [K] the set of edges of each.
        outlines: the sets.
        least_cosine: smallest cosine of the angle between the two.
    """
    edge, offsets = take_rows(outlines.offsets, outline)
    owner = row_of_value(np.diff(offsets))
    cosine = _dot(across_edges(outlines.end[edge] - outlines.start[edge]), normals[owner])
    largest = np.full(len(normals), -np.inf)
    np.maximum.at(largest, owner, cosine)
    is_nearest = (cosine >= largest[owner] - TIE) & (cosine >= least_cosine - TIE)
    rows = np.flatnonzero(is_nearest & normals[owner].any(axis=1))[::-1]
    labels = np.zeros(len(normals), np.int8)
    labels[owner[rows]] = outlines.label[edge[rows]]
    return labels


def _dot(a: Floats, b: Floats) -> Floats:
    """[K] scalar products, written out so that a row has the same last bits in every batch."""
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]


def _length(vectors: Floats) -> Floats:
    """[K] lengths of vectors."""
    return np.sqrt(_dot(vectors, vectors))


def across_edges(vectors: Floats) -> Floats:
    """[K, 2] unit vectors across vectors, on the outer side of an outline that runs along them; zero for zero."""
    length = _length(vectors)
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=1) / np.where(length > 0.0, length, 1.0)[:, None]


def _best(group: Ints, distance: Floats, overlap: Floats) -> Ints:
    """The row of the smallest distance in each group that occurs, then of the largest overlap, then the first."""
    order = np.lexsort((-overlap, distance, group))
    is_first: Flags = np.diff(group[order], prepend=-1) != 0
    return order[is_first]


def edges_ahead(
    points: Floats, directions: Floats, groups: Ints, edges: EdgeSets, least: Floats
) -> tuple[Ints, Floats]:
    """The first edge ahead of each point, -1 for none, and its distance [K] in metres, infinite for none.

    Args:
        points: [K, 2] x and z in metres.
        directions: [K, 2] unit vectors in which to look.
        groups: [K] the set of edges to look at.
        edges: the sets.
        least: [K] smallest distance in metres at which an edge counts.
    """
    edge, offsets = take_rows(edges.offsets, groups)
    point = row_of_value(np.diff(offsets))
    to_edge, along = edges.start[edge] - points[point], edges.end[edge] - edges.start[edge]
    direction = directions[point]
    turn = _cross(direction, along)
    is_hit = np.abs(turn) > _PARALLEL * np.hypot(along[:, 0], along[:, 1])
    divisor = np.where(is_hit, turn, 1.0)
    distance, share = _cross(to_edge, along) / divisor, _cross(to_edge, direction) / divisor
    is_hit &= (distance > least[point]) & (share >= -_END) & (share <= 1.0 + _END)
    rows = np.flatnonzero(is_hit)
    order = rows[np.lexsort((distance[rows], point[rows]))]
    first = order[np.diff(point[order], prepend=-1) != 0]
    nearest, nearest_distance = np.full(len(points), -1), np.full(len(points), np.inf)
    nearest[point[first]], nearest_distance[point[first]] = edge[first], distance[first]
    return nearest, nearest_distance


def _cross(a: Floats, b: Floats) -> Floats:
    """[K] vector products of vectors in the plane."""
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
