"""Label files: CSV, JSON lines or Parquet, one row per label, one column per field of `Label`.

Tables of text are read as spreadsheets and people write them (`grammarlab.tables`). The columns start_rule, attributes,
footprint, kind and other are optional and their cells may be empty; columns of other names are ignored. Capitals in
names of columns do not matter. A comparison (kind ``rather`` or ``tie``) needs no score; other rows without one are
left out and counted in `Labels.notes`, which also names scales other than 0 to 100.

Fractions of 1 are read as points of 100, shorter scales are named in a note.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, fields, replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from grammarlab.arrays import SEVERAL
from grammarlab.errors import AssetError, TableError, UsageError
from grammarlab.files import read_bounded, write_bytes
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.labels import COMPARISONS, SCORES, Label, Labels
from grammarlab.tables import Table, TableRow, decoded, read_table

_Rows = Iterator[tuple[str, Mapping[str, Any]]]
"""Position of each row, for messages, and its cells."""
number: Callable[[str], float | None] = Table(",", ()).number
"""A text with a decimal point as a finite number; None if it is not one."""
MAX_FILE_BYTES = 64 << 20
"""Largest size of a label file in bytes."""
MAX_UNPACKED_BYTES = 512 << 20
"""Largest uncompressed size that a Parquet file may declare, in bytes."""
MAX_LABELS = 500_000
"""Largest number of labels in a file."""
_DIGITS = re.compile(r"-?[0-9]{1,4300}")
_WITH_ZEROS = re.compile(r"(-?[0-9]{1,4300})[.,](0+)")
_ROUNDED = re.compile(r"-?[0-9]+([.,][0-9]+)?[eE]\+?[0-9]+")
_EXACT = sys.float_info.radix**sys.float_info.mant_dig
"""Integers below this are exact as floats of 64 bits."""
_NO_SCORE = frozenset(("", "nan", "na", "n/a", "#n/a", "null", "none"))
_KEEP = "integers of more than 15 digits lose some in spreadsheets and in floats. Keep this column as text."
_MAX_SHORT_SCALE = 10.0
"""Largest highest score that is likely one of a scale of up to five or ten."""
_ADVICE = (
    "Give scores of a shorter scale in points of 100, or stars as the kind 'stars' with the scores 0, 25, 50, 75 and "
    "100."
)
_COLUMNS = tuple(field.name for field in fields(Label))
_REQUIRED = tuple(field.name for field in fields(Label) if field.default is MISSING)
_OPTIONAL = frozenset(_COLUMNS) - frozenset(_REQUIRED)
_KINDS: dict[str, Any] = {"seed": pa.uint64(), "model": pa.uint64(), "score": pa.float64()}
"""Parquet types of the columns that are not text."""


def save_labels(labels: Labels, path: Path | str) -> None:
    """Write a label file atomically; an existing file is replaced.

    Args:
        labels: labels, any number of them.
        path: path of the file; its suffix .csv, .jsonl or .parquet selects the format.

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
        path: path of the file; its suffix .csv, .tsv, .txt, .jsonl or .parquet selects the format.

    Returns:
        The labels. `Labels.notes` says what was left out, and which scale other than 0 to 100 was understood.

    Raises:
        UsageError: If the suffix is another one.
        AssetError: If the file is missing, too large or broken, or no row has a score; the message names row and
            column.

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
    if not path.exists():
        raise AssetError(f"{path}: no such label file.")
    try:
        return _labels(reader(read_bounded(path, MAX_FILE_BYTES)))
    except (_RowError, TableError, ValueError, OSError, RecursionError, pa.ArrowException) as error:
        raise AssetError(f"{path}: {error}") from error


def score(value: object, read_number: Callable[[str], float | None] = number) -> object:
    """A score as a number, None for a blank or missing one; any other value unchanged.

    Args:
        value: a cell.
        read_number: reads a text.

    >>> [score(value) for value in (3, "12.5", " ", "NaN", float("nan"), "good")]
    [3, 12.5, None, None, None, 'good']
    """
    if isinstance(value, str):
        if value.strip().lower() in _NO_SCORE:
            return None
        result = read_number(value.strip())
        return value if result is None else result
    if isinstance(value, Decimal):
        value = float(value)
    return None if isinstance(value, float) and math.isnan(value) else value


