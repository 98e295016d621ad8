"""Facts of parcels for the page, from the table that a build writes (``parcels.parquet``)."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import AssetError, UsageError, shown
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.runs.city.parcel_reading import frame_of_table, read_parcel_table
from grammarlab.runs.city.parcel_rows import ParcelRows

FILE = "parcels.parquet"


@dataclass(frozen=True, eq=False)
class ParcelFacts:
    """What a table says of N parcels, in its order."""

    rows: ParcelRows
    frame: Frame

    @classmethod
    def read(cls, folder: Path) -> ParcelFacts:
        """The table in the folder of a city.

        Raises:
            AssetError: If there is none, or it is not such a table.
        """
        path = folder / FILE
        if not path.is_file():
            raise AssetError(f"{folder}: expected the folder of a built city; {FILE} is missing. Build it first.")
        return cls(read_parcel_table(path), frame_of_table(path))

    def __len__(self) -> int:
        return len(self.rows)

    @cached_property
    def zones(self) -> list[str]:
        """Names of zones, in alphabetical order."""
        return sorted({*self.rows.zone} - {""})

    @property
    def is_built(self) -> NDArray[np.bool_]:
        """[N] whether the parcel has a building."""
        return self.rows.is_built

    def row(self, parcel: str) -> int:
        """Row of a parcel.

        Raises:
            UsageError: If there is no parcel with this id.
        """
        if parcel not in self._rows:
            raise UsageError(f"id: there is no parcel {shown(parcel)}.")
        return self._rows[parcel]

    def zone_of(self, parcel: str) -> str:
        """Zone of a parcel; empty for none."""
        return self.rows.zone[self.row(parcel)]

    def address_of(self, parcel: str) -> tuple[int, int]:
        """Seed and index of the model of a parcel."""
        row = self.row(parcel)
        return int(self.rows.seed[row]), int(self.rows.model[row])

    def of(self, parcel: str) -> list[tuple[str, str]]:
        """Names and values of what is known of a parcel, as text; without those that are missing.

        Raises:
            UsageError: If there is no parcel with this id.
        """
        row, rows = self.row(parcel), self.rows
        widths = rows.street_width[slice(*rows.lot_edges[row : row + 2])]
        facts = {
            "empty": rows.reason[row],
            "seed": str(rows.seed[row]),
            "model": str(rows.model[row]),
            "reroll": str(rows.reroll[row]),
            "area": f"{_number(rows.area[row])} m²",
            "street widths": ", ".join(f"{_number(width)} m" for width in widths[:12]),
            "tile": rows.tile[row],
        }
        facts |= {name: _number(values[row]) for name, values in rows.reports.items() if np.isfinite(values[row])}
        return [(name, text) for name, text in facts.items() if text]

    def numbers_of_empty(self) -> dict[str, int]:
        """Number of parcels without a building, by reason."""
        return dict(Counter(self.rows.reason[~self.is_built].tolist()))

    @cached_property
    def _rows(self) -> dict[str, int]:
        return {parcel: row for row, parcel in enumerate(self.rows.id.tolist())}


def _number(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")
