"""Kinds of the surfaces of a building, by the names of CityGML."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

UNLABELLED, GROUND, WALL, ROOF, WINDOW, DOOR = range(6)
"""Kinds of surfaces; faces of an unlabelled instance are ground, wall or roof by their directions and heights."""
SURFACE_TYPES = ("", "GroundSurface", "WallSurface", "RoofSurface", "Window", "Door")
"""Names of the kinds in CityJSON."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceLabels:
    """Kinds of the I instances of a scene, in their order."""

    kind: NDArray[np.int8]
    """[I] index into `SURFACE_TYPES`."""
    opening: NDArray[np.int32]
    """[I] instances of one window or of one door have the same number; arbitrary for other kinds."""

    def __len__(self) -> int:
        return len(self.kind)

    @classmethod
    def none(cls, num_instances: int) -> Self:
        """Labels of instances of which nothing is known."""
        return cls(np.zeros(num_instances, np.int8), np.zeros(num_instances, np.int32))

    def take(self, rows: slice | NDArray[np.integer] | NDArray[np.bool_]) -> SurfaceLabels:
        """Labels of selected instances."""
        return SurfaceLabels(self.kind[rows], self.opening[rows])

    @classmethod
    def concatenate(cls, parts: Sequence[SurfaceLabels]) -> Self:
        """The labels of all parts, in order; numbers of openings of different parts are of different ones."""
        ends = np.cumsum([0, *(int(part.opening.max(initial=-1)) + 1 for part in parts)])
        return cls(
            np.concatenate([np.zeros(0, np.int8), *(part.kind for part in parts)]),
            np.concatenate(
                [np.zeros(0, np.int32), *(part.opening + end for part, end in zip(parts, ends.tolist(), strict=False))]
            ).astype(np.int32),
        )
