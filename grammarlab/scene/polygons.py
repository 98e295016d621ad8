"""Faces of a scene as polygons over the vertices of its triangles, for files that have polygons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, offsets_from_counts, row_of_value, take_rows
from grammarlab.geometry.meshes.ragged import max_rows, next_in_row, sum_rows
from grammarlab.scene.instances import Scene
from grammarlab.scene.shading import ShadedMeshes, shaded_meshes
from grammarlab.scene.triangles import (
    CREASE_ANGLE,
    LARGEST_COORDINATE,
    MANY_REPEATS,
    TriangleBatch,
    in_groups,
)


@dataclass(frozen=True, slots=True)
class PolygonBatch:
    """F faces over the vertices of a batch of triangles, in the order of its groups.

    Simple faces are polygons of any number of corners; a face with a hole, whose outline meets itself, is triangles.
    """

    rows: Ints
    """[C] rows of `TriangleBatch.vertices` of the corners of the faces."""
    offsets: Ints
    """[F + 1] into `rows`."""
    group_faces: Ints
    """[G + 1] into faces."""
    texture_map: NDArray[np.int32]
    """[F] as in `TriangleBatch`."""


def polygons(scene: Scene, batch: TriangleBatch) -> PolygonBatch:
    """The faces of a scene.

    Args:
        scene: the scene.
        batch: ``triangles(scene)``.
    """
    used = np.bincount(scene.mesh, minlength=len(scene.meshes)) > 0
    shaded = shaded_meshes(scene, np.flatnonzero(used), CREASE_ANGLE)
    place_of_mesh = np.cumsum(used) - 1
    scene = in_groups(scene, (np.diff(shaded.mesh_triangles) > 0)[place_of_mesh[scene.mesh]])
    mesh = place_of_mesh[scene.mesh]
    corners, face_offsets, mesh_faces = _faces(shaded)
    face, instance_faces = take_rows(mesh_faces, mesh)
    corner, offsets = take_rows(face_offsets, face)
    first_vertex = offsets_from_counts(np.diff(shaded.mesh_vertices)[mesh])[:-1]
    faces_per_instance = np.diff(instance_faces)
    per_face = first_vertex.repeat(faces_per_instance)
    vertices = batch.group_vertices
    group_of_instance = np.searchsorted(vertices, first_vertex, side="right") - 1
    per_group = np.bincount(group_of_instance, faces_per_instance, len(vertices) - 1).astype(np.int64)
    return PolygonBatch(
        rows=corners[corner] + per_face.repeat(np.diff(offsets)),
        offsets=offsets,
        group_faces=offsets_from_counts(per_group),
        texture_map=scene.texture_map.repeat(faces_per_instance),
    )


def polygon_coordinates(batch: TriangleBatch, faces: PolygonBatch, chosen: slice) -> Floats:
    """U and v (upwards) of the corners of selected faces, as `texture_coordinates` has them for triangles.

    Args:
        batch: the triangles.
        faces: their polygons.
        chosen: consecutive faces.

    Returns:
        [C, 2] coordinates of the corners of these faces.
    """
    offsets = faces.offsets[chosen.start : chosen.stop + 1]
    rows, offsets = faces.rows[offsets[0] : offsets[-1]], offsets - offsets[0]
    face = row_of_value(np.diff(offsets))
    points = batch.vertices[rows].astype(np.float64)
    map_of_corner = faces.texture_map[chosen][face]
    coordinates = _planar(points, offsets)
    if batch.coordinates is not None:
        coordinates = batch.coordinates[rows].astype(np.float64)
    elif batch.corner_coordinates is not None:
        of_file = batch.corner_coordinates[rows].astype(np.float64)
        known = sum_rows(~np.isfinite(of_file[:, 0]), offsets)[face] == 0
        own = np.flatnonzero(known & (map_of_corner < 0))
        coordinates[own] = of_file[own]
    mapped = np.flatnonzero(map_of_corner >= 0)
    if len(mapped):
        maps = batch.texture_maps[map_of_corner[mapped]]
        values = np.einsum("cij,cj->ci", maps[:, :, :3], points[mapped]) + maps[:, :, 3]
        coordinates[mapped] = np.clip(np.nan_to_num(values), -LARGEST_COORDINATE, LARGEST_COORDINATE)
    low = np.stack([-max_rows(-coordinates[:, axis], offsets, 0.0) for axis in range(2)], axis=1)
    return coordinates - np.where(np.abs(low) > MANY_REPEATS, np.floor(low), 0.0)[face]


def _faces(shaded: ShadedMeshes) -> tuple[Ints, Ints, Ints]:
    """Corners of faces, the offsets of the faces and of the meshes; triangles in place of faces with holes."""
    counts = np.diff(shaded.face_offsets)
    mesh, face = row_of_value(np.diff(shaded.mesh_faces)), row_of_value(counts)
    points = shaded.points[shaded.corners + shaded.mesh_vertices[mesh[face]]]
    order = np.lexsort((*points.T, face))
    repeats = (np.diff(points[order], axis=0) == 0.0).all(axis=1) & (np.diff(face[order]) == 0)
    simple = (np.bincount(face[order[1:][repeats]], minlength=len(counts)) == 0) & (counts >= 3)
    chosen = np.flatnonzero(simple)
    corner, _ = take_rows(shaded.face_offsets, chosen)
    cut = np.flatnonzero(~simple[shaded.triangle_faces])
    owner = np.concatenate([chosen, shaded.triangle_faces[cut]])
    sizes = np.concatenate([counts[chosen], np.full(len(cut), 3)])
    rows = np.concatenate([shaded.corners[corner], shaded.triangles[cut].ravel()])
    order = np.argsort(owner, kind="stable")
    where, offsets = take_rows(offsets_from_counts(sizes), order)
    per_mesh = np.bincount(mesh[owner], minlength=len(shaded.mesh_faces) - 1)
    return rows[where], offsets, offsets_from_counts(per_mesh)


def _planar(points: Floats, offsets: Ints) -> Floats:
    """[C, 2] coordinates in metres, projected along the axis that each face looks along most, v upwards."""
    ahead = points[next_in_row(offsets)]
    turns = np.cross(points, ahead)
    normal = np.stack([sum_rows(turns[:, axis], offsets) for axis in range(3)], axis=1)
    axis = np.abs(normal).argmax(axis=1)
    outward = np.where(np.take_along_axis(normal, axis[:, None], axis=1) < 0, -1.0, 1.0)[:, 0]
    face = row_of_value(np.diff(offsets))
    axis, outward = axis[face], outward[face]
    x, y, z = points.T
    u = np.where(axis == 0, -outward * z, np.where(axis == 1, x, outward * x))
    return np.stack([u, np.where(axis == 1, -outward * z, y)], axis=1)
