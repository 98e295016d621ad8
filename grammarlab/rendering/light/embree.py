"""Rays by Intel Embree. The only file that imports embreex."""

from __future__ import annotations

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats
from grammarlab.rendering.light.box_tree import AbstractScene, Hits


class EmbreeTriangles(AbstractScene):
    """Triangles in Embree's hierarchy."""

    def __init__(self, vertices: AnyFloats, triangles: NDArray[np.integer]) -> None:
        self._scene = EmbreeScene()
        TriangleMesh(self._scene, np.ascontiguousarray(vertices), np.ascontiguousarray(triangles, dtype=np.int32))

    def first_hit(self, origins: AnyFloats, directions: AnyFloats) -> Hits:
        """See `AbstractScene.first_hit`."""
        result = self._scene.run(origins, directions, output=1)
        return Hits(result["primID"], result["tfar"], result["u"], result["v"])

    def is_blocked(self, origins: AnyFloats, directions: AnyFloats, reach: float | None) -> NDArray[np.bool_]:
        """See `AbstractScene.is_blocked`."""
        limit = None if reach is None else np.full(len(origins), reach, np.float32)
        return self._scene.run(origins, directions, dists=limit, query="OCCLUDED") >= 0
