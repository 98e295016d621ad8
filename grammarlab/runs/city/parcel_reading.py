"""Reading tables of parcels that `grammarlab.runs.city.parcel_table` has written."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from functools import reduce
from operator import and_
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import shapely

from grammarlab.arrays import offsets_from_counts
from grammarlab.city.packed_outlines import Outlines
from grammarlab.errors import AssetError
from grammarlab.files import open_regular
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.runs.city.parcel_rows import ParcelRows, Texts
from grammarlab.runs.city.parcel_table import COLUMNS, FORMAT, NOTE, REPORT

MAX_ROWS = 4_000_000
"""Largest number of parcels of a file."""
MAX_BYTES = 1 << 33
"""Largest size of the columns of a file in memory, in bytes."""
_DAMAGE = (LookupError, ValueError, TypeError, AttributeError, RecursionError, pa.ArrowException, shapely.GEOSException)


def frame_of_table(path: Path) -> Frame:
    """Frame of the city of a table.

    Raises:
        AssetError: If the file is not a table of parcels of a known version.
        OSError: If it cannot be opened.
    """
    with _checked(path) as (_, frame):
        return frame


def read_parcel_table(
    path: Path, *, box: tuple[float, float, float, float] | None = None, ids: Texts | None = None
) -> ParcelRows:
    """Parcels of a table, in its order.

    Args:
        path: a file of `ParcelTableWriter`.
        box: west, south, east and north in metres from the frame's origin: only parcels whose bounding boxes meet it;
            groups of rows outside are not read. None for all parcels.
        ids: only parcels of these ids; None for all.

    Raises:
        AssetError: If the file is not a table of parcels, is damaged, or too large.
        OSError: If it cannot be opened.
    """
    with _checked(path) as (stream, frame):
        table = pq.read_table(stream, filters=_condition(frame, box, ids))
        return _rows(table, frame)


@contextmanager
def _checked(path: Path) -> Iterator[tuple[BinaryIO, Frame]]:
    """An open file whose metadata are those of a table of parcels, and its frame."""
    with open_regular(path) as stream:
        try:
            metadata = pq.read_metadata(stream)
            note = json.loads((metadata.metadata or {})[NOTE])
            if note["format"] != FORMAT:
                raise AssetError(
                    f"{path}: expected a table of parcels of format {FORMAT}, found {note['format']!r:.60}."
                )
            size = sum(metadata.row_group(group).total_byte_size for group in range(metadata.num_row_groups))
            if metadata.num_rows > MAX_ROWS or size > MAX_BYTES:
                raise AssetError(
                    f"{path}: expected at most {MAX_ROWS:,} parcels and {MAX_BYTES:,} bytes, found "
                    f"{metadata.num_rows:,} and {size:,}."
                )
            east, north = note["origin"]
            stream.seek(0)
            yield stream, Frame(str(note["crs"]), (float(east), float(north)))
        except _DAMAGE as error:
            raise AssetError(
                f"{path}: expected the table of parcels of a city, found something else ({error!s:.200}). "
                "Build the city again."
            ) from error


def _condition(frame: Frame, box: tuple[float, float, float, float] | None, ids: Texts | None) -> pc.Expression | None:
    """The condition on rows; None if there is none."""
    conditions = []
    if box is not None:
        west, south, east, north = (np.array(box) + np.tile(frame.origin, 2)).tolist()
        conditions += [pc.field("bbox", "xmin") <= east, pc.field("bbox", "xmax") >= west]
        conditions += [pc.field("bbox", "ymin") <= north, pc.field("bbox", "ymax") >= south]
    if ids is not None:
        conditions.append(pc.field("id").isin(pa.array(ids, pa.string())))
    return reduce(and_, conditions) if conditions else None


def _rows(table: pa.Table, frame: Frame) -> ParcelRows:
    columns = {name: table[name].cast(kind).combine_chunks() for name, kind in COLUMNS.items()}
    reports = {name: table[name].cast(pa.float64()) for name in table.column_names if name.startswith(REPORT)}
    widths = columns["street_widths"].fill_null([])
    texts: dict[str, Any] = {name: _texts(columns[name]) for name in ("id", "zone", "reason", "grammar", "tile")}
    return ParcelRows(
        outline=_outlines(columns["geometry"], frame),
        lot=_outlines(columns["lot"], frame),
        street_width=widths.flatten().to_numpy(),
        lot_edges=offsets_from_counts(widths.value_lengths().to_numpy()),
        reports={name.removeprefix(REPORT): column.to_numpy() for name, column in reports.items()},
        **texts,
        **{name: columns[name].to_numpy() for name in ("seed", "model", "reroll", "area")},
    )


def _texts(column: pa.Array) -> Texts:
    """Texts; empty for null."""
    return column.fill_null("").to_numpy(zero_copy_only=False)


def _outlines(column: pa.Array, frame: Frame) -> Outlines:
    """Outlines in metres from the origin of the frame, to a nanometre; None for null."""
    outlines = shapely.from_wkb(column.to_numpy(zero_copy_only=False))
    return shapely.transform(outlines, lambda points: points - frame.origin)
