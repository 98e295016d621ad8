"""Trees of a map: points with the names of their species, such as a city's inventory of the trees along its streets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.city.map_shapes import read_shapes
from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.frame import Frame


@dataclass(frozen=True, eq=False)
class MappedTrees:
    """n trees of a map."""

    east_north: Floats
    """[n, 2] metres from the frame's origin."""
    name: NDArray[np.object_]
    """[n] name of the species on the map; empty if it is missing."""

    def __len__(self) -> int:
        return len(self.name)


def read_mapped_trees(path: Path, field: str, frame: Frame) -> MappedTrees:
    """The points of a map as trees; its lines and polygons are left out.

    Args:
        path: file of a vector format; ``:LAYER`` may follow.
        field: field with the name of the species.
        frame: frame of the city.

    Raises:
        AssetError: If the file cannot be read, or has no points or no such field.
        UsageError: If the layer is unknown, or the extra ``city`` is missing.
    """
    shapes = read_shapes(path, frame)
    if field not in shapes.attributes.column_names:
        listing = ", ".join(shapes.attributes.column_names)[:200] or "none"
        raise AssetError(
            f"{path}: expected the names of species in the field {field!r}, found the fields {listing}. "
            'Name the one of them: [tree_map] field = "…".'
        )
    parts, row = shapely.get_parts(shapes.geometry, return_index=True)
    is_point = shapely.get_type_id(parts) == shapely.GeometryType.POINT
    if not is_point.any():
        raise AssetError(f"{path}: expected trees as points, found none.")
    names = np.array([_text(value) for value in shapes.attributes[field].to_pylist()], object)
    return MappedTrees(shapely.get_coordinates(parts[is_point]), names[row[is_point]])


def _text(value: object) -> str:
    return "" if value is None else str(value).strip()
