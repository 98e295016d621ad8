"""Unions, differences and intersections of solids, as meshes of polygons that are parts of faces of the solids."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from functools import reduce
from typing import Literal, NamedTuple

import numpy as np
from manifold3d import Error, Manifold, Mesh64

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.flat_booleans import flat_combined
from grammarlab.geometry.meshes.flat_patches import faces_within, loops_of
from grammarlab.geometry.meshes.mesh import Indices, Meshes, SourcedMesh
from grammarlab.geometry.meshes.triangulate import triangulate

Operation = Literal["union", "subtract", "intersect"]


def united(meshes: Sequence[Meshes]) -> SourcedMesh | None:
    """The union of meshes; None if one is not closed.

    Args:
        meshes: single meshes, points in metres.
    """
    solids = _Solids.of(meshes)
    return None if solids is None else solids.faces_of(reduce(lambda one, other: one + other, solids.solids))


def combined(meshes: Sequence[Meshes], num_first: int, operation: Operation) -> SourcedMesh | None:
    """One mesh of two groups of meshes; None if a mesh is not closed, unless all lie in one plane.

    Args:
        meshes: single meshes, points in metres, those of the first group first; each group is united to one solid.
        num_first: number of meshes of the first group.
        operation: ``union``, ``subtract`` (the second from the first) or ``intersect``.
    """
    if num_first in (0, len(meshes)):
        remains = operation == "union" or (operation == "subtract" and num_first > 0)
        if not remains or not meshes:
            return SourcedMesh(Meshes.united([]), np.zeros(0, np.int64), np.zeros(0, np.int64))
        if len(meshes) == 1:
            faces = np.arange(meshes[0].num_faces)
            return SourcedMesh(meshes[0], np.zeros_like(faces), faces)
        return united(meshes)
    flat = flat_combined(meshes, num_first, operation)
    if flat is not None:
        return flat
    solids = _Solids.of(meshes)
    if solids is None:
        return None
    first = reduce(lambda one, other: one + other, solids.solids[:num_first])
    second = reduce(lambda one, other: one + other, solids.solids[num_first:])
    if operation == "union":
        return solids.faces_of(first + second)
    return solids.faces_of(first - second if operation == "subtract" else first ^ second)


class _Solids(NamedTuple):
    """Solids whose triangles remember the faces that they are parts of."""

    solids: list[Manifold]
    first_id: int

    @classmethod
    def of(cls, meshes: Sequence[Meshes]) -> _Solids | None:
        """The solids of meshes; None if there is none, or one is not closed."""
        first = Manifold.reserve_ids(max(len(meshes), 1))
        solids = [_solid(mesh, first + number) for number, mesh in enumerate(meshes)]
        whole = [solid for solid in solids if solid is not None]
        return cls(whole, first) if whole and len(whole) == len(solids) else None

    def faces_of(self, solid: Manifold) -> SourcedMesh:
        """The surface of a solid made of these."""
        mesh, source, face = faces_of(solid)
        return SourcedMesh(mesh, source - self.first_id, face)


def faces_of(solid: Manifold) -> SourcedMesh:
    """The surface of a solid: connected triangles of one face are one face.

    The numbers of sources are those that the library gives to the solids that a solid is made of.
    """
    surface = solid.to_mesh64()
    points = np.asarray(surface.vert_properties, dtype=np.float64)[:, :3]
    triangles = np.asarray(surface.tri_verts, dtype=np.int64)
    if len(triangles) == 0:
        return SourcedMesh(Meshes.united([]), np.zeros(0, np.int64), np.zeros(0, np.int64))
    runs = np.diff(np.asarray(surface.run_index, dtype=np.int64)) // 3
    source = np.repeat(np.asarray(surface.run_original_id, dtype=np.int64), runs)
    face = np.asarray(surface.face_id, dtype=np.int64)
    patches = _patches(triangles, source, face)
    loops = [loops_of(_edges(triangles[patch])) for patch in patches]
    # A corner of three faces stays also in the face in which it is straight, so that edges have two faces.
    uses = np.bincount([index for outlines in loops for loop in outlines for index in loop], minlength=len(points))
    faces: list[Indices] = []
    first: list[int] = []
    for patch, outlines in zip(patches, loops, strict=True):
        simple = [_simplified(points, loop, uses) for loop in outlines]
        parts = faces_within(points, simple, _normal(points, triangles[patch]))
        faces += parts
        first += [int(patch[0])] * len(parts)
    used, corners = np.unique(np.concatenate(faces), return_inverse=True)
    sizes = np.cumsum([len(part) for part in faces])[:-1]
    mesh = Meshes.single(points[used], [part.tolist() for part in np.split(corners, sizes)])
    return SourcedMesh(mesh, source[first], face[first])


def _solid(mesh: Meshes, number: int) -> Manifold | None:
    """The solid of one mesh whose triangles have this number; None if it is not closed or looks inwards."""
    triangles, face = triangulate(mesh)
    if len(triangles) < 4:
        return None
    surface = Mesh64(
        vert_properties=np.ascontiguousarray(mesh.points),
        tri_verts=triangles.astype(np.uint64),
        run_index=np.array([0, 3 * len(triangles)], dtype=np.uint64),
        run_original_id=np.array([number], dtype=np.uint32),
        face_id=face.astype(np.uint64),
    )
    surface.merge()
    solid = Manifold(surface)
    if solid.status() != Error.NoError or solid.is_empty() or not solid.volume() > 0.0:
        return None
    return solid


def _patches(triangles: Indices, source: Indices, face: Indices) -> list[Indices]:
    """Sets of triangles of one face that are connected by edges, each with the smallest first, by face."""
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
            if other is not None and source[number] == source[other] and face[number] == face[other]:
                parent[max(root(number), root(other))] = min(root(number), root(other))
    groups: dict[int, list[int]] = defaultdict(list)
    for number in range(len(triangles)):
        groups[root(number)].append(number)
    patches = sorted(groups.values(), key=lambda group: (source[group[0]], face[group[0]], group[0]))
    return [np.array(group) for group in patches]


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
