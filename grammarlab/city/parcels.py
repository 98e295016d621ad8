"""Parcels: outlines with identities and attributes, in the frame of a city."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.frame import Frame

if TYPE_CHECKING:
    import pyarrow as pa

Outlines: TypeAlias = NDArray[np.object_]
"""[N] polygons of shapely, with their holes."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Parcels:
    """N parcels, ordered by id."""

    frame: Frame
    id: NDArray[np.object_]
    """[N] different texts: canonical ids (`grammarlab.city.parcel_ids`); parts of one parcel end in ``#1``, ``#2``."""
    outline: Outlines
    """[N] valid polygons, x to the east and y to the north of the frame's origin, in metres."""
    elevation: Floats
    """[N] height of a parcel of a 3D map in metres, NaN if unknown."""
    attributes: pa.Table
    """[N] columns of the map: texts, numbers and flags, with nulls."""
    reason: NDArray[np.object_]
    """[N] why nothing can be built: ``overlap``, ``small``; empty for usable parcels."""

    def __post_init__(self) -> None:
        columns = (self.outline, self.elevation, self.reason, *self.attributes.columns)
        if any(len(column) != len(self) for column in columns):
            raise UsageError("parcels: expected columns of equal length")

    def __len__(self) -> int:
        return len(self.id)

    @property
    def usable(self) -> NDArray[np.bool_]:
        """[N] whether something may be built."""
        return self.reason == ""

    @property
    def area(self) -> Floats:
        """[N] square metres."""
        return shapely.area(self.outline)

    def take(self, rows: NDArray[Any]) -> Parcels:
        """The parcels at these rows (indices or flags), in this order."""
        indices = np.arange(len(self))[rows]
        return Parcels(
            frame=self.frame,
            id=self.id[indices],
            outline=self.outline[indices],
            elevation=self.elevation[indices],
            attributes=self.attributes.take(indices),
            reason=self.reason[indices],
        )
