"""Flat faces of the shapes of a scene, as columns: what models are simplified from.

Large shapes have their own faces. A small one is seen from afar as a flat rectangle, and a round one as the convex hull
of a few of its points.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, offsets_from_counts, take_rows
from grammarlab.geometry.meshes.measure import area_vectors
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.instances import Scene

SMALL = 4.0
"""Largest area in square metres of the broadest side of a shape that counts as one rectangle."""
TINY = 0.1
"""Largest area in square metres of a face that is left out: 2 pixels at 234 m, where whole models disappear."""
MAX_FACES = 64
"""Most faces of a mesh that are used as they are."""
_DIRECTIONS = np.array([d for d in product((-1.0, 0.0, 1.0), repeat=3) if any(d)])
"""[26, 3] directions in which a round mesh keeps its farthest points."""
_RECTANGLE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""[4, 2] corners of a rectangle along its two axes."""


@dataclass(frozen=True, slots=True)
class Facets:
    """F flat polygons, ordered by their model."""

    points: Floats
    """[P, 3] corners in metres from the origin of the model."""
    offsets: Ints
    """[F + 1] into `points`; at least three corners each."""
    model: Ints
    """[F] ascending."""
    material: Ints
    """[F] index into the materials of the scene."""
    vector: Floats
    """[F, 3] area vectors: normals times square metres, longer than `TINY`."""

    def __len__(self) -> int:
        return len(self.model)

    def take(self, rows: NDArray[np.integer]) -> Facets:
        """These facets [K], in any order."""
        points, offsets = take_rows(self.offsets, rows)
        return Facets(self.points[points], offsets, self.model[rows], self.material[rows], self.vector[rows])


def facets(scene: Scene) -> Facets:
    """The faces of a scene that count from afar."""
    used, mesh = np.unique(scene.mesh, return_inverse=True)
    meshes = _few_faces(scene.meshes.take(used))
    low, high = meshes.bounds()
    sides = (high - low)[mesh] * scene.size
    flat = np.argmin(sides, axis=1)
    across = (flat[:, None] + (1, 2)) % 3
    area = np.prod(np.take_along_axis(sides, across, axis=1), axis=1)
    small, large = np.flatnonzero((area > TINY) & (area <= SMALL)), np.flatnonzero(area > SMALL)
    instance, points, counts = (
        np.concatenate(columns)
        for columns in zip(
            _rectangles(low, high, mesh[small], flat[small], across[small], small),
            _faces(meshes, mesh[large], large),
            strict=True,
        )
    )
    row = instance.repeat(counts)
    world = scene.position[row]
    columns = np.ascontiguousarray(scene.frames.T)
    for axis in range(3):
        world += columns[axis].T[scene.frame[row]] * (points[:, axis] * scene.size[row, axis])[:, None]
    vector = area_vectors(Meshes.from_polygons(world, counts))
    result = Facets(
        world,
        offsets_from_counts(counts),
        scene.model[instance].astype(np.int64),
        scene.material[instance].astype(np.int64),
        vector,
    )
    rows = np.flatnonzero(np.einsum("ij,ij->i", vector, vector) > TINY * TINY)
    # By the order of shapes, which does not depend on the other models.
    return result.take(rows[np.argsort(instance[rows], kind="stable")])


def _faces(meshes: Meshes, mesh: Ints, instance: Ints) -> tuple[Ints, Floats, Ints]:
    """Instances [F] of all faces of meshes [n], their corners [P, 3] in the mesh, and the number [F] of these."""
    face, ends = take_rows(meshes.mesh_faces, mesh)
    corner, face_ends = take_rows(meshes.face_offsets, face)
    return instance.repeat(np.diff(ends)), meshes.points[meshes.corner_points()[corner]], np.diff(face_ends)


def _rectangles(
    low: Floats, high: Floats, mesh: Ints, flat: Ints, across: Ints, instance: Ints
) -> tuple[Ints, Floats, Ints]:
    """Rectangles through the middle of the boxes of meshes [n], across their thinnest sides; as `_faces`."""
    middle, half = (high + low)[mesh] / 2.0, (high - low)[mesh] / 2.0
    points = np.repeat(middle[:, None], 4, axis=1)
    for axis in range(2):
        chosen = across[:, axis]
        rows = np.arange(len(mesh))
        points[rows, :, chosen] += _RECTANGLE[:, axis] * half[rows, chosen][:, None]
    return instance, points.reshape(-1, 3), np.full(len(flat), 4, dtype=np.int64)


def _few_faces(meshes: Meshes) -> Meshes:
    """The meshes, those of more than `MAX_FACES` faces as convex hulls of their farthest points."""
    num_faces = np.diff(meshes.mesh_faces)
    many = np.flatnonzero(num_faces > MAX_FACES)
    if not len(many):
        return meshes
    few = np.flatnonzero(num_faces <= MAX_FACES)
    hulls = [_hull(meshes.points[slice(*meshes.mesh_points[mesh : mesh + 2])]) for mesh in many.tolist()]
    joined = Meshes.concatenate([meshes.take(few), *hulls])
    return joined.take(np.argsort(np.concatenate((few, many)), kind="stable"))


def _hull(points: Floats) -> Meshes:
    """Convex hull of the farthest points of a mesh in 26 directions; its box if it is flat."""
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  # takes long to import

    low, high = points.min(axis=0), points.max(axis=0)
    extent = np.where(high > low, high - low, 1.0)
    farthest = np.unique(((points - low) / extent @ _DIRECTIONS.T).argmax(axis=0))
    corners = points[farthest]
    try:
        hull = ConvexHull((corners - low) / extent)
    except (QhullError, ValueError):
        return _box(low, high)
    normals = hull.equations[:, :3]
    triangles = hull.simplices
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), normals) < 0
    triangles = np.where(inward[:, None], triangles[:, ::-1], triangles)
    return Meshes.single(corners, triangles.tolist())


def _box(low: Floats, high: Floats) -> Meshes:
    corners = np.array(list(product(*zip(low.tolist(), high.tolist(), strict=True))))
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return Meshes.single(corners, faces)