def integer(name: str, value: object) -> object:
    """A whole number as an integer, such as ``17``, ``17.0`` or ``"17"``; any other value unchanged.

    Args:
        name: name of the column, for messages.
        value: a cell.

    Raises:
        UsageError: If digits may have been lost, or the number may be two.

    >>> [integer("model", value) for value in ("17", "17.0", 17.0, "17,0", "1_000", "1e3x", "١٧")]
    [17, 17, 17, 17, '1_000', '1e3x', '١٧']
    """
    if isinstance(value, str):
        return _integer_of_text(name, value)
    if isinstance(value, float | Decimal) and math.isfinite(value) and value == int(value):
        if isinstance(value, float) and abs(value) >= _EXACT:
            raise UsageError(f"{name}: {value:.17g} is rounded: {_KEEP}")
        return int(value)
    return value


def on_one_scale(rows: Sequence[Label]) -> tuple[tuple[Label, ...], tuple[str, ...]]:
    """Labels whose scores are from 0 to 100, and notes about other scales.

    Only labels of kind ``score`` matter, since other kinds have fixed scores.

    Args:
        rows: all labels of a file.

    >>> rows = [Label(1, model, "overall", score, "0" * 64) for model, score in enumerate((0.0, 0.25))]
    >>> labels, notes = on_one_scale(rows)
    >>> [label.score for label in labels], notes
    ([0.0, 25.0], ('all scores are from 0 to 1 and are read as fractions of 100: 0.25 as 25',))
    """
    scores = {label.score for label in rows if label.kind == "score"}
    highest = max(scores, default=0.0)
    if highest > 1.0:
        return tuple(rows), _short_notes(rows, highest)
    if not highest:
        return tuple(rows), ()
    points = tuple(
        replace(label, score=round(MAX_SCORE * label.score, 9)) if label.kind == "score" else label for label in rows
    )
    if scores <= {0.0, 1.0}:
        return points, (f"all scores are 0 or 1 and are read as 0 (disliked) and {MAX_SCORE:g} (liked)",)
    example = min(value for value in scores if 0.0 < value < 1.0)
    reading = f"{example:g} as {MAX_SCORE * example:g}"
    return points, (f"all scores are from 0 to 1 and are read as fractions of {MAX_SCORE:g}: {reading}",)


def _format(path: Path, formats: Mapping[str, Callable[..., Any]]) -> Callable[..., Any]:
    if path.suffix.lower() not in formats:
        raise UsageError(f"{path.name}: expected a label file that ends in {', '.join(formats)}.")
    return formats[path.suffix.lower()]


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


_WRITERS: dict[str, Callable[[Labels], bytes]] = {
    ".csv": _write_csv,
    ".jsonl": _write_jsonl,
    ".parquet": _write_parquet,
}


def _read_text_table(data: bytes) -> _Rows:
    table = read_table(data, MAX_LABELS + 2)
    header = table.header
    _check_header(header)
    for row in table.body:
        yield f"line {row.line}", _cells_of(table, header, row)


def _read_jsonl(data: bytes) -> _Rows:
    for number, line in enumerate(decoded(data).split("\n"), 1):
        if not line.strip():
            continue
        try:
            cells = json.loads(line)
        except (ValueError, RecursionError) as error:
            raise _RowError(f"line {number}: expected a JSON object, but this is not JSON ({error}).") from error
        if not isinstance(cells, dict):
            raise _RowError(f"line {number}: expected one JSON object per line, found {line[:40]!r}.")
        names = [_normal(name) for name in cells]
        _check_different(names, f"line {number}: ")
        yield f"line {number}", dict(zip(names, cells.values(), strict=True))


def _read_parquet(data: bytes) -> _Rows:
    written = pq.read_schema(io.BytesIO(data)).names
    _check_header([_normal(name) for name in written])
    columns = {name: _normal(name) for name in written if _normal(name) in _COLUMNS}
    # A dictionary stores a repeated text once.
    texts = [name for name, normal in columns.items() if normal not in _KINDS]
    file = pq.ParquetFile(io.BytesIO(data), read_dictionary=texts)
    unpacked = sum(file.metadata.row_group(i).total_byte_size for i in range(file.metadata.num_row_groups))
    if unpacked > MAX_UNPACKED_BYTES:
        raise _RowError(f"{unpacked} bytes when unpacked; {MAX_UNPACKED_BYTES} are allowed.")
    number = 0
    for batch in file.iter_batches(batch_size=1024, columns=list(columns)):
        for cells in batch.to_pylist():
            number += 1
            yield f"row {number}", {columns[name]: value for name, value in cells.items()}


_READERS: dict[str, Callable[[bytes], _Rows]] = {
    ".csv": _read_text_table,
    ".tsv": _read_text_table,
    ".txt": _read_text_table,
    ".jsonl": _read_jsonl,
    ".parquet": _read_parquet,
}


