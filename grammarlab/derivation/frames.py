"""Orientations of scopes, interned: a frame is a base rotation times one of the 24 rotations of a cube.

A shape carries one integer, ``24 * base + cube``. The faces of a box and every turn by a right angle stay within one base, so
they are table look-ups and exact to the last bit.
"""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ids = NDArray[np.int32]


def _cube_rotations() -> Floats:
    rotations = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            matrix = np.zeros((3, 3))
            matrix[order, range(3)] = signs
            if np.linalg.det(matrix) > 0:
                rotations.append(matrix)
    identity_first = sorted(rotations, key=lambda m: -np.trace(m))
    return np.array(identity_first)


CUBE: Floats = _cube_rotations()
"""[24, 3, 3] the rotations that take a cube to itself; the first is the identity."""

_PRODUCTS = np.einsum("aij,bjk->abik", CUBE, CUBE)
COMPOSE: Ids = np.array(
    [[np.flatnonzero((CUBE == m).all(axis=(1, 2)))[0] for m in row] for row in _PRODUCTS], dtype=np.int32
)
"""[24, 24] ``CUBE[COMPOSE[a, b]] == CUBE[a] @ CUBE[b]``."""


def cube_index(matrix: Floats) -> int:
    """The index in `CUBE` of a rotation by right angles [3, 3]."""
    return int(np.flatnonzero((np.abs(matrix - CUBE) < 0.5).all(axis=(1, 2)))[0])


class FramePool:
    """The base rotations met in one derivation, each with its 24 turned copies."""

    def __init__(self) -> None:
        self._table = CUBE.copy()
        self._used = len(CUBE)

    @property
    def table(self) -> Floats:
        """[K, 3, 3] the rotation of every frame; columns are the scope's axes in the world."""
        return self._table[: self._used]

    def add(self, rotations: Floats) -> Ids:
        """Frames [N] of new base rotations [N, 3, 3]."""
        first, count = self._used, 24 * len(rotations)
        if first + count > len(self._table):
            grown = np.empty((max(2 * len(self._table), first + count), 3, 3))
            grown[:first] = self.table
            self._table = grown
        self._table[first : first + count] = np.einsum("nij,bjk->nbik", rotations, CUBE).reshape(-1, 3, 3)
        self._used += count
        return np.arange(first, first + count, 24, dtype=np.int32)

    def turned(self, frames: Ids, cube: int) -> Ids:
        """Frames [N] turned, in their own axes, by one rotation of the cube."""
        if cube == 0:
            return frames
        base = frames // 24
        return base * 24 + COMPOSE[frames - base * 24, cube]

    def rotated(self, frames: Ids, rotations: Floats) -> Ids:
        """Frames [N] rotated, in their own axes, by rotations [3, 3] or [N, 3, 3].

        One rotation for all makes one new base for each different frame.
        """
        if rotations.ndim == 2:
            unique, inverse = np.unique(frames, return_inverse=True)
            return self.add(self.table[unique] @ rotations)[inverse]
        return self.add(self.table[frames] @ rotations)

    def axis(self, frames: Ids, axis: int) -> Floats:
        """[N, 3] the direction of one scope axis in the world."""
        return self._table[:, :, axis][frames]

    def to_world(self, frames: Ids, vectors: Floats) -> Floats:
        """Vectors [N, 3] or [3] in scope axes, turned into world axes [N, 3]."""
        return (self._table[frames] @ np.broadcast_to(vectors, (len(frames), 3))[:, :, None])[:, :, 0]
