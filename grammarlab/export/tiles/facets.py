"""Flat faces of the shapes of a scene, as columns: what models are simplified from.

Large shapes have their own faces. A small one is seen from afar as a flat rectangle, and a round one as the convex hull
of a few of its points.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints, offsets_from_counts, take_rows
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
    """[F, 3] area vectors: normals times square metres, longer than `TINY`. Those of small shapes have the area of
    their faces: a railing covers less than its rectangle."""

    def __len__(self) -> int:
        return len(self.model)

    def take(self, rows: NDArray[np.integer]) -> Facets:
        """These facets [K], in any order."""
        points, offsets = take_rows(self.offsets, rows)
        return Facets(self.points[points], offsets, self.model[rows], self.material[rows], self.vector[rows])


class _Polygons(NamedTuple):
    """F polygons of shapes."""

    instance: Ints
    """[F]."""
    points: Floats
    """[P, 3] corners in the mesh."""
    counts: Ints
    """[F] number of the corners of each."""
    vector: Floats
    """[F, 3] area vectors in the mesh."""


def facets(scene: Scene) -> Facets:
    """The faces of a scene that count from afar."""
    used, mesh = np.unique(scene.mesh, return_inverse=True)
    meshes = scene.meshes.take(used)
    low, high = meshes.bounds()
    sides = (high - low)[mesh] * scene.size
    flat = np.argmin(sides, axis=1)
    area = np.prod(np.take_along_axis(sides, (flat[:, None] + (1, 2)) % 3, axis=1), axis=1)
    filled = _filled(meshes, high - low)[mesh, flat]
    small = np.flatnonzero((area * filled > TINY) & (area <= SMALL))
    large = np.flatnonzero(area > SMALL)
    is_large = np.bincount(mesh[large], minlength=len(meshes)) > 0
    parts = (
        _rectangles(low, high, mesh, flat, small),
        _faces(_few_faces(meshes, is_large), mesh, scene.size, large),
    )
    instance, counts = (np.concatenate([getattr(part, name) for part in parts]) for name in ("instance", "counts"))
    points, vector = (np.concatenate([getattr(part, name) for part in parts]) for name in ("points", "vector"))
    # By the order of shapes, which does not depend on the other models.
    order = np.argsort(instance, kind="stable")
    corners, offsets = take_rows(offsets_from_counts(counts), order)
    instance = instance[order]
    axes = np.ascontiguousarray(scene.frames.transpose(2, 1, 0))
    vector = _turned(axes, scene.frame[instance], _area_vectors(vector[order], scene.size[instance]))
    vector *= np.where(area <= SMALL, filled, 1.0)[instance, None]
    row = instance.repeat(np.diff(offsets))
    world = _turned(axes, scene.frame[row], points[corners] * scene.size[row])
    world += scene.position[row]
    model, material = (column[instance].astype(np.int64) for column in (scene.model, scene.material))
    return Facets(world, offsets, model, material, vector)


def _turned(axes: Floats, frame: NDArray[np.integer], vectors: Floats) -> Floats:
    """Vectors [n, 3] under the rotations [n] of a table [3, 3, K], by axis, then by coordinate."""
    result = np.empty_like(vectors)
    x, y, z = vectors.T
    for coordinate in range(3):
        by_axis = axes[:, coordinate]
        result[:, coordinate] = by_axis[0].take(frame) * x + by_axis[1].take(frame) * y + by_axis[2].take(frame) * z
    return result


def _area_vectors(vectors: Floats, size: Floats) -> Floats:
    """[n, 3] area vectors of faces that are stretched by sizes [n, 3]."""
    return vectors * np.column_stack((size[:, 1] * size[:, 2], size[:, 2] * size[:, 0], size[:, 0] * size[:, 1]))


def _faces(meshes: Meshes, mesh: Ints, size: Floats, rows: Ints) -> _Polygons:
    """The faces of instances at some rows that are larger than `TINY`."""
    face, ends = take_rows(meshes.mesh_faces, mesh[rows])
    instance, vector = rows.repeat(np.diff(ends)), area_vectors(meshes)[face]
    stretched = _area_vectors(vector, size[instance])
    chosen = np.flatnonzero(np.einsum("ij,ij->i", stretched, stretched) > TINY * TINY)
    corner, face_ends = take_rows(meshes.face_offsets, face[chosen])
    points = meshes.points[meshes.corner_points()[corner]]
    return _Polygons(instance[chosen], points, np.diff(face_ends), vector[chosen])


def _rectangles(low: Floats, high: Floats, mesh: Ints, flat: Ints, rows: Ints) -> _Polygons:
    """Rectangles in the middle of the boxes of instances at some rows, across their thinnest sides."""
    thin, box_low, box_high = flat[rows], low[mesh[rows]], high[mesh[rows]]
    middle, half = (box_high + box_low) / 2.0, (box_high - box_low) / 2.0
    number = np.arange(len(rows))
    points = np.repeat(middle[:, None], 4, axis=1)
    for index in range(2):
        axis = (thin + 1 + index) % 3
        points[number, :, axis] += _RECTANGLE[:, index] * half[number, axis][:, None]
    vector = np.zeros((len(rows), 3))
    vector[number, thin] = 4.0 * half[number, (thin + 1) % 3] * half[number, (thin + 2) % 3]
    return _Polygons(rows, points.reshape(-1, 3), np.full(len(rows), 4, dtype=np.int64), vector)


def _filled(meshes: Meshes, extent: Floats) -> Floats:
    """[M, 3] share of a side of the box of a mesh that is covered by faces towards it, seen along each axis."""
    vector, mesh = area_vectors(meshes), meshes.mesh_of_face()
    fronts = []
    for axis in range(3):
        sides = [np.bincount(mesh, np.maximum(sign * vector[:, axis], 0.0), len(meshes)) for sign in (1.0, -1.0)]
        fronts.append(np.maximum(*sides))
    box = np.prod(extent[:, ((1, 2), (2, 0), (0, 1))], axis=2)
    return np.minimum(1.0, np.stack(fronts, axis=1) / np.where(box > 0.0, box, 1.0))


def _few_faces(meshes: Meshes, is_used: Flags) -> Meshes:
    """The meshes, used ones of more than `MAX_FACES` faces as convex hulls of their farthest points."""
    is_hull = is_used & (np.diff(meshes.mesh_faces) > MAX_FACES)
    many, few = np.flatnonzero(is_hull), np.flatnonzero(~is_hull)
    if not len(many):
        return meshes
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
