"""Unique meshes as triangles with shading normals.

Facets are flat, and smooth where faces meet at less than a crease angle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, connected, offsets_from_counts, take_rows
from grammarlab.geometry.meshes.measure import area_vectors
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.ragged import next_in_row
from grammarlab.geometry.meshes.triangulate import triangulate
from grammarlab.scene.instances import Scene

_AXIS_TOLERANCE = 1e-9
"""Largest distance from an axis of a normal that keeps its direction under any size along the axes."""


@dataclass(frozen=True, slots=True)
class ShadedMeshes:
    """M meshes whose vertices each have one position and one normal.

    Faces that meet smoothly share vertices; across a crease each side has its own. Every mesh's vertices and
    triangles are contiguous.
    """

    points: Floats
    """[V, 3] metres, or unit-cube coordinates."""
    normals: Floats
    """[V, 3] unit vectors."""
    triangles: Ints
    """[T, 3] vertices, counted from the first vertex of their own mesh; counter-clockwise from outside."""
    mesh_vertices: Ints
    """[M + 1] into vertices."""
    mesh_triangles: Ints
    """[M + 1] into triangles."""
    axis_aligned: NDArray[np.bool_]
    """[M] whether every normal of the mesh is along an axis, as in boxes and upright rectangles."""
    corners: Ints
    """[C] vertices of the corners of the faces that the triangles cover, counted as in `triangles`."""
    face_offsets: Ints
    """[F + 1] into `corners`."""
    mesh_faces: Ints
    """[M + 1] into faces."""
    triangle_faces: Ints
    """[T] the face that each triangle covers with others, ascending."""
    coordinates: Floats | None = None
    """[V, 2] u and v of the vertices, v upwards; None if they follow from texture maps."""
    corner_coordinates: Floats | None = None
    """[V, 2] u and v that files of meshes gave the vertices, v upwards, NaN for none; None if no file gave any."""


def shaded_meshes(scene: Scene, chosen: NDArray[np.integer], crease_angle: float) -> ShadedMeshes:
    """Selected meshes [M] of a scene with the surface of their points, or else as `shade` sees them."""
    meshes = scene.meshes.take(chosen)
    if scene.surface is None:
        return shade(meshes, crease_angle)
    point, mesh_points = take_rows(scene.meshes.mesh_points, chosen)
    normals = scene.surface.normals.take(point, axis=0)
    return ShadedMeshes(
        points=meshes.points,
        normals=normals,
        triangles=meshes.corners.reshape(-1, 3),
        mesh_vertices=mesh_points,
        mesh_triangles=meshes.mesh_faces,
        axis_aligned=_axis_aligned(normals, mesh_points),
        corners=meshes.corners,
        face_offsets=meshes.face_offsets,
        mesh_faces=meshes.mesh_faces,
        triangle_faces=np.arange(meshes.num_faces),
        coordinates=scene.surface.coordinates.take(point, axis=0),
    )


def shade(meshes: Meshes, crease_angle: float) -> ShadedMeshes:
    """Triangles and normals of each mesh, computed once for all instances of the mesh.

    Two faces that share an edge and turn by less than `crease_angle` share their normals at its ends: the mean of the
    faces around, weighted by area.

    Args:
        meshes: polygon meshes, in metres or in the unit cube.
        crease_angle: radians in 0..pi, measured on the meshes as given; 0 shades every face flat.
    """
    triangles, face_of_triangle = triangulate(meshes)

    point, face = meshes.corner_points(), meshes.face_of_corner()
    num_points = max(len(meshes.points), 1)
    # A keyhole polygon visits a point twice within one face: both visits are the same vertex.
    corner_keys, corner = np.unique(face * num_points + point, return_inverse=True)
    outward = area_vectors(meshes)
    vertex_of_corner = _smooth_groups(meshes, point, face, corner, outward, crease_angle)

    num_vertices = int(vertex_of_corner.max(initial=-1)) + 1
    first_corner = np.full(num_vertices, len(corner_keys), dtype=np.int64)
    np.minimum.at(first_corner, vertex_of_corner, np.arange(len(corner_keys)))
    vertex_key = corner_keys[first_corner]
    corner_face = corner_keys // num_points
    normals = _unit_or_up(_sums(vertex_of_corner, outward[corner_face], num_vertices))

    coordinates = None
    if meshes.data is not None:
        place = np.zeros(len(corner_keys), np.int64)
        place[corner] = np.arange(len(corner))
        divided = _divided(vertex_of_corner, meshes.data.values[place, :5], normals)
        vertex_of_corner, normals, coordinates = divided.vertex, divided.normals, divided.coordinates
        vertex_key = corner_keys[divided.first]

    mesh_of_face = meshes.mesh_of_face()
    mesh_vertices = offsets_from_counts(np.bincount(mesh_of_face[vertex_key // num_points], minlength=len(meshes)))
    mesh_of_triangle = mesh_of_face[face_of_triangle]
    mesh_triangles = offsets_from_counts(np.bincount(mesh_of_triangle, minlength=len(meshes)))
    corner_keys_of_triangles = face_of_triangle[:, None] * num_points + triangles
    vertices = vertex_of_corner[np.searchsorted(corner_keys, corner_keys_of_triangles)].reshape(-1, 3)
    return ShadedMeshes(
        points=meshes.points[vertex_key % num_points],
        normals=normals,
        triangles=vertices - mesh_vertices[mesh_of_triangle][:, None],
        mesh_vertices=mesh_vertices,
        mesh_triangles=mesh_triangles,
        axis_aligned=_axis_aligned(normals, mesh_vertices),
        corners=vertex_of_corner[corner] - mesh_vertices[mesh_of_face][face],
        face_offsets=meshes.face_offsets,
        mesh_faces=meshes.mesh_faces,
        triangle_faces=face_of_triangle,
        corner_coordinates=coordinates,
    )


class _Divided(NamedTuple):
    """Vertices divided where files gave their corners different normals or texture coordinates."""

    vertex: Ints
    """[K] vertex of each distinct corner, numbered in order of first appearance."""
    first: Ints
    """[V] first distinct corner of each vertex."""
    normals: Floats
    """[V, 3] unit vectors."""
    coordinates: Floats | None
    """[V, 2] NaN for none; None if there are no coordinates at all."""


def _divided(vertex_of_corner: Ints, values: Floats, normals: Floats) -> _Divided:
    """Vertices with one normal and one pair of coordinates each.

    Args:
        vertex_of_corner: [K] vertex of each distinct corner.
        values: [K, 3 or 5] normal of any length, u and v of the corners in a file; NaN for none.
        normals: [V, 3] unit normals of the vertices.
    """
    key = np.column_stack([vertex_of_corner, np.where(np.isnan(values), np.inf, values)])
    _, first, vertex = np.unique(key, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    first, vertex = first[order], rank[vertex.ravel()]
    of_file = values[first, :3]
    length = np.sqrt((of_file**2).sum(axis=1))
    known = length > 0.0
    own = of_file / np.where(known, length, 1.0)[:, None]
    coordinates = values[first, 3:5] if values.shape[1] > 3 and np.isfinite(values[:, 3:5]).any() else None
    return _Divided(vertex, first, np.where(known[:, None], own, normals[vertex_of_corner[first]]), coordinates)


def _smooth_groups(meshes: Meshes, point: Ints, face: Ints, corner: Ints, outward: Floats, crease_angle: float) -> Ints:
    """The vertex of each distinct (face, point), numbered in order of first appearance."""
    num_corners = int(corner.max(initial=-1)) + 1
    following = next_in_row(meshes.face_offsets)
    low, high = np.minimum(point, point[following]), np.maximum(point, point[following])
    edge = low * max(len(meshes.points), 1) + high
    order = np.argsort(edge, kind="stable")
    shared = np.flatnonzero(edge[order][:-1] == edge[order][1:])
    first, second = order[shared], order[shared + 1]
    normals = _unit_or_up(outward)
    turn = np.einsum("ij,ij->i", normals[face[first]], normals[face[second]])
    solid = np.einsum("ij,ij->i", outward, outward) > 0
    smooth = (turn > np.cos(crease_angle)) & solid[face[first]] & solid[face[second]]
    first, second = first[smooth], second[smooth]
    if len(first) == 0:
        return np.arange(num_corners, dtype=np.int64)
    return connected(num_corners, *_links(corner, following, point, first, second))


def _unit_or_up(vectors: Floats) -> Floats:
    """The vectors [N, 3] at length one; straight up if there is no direction."""
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return np.where(length[:, None] > 0, vectors / np.where(length > 0, length, 1.0)[:, None], (0.0, 1.0, 0.0))


def _links(corner: Ints, following: Ints, point: Ints, first: Ints, second: Ints) -> tuple[Ints, Ints]:
    """Pairs of corners that lie at the same end of a smooth edge."""

    def end(side: Ints, larger: bool) -> Ints:
        starts_larger = point[side] > point[following[side]]
        return corner[np.where(starts_larger == larger, side, following[side])]

    return np.concatenate([end(first, False), end(first, True)]), np.concatenate(
        [end(second, False), end(second, True)]
    )


def _sums(group: Ints, vectors: Floats, num_groups: int) -> Floats:
    """[num_groups, 3] the sum of the vectors [N, 3] of each group [N]."""
    sums = np.empty((num_groups, 3))
    for column in range(3):
        sums[:, column] = np.bincount(group, vectors[:, column], num_groups)
    return sums


def _axis_aligned(normals: Floats, mesh_vertices: Ints) -> NDArray[np.bool_]:
    aligned = np.abs(normals).max(axis=1, initial=0.0) > 1 - _AXIS_TOLERANCE
    slanted_before = np.concatenate([[0], np.cumsum(~aligned)])
    return slanted_before[mesh_vertices[1:]] == slanted_before[mesh_vertices[:-1]]
