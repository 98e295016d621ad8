"""Table of the undirected edges of meshes, for boundary tests, edge components and roof selectors."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, row_lengths
from grammarlab.geometry.meshes.measure import area_vectors
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.ragged import any_rows, next_in_row
from grammarlab.geometry.meshes.vectors import cross, dot, norm

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Edges:
    """E undirected edges, in the order of their first occurrence in a walk around all faces."""

    mesh: Indices
    """[E] mesh of the edge, ascending."""
    corner: Indices
    """[E] the corner from which the first face runs along it."""
    start: Indices
    """[E] row of `points` at that corner."""
    end: Indices
    """[E] row of `points` at the next corner."""
    faces: Indices
    """[E, 2] the first two faces at the edge; -1 for a missing second face."""
    num_faces: Indices
    """[E] number of faces at the edge: 1 on the boundary, 2 inside, more if the mesh is not a manifold."""
    edge_of_corner: Indices
    """[C] the edge that leaves each corner; -1 for the bridge between an outline and its hole."""

    def __len__(self) -> int:
        return len(self.mesh)

    @property
    def is_boundary(self) -> NDArray[np.bool_]:
        """[E] whether only one face has this edge."""
        return self.num_faces == 1


def edges(meshes: Meshes) -> Edges:
    """The edges of all meshes. Bridges (both sides of an edge in one face) are left out."""
    start = meshes.corner_points()
    end = start.take(next_in_row(meshes.face_offsets))
    face = meshes.face_of_corner()
    key = np.minimum(start, end) * max(len(meshes.points), 1) + np.maximum(start, end)
    order = np.argsort(key)
    is_first = np.diff(key.take(order), prepend=-1) != 0
    first = np.flatnonzero(is_first)
    counts = np.diff(np.append(first, len(order)))
    first_corner, second_corner = _lowest_two(order, first, counts)
    second_face = np.where(counts > 1, face[second_corner], -1)
    is_edge = second_face != face[first_corner]

    rank = np.full(len(first), -1, np.int64)
    by_encounter = np.flatnonzero(is_edge)[np.argsort(first_corner[is_edge])]
    rank[by_encounter] = np.arange(len(by_encounter))
    edge_of_corner = np.empty(len(order), np.int64)
    edge_of_corner[order] = rank[np.cumsum(is_first) - 1]

    corner = first_corner[by_encounter]
    return Edges(
        mesh=meshes.mesh_of_face()[face[corner]],
        corner=corner,
        start=start[corner],
        end=end[corner],
        faces=np.column_stack((face[corner], second_face[by_encounter])),
        num_faces=counts[by_encounter],
        edge_of_corner=edge_of_corner,
    )


def _lowest_two(values: Indices, starts: Indices, counts: Indices) -> tuple[Indices, Indices]:
    """The smallest two values of each row of a ragged list; a single value is repeated."""
    if not len(starts):
        return starts, starts
    lowest = np.minimum.reduceat(values, starts)
    remaining = values.copy()
    crowded = np.repeat(counts > 1, counts)
    remaining[crowded & (values == np.repeat(lowest, counts))] = np.iinfo(np.int64).max
    return lowest, np.minimum.reduceat(remaining, starts)


def num_edges(meshes: Meshes) -> Indices:
    """[M] undirected edges of each mesh."""
    return np.bincount(edges(meshes).mesh, minlength=len(meshes))


def num_holes(meshes: Meshes) -> Indices:
    """[M] holes in the faces of each mesh: each has one bridge, which its face passes in both directions."""
    bridges = edges(meshes).edge_of_corner < 0
    owner = meshes.mesh_of_face()[meshes.face_of_corner()[bridges]]
    return np.bincount(owner, minlength=len(meshes)) // 2


def in_rings(meshes: Meshes, edge_of_corner: Indices) -> tuple[Indices, Flags]:
    """Corners from which edges leave, face by face: first those of its outline, then those of its holes.

    Args:
        meshes: M meshes.
        edge_of_corner: `Edges.edge_of_corner` of them.

    Returns:
        [K] the corners, and whether the edge that leaves each is one of a hole.
    """
    is_bridge = edge_of_corner < 0
    corners = np.flatnonzero(~is_bridge)
    ring = np.zeros(len(is_bridge), np.int64)
    if not is_bridge.any():
        return corners, ring > 0
    here, following, of_corner = meshes.corner_points(), next_in_row(meshes.face_offsets), meshes.face_of_corner()
    turn = np.where(is_bridge, 0.0, _turning(meshes, here, following, of_corner))
    for face in np.unique(of_corner[is_bridge]).tolist():
        num_rings = 1
        # The rings that the walk is within, each entered over the bridge between these points.
        inside = [(0, frozenset[int]())]
        walk = slice(meshes.face_offsets[face], meshes.face_offsets[face + 1])
        for corner in range(walk.start, walk.stop):
            ends = frozenset((int(here[corner]), int(here[following[corner]])))
            if not is_bridge[corner]:
                ring[corner] = inside[-1][0]
            elif inside[-1][1] == ends:
                inside.pop()
            else:
                inside.append((num_rings, ends))
                num_rings += 1
        # A face may begin on a hole, but only its outline turns as its normal does.
        outline = int(np.argmax(np.bincount(ring[walk], turn[walk])))
        ring[walk] = np.where(ring[walk] == outline, 0, ring[walk] + (ring[walk] < outline))
    corners = corners[np.lexsort((ring[corners], of_corner[corners]))]
    return corners, ring[corners] > 0


def _turning(meshes: Meshes, here: Indices, following: Indices, face: Indices) -> Floats:
    """[C] what the edge that leaves each corner adds to the area of its ring, positive along the face normal."""
    arm = meshes.points[here] - meshes.points[here[meshes.face_offsets[:-1][face]]]
    return dot(cross(arm, arm[following]), area_vectors(meshes)[face])


def is_closed_surface(meshes: Meshes) -> NDArray[np.bool_]:
    """[M] whether a mesh has faces and each of its edges belongs to exactly two."""
    table = edges(meshes)
    closed = row_lengths(meshes.mesh_faces) > 0
    closed[table.mesh[table.num_faces != 2]] = False
    return closed


def joined(meshes: Meshes, chosen: NDArray[np.bool_] | None = None) -> Meshes:
    """Meshes of which the chosen ones [M], by default all, use one point where they have several at one position."""
    of_point = meshes.mesh_of_point()
    rows = np.arange(len(of_point)) if chosen is None else np.flatnonzero(chosen[of_point])
    keys = np.column_stack((of_point[rows], meshes.points[rows] + 0.0))
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    row = np.arange(len(of_point))
    row[rows] = rows[first[number.ravel()]]
    base = meshes.mesh_points[:-1][meshes.mesh_of_corner()]
    return replace(meshes, corners=row[meshes.corner_points()] - base)


def boundary_lengths(meshes: Meshes) -> Floats:
    """[M] summed lengths, in metres, of the edges that only one face has."""
    table = edges(meshes)
    lengths = np.where(table.is_boundary, norm(meshes.points[table.end] - meshes.points[table.start]), 0.0)
    return np.bincount(table.mesh, lengths, len(meshes)).astype(np.float64)


def faces_at_boundary(meshes: Meshes, table: Edges) -> NDArray[np.bool_]:
    """[F] whether a face has an edge that no other face shares."""
    is_edge = table.edge_of_corner >= 0
    at_boundary = (
        is_edge & table.is_boundary[np.where(is_edge, table.edge_of_corner, 0)] if len(table) else is_edge & False
    )
    return any_rows(at_boundary, meshes.face_offsets)
