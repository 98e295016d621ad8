"""Edges and corners of each face separately: CGA's ``comp(fe)`` and ``comp(fv)``.

Frames follow CGA. x runs along the outline in the direction of the face (for a corner: half way between its two
edges), y is the face's normal, z points out of the face in its plane.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import index_in_row
from grammarlab.geometry.meshes.edges import edges as edge_table
from grammarlab.geometry.meshes.measure import corner_edges, face_normals
from grammarlab.geometry.meshes.mesh import Floats, Indices, Meshes
from grammarlab.geometry.meshes.ragged import next_in_row
from grammarlab.geometry.meshes.vectors import has_length, norm, unit
from grammarlab.geometry.parts.components import ComponentMeshes, frames
from grammarlab.geometry.parts.roof_edges import NO_ROOF_EDGE


def face_edges(meshes: Meshes) -> ComponentMeshes:
    """Every edge of every face, in the order of their first corners; shared edges once per face.

    Bridges between an outline and its hole are left out.
    """
    table = edge_table(meshes)
    rows = np.flatnonzero(table.edge_of_corner >= 0)
    start, along, normals = _around_faces(meshes)
    along, normals, start = along.take(rows, axis=0), normals.take(rows, axis=0), start.take(rows, axis=0)
    length = norm(along)
    points = np.zeros((2 * len(rows), 3))
    points[1::2, 0] = length
    size = np.zeros((len(rows), 3))
    size[:, 0] = length
    boundary = table.is_boundary[table.edge_of_corner[rows]]
    parts = Meshes.from_polygons(points, np.full(len(rows), 2))
    return _beside_faces(meshes, rows, parts, along, normals, start, size, boundary)


def face_vertices(meshes: Meshes) -> ComponentMeshes:
    """Every corner of every face, in their order."""
    table = edge_table(meshes)
    start, along, normals = _around_faces(meshes)
    count = len(start)
    direction = unit(along)
    following = next_in_row(meshes.face_offsets)
    arriving = np.empty_like(direction)
    arriving[following] = direction
    tangent = unit(direction + arriving)
    # An outline that turns straight back has no tangent: the leaving edge decides.
    tangent = np.where(has_length(tangent), tangent, direction)
    at_border = np.zeros(len(meshes.points), bool)
    at_border[table.start[table.is_boundary]] = True
    at_border[table.end[table.is_boundary]] = True
    parts = Meshes.from_polygons(np.zeros((count, 3)), np.ones(count, np.int64))
    border = at_border[meshes.corner_points()]
    return _beside_faces(meshes, np.arange(count), parts, tangent, normals, start, np.zeros((count, 3)), border)


def _around_faces(meshes: Meshes) -> tuple[Floats, Floats, Floats]:
    """[C, 3] each corner, the edge that leaves it, and the normal of its face."""
    normals = face_normals(meshes).take(meshes.face_of_corner(), axis=0)
    return meshes.points.take(meshes.corner_points(), axis=0), corner_edges(meshes), normals


def _beside_faces(
    meshes: Meshes,
    corners: Indices,
    parts: Meshes,
    x: Floats,
    y: Floats,
    start: Floats,
    size: Floats,
    is_border: NDArray[np.bool_],
) -> ComponentMeshes:
    """Components at corners [K] of faces: x along the outline, y the face's normal, z out of the face."""
    across = frames(y, x)
    rotation = np.stack((across[:, :, 0], across[:, :, 2], -across[:, :, 1]), axis=2)
    mesh = meshes.mesh_of_face()[meshes.face_of_corner()[corners]]
    return ComponentMeshes(
        mesh=mesh,
        index=index_in_row(np.bincount(mesh, minlength=len(meshes))),
        shapes=parts,
        rotation=rotation,
        origin=start,
        pivot=start,
        size=size,
        direction=rotation[:, :, 2],
        is_border=is_border,
        roof_edge=np.full(len(corners), NO_ROOF_EDGE, np.int8),
    )
