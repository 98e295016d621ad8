"""Measures of the meshes of trees."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.scene import Scene, TriangleBatch


def bark(scene: Scene, model: int = 0) -> tuple[Floats, Ints]:
    """Points [P, 3] and triangles [T, 3] of the wood of a tree; points of seams are apart."""
    mesh = scene.meshes.take(np.array([model]))
    return mesh.points, mesh.corners.reshape(-1, 3)


def welded(points: Floats, triangles: Ints) -> Ints:
    """Triangles [T, 3] over distinct points."""
    _, index = np.unique(points, axis=0, return_inverse=True)
    return index.ravel()[triangles]


def directed_edges(triangles: Ints) -> Ints:
    """[3 T, 2] edges of triangles, in order."""
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    return edges[np.lexsort(edges.T)]


def volume(points: Floats, triangles: Ints) -> float:
    """Volume inside closed surfaces, positive if they face outwards."""
    a, b, c = points[triangles].transpose(1, 0, 2)
    return float(np.einsum("ti,ti->t", a, np.cross(b, c)).sum() / 6.0)


def extent(batch: TriangleBatch) -> tuple[Floats, Floats]:
    """Smallest and largest coordinates [3] of one model."""
    return batch.vertices.min(axis=0).astype(np.float64), batch.vertices.max(axis=0).astype(np.float64)


def areas(batch: TriangleBatch) -> Floats:
    """[T] areas of triangles."""
    a, b, c = batch.vertices[batch.triangles].astype(np.float64).transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
