"""Parcels: outlines with identities and attributes, in the frame of a city."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.city.packed_outlines import Outlines, PackedOutlines
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.frame import Frame

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True, eq=False, kw_only=True)
class Parcels:
    """N parcels, ordered by id."""

    frame: Frame
    id: NDArray[np.object_]
    """[N] different texts: canonical ids (`grammarlab.city.parcel_ids`); parts of one parcel end in ``#1``, ``#2``."""
    outlines: PackedOutlines
    """[N] valid polygons, x to the east and y to the north of the frame's origin, in metres."""
    elevation: Floats
    """[N] height of a parcel of a 3D map in metres, NaN if unknown."""
    attributes: pa.Table
    """[N] columns of the map: texts, numbers and flags, with nulls."""
    first_edge: NDArray[np.int32]
    """[N] the edge of the outer ring that the map draws first, counted from 1 in the order of `outlines`; negative
    where it draws the ring the other way round, and 0 where it draws another outline."""
    reason: NDArray[np.object_]
    """[N] why nothing can be built: ``overlap``, ``small``; empty for usable parcels."""

    def __post_init__(self) -> None:
        columns = (self.outlines, self.elevation, self.first_edge, self.reason, *self.attributes.columns)
        if any(len(column) != len(self) for column in columns):
            raise UsageError("parcels: expected columns of equal length")

    def __len__(self) -> int:
        return len(self.id)

    @property
    def usable(self) -> NDArray[np.bool_]:
        """[N] whether something may be built."""
        return self.reason == ""

    @property
    def outline(self) -> Outlines:
        """[N] polygons of shapely, made for this call: they take ten times the memory of `outlines`."""
        return self.outlines[:]

    @property
    def area(self) -> Floats:
        """[N] square metres."""
        return self.outlines.area

    def take(self, rows: NDArray[Any]) -> Parcels:
        """The parcels at these rows (indices or flags), in this order."""
        indices = np.arange(len(self))[rows]
        return Parcels(
            frame=self.frame,
            id=self.id[indices],
            outlines=self.outlines.take(indices),
            elevation=self.elevation[indices],
            attributes=self.attributes.take(indices),
            first_edge=self.first_edge[indices],
            reason=self.reason[indices],
        )
