"""Rows of the table of parcels: what stands on each parcel of a city, in columns."""

from __future__ import annotations

from collections.abc import Mapping, Sized
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city.packed_outlines import Outlines
from grammarlab.errors import UsageError

Texts = NDArray[np.object_]


@dataclass(frozen=True, eq=False, kw_only=True)
class ParcelRows:
    """N parcels in any order."""

    id: Texts
    """[N] different texts."""
    outline: Outlines
    """[N] polygons, x to the east and y to the north of the frame's origin, in metres."""
    lot: Outlines
    """[N] footprints of buildings in the same coordinates, from edge 0 on; None for empty parcels."""
    zone: Texts
    """[N] name of the zone; empty for none."""
    reason: Texts
    """[N] why nothing is built; empty for parcels that are built."""
    seed: NDArray[np.uint64]
    """[N] seed: the city's, or that of a pin."""
    model: NDArray[np.uint64]
    """[N] index of the model under the seed."""
    reroll: Ints
    """[N] how often the parcel was rerolled, >= 0."""
    grammar: Texts
    """[N] hash of the grammar; empty for empty parcels."""
    area: Floats
    """[N] square metres of the parcel."""
    street_width: Floats
    """[E] widths in metres of the streets along the edges of the lots; 0 for edges without a street."""
    lot_edges: Ints
    """[N + 1] into `street_width`."""
    tile: Texts
    """[N] path of the tile with the building; empty for none."""
    reports: Mapping[str, Floats]
    """[N] values by the keys of ``report`` in the grammars; NaN for none."""

    def __post_init__(self) -> None:
        columns: list[Sized] = [
            self.outline,
            self.lot,
            self.zone,
            self.reason,
            self.seed,
            self.model,
            self.reroll,
            self.grammar,
        ]
        columns += [self.area, self.tile, *self.reports.values()]
        if any(len(column) != len(self) for column in columns) or len(self.lot_edges) != len(self) + 1:
            raise UsageError("rows of parcels: expected columns of equal length")

    def __len__(self) -> int:
        return len(self.id)

    @property
    def is_built(self) -> Flags:
        """[N] whether something is built."""
        return self.reason == ""
