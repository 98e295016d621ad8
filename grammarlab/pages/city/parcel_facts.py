"""Facts of parcels for the page, from the table that a build writes (``parcels.parquet``)."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import shapely
from numpy.typing import NDArray

from grammarlab.errors import AssetError, UsageError, shown
from grammarlab.files import open_regular

FILE = "parcels.parquet"
MAX_FILE_BYTES = 4 << 30
"""Largest size of a table in bytes."""
BUILT = "built"
_NEEDED = ("id", "zone", "status", "reason", "seed", "model", "reroll")
_GEOMETRY = "geometry"
_UNSHOWN = {"id", "status", "zone", "grammar", _GEOMETRY, "lot", "bbox"}
_UNITS = {"area": "m²", "street_widths": "m"}
_REPORT = "report."


@dataclass(frozen=True, eq=False)
class ParcelFacts:
    """What a table says of N parcels, in its order."""

    table: pa.Table
    """[N] all columns."""

    @classmethod
    def read(cls, folder: Path) -> ParcelFacts:
        """The table in the folder of a city.

        Raises:
            AssetError: If there is none, or it is not such a table.
        """
        path = folder / FILE
        if not path.is_file():
            raise AssetError(f"{folder}: expected the folder of a built city; {FILE} is missing. Build it first.")
        try:
            with open_regular(path, MAX_FILE_BYTES) as file:
                table = pq.read_table(pa.PythonFile(file, mode="r"))
        except (pa.ArrowException, OSError) as error:
            raise AssetError(f"{path}: expected a table of parcels ({error}).") from error
        missing = [name for name in (*_NEEDED, _GEOMETRY) if name not in table.column_names]
        if missing:
            raise AssetError(f"{path}: expected a table of parcels; missing columns: {', '.join(missing)}.")
        return cls(table)

    def __len__(self) -> int:
        return self.table.num_rows

    @cached_property
    def ids(self) -> list[str]:
        """[N] ids of the parcels."""
        return self.table["id"].to_pylist()

    @cached_property
    def zones(self) -> list[str]:
        """Names of zones, in alphabetical order."""
        return sorted({zone for zone in self.table["zone"].to_pylist() if zone})

    @cached_property
    def zone(self) -> NDArray[np.object_]:
        """[N] name of the zone; empty for none."""
        return np.array([zone or "" for zone in self.table["zone"].to_pylist()], object)

    @cached_property
    def is_built(self) -> NDArray[np.bool_]:
        """[N] whether the parcel has a building."""
        return np.array([status == BUILT for status in self.table["status"].to_pylist()], np.bool_)

    @cached_property
    def outlines(self) -> NDArray[np.object_]:
        """[N] polygons in the coordinate system of the table; None for missing ones.

        Raises:
            AssetError: If they cannot be read.
        """
        try:
            return np.asarray(shapely.from_wkb(self.table[_GEOMETRY].to_numpy()))
        except shapely.GEOSException as error:
            raise AssetError(f"{FILE}: expected outlines as WKB ({error}).") from error

    @cached_property
    def crs(self) -> dict[str, Any] | None:
        """Coordinate system of the outlines as PROJJSON; None for metres at an unknown place."""
        metadata = self.table.schema.metadata or {}
        try:
            return json.loads(metadata.get(b"geo", b"{}"))["columns"][_GEOMETRY]["crs"]
        except (ValueError, LookupError, TypeError):
            return None

    def row(self, parcel: str) -> int:
        """Row of a parcel.

        Raises:
            UsageError: If there is no parcel with this id.
        """
        if parcel not in self._rows:
            raise UsageError(f"id: there is no parcel {shown(parcel)}.")
        return self._rows[parcel]

    def value(self, parcel: str, name: str) -> Any:
        """A value of a parcel."""
        return self.table[name][self.row(parcel)].as_py()

    def of(self, parcel: str) -> list[tuple[str, str]]:
        """Names and values of what is known of a parcel, as text.

        Raises:
            UsageError: If there is no parcel with this id.
        """
        row = self.row(parcel)
        values = {name: self.table[name][row].as_py() for name in self.table.column_names if name not in _UNSHOWN}
        return [
            (name.removeprefix(_REPORT).replace("_", " "), text)
            for name, value in values.items()
            if (text := _text(value, _UNITS.get(name, "")))
        ]

    def numbers_of_empty(self) -> dict[str, int]:
        """Number of parcels without a building, by reason."""
        reasons = self.table["reason"].to_pylist()
        return dict(Counter(reason or "" for reason, built in zip(reasons, self.is_built, strict=True) if not built))

    @cached_property
    def _rows(self) -> dict[str, int]:
        return {parcel: row for row, parcel in enumerate(self.ids)}


def _text(value: Any, unit: str) -> str:
    """A value in words; empty for a missing one."""
    if value is None or value == "" or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, list):
        return ", ".join(_text(each, unit) for each in value[:12])
    if isinstance(value, float):
        value = f"{value:.1f}".removesuffix(".0")
    return f"{value} {unit}".strip()
