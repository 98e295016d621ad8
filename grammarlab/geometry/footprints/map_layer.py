"""One layer of a map: the outlines of all its features and their attributes, as columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.footprint import Remark

if TYPE_CHECKING:
    import pyarrow as pa

MAX_MAP_BYTES = 4 << 30
"""Largest size of the file of a map in bytes, unpacked: a county of a million parcels has 1 GB of GeoJSON."""
MAX_FEATURES = 2_000_000
"""Largest number of features of a layer."""
MAX_ATTRIBUTES = 1_000
"""Largest number of attributes of a layer."""


@dataclass(frozen=True, eq=False, kw_only=True)
class MapLayer:
    """N features in the order of a file."""

    name: str
    """Path of the file and name of the layer, for messages."""
    bodies: Sequence[pa.Array]
    """[N] geometries of any kind and validity, perhaps with heights, in the coordinates of the file, in blocks of
    well-known binary, which takes a sixth of the memory of geometries of shapely; null where there is none."""
    attributes: pa.Table
    """[N] columns in the order of their names: int64, double, bool and string, with nulls."""
    crs: str | None
    """Name or WKT of the coordinate reference system; None if the file does not say."""
    default_crs: str = ""
    """System of files of this format that do not say, if the coordinates can be its."""
    remarks: tuple[Remark, ...] = ()

    def __post_init__(self) -> None:
        if self.attributes.num_columns and len(self.attributes) != len(self):
            raise UsageError("map layer: expected columns of equal length")

    def __len__(self) -> int:
        return sum(map(len, self.bodies))

    def blocks(self) -> Iterator[NDArray[np.object_]]:
        """The geometries as those of shapely, a block at a time."""
        return (shapely.from_wkb(block.to_numpy(zero_copy_only=False)) for block in self.bodies)

    @property
    def geometry(self) -> NDArray[np.object_]:
        """[N] geometries of shapely, None where there is none."""
        return np.concatenate([np.zeros(0, object), *self.blocks()])


def bodies_of(geometry: NDArray[np.object_]) -> pa.Array:
    """[n] well-known binary of geometries of shapely."""
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    return pa.array(shapely.to_wkb(geometry), pa.binary())
