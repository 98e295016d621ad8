"""Boolean operations on faces that lie in one plane."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal, cast

import numpy as np
from shapely import Polygon, get_parts, make_valid, prepare, set_precision, union_all
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.flat_patches import faces_within
from grammarlab.geometry.meshes.measure import area_vectors
from grammarlab.geometry.meshes.mesh import Indices, Meshes, SourcedMesh

_FLAT = 1e-6
"""Largest distance from the plane, as a share of the size of all meshes: a tolerance."""
_GRID = 1e-9
"""Distance of points that are one, as a share of that size."""


def flat_combined(
    meshes: Sequence[Meshes], num_first: int, operation: Literal["union", "subtract", "intersect"]
) -> SourcedMesh | None:
    """One mesh of two groups of meshes in one plane, with the mesh and the face that each face comes from.

    A union keeps all edges: what only the first has, what both have, what only the second has.

    Args:
        meshes: single meshes, those of the first group first.
        num_first: number of meshes of the first group.
        operation: the operation.

    Returns:
        None if the meshes do not lie in one plane.
    """
    points = np.concatenate([mesh.points for mesh in meshes])
    normal = area_vectors(meshes[0]).sum(axis=0) if meshes[0].num_faces else np.zeros(3)
    size, length = float(np.ptp(points, axis=0).max(initial=0.0)), float(np.linalg.norm(normal))
    if length <= 0.0 or size <= 0.0:
        return None
    z = normal / length
    origin = points[0]
    if np.abs((points - origin) @ z).max() > _FLAT * size:
        return None
    x = np.cross(z, np.eye(3)[np.abs(z).argmin()])
    x /= np.linalg.norm(x)
    axes: Floats = np.column_stack([x, np.cross(z, x)]).astype(np.float64)
    faces = [list(_faces(mesh, (mesh.points - origin) @ axes, _GRID * size)) for mesh in meshes]
    whole = [union_all([face for group in part for face in group]) for part in (faces[:num_first], faces[num_first:])]
    for shape in whole:
        prepare(shape)
    result: list[tuple[BaseGeometry, int, int]] = []
    for number, group in enumerate(faces):
        is_first = number < num_first
        other = whole[1 if is_first else 0]
        for index, face in enumerate(group):
            if operation != "intersect" and (is_first or operation == "union"):
                result.append((face.difference(other), number, index))
            if operation != "subtract" and is_first:
                result.append((face.intersection(other), number, index))
    return _mesh(result, origin, axes, z)


def _faces(mesh: Meshes, flat: Floats, grid: float) -> Iterator[BaseGeometry]:
    """The faces of a mesh as shapes in the plane; those with keyholes as shapes with holes."""
    corners = mesh.corner_points()
    for begin, end in zip(mesh.face_offsets[:-1].tolist(), mesh.face_offsets[1:].tolist(), strict=True):
        ring = flat[corners[begin:end]]
        yield cast("BaseGeometry", set_precision(make_valid(Polygon(ring)) if len(ring) > 2 else Polygon(), grid))


def _mesh(shapes: Sequence[tuple[BaseGeometry, int, int]], origin: Floats, axes: Floats, normal: Floats) -> SourcedMesh:
    points: list[Floats] = []
    faces: list[Indices] = []
    sources: list[tuple[int, int]] = []
    count = 0
    for shape, number, index in shapes:
        for part in get_parts(shape).tolist():
            if not isinstance(part, Polygon) or part.is_empty:
                continue
            oriented = orient(part)  # holes run the other way
            rings = [np.asarray(ring.coords)[:-1] for ring in (oriented.exterior, *oriented.interiors)]
            flat = np.concatenate(rings)
            ends = np.cumsum([len(ring) for ring in rings])
            loops = [list(range(end - len(ring), end)) for ring, end in zip(rings, ends, strict=True)]
            solid = flat @ axes.T + origin
            for face in faces_within(solid, loops, normal):
                faces.append(face + count)
                sources.append((number, index))
            points.append(solid)
            count += len(solid)
    mesh = Meshes.single(np.concatenate(points) if points else np.zeros((0, 3)), [face.tolist() for face in faces])
    source = np.array(sources, dtype=np.int64).reshape(-1, 2)
    return SourcedMesh(mesh, source[:, 0], source[:, 1])
