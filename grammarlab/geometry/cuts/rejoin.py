"""Faces rejoined along a cut if they leave the kept side more than once or touch the plane.

Sorted along the cut, the k-th exit of a face is joined to its k-th entry: the gaps between them lie inside the face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts, row_of_value
from grammarlab.geometry.meshes.measure import area_vectors
from grammarlab.geometry.meshes.mesh import Floats, Indices
from grammarlab.geometry.meshes.ragged import cycles, next_in_row, sum_rows
from grammarlab.geometry.meshes.soup import Soup
from grammarlab.geometry.meshes.vectors import cross, dot

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Walk:
    """Corners of faces in cyclic order, and the plane that cuts them."""

    faces: Soup
    following: Indices
    """[C] the next corner."""
    distance: Floats
    """[C] distance of each corner from the plane, positive on the kept side."""
    edge_row: Indices
    """[C] row of the point where the edge after the corner leaves or enters the kept side; arbitrary for others."""


@dataclass(frozen=True, slots=True)
class _Gaps:
    """G gaps in what remains of faces, sorted by face and along the cut."""

    leaving: Indices
    """[G] the corner before the edge at which a gap begins."""
    entering: Indices
    """[G] the corner before the edge at which it ends."""
    start: Floats
    """[G] its beginning along the cut."""
    end: Floats
    """[G] its end along the cut, before or after `start`."""


def rejoined(walk: Walk, points: Floats, normals: Floats) -> Soup:
    """The pieces of faces on the kept side.

    Corners on the plane that lie in a gap become corners of the piece, so that it shares them with other faces.

    Args:
        walk: the corners of the faces.
        points: [P, 3] the table of points in metres, new ones included.
        normals: [M, 3] normal of the plane that cuts each mesh.
    """
    faces = walk.faces
    face = row_of_value(np.diff(faces.offsets))
    along = cross(area_vectors(faces.as_one_mesh(points)), normals[faces.mesh])
    kept = walk.distance > 0.0
    changes = kept != kept.take(walk.following)
    gaps = _gaps(walk, face, points, along)
    touching, gap, place = _corners_in_gaps(walk, face, points, along, gaps)

    # Two nodes per corner: the corner itself, then the point where the edge after it leaves or enters.
    rows = np.stack((faces.rows, walk.edge_row), axis=1).ravel()
    chains = np.flatnonzero(np.stack((kept, changes), axis=1).ravel())
    offsets = offsets_from_counts(sum_rows(kept + changes.view(np.int8), faces.offsets))
    successor = np.zeros(len(rows), np.int64)
    successor[chains] = chains.take(next_in_row(offsets))
    here, there = _bridges(gaps, touching, gap, place)
    successor[here] = there

    nodes = np.sort(np.concatenate((chains, 2 * touching)))
    renumbered = np.empty(len(rows), np.int64)
    renumbered[nodes] = np.arange(len(nodes))
    cycle, loop_offsets = cycles(renumbered[successor[nodes]])
    root = nodes[cycle[loop_offsets[:-1]]]
    source = face[root // 2]
    loops = Soup(rows[nodes[cycle]], loop_offsets, faces.mesh[source], faces.place[source], faces.tags[source])
    # The rest of the first edge of a face is its first node, if that belongs to its first corner.
    has_first = (root == chains[offsets[:-1]][source]) & (root // 2 == faces.offsets[:-1][source])
    return loops.begun_earlier(~has_first).without_repeats()


def _bridges(gaps: _Gaps, touching: Indices, gap: Indices, place: Floats) -> tuple[Indices, Indices]:
    """Nodes across the gaps and the node that follows each: from the exit over the touching corners to the entry."""
    number = np.arange(len(gaps.leaving))
    nodes = np.concatenate((2 * gaps.leaving + 1, 2 * touching, 2 * gaps.entering + 1))
    of_gap = np.concatenate((number, gap, number))
    far = np.full(len(number), np.inf)
    order = np.lexsort((np.concatenate((-far, place, far)), of_gap))
    goes_on = np.flatnonzero(np.diff(of_gap[order]) == 0)
    return nodes[order[goes_on]], nodes[order[goes_on + 1]]


def _gaps(walk: Walk, face: Indices, points: Floats, along: Floats) -> _Gaps:
    kept = walk.distance > 0.0
    then_kept = kept.take(walk.following)
    ends = []
    for corners in (np.flatnonzero(kept & ~then_kept), np.flatnonzero(~kept & then_kept)):
        here, there = walk.faces.rows[corners], walk.faces.rows[walk.following[corners]]
        inner, outer = np.where(kept[corners], here, there), np.where(kept[corners], there, here)
        direction = along[face[corners]]
        depth = np.abs(walk.distance[walk.following[corners]] - walk.distance[corners])
        # Edges that meet the plane in one point are sorted by their position slightly further inside.
        drift = dot(points[inner] - points[outer], direction) / depth
        place = dot(points[walk.edge_row[corners]], direction)
        order = np.lexsort((drift, place, face[corners]))
        ends.append((corners[order], place[order]))
    (leaving, start), (entering, end) = ends
    return _Gaps(leaving, entering, start, end)


def _corners_in_gaps(
    walk: Walk, face: Indices, points: Floats, along: Floats, gaps: _Gaps
) -> tuple[Indices, Indices, Floats]:
    """Corners [T] on the plane within a gap, the gap of each, and its position in the gap."""
    on_plane = walk.distance == 0.0
    on_plane[walk.following[gaps.leaving]] = False
    on_plane[gaps.entering] = False
    corner = np.flatnonzero(on_plane)
    place = dot(points[walk.faces.rows[corner]], along[face[corner]])
    low, high = np.minimum(gaps.start, gaps.end), np.maximum(gaps.start, gaps.end)

    # A sweep along the cut of each face; at one place gaps end first and begin last.
    gap_face = face[gaps.leaving]
    count, spare = len(gap_face), len(corner)
    kind = np.repeat([0, 1, 2], [count, spare, count])
    order = np.lexsort((kind, np.concatenate((high, place, low)), np.concatenate((gap_face, face[corner], gap_face))))
    is_open = np.cumsum(np.array([-1, 0, 1])[kind[order]])
    latest = np.maximum.accumulate(np.where(kind[order] == 2, np.arange(len(order)), -1))
    inside = np.flatnonzero((kind[order] == 1) & (is_open == 1))
    gap = order[latest[inside]] - count - spare
    chosen = order[inside] - count
    return corner[chosen], gap, np.abs(place[chosen] - gaps.start[gap])
