"""Sides of lots: edges along streets are the front; the others are at the back, at the left or at the right.

Left and right are those of a person who stands on the street and looks at the lot. A lot is seen from above: x to the
right, z towards the viewer, outlines counter-clockwise, holes joined to them by doubled edges.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, row_of_value
from grammarlab.geometry.meshes.ragged import next_in_row, sum_rows

NO_SIDE, FRONT, BACK, LEFT, RIGHT = range(5)
"""Sides of edges and normals; `NO_SIDE` for edges without a length, bridges to holes, and vertical normals."""
Sides = NDArray[np.int8]

_COS_BACK = np.cos(np.radians(135.0))
"""Cosine of the angle to the front above which a normal looks to the back."""
_TIE = 1e-6
"""Tolerance for equal cosines: the edges of a square corner lot are at 135 degrees, whatever the rounding."""
_LEAST_MEAN = 0.1
"""Tolerance: a shorter mean of front normals gives no direction, as that of a lot between two streets."""
_FEWEST_WITH_HOLE = 8
"""Corners of a triangle with a triangular hole, joined by a bridge that is passed in both directions."""


def outward_normals(corners: Floats, offsets: Ints) -> tuple[Floats, Floats]:
    """Unit normals [P, 2] that point out of outlines at the edges that leave their corners, and the lengths [P].

    The normal of an edge without a length is zero.

    Args:
        corners: [P, 2] x and z in metres.
        offsets: [F + 1] corners of each outline.
    """
    along = corners[next_in_row(offsets)] - corners
    length = np.hypot(along[:, 0], along[:, 1])
    normals = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.where(length > 0.0, length, 1.0)[:, None]
    return normals, length


def edge_sides(corners: Floats, offsets: Ints, street_width: Floats) -> Sides:
    """[P] the side of the edge that leaves each corner of the outlines of lots.

    `FRONT` are all edges along a street. The others are classified by their outward normals against the mean normal of
    the front (`front_normals`): `BACK` at more than 135 degrees, otherwise `LEFT` or `RIGHT`. A lot without streets has
    no front.

    Args:
        corners: [P, 2] x and z in metres.
        offsets: [F + 1] corners of each outline.
        street_width: [P] width of the street along the edge that leaves each corner, 0 for no street.

    >>> corners = np.array([[0, 9.0], [5, 9], [5, 0], [0, 0]])
    >>> edge_sides(corners, np.array([0, 4]), np.array([8.0, 0, 0, 0])).tolist() == [FRONT, RIGHT, BACK, LEFT]
    True
    """
    normals, length = outward_normals(corners, offsets)
    is_edge = (length > 0.0) & ~is_bridge(corners, offsets)
    is_street = is_edge & (street_width > 0.0)
    front = _mean_normals(normals, length, offsets, is_street)
    sides = sides_of_normals(normals, front[row_of_value(np.diff(offsets))])
    return np.where(is_edge, np.where(is_street, FRONT, sides), NO_SIDE).astype(np.int8)


def front_normals(corners: Floats, offsets: Ints, street_width: Floats) -> Floats:
    """[F, 2] the direction in which the front of each lot looks.

    It is the mean outward normal of the edges along streets, weighted by their lengths, so that dividing an edge
    changes nothing. If streets on opposite sides leave no direction, it is the normal of the first edge along a street;
    for a lot without streets, that of the first edge.

    Args:
        corners: [P, 2] x and z in metres.
        offsets: [F + 1] corners of each outline.
        street_width: [P] width of the street along the edge that leaves each corner, 0 for no street.
    """
    normals, length = outward_normals(corners, offsets)
    is_street = (length > 0.0) & ~is_bridge(corners, offsets) & (street_width > 0.0)
    return _mean_normals(normals, length, offsets, is_street)


def sides_of_normals(normals: Floats, front: Floats) -> Sides:
    """[K] `BACK`, `LEFT` or `RIGHT` for directions that do not look at a street.

    Args:
        normals: [K, 2] unit vectors along x and z; zero vectors have `NO_SIDE`.
        front: [K, 2] unit direction of the front of each lot.

    >>> sides = sides_of_normals(np.array([[0.0, -1.0], [-1, 0], [1, 0], [0, 0]]), np.array([[0.0, 1.0]]))
    >>> sides.tolist() == [BACK, LEFT, RIGHT, NO_SIDE]
    True
    """
    ahead = normals[:, 0] * front[:, 0] + normals[:, 1] * front[:, 1]
    across = normals[:, 0] * front[:, 1] - normals[:, 1] * front[:, 0]
    lateral = np.where(across < -_TIE, LEFT, RIGHT)
    sides = np.where(ahead < _COS_BACK - _TIE, BACK, lateral)
    return np.where(normals.any(axis=1), sides, NO_SIDE).astype(np.int8)


def _mean_normals(normals: Floats, length: Floats, offsets: Ints, is_street: NDArray[np.bool_]) -> Floats:
    """[F, 2] see `front_normals`; ``is_street``: [P] whether each edge is along a street."""
    weight = np.where(is_street, length, 0.0)
    total = np.stack([sum_rows(weight * normals[:, axis], offsets) for axis in range(2)], axis=1)
    mean_length = np.hypot(total[:, 0], total[:, 1])
    is_clear = mean_length > _LEAST_MEAN * sum_rows(weight, offsets)
    mean = total / np.where(is_clear, mean_length, 1.0)[:, None]
    lot = row_of_value(np.diff(offsets))
    result = np.zeros((len(offsets) - 1, 2))
    # Written in reverse order, so that the first edge of a lot is kept; one along a street is better than any other.
    for candidates in (np.flatnonzero(length > 0.0)[::-1], np.flatnonzero(is_street)[::-1]):
        result[lot[candidates]] = normals[candidates]
    return np.where(is_clear[:, None], mean, result)


def is_bridge(corners: Floats, offsets: Ints) -> NDArray[np.bool_]:
    """[P] whether an outline passes the edge that leaves each corner in the other direction, too."""
    counts = np.diff(offsets)
    result = np.zeros(len(corners), dtype=bool)
    lot = row_of_value(counts)
    rows = np.flatnonzero(counts[lot] >= _FEWEST_WITH_HOLE)
    if len(rows) == 0:
        return result
    start, end = corners[rows], corners[next_in_row(offsets)[rows]]
    there = np.column_stack([lot[rows], start, end])
    back = np.column_stack([lot[rows], end, start])
    order = np.lexsort(np.concatenate([there, back]).T)
    ordered = np.concatenate([there, back])[order]
    starts_group = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))
    group = np.empty(len(order), dtype=np.int64)
    group[order] = np.cumsum(starts_group) - 1
    forward, reverse = group[: len(rows)], group[len(rows) :]
    has_reverse = np.zeros(len(order), dtype=bool)
    has_reverse[reverse] = True
    result[rows] = has_reverse[forward]
    return result
