"""Intersection of rays and triangles: by Embree, or without it more slowly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats
from grammarlab.geometry.meshes.ragged import distinct_keys
from grammarlab.rendering.light.box_tree import AbstractScene, BoxedTriangles, Hits
from grammarlab.rendering.light.textures import PerforatedTriangles, Skin


class Tracer:
    """Triangles for ray queries, in single precision: the model should be near the origin at about unit size.

    Args:
        vertices: [V, 3].
        triangles: [T, 3].
        skin: pictures on the triangles; rays pass through their holes.
    """

    def __init__(self, vertices: AnyFloats, triangles: NDArray[np.integer], skin: Skin | None = None) -> None:
        self._scene = _scene(vertices, triangles) if len(triangles) else None
        if self._scene is not None and skin is not None and skin.perforated.any():
            self._scene = PerforatedTriangles(self._scene, skin)

    def first_hit(self, origins: AnyFloats, directions: AnyFloats) -> Hits:
        """The nearest triangle in front of each ray [N, 3]."""
        if self._scene is None or len(origins) == 0:
            zeros = np.zeros(len(origins), np.float32)
            return Hits(np.full(len(origins), -1, np.int32), np.full(len(origins), np.inf, np.float32), zeros, zeros)
        return self._scene.first_hit(_contiguous(origins), _contiguous(directions))

    def is_blocked(self, origins: AnyFloats, directions: AnyFloats, reach: float | None = None) -> NDArray[np.bool_]:
        """[N] whether a triangle lies on each ray [N, 3], no farther than `reach` (same unit as the directions)."""
        if self._scene is None or len(origins) == 0:
            return np.zeros(len(origins), bool)
        return self._scene.is_blocked(_contiguous(origins), _contiguous(directions), reach)


def has_embree() -> bool:
    """Whether Embree works on this machine; there are no packages of it for Linux on ARM, for example."""
    try:
        from grammarlab.rendering.light import embree  # noqa: F401, PLC0415
    except ImportError:
        return False
    return True


def _scene(vertices: AnyFloats, triangles: NDArray[np.integer]) -> AbstractScene:
    if not has_embree():
        return BoxedTriangles(vertices, triangles)
    from grammarlab.rendering.light.embree import EmbreeTriangles  # noqa: PLC0415

    return EmbreeTriangles(vertices, triangles)


def welded(vertices: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """The different vertices of [V, 3], and the index of each vertex among them [V].

    Merging duplicates, which shading needs but rays do not, is faster than passing them to Embree.
    """
    bits = np.ascontiguousarray(vertices).view(np.uint32).astype(np.uint64)
    key = (bits[:, 0] << np.uint64(32) | bits[:, 1]) * np.uint64(0x9E3779B97F4A7C15)
    key ^= bits[:, 2] * np.uint64(0xBF58476D1CE4E5B9)
    first, number = distinct_keys(key)
    different, index = vertices[first], number.astype(np.int32)
    if np.array_equal(different.take(index, axis=0), vertices):
        return different, index
    return vertices, np.arange(len(vertices), dtype=np.int32)


def _contiguous(values: AnyFloats) -> AnyFloats:
    return np.ascontiguousarray(values, dtype=np.float32)
