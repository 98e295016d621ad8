"""Rays against triangles, by Intel Embree. The only file that imports embreex."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

Floats = NDArray[np.floating]


@dataclass(frozen=True, slots=True)
class Hits:
    """The nearest hits of N rays."""

    triangle: NDArray[np.int32]
    """[N] triangle, -1 for none."""
    distance: Floats
    """[N] along the ray; huge where there is no hit."""
    u: Floats
    """[N] weight of the triangle's second corner."""
    v: Floats
    """[N] weight of its third."""


class Tracer:
    """Triangles that rays can be sent at. Single precision: put the model near the origin at about unit size."""

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


def _contiguous(values: Floats) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float32)
