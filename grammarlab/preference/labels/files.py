"""Label files: CSV, JSON lines or Parquet, one row per label, one column per field of `Label`.

The columns start_rule, attributes, footprint, kind and other are optional, and columns of other names are ignored.
A comparison (kind ``rather`` or ``tie``) needs no score: its cell may be empty.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from grammarlab.errors import AssetError, UsageError
from grammarlab.files import write_bytes
from grammarlab.preference.labels.table import COMPARISONS, SCORES, Label, Labels

MAX_FILE_BYTES = 64 << 20
MAX_UNPACKED_BYTES = 512 << 20
"""Largest uncompressed size that a Parquet file may declare, in bytes."""
MAX_LABELS = 500_000

_COLUMNS = tuple(field.name for field in fields(Label))
_REQUIRED = tuple(field.name for field in fields(Label) if field.default is MISSING)
_KINDS: dict[str, Any] = {"seed": pa.uint64(), "model": pa.int64(), "score": pa.float64()}
"""Parquet types of the columns that are not text."""


class _RowError(Exception):
    """An error of a whole row; file and place are added where it is caught."""


_Rows = Iterator[tuple[str, Mapping[str, Any]]]
"""Place of each row, for messages, and its cells."""


def save_labels(labels: Labels, path: Path | str) -> None:
    """Write a label file atomically; an existing file is replaced.

    Args:
        labels: any number.
        path: its suffix .csv, .jsonl or .parquet selects the format.

    Raises:
        UsageError: If the suffix is another one.

    >>> import grammarlab as gl
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> labels = gl.Labels((gl.Label(1, 17, "overall", 80.0, "0" * 64),))
    >>> with TemporaryDirectory() as folder:
    ...     _ = gl.save_labels(labels, Path(folder) / "labels.csv")
    ...     gl.read_labels(Path(folder) / "labels.csv") == labels
    True
    """
    path = Path(path)
    write_bytes(path, _format(path, _WRITERS)(labels))


def read_labels(path: Path | str) -> Labels:
    """Labels from a file.

    Args:
        path: its suffix .csv, .jsonl or .parquet selects the format.

    Raises:
        UsageError: If the suffix is another one.
        AssetError: If the file is missing, too large or broken; the message names row and column.

    >>> import grammarlab as gl
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "labels.csv"
    ...     gl.save_labels(gl.Labels((gl.Label(1, 17, "overall", 80.0, "0" * 64),)), file)
    ...     gl.read_labels(file).scores.tolist()
    [80.0]
    """
    path = Path(path)
    reader = _format(path, _READERS)
    if not path.is_file():
        raise AssetError(f"{path}: no such label file.")
    if (size := path.stat().st_size) > MAX_FILE_BYTES:
        raise AssetError(f"{path}: {size} bytes; label files may have {MAX_FILE_BYTES} at most.")
    try:
        return Labels(tuple(_labels(reader(path.read_bytes()))))
    except (_RowError, ValueError, OSError, RecursionError, pa.ArrowException) as error:
        raise AssetError(f"{path}: {error}") from error


def _format(path: Path, formats: Mapping[str, Callable[..., Any]]) -> Callable[..., Any]:
    if path.suffix.lower() not in formats:
        raise UsageError(f"{path.name}: expected a label file that ends in {', '.join(formats)}.")
    return formats[path.suffix.lower()]


def _labels(rows: _Rows) -> Iterator[Label]:
    for number, (place, cells) in enumerate(rows):
        if number >= MAX_LABELS:
            raise _RowError(f"more than {MAX_LABELS} labels; split the file.")
        missing = [name for name in _REQUIRED if name not in cells]
        if missing:
            raise _RowError(f"{place}: expected {', '.join(_REQUIRED)}; missing {', '.join(missing)}.")
        try:
            yield Label(**_completed({name: cells[name] for name in _COLUMNS if name in cells}))
        except UsageError as error:
            raise _RowError(f"{place}: {error}") from error


def _completed(cells: dict[str, Any]) -> dict[str, Any]:
    """Cells of a row, with the defaults of an empty kind and of the empty score of a comparison."""
    told = {name: cells[name] for name in cells if name not in ("kind", "other") or cells[name] not in ("", None)}
    kind = told.get("kind")
    if kind in COMPARISONS and told["score"] in ("", None):
        told["score"] = SCORES[str(kind)][0]
    return told


def _read_csv(data: bytes) -> _Rows:
    reader = csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=""), strict=True)
    try:
        header = next(reader, [])
        _check_header(header)
        for cells in filter(None, reader):
            yield f"line {reader.line_num}", _csv_cells(header, cells)
    except (csv.Error, _RowError) as error:
        raise _RowError(f"line {reader.line_num}: {error}") from error


def _csv_cells(header: list[str], cells: list[str]) -> dict[str, Any]:
    if len(cells) != len(header):
        raise _RowError(f"expected {len(header)} cells as in the header, found {len(cells)}.")
    return {name: _typed(name, cell) for name, cell in zip(header, cells, strict=True)}


def _typed(name: str, cell: str) -> Any:
    """A cell of a text file as a number; unchanged if it is not a number, so that `Label` refuses it."""
    try:
        return int(cell) if name in ("seed", "model") else float(cell) if name == "score" else cell
    except ValueError:
        return cell


def _read_jsonl(data: bytes) -> _Rows:
    for number, line in enumerate(data.decode("utf-8-sig").split("\n"), 1):
        if not line.strip():
            continue
        try:
            cells = json.loads(line)
        except (ValueError, RecursionError) as error:
            raise _RowError(f"line {number}: expected a JSON object, but this is not JSON ({error}).") from error
        if not isinstance(cells, dict):
            raise _RowError(f"line {number}: expected a JSON object, found {line[:40]!r}.")
        yield f"line {number}", cells


def _read_parquet(data: bytes) -> _Rows:
    names = pq.read_schema(io.BytesIO(data)).names
    _check_header(names)
    # A dictionary stores a repeated text once.
    texts = [name for name in _COLUMNS if name in names and name not in _KINDS]
    file = pq.ParquetFile(io.BytesIO(data), read_dictionary=texts)
    unpacked = sum(file.metadata.row_group(i).total_byte_size for i in range(file.metadata.num_row_groups))
    if unpacked > MAX_UNPACKED_BYTES:
        raise _RowError(f"{unpacked} bytes when unpacked; {MAX_UNPACKED_BYTES} are allowed.")
    number = 0
    for batch in file.iter_batches(batch_size=1024, columns=[name for name in _COLUMNS if name in names]):
        for cells in batch.to_pylist():
            number += 1
            yield f"row {number}", cells


def _check_header(names: Iterable[str]) -> None:
    found = list(names)
    missing = [name for name in _REQUIRED if name not in found]
    if missing:
        shown = ", ".join(found)[:200] or "none"
        raise _RowError(f"expected the columns {', '.join(_REQUIRED)}; missing {', '.join(missing)}; found {shown}.")
    if len(set(found)) < len(found):
        raise _RowError("two columns have the same name.")


def _write_csv(labels: Labels) -> bytes:
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    writer.writerows([getattr(label, name) for name in _COLUMNS] for label in labels)
    return text.getvalue().encode("utf-8")


def _write_jsonl(labels: Labels) -> bytes:
    lines = (json.dumps({name: getattr(label, name) for name in _COLUMNS}, ensure_ascii=False) for label in labels)
    return "".join(f"{line}\n" for line in lines).encode("utf-8")


def _write_parquet(labels: Labels) -> bytes:
    columns = {
        name: pa.array([getattr(label, name) for label in labels], _KINDS.get(name, pa.string())) for name in _COLUMNS
    }
    sink = io.BytesIO()
    pq.write_table(pa.table(columns), sink, compression="zstd")
    return sink.getvalue()


_READERS: dict[str, Callable[[bytes], _Rows]] = {".csv": _read_csv, ".jsonl": _read_jsonl, ".parquet": _read_parquet}
_WRITERS: dict[str, Callable[[Labels], bytes]] = {
    ".csv": _write_csv,
    ".jsonl": _write_jsonl,
    ".parquet": _write_parquet,
}
