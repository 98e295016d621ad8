"""Orientations of scopes, interned: a frame is a base rotation times one of the 24 rotations of a cube.

A shape has one integer, ``24 * base + cube``. The faces of a box and every rotation by a right angle have the same
base, so they are table look-ups and exact to the last bit. Angles of rotations are in degrees.
"""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, distinct, ranked

Ids = NDArray[np.int32]

_LOCKED = 1e-7
"""Cosine of the angle about y below which the angles about x and z cannot be told apart: rounding decides."""
_TOLERANCE = 1e-12
"""Tolerance of the entries -1, 0 and 1 of rotations by right angles."""
_MANY = 64
"""Frames of a column for each frame of the table above which gathering them is several times faster."""
_MOST_LISTED = 1 << 16
"""Largest number of frames whose directions are listed, a budget: 1.5 MB for each axis."""


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
"""[24, 3, 3] the rotations that map a cube to itself; the first is the identity."""
_PRODUCTS = np.einsum("aij,bjk->abik", CUBE, CUBE)
COMPOSE: Ids = np.array(
    [[np.flatnonzero((m == CUBE).all(axis=(1, 2)))[0] for m in row] for row in _PRODUCTS], dtype=np.int32
)
"""[24, 24] ``CUBE[COMPOSE[a, b]] == CUBE[a] @ CUBE[b]``."""
_SOURCE: Ids = np.abs(CUBE).argmax(axis=1).astype(np.int32)
"""[24, 3] axis of the base along each axis of a rotated frame; `_SIGN` has the directions."""
_SIGN: Floats = np.take_along_axis(CUBE, _SOURCE[:, None, :].astype(np.int64), axis=1)[:, 0, :]
_ENTRIES = 3 * np.arange(3)[None, :, None] + _SOURCE.astype(np.int64)[:, None, :]
"""[24, 3, 3] place of each entry of a rotated frame among the nine of its base."""
_ENTRY_SIGNS = np.ascontiguousarray(np.broadcast_to(_SIGN[:, None, :], (24, 3, 3)))
"""[24, 3, 3] sign of each entry."""
_CODES = np.full(27 * 8, -1, dtype=np.int32)
_CODES[(_SOURCE @ [9, 3, 1]) * 8 + (_SIGN < 0.0) @ [4, 2, 1]] = np.arange(24)


