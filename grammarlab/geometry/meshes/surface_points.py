"""Points on the surfaces of meshes. Each mesh is processed alone, so its points do not depend on the others."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.triangulate import triangulate

_MOST_PAIRS = 200_000
"""Number of pairs of a point and a triangle that are compared at once."""


def points_on(meshes: Meshes, mesh: Indices, draws: Floats) -> tuple[Floats, Indices]:
    """Points distributed uniformly over surfaces.

    Args:
        meshes: with faces of positive area.
        mesh: [K] the mesh of each point, ascending.
        draws: [K, 3] numbers in [0, 1): uniform draws give uniform points.

    Returns:
        [K, 3] the points in metres, and [K] the faces they lie on.
    """
    points, faces = np.zeros((len(mesh), 3)), np.zeros(len(mesh), np.int64)
    for rows, corners, face in _mesh_triangles(meshes, mesh):
        sides = corners[:, 1:] - corners[:, :1]
        normals = np.cross(sides[:, 0], sides[:, 1])
        ends = np.cumsum(np.sqrt(normals[:, 0] ** 2 + normals[:, 1] ** 2 + normals[:, 2] ** 2))
        triangle = np.minimum(np.searchsorted(ends, draws[rows, 0] * ends[-1], side="right"), len(ends) - 1)
        # A square of draws folded onto a triangle (Turk 1990, "Generating random points in triangles").
        root = np.sqrt(draws[rows, 1])
        along, across = root * (1.0 - draws[rows, 2]), root * draws[rows, 2]
        points[rows] = corners[triangle, 0] + along[:, None] * sides[triangle, 0] + across[:, None] * sides[triangle, 1]
        faces[rows] = face[triangle]
    return points, faces


def nearest_on(meshes: Meshes, mesh: Indices, points: Floats) -> tuple[Floats, Indices]:
    """The points of surfaces that are closest to given ones.

    Args:
        meshes: with at least one face each.
        mesh: [K] the mesh of each point, ascending.
        points: [K, 3] positions in metres.

    Returns:
        [K, 3] the closest points, and [K] the faces they lie on.
    """
    nearest, faces = np.zeros((len(mesh), 3)), np.zeros(len(mesh), np.int64)
    for rows, corners, face in _mesh_triangles(meshes, mesh):
        step = max(1, _MOST_PAIRS // len(corners))
        for first in range(rows.start, rows.stop, step):
            batch = slice(first, min(first + step, rows.stop))
            closest = _closest(points[batch, None, :], corners[None])
            away = closest - points[batch, None, :]
            argmin = (away * away).sum(axis=2).argmin(axis=1)
            nearest[batch] = closest[np.arange(len(argmin)), argmin]
            faces[batch] = face[argmin]
    return nearest, faces


def _mesh_triangles(meshes: Meshes, mesh: Indices) -> Iterator[tuple[slice, Floats, Indices]]:
    """For each mesh with points: their rows, the corners [T, 3, 3] and the faces [T] of its triangles."""
    triangles, face = triangulate(meshes)
    first = np.searchsorted(face, meshes.mesh_faces)
    numbers, starts = np.unique(mesh, return_index=True)
    ends = np.searchsorted(mesh, numbers, side="right")
    for number, start, end in zip(numbers.tolist(), starts.tolist(), ends.tolist(), strict=True):
        triangle_rows = slice(first[number], first[number + 1])
        yield slice(start, end), meshes.points[triangles[triangle_rows]], face[triangle_rows]


def _closest(points: Floats, corners: Floats) -> Floats:
    """[K, T, 3] the points of triangles [1, T, 3, 3] that are closest to points [K, 1, 3]."""
    a, b, c = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    on_edges = [_on_edge(points, start, end) for start, end in ((a, b), (b, c), (c, a))]
    edge = np.stack(on_edges)
    away = edge - points
    best = (away * away).sum(axis=-1).argmin(axis=0)
    closest = np.take_along_axis(edge, best[None, ..., None], axis=0)[0]
    normal = np.cross(b - a, c - a)
    length = (normal * normal).sum(axis=-1, keepdims=True)
    height = ((points - a) * normal).sum(axis=-1, keepdims=True)
    below = points - normal * np.divide(height, length, out=np.zeros_like(height), where=length > 0.0)
    inside = _is_inside(below, a, b, c, normal) & (length[..., 0] > 0.0)
    return np.where(inside[..., None], below, closest)


def _on_edge(points: Floats, start: Floats, end: Floats) -> Floats:
    way = end - start
    length = (way * way).sum(axis=-1)
    share = ((points - start) * way).sum(axis=-1)
    share = np.divide(share, length, out=np.zeros_like(share), where=length > 0.0)
    return start + np.clip(share, 0.0, 1.0)[..., None] * way


def _is_inside(points: Floats, a: Floats, b: Floats, c: Floats, normal: Floats) -> NDArray[np.bool_]:
    """Whether points in the planes of triangles lie inside them."""
    turns = [(np.cross(end - start, points - start) * normal).sum(axis=-1) for start, end in ((a, b), (b, c), (c, a))]
    return (turns[0] >= 0.0) & (turns[1] >= 0.0) & (turns[2] >= 0.0)