def _check_header(names: Iterable[str]) -> None:
    present = list(names)
    missing = [name for name in _REQUIRED if name not in present]
    if missing:
        listing = ", ".join(filter(None, present))[:200] or "none"
        raise _RowError(f"expected the columns {', '.join(_REQUIRED)}; missing {', '.join(missing)}; found {listing}.")
    _check_different(present)


class _RowError(Exception):
    """An error of a whole row; file and place are added where it is caught."""


def _check_different(names: Sequence[str], prefix: str = "") -> None:
    repeated = [name for name in _COLUMNS if names.count(name) > 1]
    if repeated:
        raise _RowError(f"{prefix}two columns have the same name: {', '.join(repeated)}.")


def _cells_of(table: Table, header: Sequence[str], row: TableRow) -> dict[str, Any]:
    """Cells by column; spreadsheets leave empty cells at the end out, or add some."""
    required = max(header.index(name) for name in _REQUIRED) + 1
    if len(row.cells) < required or any(row.cells[len(header) :]):
        raise _RowError(f"line {row.line}: expected {len(header)} cells as in the header, found {len(row.cells)}.")
    cells: dict[str, Any] = dict(zip(header, row.cells, strict=False))
    return cells | {"score": score(cells["score"], table.number)}


def _normal(name: str) -> str:
    return name.strip().lower()


def _labels(rows: _Rows) -> Labels:
    labels, num_blank = list[Label](), 0
    for position, cells in rows:
        if len(labels) + num_blank >= MAX_LABELS:
            raise _RowError(f"more than {MAX_LABELS} labels; split the file.")
        missing = [name for name in _REQUIRED if name not in cells]
        if missing:
            raise _RowError(f"{position}: expected {', '.join(_REQUIRED)}; missing {', '.join(missing)}.")
        try:
            label = _label(cells)
        except UsageError as error:
            raise _RowError(f"{position}: {error}") from error
        if label is None:
            num_blank += 1
        else:
            labels.append(label)
    if num_blank and not labels:
        raise _RowError(f"none of {num_blank:,} rows has a score.")
    scaled, notes = on_one_scale(labels)
    left_out = "1 row without a score is" if num_blank == 1 else f"{num_blank:,} rows without a score are"
    return Labels(scaled, notes=(*([f"{left_out} left out"] if num_blank else []), *notes))


def _label(cells: Mapping[str, Any]) -> Label | None:
    """Label of a row; None if it has no score and is not a comparison."""
    values = {name: cells[name] for name in _COLUMNS if name in cells}
    values = {name: value for name, value in values.items() if name not in _OPTIONAL or not _is_blank(value)}
    for name in ("kind", "grammar"):
        if isinstance(values.get(name), str):
            values[name] = values[name].lower()
    for name in ("seed", "model"):
        values[name] = integer(name, values[name])
    values["score"] = score(values["score"])
    if values["score"] is None:
        if values.get("kind") in COMPARISONS:
            values["score"] = SCORES[values["kind"]][0]
        elif "other" not in values:
            return None
    return Label(**values)


def _is_blank(value: object) -> bool:
    """Whether a cell of text has no value."""
    return value is None or value == "" or (isinstance(value, float) and math.isnan(value))


def _integer_of_text(name: str, text: str) -> object:
    text = text.strip()
    if _DIGITS.fullmatch(text):
        return int(text)
    match = _WITH_ZEROS.fullmatch(text)
    if match is not None:
        if len(match[2]) == 3:
            raise UsageError(
                f"{name}: {text[:40]} may be {match[1][:40]} or a thousand times as much: write one number."
            )
        return int(match[1])
    if _ROUNDED.fullmatch(text):
        raise UsageError(f"{name}: {text[:40]} is rounded: {_KEEP}")
    return text


def _short_notes(rows: Sequence[Label], highest: float) -> tuple[str, ...]:
    """A note if all scores, or all of some factors, are likely of a shorter scale."""
    scale = f"on a scale of 0 (disliked) to {MAX_SCORE:g}, so all models are nearly disliked"
    if highest <= _MAX_SHORT_SCALE:
        return (f"the highest score is {highest:g}, {scale}. {_ADVICE}",)
    of_factor: dict[str, float] = {}
    for label in rows:
        if label.kind == "score":
            of_factor[label.factor] = max(label.score, of_factor.get(label.factor, 0.0))
    short = [
        f"{score:g} for the factor {factor!r}" for factor, score in of_factor.items() if 0 < score <= _MAX_SHORT_SCALE
    ]
    if not short:
        return ()
    more = f" and {len(short) - SEVERAL} more factors" if len(short) > SEVERAL else ""
    return (f"the highest score is {', '.join(short[:SEVERAL])}{more}, {scale} by it. {_ADVICE}",)