class FrameTable:
    """Base rotations of one derivation; the first one is the identity."""

    def __init__(self) -> None:
        self._bases = np.eye(3)[None].repeat(16, axis=0)
        self._used = 1
        self.has_mirrored = False
        """Whether a base may be left-handed."""
        self._axes: dict[tuple[int, int], Floats] = {}
        self._listed = [np.empty((0, 3))] * 3
        self._num_asked = 0

    def add(self, rotations: Floats) -> Ids:
        """Frames [N] of new base rotations [N, 3, 3]."""
        first, end = self._used, self._used + len(rotations)
        if end > len(self._bases):
            grown = np.empty((max(2 * len(self._bases), end), 3, 3))
            grown[:first] = self._bases[:first]
            self._bases = grown
        self._bases[first:end] = rotations
        self._used = end
        return np.arange(24 * first, 24 * end, 24, dtype=np.int32)

    def turned(self, frames: Ids, cube: int) -> Ids:
        """Frames [N] rotated, in their own axes, by one rotation of the cube."""
        if cube == 0:
            return frames
        base = frames // 24
        return base * 24 + COMPOSE[frames - base * 24, cube]

    def turned_each(self, frames: Ids, cubes: Ids) -> Ids:
        """Frames [N] rotated, in their own axes, by one rotation of the cube each [N]."""
        base = frames // 24
        return base * 24 + COMPOSE[frames - base * 24, cubes]

    def rotated(self, frames: Ids, rotations: Floats) -> Ids:
        """Frames [N] rotated, in their own axes, by rotations [3, 3] or [N, 3, 3].

        Rotations by right angles stay exact. Another single rotation makes one new base for each different frame.
        """
        if rotations.ndim == 2:
            turn = int(cube_indices(rotations[None])[0])
            self.has_mirrored = self.has_mirrored or bool(np.linalg.det(rotations) < 0.0)
            if turn >= 0:
                return self.turned(frames, turn)
            different = distinct(frames, 24 * self._used).astype(np.int32)
            added = self.add(self.rotations(different) @ rotations)
            return added[np.searchsorted(different, frames)]
        cube = cube_indices(rotations)
        skew = np.flatnonzero(cube < 0)
        result = self.turned_each(frames, cube)
        if len(skew):
            result[skew] = self.add(self.rotations(frames[skew]) @ rotations[skew])
        return result

    def rotated_alike(self, frames: Ids, rotations: Floats, number: NDArray[np.int64]) -> Ids:
        """Frames [N] rotated, in their own axes, each by the rotation [K, 3, 3] of its number [N].

        Equal frames with the same rotation have the same result.
        """
        cube = cube_indices(rotations)[number]
        result = self.turned_each(frames, cube)
        skew = np.flatnonzero(cube < 0)
        if len(skew):
            pairs, inverse = np.unique(
                frames[skew].astype(np.int64) * len(rotations) + number[skew], return_inverse=True
            )
            frame, turn = np.divmod(pairs, len(rotations))
            result[skew] = self.add(self.rotations(frame.astype(np.int32)) @ rotations[turn])[inverse]
        return result

    def rotated_about(self, frames: Ids, axes: Ids, rotations: Floats) -> Ids:
        """Frames [N] rotated, in the axes of other frames [N], by rotations [3, 3] or [N, 3, 3]."""
        other = np.flatnonzero(frames != axes)
        if len(other) == 0:
            return self.rotated(frames, rotations)
        if rotations.ndim == 2:
            limit = 24 * self._used
            pairs, inverse = np.unique(frames.astype(np.int64) * limit + axes, return_inverse=True)
            frames, axes = (part.astype(np.int32) for part in np.divmod(pairs, limit))
            return self.rotated_about(frames, axes, rotations[None].repeat(len(pairs), axis=0))[inverse]
        rotations_in_frames = rotations.copy()
        about, own = self.rotations(axes[other]), self.rotations(frames[other])
        relative = np.swapaxes(about, 1, 2) @ own
        rotations_in_frames[other] = np.swapaxes(relative, 1, 2) @ rotations[other] @ relative
        cube = cube_indices(rotations_in_frames)
        result = self.turned_each(frames, cube)
        skew = np.flatnonzero(cube < 0)
        if len(skew):
            turned = self.rotations(frames) @ rotations
            # A product with ``rotations_in_frames`` has the frame three times, whose rounding error would triple.
            turned[other] = about @ rotations[other] @ np.swapaxes(about, 1, 2) @ own
            result[skew] = self.add(turned[skew])
        return result

    def are_left_handed(self, frames: Ids) -> NDArray[np.bool_]:
        """[N] whether frames have a left-handed base."""
        if not self.has_mirrored:
            return np.zeros(len(frames), dtype=bool)
        return np.linalg.det(self._bases[: self._used])[frames // 24] < 0.0

    def rotations(self, frames: Ids) -> Floats:
        """[N, 3, 3] rotations of frames; columns are the scope's axes in the world."""
        if self._repeat(frames):
            different, rank = ranked(frames, 24 * self._used)
            return self._turned(different.astype(np.int32)).take(rank, axis=0)
        return self._turned(frames)

    def _repeat(self, frames: Ids) -> bool:
        """Whether frames [N] are so many that it pays to compute each different one once."""
        return len(frames) >= _MANY * 24 * self._used

    def _turned(self, frames: Ids) -> Floats:
        """[N, 3, 3] the same, computed for each frame."""
        base = frames // 24
        cube = frames - base * 24
        entry = _ENTRIES.take(cube, axis=0)
        entry += 9 * base.astype(np.int64)[:, None, None]
        turned = self._bases.ravel().take(entry)
        turned *= _ENTRY_SIGNS.take(cube, axis=0)
        return turned

    def axis(self, frames: Ids, axis: int) -> Floats:
        """[N, 3] the direction of one scope axis in the world."""
        if len(frames) == 1:
            return self._single_axis(int(frames[0]), axis)
        if self._pays_to_list(len(frames)):
            return self._list(axis).take(frames, axis=0)
        if self._repeat(frames):
            different, rank = ranked(frames, 24 * self._used)
            return self._directions(different.astype(np.int32), axis).take(rank, axis=0)
        return self._directions(frames, axis)

    def _pays_to_list(self, count: int) -> bool:
        """Whether directions have been computed for more frames than the table has, these included."""
        self._num_asked += count
        return 24 * self._used <= min(self._num_asked, _MOST_LISTED)

    def _list(self, axis: int) -> Floats:
        """[24 bases, 3] direction of one scope axis of all frames; those of new bases are added."""
        listed = self._listed[axis]
        if len(listed) < 24 * self._used:
            added = self._directions(np.arange(len(listed), 24 * self._used, dtype=np.int32), axis)
            self._listed[axis] = listed = np.concatenate([listed, added])
        return listed

    def _directions(self, frames: Ids, axis: int) -> Floats:
        """[N, 3] the same, computed for each frame."""
        base = frames // 24
        cube = frames - base * 24
        return self._bases[base, :, _SOURCE[cube, axis]] * _SIGN[cube, axis][:, None]

    def _single_axis(self, frame: int, axis: int) -> Floats:
        """[1, 3] the same for one frame; cached, since consecutive shapes are cut along it."""
        direction = self._axes.get((frame, axis))
        if direction is None:
            base, turn = divmod(frame, 24)
            direction = (self._bases[base, :, _SOURCE[turn, axis]] * _SIGN[turn, axis])[None, :]
            self._axes[frame, axis] = direction
        return direction

    def to_world(self, frames: Ids, vectors: Floats) -> Floats:
        """Vectors [N, 3] in scope axes, turned into world axes [N, 3]."""
        return np.einsum("nij,nj->ni", self.rotations(frames), vectors)

    def to_local(self, frames: Ids, vectors: Floats) -> Floats:
        """Vectors [N, 3] in world axes, turned into scope axes [N, 3]."""
        return np.einsum("nji,nj->ni", self.rotations(frames), vectors)

    def used(self, frames: Ids) -> tuple[Floats, Ids]:
        """Rotations [K, 3, 3] of the different frames of a column [N], and the index [N] of each among them."""
        present = np.zeros(24 * self._used, dtype=bool)
        places = frames.astype(np.int64)
        present[places] = True
        index = (np.cumsum(present) - 1).astype(np.int32)
        return self.rotations(np.flatnonzero(present).astype(np.int32)), index.take(places)


def cube_index(matrix: Floats) -> int:
    """The index in `CUBE` of a rotation by right angles [3, 3]."""
    return int(np.flatnonzero((np.abs(matrix - CUBE) < 0.5).all(axis=(1, 2)))[0])


def cube_indices(rotations: Floats) -> Ids:
    """Indices [N] in `CUBE` of rotations [N, 3, 3], -1 for rotations that are not by right angles."""
    rounded = np.rint(rotations)
    code = (np.abs(rounded).argmax(axis=1) @ [9, 3, 1]) * 8 + (rounded.sum(axis=1) < 0.0) @ [4, 2, 1]
    straight = np.abs(rotations - rounded).max(axis=(1, 2), initial=0.0) < _TOLERANCE
    return np.where(straight, _CODES[code], np.int32(-1))


def euler(x: float | Floats, y: float | Floats, z: float | Floats) -> Floats:
    """Rotations Rz Ry Rx, about x first, by angles in degrees: [3, 3] from numbers, [N, 3, 3] with columns [N]."""
    x, y, z = np.broadcast_arrays(*np.radians(np.broadcast_arrays(x, y, z)))
    (cx, cy, cz), (sx, sy, sz) = (np.cos(a) for a in (x, y, z)), (np.sin(a) for a in (x, y, z))
    rows = [
        [cy * cz, sx * sy * cz - cx * sz, cx * sy * cz + sx * sz],
        [cy * sz, sx * sy * sz + cx * cz, cx * sy * sz - sx * cz],
        [-sy, sx * cy, cx * cy],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def euler_angles(rotations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles [N, 3] in degrees about x, y, z whose rotations Rz Ry Rx, about x first, give the matrices [N, 3, 3].

    Where the angle about y is a right one, those about x and z turn about one axis, and the latter is 0.
    """
    is_locked = np.hypot(rotations[:, 2, 1], rotations[:, 2, 2]) < _LOCKED
    sine = np.clip(-rotations[:, 2, 0], -1.0, 1.0)
    # The inverse of the sine has half as many digits there.
    y = np.arcsin(np.where(is_locked, np.sign(sine), sine))
    x = np.arctan2(
        np.where(is_locked, -rotations[:, 1, 2], rotations[:, 2, 1]),
        np.where(is_locked, rotations[:, 1, 1], rotations[:, 2, 2]),
    )
    z = np.where(is_locked, 0.0, np.arctan2(rotations[:, 1, 0], rotations[:, 0, 0]))
    return np.degrees(np.stack([x, y, z], axis=1))
