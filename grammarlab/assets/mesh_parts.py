"""Parts of a mesh from a file, in the coordinates of the file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.errors import AssetError

Indices: TypeAlias = NDArray[np.int64]
Color: TypeAlias = tuple[float, float, float, float]
"""Red, green, blue and opacity, 0 to 1."""
Neighbours: TypeAlias = Callable[[str], bytes]
"""Function from a name in a file to the content of the file with this name; it raises AssetError."""

FARTHEST = 1e12
"""Largest coordinate that is read, in the units of the file: squares and cubes of larger ones lose their digits."""


@dataclass(frozen=True, slots=True)
class MeshPart:
    """Triangles of one color, or points without faces."""

    points: Floats
    """[P, 3] points; each is a corner of a triangle if there are triangles."""
    triangles: Indices
    """[T, 3] rows of `points`; T is 0 for a scan."""
    color: Color | None = None
    """Main color of its material; None if the file has none."""

    def __post_init__(self) -> None:
        """Refuse points and triangles that no program can use.

        Raises:
            AssetError: If a coordinate is not finite or too large, or a triangle has a corner that does not exist.
        """
        if self.points.ndim != 2 or self.points.shape[1] != 3:
            raise AssetError("it has points without three coordinates")
        if not np.isfinite(self.points).all():
            raise AssetError("it has points that are not finite numbers")
        if not (np.abs(self.points) <= FARTHEST).all():
            raise AssetError(f"it has coordinates larger than {FARTHEST:g}")
        if self.triangles.size and not 0 <= self.triangles.min() <= self.triangles.max() < len(self.points):
            raise AssetError("it has faces with corners that do not exist")

    @classmethod
    def of_triangles(cls, points: Floats, triangles: Indices, color: Color | None = None) -> MeshPart:
        """Triangles with their own corners among points [P, 3] that other parts may use.

        Raises:
            AssetError: If a triangle has a corner that does not exist.
        """
        used, rows = np.unique(triangles, return_inverse=True)
        if len(used) and not 0 <= used[0] <= used[-1] < len(points):
            raise AssetError(f"it has {len(points):,} points, and faces with corners that do not exist")
        return cls(points[used], rows.reshape(-1, 3).astype(np.int64), color)


def joined(parts: Sequence[MeshPart]) -> tuple[Floats, Indices]:
    """The points [P, 3] of all parts one after the other, and their triangles [T, 3] as rows of these points.

    >>> corner = MeshPart(np.eye(3), np.array([[0, 1, 2]]))
    >>> joined([corner, corner])[1].tolist()
    [[0, 1, 2], [3, 4, 5]]
    """
    firsts = np.cumsum([0, *(len(part.points) for part in parts)])
    triangles = [part.triangles + first for part, first in zip(parts, firsts, strict=False)]
    no_points = np.zeros((0, 3))
    return (
        np.concatenate([no_points, *(part.points for part in parts)]),
        np.concatenate([no_points.astype(np.int64), *triangles]),
    )


def color_of(channels: object) -> Color | None:
    """A color from 3 or 4 numbers, in steps of 1/255 as images have; None for other values."""
    try:
        values = np.array(channels, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    if values.shape not in {(3,), (4,)} or not np.isfinite(values).all():
        return None
    red, green, blue, opacity = (np.round(np.round(255.0 * np.clip([*values, 1.0][:4], 0.0, 1.0)) / 255.0, 4)).tolist()
    return red, green, blue, opacity
