"""The meshes of one derivation, in the unit cube of their scopes, referred to by id."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.shapes import EMPTY, Floats, Ids
from grammarlab.geometry.mesh import Meshes

_CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
"""The cube's corners: corner 4x + 2y + z."""

_NOTHING = Meshes.single(np.zeros((0, 3)), [])
_BOX = Meshes.single(_CORNERS, [[1, 5, 7, 3], [5, 4, 6, 7], [4, 0, 2, 6], [0, 1, 3, 2], [3, 7, 6, 2], [0, 4, 5, 1]])
"""Front, right, back, left, top, bottom."""
_FOOTPRINT = Meshes.single(_CORNERS[[1, 5, 4, 0]], [[0, 1, 2, 3]])
_FACE = Meshes.single(_CORNERS[[0, 4, 6, 2]], [[0, 1, 2, 3]])


class MeshPool:
    """Meshes in the order they were made; the first four are `EMPTY`, `BOX`, `FOOTPRINT` and `FACE`."""

    def __init__(self) -> None:
        self._batches = [Meshes.concatenate([_NOTHING, _BOX, _FOOTPRINT, _FACE])]
        self._starts = [0]
        self._used = 4
        self._named: dict[str, int] = {}

    def __len__(self) -> int:
        return self._used

    def add(self, meshes: Meshes) -> Ids:
        """Ids [N] of new meshes whose points lie in the unit cube; a mesh without faces is `EMPTY`."""
        ids = np.arange(self._used, self._used + len(meshes), dtype=np.int32)
        self._batches.append(meshes)
        self._starts.append(self._used)
        self._used += len(meshes)
        return np.where(np.diff(meshes.mesh_faces) > 0, ids, np.int32(EMPTY))

    def named(self, name: str, mesh: Meshes) -> int:
        """The id of one shared mesh in the unit cube, added when the name is new."""
        known = self._named.get(name)
        if known is None:
            known = self._named[name] = int(self.add(mesh)[0])
        return known

    def take(self, ids: NDArray[np.integer]) -> Meshes:
        """The meshes [N] with these ids, in the unit cube."""
        batch = np.searchsorted(self._starts, ids, side="right") - 1
        touched = np.unique(batch)
        if len(touched) == 1:
            return self._from_batch(int(touched[0]), ids)
        rows = [np.flatnonzero(batch == b) for b in touched]
        parts = [self._from_batch(int(b), ids[r]) for b, r in zip(touched, rows, strict=True)]
        return Meshes.concatenate(parts).take(np.argsort(np.concatenate(rows)))

    def freeze(self) -> Meshes:
        """All meshes, in the order of their ids."""
        return Meshes.concatenate(self._batches)

    def _from_batch(self, batch: int, ids: NDArray[np.integer]) -> Meshes:
        return self._batches[batch].take(ids - self._starts[batch])


def scaled(meshes: Meshes, size: Floats) -> Meshes:
    """Meshes with the points of each multiplied by its size [N, 3]."""
    return meshes.with_points(meshes.points * np.repeat(size, np.diff(meshes.mesh_points), axis=0))


def normalized(meshes: Meshes) -> tuple[Meshes, Floats, Floats]:
    """Meshes moved and scaled into the unit cube, and the low corner and size [N, 3] they had."""
    low, high = meshes.bounds()
    size = high - low
    counts = np.diff(meshes.mesh_points)
    inverse = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    points = (meshes.points - np.repeat(low, counts, axis=0)) * np.repeat(inverse, counts, axis=0)
    return meshes.with_points(points), low, size
