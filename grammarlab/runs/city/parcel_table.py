"""Writing tables of parcels: GeoParquet 1.1 in the coordinate reference system of the city.

geometry       outline of the parcel, WKB
lot            footprint of the building, WKB; null for empty parcels
bbox           struct of xmin, ymin, xmax, ymax of the outline; readers skip groups of rows by it
id, zone       texts
status         ``built`` or ``empty``
reason         why the parcel is empty, or null
seed, model    uint64: address of the model; reroll is the number of its rerolls
grammar        hash of the grammar, or null
area           square metres of the parcel
street_widths  list: width in metres of the street along each edge of the lot from its first corner, 0 for none
tile           path of the tile with the building, or null
report.KEY     values of the grammar's ``report``, or null

Rows are in Morton order of their places, in groups of 20,000, whatever the order in which they came.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self, final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import shapely

from grammarlab.arrays import Ints
from grammarlab.city.packed_outlines import Outlines
from grammarlab.export.model_files import whole_file
from grammarlab.export.tiles.tile_grid import morton
from grammarlab.extras import named_extras
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.runs.city.parcel_rows import ParcelRows, Texts

FORMAT = 1
"""Version of the columns above."""
GROUP_ROWS = 20_000
"""Rows per group of the file."""
REPORT = "report."
"""Prefix of the columns of values that grammars report."""
NOTE = b"grammarlab"
"""Key of the metadata with the version and the frame."""
_BOX = pa.struct([(name, pa.float64()) for name in ("xmin", "ymin", "xmax", "ymax")])
COLUMNS = {
    "geometry": pa.binary(),
    "lot": pa.binary(),
    "bbox": _BOX,
    "id": pa.string(),
    "zone": pa.string(),
    "status": pa.string(),
    "reason": pa.string(),
    "seed": pa.uint64(),
    "model": pa.uint64(),
    "reroll": pa.int64(),
    "grammar": pa.string(),
    "area": pa.float64(),
    "street_widths": pa.list_(pa.float64()),
    "tile": pa.string(),
}
"""Columns of every table, in their order."""
_TYPES = {3: "Polygon", 6: "MultiPolygon"}
"""Names of the types of geometries by their numbers in shapely."""
_ORDER = [("code", "ascending"), ("id", "ascending")]
_MIDDLE = 2**30
"""Offset in metres that makes all coordinates of a frame positive, so that tiles are consecutive in Morton order."""
_REPEATED = ["zone", "status", "reason", "grammar", "tile"]
"""Columns of few different texts."""


@final
class ParcelTableWriter:
    """A table of parcels in the making, which is under its name once it is complete, or not at all.

    Rows wait on the disk until all have come, so memory hardly grows with the number of parcels, and the file does not
    depend on how rows came in parts.

    Args:
        path: the file; its folder is made.
        frame: frame of the city.

    Raises:
        UsageError: If the path cannot be written to.
    """

    def __init__(self, path: Path, frame: Frame) -> None:
        self._frame = frame
        with ExitStack() as stack:
            self._output = stack.enter_context(whole_file(path))
            self._rows = _WaitingRows(stack.enter_context(tempfile.TemporaryFile(dir=self._output.folder)))
            self._stack = stack.pop_all()

    def add(self, rows: ParcelRows) -> Self:
        """Add parcels."""
        self._rows.add(rows, self._frame)
        return self

    def finish(self) -> None:
        """Complete the file."""
        with self._stack:
            self._rows.write(self._output.stream, self._frame)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None:
            self.finish()
        else:
            self._stack.__exit__(kind, error, traceback)


class _WaitingRows:
    """Rows in a temporary file, in pieces, and their places in the final order."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._ends = [0]
        self._keys: list[pa.Table] = []
        self._reports: set[str] = set()
        self._types: dict[str, set[str]] = {"geometry": set(), "lot": set()}
        self._box = np.array([np.inf, np.inf, -np.inf, -np.inf])

    def add(self, rows: ParcelRows, frame: Frame) -> None:
        """Append rows."""
        if len(rows) == 0:
            return
        self._reports.update(REPORT + name for name in rows.reports)
        for name, outlines in (("geometry", rows.outline), ("lot", rows.lot)):
            self._types[name].update(
                _TYPES[number] for number in np.unique(shapely.get_type_id(outlines)) if number >= 0
            )
        bounds = shapely.bounds(rows.outline) + np.tile(frame.origin, 2)
        self._box[:2] = np.minimum(self._box[:2], bounds[:, :2].min(axis=0))
        self._box[2:] = np.maximum(self._box[2:], bounds[:, 2:].max(axis=0))
        keys = pa.table(
            {"code": _codes(rows.outline), "id": pa.array(rows.id, pa.string()), "row": np.arange(len(rows))}
        )
        keys = keys.sort_by(_ORDER)
        table = _to_arrow(rows, frame).take(keys["row"])
        for start in range(0, len(table), GROUP_ROWS):
            self._append(table.slice(start, GROUP_ROWS), keys.slice(start, GROUP_ROWS))

    def _append(self, table: pa.Table, keys: pa.Table) -> None:
        sink = pa.BufferOutputStream()
        with pa.ipc.new_stream(sink, table.schema) as stream:
            stream.write_table(table)
        self._ends.append(self._ends[-1] + self._file.write(sink.getvalue()))
        piece = np.full(len(table), len(self._ends) - 2)
        self._keys.append(keys.set_column(2, "row", [np.arange(len(table))]).append_column("piece", [piece]))

    def write(self, stream: IO[bytes], frame: Frame) -> None:
        """Write all rows in order."""
        schema = pa.schema({**COLUMNS, **dict.fromkeys(sorted(self._reports), pa.float64())})
        schema = schema.with_metadata({b"geo": _json(self._geo(frame)), NOTE: _json(_note(frame))})
        options: dict[str, Any] = {"compression": "zstd", "use_dictionary": _REPEATED}
        with pq.ParquetWriter(stream, schema, **options) as writer:
            order = self._order()
            for start in range(0, len(order), GROUP_ROWS):
                group = order.slice(start, GROUP_ROWS)
                writer.write_table(self._gathered(group, schema), row_group_size=GROUP_ROWS)

    def _order(self) -> pa.Table:
        """Piece and row of each row of the file."""
        if not self._keys:
            return pa.table({"piece": np.zeros(0, np.int64), "row": np.zeros(0, np.int64)})
        return pa.concat_tables(self._keys).sort_by(_ORDER).select(["piece", "row"])

    def _gathered(self, order: pa.Table, schema: pa.Schema) -> pa.Table:
        """Selected rows of the pieces, with all columns of a schema."""
        piece, row = order["piece"].to_numpy(), order["row"].to_numpy()
        by_piece = np.argsort(piece, kind="stable")
        used, starts = np.unique(piece[by_piece], return_index=True)
        tables = [
            _aligned(self._piece(index).take(rows), schema)
            for index, rows in zip(used.tolist(), np.split(row[by_piece], starts[1:]), strict=True)
        ]
        return pa.concat_tables(tables).take(np.argsort(by_piece, kind="stable"))

    def _piece(self, index: int) -> pa.Table:
        start, end = self._ends[index : index + 2]
        self._file.seek(start)
        with pa.ipc.open_stream(self._file.read(end - start)) as stream:
            return stream.read_all()

    def _geo(self, frame: Frame) -> dict[str, Any]:
        """Metadata of GeoParquet."""
        columns = {name: _geo_column(frame, types) for name, types in self._types.items()}
        corners = {corner: ["bbox", corner] for corner in ("xmin", "ymin", "xmax", "ymax")}
        columns["geometry"]["covering"] = {"bbox": corners}
        if np.isfinite(self._box).all():
            columns["geometry"]["bbox"] = self._box.tolist()
        return {"version": "1.1.0", "primary_column": "geometry", "columns": columns}


