"""Intersection of rays and triangles, by Intel Embree. The only file that imports embreex."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

from grammarlab.geometry.meshes.ragged import distinct_keys

Floats = NDArray[np.floating]


@dataclass(frozen=True, slots=True)
class Hits:
    """The nearest hits of N rays."""

    triangle: NDArray[np.int32]
    """[N] triangle, -1 for none."""
    distance: Floats
    """[N] distance along the ray; huge without a hit."""
    u: Floats
    """[N] weight of the triangle's second corner."""
    v: Floats
    """[N] weight of its third."""


class Tracer:
    """Triangles for ray queries, in single precision: the model should be near the origin at about unit size."""

    def __init__(self, vertices: Floats, triangles: NDArray[np.integer]) -> None:
        self._scene: Any = None
        if len(triangles):
            self._scene = EmbreeScene()
            TriangleMesh(self._scene, np.ascontiguousarray(vertices), np.ascontiguousarray(triangles, dtype=np.int32))

    def first_hit(self, origins: Floats, directions: Floats) -> Hits:
        """The nearest triangle in front of each ray [N, 3]."""
        if self._scene is None or len(origins) == 0:
            zeros = np.zeros(len(origins), np.float32)
            return Hits(np.full(len(origins), -1, np.int32), np.full(len(origins), np.inf, np.float32), zeros, zeros)
        found = self._scene.run(_contiguous(origins), _contiguous(directions), output=1)
        return Hits(found["primID"], found["tfar"], found["u"], found["v"])

    def is_blocked(self, origins: Floats, directions: Floats, reach: float | None = None) -> NDArray[np.bool_]:
        """[N] whether a triangle lies on each ray [N, 3], no farther than `reach` (same unit as the directions)."""
        if self._scene is None or len(origins) == 0:
            return np.zeros(len(origins), bool)
        limit = None if reach is None else np.full(len(origins), reach, np.float32)
        found = self._scene.run(_contiguous(origins), _contiguous(directions), dists=limit, query="OCCLUDED")
        return found >= 0


def welded(vertices: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """The different vertices of [V, 3], and the index of each vertex among them [V].

    Merging duplicates, which shading needs but rays do not, is faster than passing them to Embree.
    """
    bits = np.ascontiguousarray(vertices).view(np.uint32).astype(np.uint64)
    key = (bits[:, 0] << np.uint64(32) | bits[:, 1]) * np.uint64(0x9E3779B97F4A7C15)
    key ^= bits[:, 2] * np.uint64(0xBF58476D1CE4E5B9)
    first, number = distinct_keys(key)
    different, place = vertices[first], number.astype(np.int32)
    if np.array_equal(different.take(place, axis=0), vertices):
        return different, place
    return vertices, np.arange(len(vertices), dtype=np.int32)


def _contiguous(values: Floats) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float32)
