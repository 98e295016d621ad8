"""Unions, differences and intersections of solids, as meshes of polygons."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from functools import reduce
from typing import Literal

import numpy as np
from manifold3d import Manifold

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.contact import solid_of
from grammarlab.geometry.meshes.flat_patches import faces_within, loops_of
from grammarlab.geometry.meshes.mesh import Indices, Meshes

Operation = Literal["union", "subtract", "intersect"]

_SAME_PLANE = 1e-6
"""Largest difference of the normals, and of the distances relative to the size, of triangles in one plane."""


def united(meshes: Sequence[Meshes]) -> Manifold | None:
    """The union of meshes as one solid; None if one is not closed.

    Args:
        meshes: single meshes, points in metres.
    """
    solids = [solid_of(mesh) for mesh in meshes]
    if not solids or any(solid is None for solid in solids):
        return None
    return reduce(lambda first, second: first + second, [solid for solid in solids if solid is not None])


def combined(first: Sequence[Meshes], second: Sequence[Meshes], operation: Operation) -> Meshes | None:
    """One mesh of two groups of meshes; None if a mesh is not closed.

    Args:
        first: single meshes, united to one solid.
        second: single meshes, united to the other solid.
        operation: ``union``, ``subtract`` (the second from the first) or ``intersect``.
    """
    if not first or not second:
        rest = first if operation != "intersect" else ()
        return _joined(rest or (second if operation == "union" else ()))
    left, right = united(first), united(second)
    if left is None or right is None:
        return None
    if operation == "union":
        return polygons_of(left + right)
    return polygons_of(left - right if operation == "subtract" else left ^ right)


def _joined(meshes: Sequence[Meshes]) -> Meshes | None:
    if not meshes:
        return Meshes.single(np.zeros((0, 3)), [])
    solid = united(meshes)
    return None if solid is None else polygons_of(solid)


def polygons_of(solid: Manifold) -> Meshes:
    """The surface of a solid as one mesh: triangles of one plane that share edges are one face."""
    surface = solid.to_mesh64()
    points = np.asarray(surface.vert_properties, dtype=np.float64)[:, :3]
    triangles = np.asarray(surface.tri_verts, dtype=np.int64)
    if len(triangles) == 0:
        return Meshes.single(np.zeros((0, 3)), [])
    patches = _patches(points, triangles)
    loops = [loops_of(_edges(triangles[patch])) for patch in patches]
    # A corner of three faces stays also in the face in which it is straight, so that edges have two faces.
    uses = np.bincount([index for outlines in loops for loop in outlines for index in loop], minlength=len(points))
    faces: list[Indices] = []
    for patch, outlines in zip(patches, loops, strict=True):
        faces += faces_within(
            points, [_simplified(points, loop, uses) for loop in outlines], _normal(points, triangles[patch])
        )
    used, corners = np.unique(np.concatenate(faces), return_inverse=True)
    sizes = np.cumsum([len(face) for face in faces])[:-1]
    return Meshes.single(points[used], [part.tolist() for part in np.split(corners, sizes)])


def _patches(points: Floats, triangles: Indices) -> list[Indices]:
    """Sets of triangles in one plane that are connected by edges, each with the smallest first."""
    corner = points[triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(normal, axis=1)
    normal = normal / np.maximum(length, 1e-300)[:, None]
    size = float(np.ptp(points, axis=0).max()) or 1.0
    level = np.einsum("ti,ti->t", normal, corner.mean(axis=1)) / size
    plane = np.column_stack([normal, level])
    neighbours: dict[tuple[int, int], int] = {}
    parent = list(range(len(triangles)))

    def root(index: int) -> int:
        while parent[index] != index:
            parent[index] = parent[parent[index]]
            index = parent[index]
        return index

    for number, (a, b, c) in enumerate(triangles.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            other = neighbours.get((edge[1], edge[0]))
            neighbours[edge] = number
            # A sliver has no normal of its own: it belongs to whatever it borders.
            is_sliver = other is not None and min(length[number], length[other]) < 1e-12 * size**2
            if other is not None and (is_sliver or np.abs(plane[number] - plane[other]).max() < _SAME_PLANE):
                parent[max(root(number), root(other))] = min(root(number), root(other))
    groups: dict[int, list[int]] = defaultdict(list)
    for number in range(len(triangles)):
        groups[root(number)].append(number)
    return [np.array(group) for group in groups.values()]


def _simplified(points: Floats, loop: list[int], uses: Indices) -> list[int]:
    """A loop without corners of two faces at which it goes straight on."""
    corner = points[loop]
    before, after = corner - np.roll(corner, 1, axis=0), np.roll(corner, -1, axis=0) - corner
    turn = np.linalg.norm(np.cross(before, after), axis=1)
    reach = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    bends = (turn > 1e-9 * reach) | (uses[loop] > 2)
    return [index for index, stays in zip(loop, bends.tolist(), strict=True) if stays]


def _edges(triangles: Indices) -> list[tuple[int, int]]:
    return [edge for a, b, c in triangles.tolist() for edge in ((a, b), (b, c), (c, a))]


def _normal(points: Floats, triangles: Indices) -> Floats:
    corner = points[triangles]
    return np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]).sum(axis=0)