def _aligned(table: pa.Table, schema: pa.Schema) -> pa.Table:
    """The table with all columns of a schema, those that it lacks without values."""
    columns = [
        table[field.name] if field.name in table.column_names else pa.nulls(len(table), field.type) for field in schema
    ]
    return pa.table(columns, schema=schema)


def _to_arrow(rows: ParcelRows, frame: Frame) -> pa.Table:
    outlines, lots = (_in_system(column, frame) for column in (rows.outline, rows.lot))
    boxes = shapely.bounds(outlines)
    columns = {
        "geometry": _wkb(outlines),
        "lot": _wkb(lots),
        "bbox": pa.StructArray.from_arrays([pa.array(column) for column in boxes.T], fields=list(_BOX)),
        "id": pa.array(rows.id, pa.string()),
        "zone": _texts(rows.zone),
        "status": pa.array(np.where(rows.is_built, "built", "empty")),
        "reason": _texts(rows.reason),
        "seed": pa.array(rows.seed),
        "model": pa.array(rows.model),
        "reroll": pa.array(rows.reroll),
        "grammar": _texts(rows.grammar),
        "area": pa.array(rows.area),
        "street_widths": pa.ListArray.from_arrays(
            pa.array(rows.lot_edges, pa.int32()), pa.array(rows.street_width), mask=pa.array(shapely.is_missing(lots))
        ),
        "tile": _texts(rows.tile),
    }
    reports = {REPORT + name: pa.array(values, from_pandas=True) for name, values in rows.reports.items()}
    return pa.table(columns | reports)


def _in_system(outlines: Outlines, frame: Frame) -> Outlines:
    """Outlines in the coordinates of the system of the frame."""
    return shapely.transform(outlines, lambda points: points + frame.origin)


def _wkb(outlines: Outlines) -> pa.Array:
    return pa.array(shapely.to_wkb(outlines), pa.binary())


def _texts(column: Texts) -> pa.Array:
    """Texts; empty ones are null."""
    return pa.array(column, pa.string(), mask=column == "")


def _codes(outlines: Outlines) -> Ints:
    """[N] places in Morton order of the middles of bounding boxes, in whole metres."""
    west, south, east, north = shapely.bounds(outlines).T
    middles = np.column_stack([west + east, south + north]) / 2
    return morton(np.floor(middles).astype(np.int64) + _MIDDLE)


def _geo_column(frame: Frame, types: set[str]) -> dict[str, Any]:
    """Metadata of a column; without ``crs`` its coordinates would be degrees, and null says that nothing is known."""
    return {"encoding": "WKB", "geometry_types": sorted(types), "crs": _projjson(frame), "edges": "planar"}


def _projjson(frame: Frame) -> dict[str, Any] | None:
    if not frame.has_place:
        return None
    with named_extras():
        from pyproj import CRS  # noqa: PLC0415  # an extra
    return CRS.from_user_input(frame.crs).to_json_dict()


def _note(frame: Frame) -> dict[str, Any]:
    """What GeoParquet does not say: the frame, so that a reader has its metres again."""
    return {"format": FORMAT, "crs": frame.crs, "origin": frame.origin}


def _json(value: Mapping[str, Any]) -> bytes:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).encode()
