"""Polygons cut along a plane, for all faces of a batch at once.

A face that leaves the kept side once is cut by the rule of Sutherland and Hodgman ("Reentrant polygon clipping", CACM
17(1), 1974): keep the corners on the kept side, and add a point where an edge passes the plane. Other faces are
rejoined along the cut, see `rejoin`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts, row_of_value, take_rows
from grammarlab.geometry.cuts.rejoin import Walk, rejoined
from grammarlab.geometry.meshes.mesh import Floats, Indices
from grammarlab.geometry.meshes.ragged import distinct_keys, next_in_row, sum_rows
from grammarlab.geometry.meshes.soup import Soup

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Cut:
    """Faces on the kept side of a plane, and the points made where edges pass it."""

    faces: Soup
    """The pieces; rows from the number of old points on are new points."""
    points: Floats
    """[Q, 3] new points in metres."""
    mesh_of_point: Indices
    """[Q] the mesh of each new point."""


def cut(faces: Soup, points: Floats, distance: Floats, normals: Floats) -> Cut:
    """The parts of faces where the distance is positive.

    Faces that share an edge get the same new point on it. The first edge of a piece is the rest of the first edge
    of its face, or otherwise the edge along the cut.

    Args:
        faces: faces with corners on both sides of the plane.
        points: [P, 3] the table of points in metres.
        distance: [P] distance of each point from the plane, positive on the kept side, exactly zero on the plane.
        normals: [M, 3] normal of the plane that cuts each mesh.
    """
    walk, made, owner = _walked(faces, points, distance)
    difficult = _leaves_often_or_touches(walk)
    if not difficult.any():
        return Cut(_remains(walk), made, owner)
    simple = _only(walk, np.flatnonzero(~difficult))
    rest = rejoined(_only(walk, np.flatnonzero(difficult)), np.concatenate((points, made)), normals)
    return Cut(Soup.together([_remains(simple), rest]), made, owner)


def _walked(faces: Soup, points: Floats, distance: Floats) -> tuple[Walk, Floats, Indices]:
    """The walk around faces, the new points [Q, 3] and their meshes [Q]."""
    following = next_in_row(faces.offsets)
    here = distance.take(faces.rows)
    there = here.take(following)
    corners = np.flatnonzero((here > 0.0) != (there > 0.0))
    start, end = here.take(corners), there.take(corners)
    passing = np.flatnonzero((start != 0.0) & (end != 0.0))
    edge_row = faces.rows.copy()
    edge_row[corners] = faces.rows.take(np.where(start == 0.0, corners, following.take(corners)))
    corners = corners.take(passing)
    new, made = _crossings(faces.rows.take(corners), faces.rows.take(following.take(corners)), points, distance)
    edge_row[corners] = new + len(points)
    owner = np.empty(len(made), np.int64)
    owner[new] = faces.mesh.take(row_of_value(np.diff(faces.offsets)).take(corners))
    return Walk(faces, following, here, edge_row), made, owner


def _crossings(start: Indices, end: Indices, points: Floats, distance: Floats) -> tuple[Indices, Floats]:
    """For directed edges [X], the number of their new point, and the new points, one for each undirected edge."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    first, number = distinct_keys(low * len(points) + high)
    low, high = low.take(first), high.take(first)
    share = distance.take(low) / (distance.take(low) - distance.take(high))
    begin = points.take(low, axis=0)
    return number, begin + share[:, None] * (points.take(high, axis=0) - begin)


def _only(walk: Walk, chosen: Indices) -> Walk:
    where, _ = take_rows(walk.faces.offsets, chosen)
    faces = walk.faces.take(chosen)
    return Walk(faces, next_in_row(faces.offsets), walk.distance.take(where), walk.edge_row.take(where))


def _leaves_often_or_touches(walk: Walk) -> Flags:
    """[F] whether faces leave the kept side more than once, or have corners on the plane without a kept neighbour."""
    offsets, following = walk.faces.offsets, walk.following
    ahead = walk.distance > 0.0
    then_ahead = ahead.take(following)
    difficult = sum_rows(ahead & ~then_ahead, offsets) > 1
    on_plane = walk.distance == 0.0
    if on_plane.any():
        beside = then_ahead.copy()
        beside[following] |= ahead
        difficult |= sum_rows(on_plane & ~beside, offsets) > 0
        difficult |= sum_rows(on_plane & on_plane.take(following), offsets) > 0
    return difficult


def _remains(walk: Walk) -> Soup:
    """Remaining parts of faces that leave the kept side once."""
    faces = walk.faces
    kept = walk.distance > 0.0
    then_kept = kept.take(walk.following)
    changes = kept != then_kept
    # Two slots per corner: the corner itself, then the point where the edge after it leaves or enters.
    filled = np.stack((kept, changes), axis=1)
    rows = np.stack((faces.rows, walk.edge_row), axis=1)[filled]
    counts = sum_rows(kept + changes.view(np.int8), faces.offsets)
    pieces = replace(faces, rows=rows, offsets=offsets_from_counts(counts))
    first = faces.offsets[:-1]
    return pieces.begun_earlier(~kept.take(first) & ~then_kept.take(first))
