"""Normals, texture coordinates and materials of faces: what meshes from files have besides their points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats

Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class CornerData:
    """Values at C corners, and materials of F faces; corners of one point may have different values.

    >>> data = CornerData.of_sets([np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])], 1)
    >>> data.num_sets, data.coordinates(0)[1].tolist(), data.coordinates(1)[1].tolist()
    (1, [1.0, 0.0], [nan, nan])
    """

    values: Floats
    """[C, 3 + 2 S] normal, then u and v (upwards) of each of S uv sets; NaN for none. A normal has any length > 0, and
    lies in the axes of the points: where these are stretched by a factor, it is divided by the factor."""
    slots: NDArray[np.int32]
    """[F] number of the material of each face among those of its shape."""

    @classmethod
    def of_sets(
        cls, sets: Sequence[Floats], num_faces: int, normals: Floats | None = None, slots: Indices | None = None
    ) -> CornerData:
        """Values from at least one uv set [C, 2], normals [C, 3] and materials [F] of faces."""
        missing = np.full((len(sets[0]), 3), np.nan)
        values = np.concatenate([missing if normals is None else normals, *sets], axis=1)
        return cls(values, np.zeros(num_faces, np.int32) if slots is None else slots.astype(np.int32))

    @property
    def num_sets(self) -> int:
        """S."""
        return (self.values.shape[1] - 3) // 2

    @property
    def normals(self) -> Floats:
        """[C, 3]; NaN for none."""
        return self.values[:, :3]

    def coordinates(self, uv_set: int) -> Floats:
        """[C, 2] u and v of one set; NaN for none."""
        if uv_set >= self.num_sets:
            return np.full((len(self.values), 2), np.nan)
        return self.values[:, 3 + 2 * uv_set : 5 + 2 * uv_set]

    def has_values(self) -> NDArray[np.bool_]:
        """[C] whether a corner has a normal or coordinates."""
        return np.count_nonzero(~np.isnan(self.values), axis=1) > 0

    def take(self, corners: NDArray[np.integer], faces: NDArray[np.integer]) -> CornerData:
        """The values of some corners and the materials of some faces."""
        return CornerData(self.values.take(corners, axis=0), self.slots.take(faces))

    def of_corners(self, corners: NDArray[np.integer]) -> CornerData:
        """The same faces with the values of other corners."""
        return replace(self, values=self.values.take(corners, axis=0))

    def with_normals(self, normals: Floats) -> CornerData:
        """The same values with other normals [C, 3]."""
        return replace(self, values=np.concatenate([normals, self.values[:, 3:]], axis=1))

    def without_normals(self) -> CornerData:
        """The same values without normals."""
        return self.with_normals(np.full((len(self.values), 3), np.nan))

    def with_coordinates(self, uv_set: int, coordinates: Floats) -> CornerData:
        """The same values with other coordinates [C, 2] in one set that exists."""
        values = self.values.copy()
        values[:, 3 + 2 * uv_set : 5 + 2 * uv_set] = coordinates
        return replace(self, values=values)


def join_data(parts: Sequence[tuple[CornerData | None, int, int]]) -> CornerData | None:
    """Values of several parts, one after the other; None if no part has any.

    Args:
        parts: the values of each part, its number of corners and its number of faces.
    """
    width = max((data.values.shape[1] for data, _, _ in parts if data is not None), default=0)
    if not width:
        return None
    values = np.full((sum(corners for _, corners, _ in parts), width), np.nan)
    slots = np.zeros(sum(faces for *_, faces in parts), np.int32)
    corner = face = 0
    for data, num_corners, num_faces in parts:
        if data is not None:
            values[corner : corner + num_corners, : data.values.shape[1]] = data.values
            slots[face : face + num_faces] = data.slots
        corner, face = corner + num_corners, face + num_faces
    return CornerData(values, slots)
