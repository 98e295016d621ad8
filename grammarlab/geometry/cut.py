"""Polygons cut along a plane, for all faces of a batch at once.

A face that leaves the kept side once is cut by the rule of Sutherland and Hodgman ("Reentrant polygon clipping", CACM
17(1), 1974): keep the corners on the kept side, and add a point where an edge passes the plane. A face that leaves it
more often falls into several pieces: sorted along the cut, its k-th exit is joined to its k-th entry.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import index_in_row, offsets_from_counts, row_of_value, take_rows
from grammarlab.geometry.measure import area_vectors
from grammarlab.geometry.mesh import Floats, Indices
from grammarlab.geometry.ragged import any_rows, cycles, next_in_row, sum_rows
from grammarlab.geometry.soup import Soup
from grammarlab.geometry.vectors import cross, dot

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


@dataclass(frozen=True, slots=True)
class _Walk:
    """The corners of faces on their way round, and what the plane does to the edge after each of them."""

    faces: Soup
    points: Floats
    """[P, 3] the table of points."""
    distance: Floats
    """[C] of each corner from the plane."""
    following: Indices
    """[C] the next corner."""
    passes: Flags
    """[C] whether the edge after the corner passes through the plane."""
    crossing: Floats
    """[X, 3] where, for the edges that pass."""


def cut(faces: Soup, points: Floats, distance: Floats, normals: Floats) -> Cut:
    """The parts of faces where the distance is not negative.

    Faces that share an edge get the same new point on it. The first edge of a piece is what is left of the first edge
    of its face, or else the edge along the cut.

    Args:
        faces: faces with corners on both sides of the plane.
        points: [P, 3] the table of points in metres.
        distance: [P] of each point from the plane, positive on the kept side, exactly zero on the plane.
        normals: [M, 3] normal of the plane that cuts each mesh.
    """
    following = next_in_row(faces.offsets)
    here = distance[faces.rows]
    passes = here * here[following] < 0.0
    corners = np.flatnonzero(passes)
    new_row, made = _crossings(faces.rows[corners], faces.rows[following[corners]], points, distance)
    owner = np.empty(len(made), np.int64)
    face_of_corner = row_of_value(np.diff(faces.offsets))
    owner[new_row] = faces.mesh[face_of_corner[corners]]

    # Two slots a corner: the corner itself, then the point where the edge after it passes the plane.
    kept = here >= 0.0
    slots = np.zeros((len(here), 2), np.int64)
    slots[:, 0] = faces.rows
    slots[corners, 1] = new_row + len(points)
    filled = np.empty((len(here), 2), bool)
    filled[:, 0], filled[:, 1] = kept, passes
    counts = sum_rows(kept.astype(np.int64) + passes, faces.offsets)
    pieces = replace(faces, rows=slots[filled], offsets=offsets_from_counts(counts))

    first = faces.offsets[:-1]
    lost_first = (here[first] < 0.0) & (here[first + 1] <= 0.0)
    exits = kept & ~kept[following]
    broken = sum_rows(exits.astype(np.int64), faces.offsets) > 1
    if not broken.any():
        return Cut(_turned(pieces, lost_first), made, owner)
    walk = _Walk(faces, points, here, following, passes, made[new_row])
    in_broken = broken[face_of_corner]
    leaving, entering = np.flatnonzero(exits & in_broken), np.flatnonzero(~kept & kept[following] & in_broken)
    item = np.cumsum(filled.ravel()) - 1
    successor = next_in_row(pieces.offsets)
    last = item[2 * leaving + passes[leaving]]
    next_entry = item[np.where(passes[entering], 2 * entering + 1, 2 * following[entering])]
    successor[last[_order_along_cut(walk, leaving, normals)]] = next_entry[_order_along_cut(walk, entering, normals)]

    is_ahead = np.append(distance, np.zeros(len(made)))[pieces.rows] > 0.0
    whole = _turned(pieces.take(np.flatnonzero(~broken)), lost_first[~broken])
    split = _loops(pieces, np.flatnonzero(broken), successor, is_ahead, lost_first)
    return Cut(Soup.together([whole, split]), made, owner)


def _crossings(start: Indices, end: Indices, points: Floats, distance: Floats) -> tuple[Indices, Floats]:
    """For directed edges [X], the number of their new point, and the new points, one for each undirected edge."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, first, number = np.unique(low * len(points) + high, return_index=True, return_inverse=True)
    low, high = low[first], high[first]
    share = distance[low] / (distance[low] - distance[high])
    return number, points[low] + share[:, None] * (points[high] - points[low])


def _order_along_cut(walk: _Walk, corners: Indices, normals: Floats) -> Indices:
    """The edges after these corners, which all leave or all enter, sorted by face and along the cut.

    Two edges that meet the plane in one place are sorted by where they would meet it a little further out.
    """
    faces = walk.faces
    face = row_of_value(np.diff(faces.offsets))[corners]
    along = cross(area_vectors(faces.as_one_mesh(walk.points)), normals[faces.mesh])[face]
    start, end = faces.rows[corners], faces.rows[walk.following[corners]]
    leaves = walk.distance[corners] >= 0.0
    inner, outer = np.where(leaves, start, end), np.where(leaves, end, start)
    depth = np.abs(walk.distance[walk.following[corners]] - walk.distance[corners])
    drift = dot(walk.points[outer] - walk.points[inner], along) / depth
    place = walk.points[inner]
    number = np.cumsum(walk.passes) - 1
    through = walk.passes[corners]
    place[through] = walk.crossing[number[corners[through]]]
    return np.lexsort((drift, dot(place, along), face))


def _loops(pieces: Soup, broken: Indices, successor: Indices, is_ahead: Flags, lost_first: Flags) -> Soup:
    """The pieces of broken faces: the cycles of `successor` among their corners, without those that have no area."""
    where, offsets = take_rows(pieces.offsets, broken)
    renumbered = np.empty(len(successor), np.int64)
    renumbered[where] = np.arange(len(where))
    order, loop_offsets = cycles(renumbered[successor[where]])
    face = row_of_value(np.diff(offsets))[order[loop_offsets[:-1]]]
    starts_face = order[loop_offsets[:-1]] == offsets[:-1][face]
    solid = any_rows(is_ahead[where[order]], loop_offsets) & (np.diff(loop_offsets) >= 3)
    source = broken[face]
    loops = Soup(
        pieces.rows[where[order]],
        loop_offsets,
        pieces.mesh[source],
        pieces.place[source],
        pieces.tags[source],
    )
    return _turned(loops, lost_first[source] | ~starts_face).take(np.flatnonzero(solid))


def _turned(faces: Soup, turn: Flags) -> Soup:
    """Faces of which some begin one corner earlier."""
    if not turn.any():
        return faces
    counts = np.diff(faces.offsets)
    place = index_in_row(counts)
    face = row_of_value(counts)
    source = np.where(turn[face], (place - 1) % counts[face], place) + faces.offsets[:-1][face]
    return replace(faces, rows=faces.rows[source])
