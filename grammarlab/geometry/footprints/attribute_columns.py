"""Attributes of features as columns of four kinds: whole numbers, numbers, flags and texts.

The kind of a column depends on the set of its values, not on their order: numbers among texts become texts, without the
``.0`` of whole numbers. Lists of numbers are texts, ``[8, 0, 5.5]``; other lists, and objects, are left out.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.geojson_features import well_formed
from grammarlab.geometry.footprints.map_layer import MAX_ATTRIBUTES

_MAX_WHOLE = 2.0**53
"""Floats below are exact whole numbers if they have no fraction."""

NOT_USED = "values other than numbers, flags, texts and lists of numbers are not used"
"""Words of a remark, before the names of attributes."""
Columns = dict[str, pa.Array]
"""Attributes of some features by name, each of the same length."""


def number_text(value: float) -> str:
    """A number as a text.

    >>> number_text(12.0), number_text(0.5), number_text(12)
    ('12', '0.5', '12')
    """
    if isinstance(value, float) and abs(value) < _MAX_WHOLE and value.is_integer():
        return str(int(value))
    return str(value) if isinstance(value, int) else repr(value)


def columns_of(records: Sequence[Mapping[str, Any]]) -> tuple[Columns, set[str]]:
    """Columns of the parsed JSON objects of some features, and the names of those with values that are left out.

    Raises:
        AssetError: If they have too many different names.
    """
    names: dict[str, None] = {}
    for record in records:
        if not names.keys() >= record.keys():
            names.update(dict.fromkeys(record))
            _check_number(len(names))
    columns: Columns = {}
    unread = set()
    for name in names:
        values = [record.get(name) for record in records]
        column, is_nested = _column(values)
        columns[well_formed(name)] = column
        if is_nested:
            unread.add(well_formed(name))
    return columns, unread


def united(chunks: Sequence[Columns], lengths: Sequence[int]) -> pa.Table:
    """Columns of chunks of features as one table with a column for each name, in the order of the names.

    Args:
        chunks: columns of consecutive features.
        lengths: number of features of each chunk.
    """
    names = sorted({name for chunk in chunks for name in chunk})
    _check_number(len(names))
    table: dict[str, pa.ChunkedArray] = {}
    for name in names:
        parts = [chunk.get(name, pa.nulls(length)) for chunk, length in zip(chunks, lengths, strict=True)]
        kind = _common({part.type for part in parts})
        table[name] = pa.chunked_array([_cast(part, kind) for part in parts], kind)
    return pa.table(table)


def plain_columns(batch: pa.RecordBatch) -> tuple[Columns, set[str]]:
    """Columns of a batch of Arrow as one of the four kinds, and the names of those with values that are left out."""
    columns: Columns = {}
    unread = set()
    for name, column in zip(batch.schema.names, batch.columns, strict=True):
        kind, nested = _plain_kind(column.type), _nested_values(column)
        if kind is not None:
            columns[well_formed(name)] = _without_nan(_of_unicode(column.cast(kind, safe=False)))
        elif nested is not None:
            columns[well_formed(name)], is_partial = _column(nested)
            unread |= {well_formed(name)} if is_partial else set()
        else:
            unread.add(well_formed(name))
    return columns, unread


def _nested_values(column: pa.Array) -> list[Any] | None:
    """The values of a column of lists, or of JSON, as GDAL has lists of GeoPackages; None for other columns."""
    if pa.types.is_nested(column.type):
        return column.to_pylist()
    if isinstance(column.type, pa.BaseExtensionType) and column.type.extension_name == "arrow.json":
        return [None if text is None else _parsed(text) for text in column.to_pylist()]
    return None


def _parsed(text: str) -> Any:
    """The value of a JSON text; a text that is none is its own value."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _of_unicode(column: pa.Array) -> pa.Array:
    """A column whose texts are Unicode: tables of Shapefiles cut texts at a number of bytes, or lie about encodings."""
    if not pa.types.is_string(column.type):
        return column
    try:
        column.validate(full=True)
    except pa.ArrowInvalid:
        bodies = column.cast(pa.binary()).to_pylist()
        return pa.array([body and body.decode(errors="replace") for body in bodies], pa.string())
    return column


def _check_number(number: int) -> None:
    if number > MAX_ATTRIBUTES:
        raise AssetError(f"expected at most {MAX_ATTRIBUTES:,} different attributes.")


def _column(values: list[Any]) -> tuple[pa.Array, bool]:
    """A column of parsed JSON values, and whether some of them are left out."""
    is_partial = False
    if any(isinstance(value, list | dict) for value in values):
        flat = [_list_text(value) if isinstance(value, list | dict) else value for value in values]
        is_partial = flat.count(None) > values.count(None)
        values = flat
    try:
        column = pa.array(values)
    except (pa.ArrowException, OverflowError, UnicodeError):
        column = pa.array([_text(value) for value in values], pa.string())
    return _without_nan(column), is_partial


def _list_text(value: list[Any] | dict[str, Any]) -> str | None:
    """A list of numbers as a text; None for anything else, and for an empty list.

    >>> _list_text([8, 0.0, 5.5]), _list_text([8, None]), _list_text([])
    ('[8, 0, 5.5]', None, None)
    """
    if not value or not isinstance(value, list) or not all(map(_is_number, value)):
        return None
    return f"[{', '.join(map(number_text, value))}]"


def _is_number(value: Any) -> bool:
    return math.isfinite(value) if isinstance(value, float) else isinstance(value, int) and not isinstance(value, bool)


def _text(value: Any) -> str | None:
    """A parsed JSON value as a text."""
    match value:
        case None:
            return None
        case str():
            return well_formed(value)
        case bool():
            return "true" if value else "false"
        case float() if not math.isfinite(value):
            return None
        case _:
            return number_text(value)


def _without_nan(column: pa.Array) -> pa.Array:
    """A column with nulls instead of numbers that are not finite."""
    if not pa.types.is_floating(column.type):
        return column
    numbers = column.to_numpy(zero_copy_only=False)
    return pa.array(numbers, column.type, mask=~np.isfinite(numbers))


def _common(kinds: Iterable[pa.DataType]) -> pa.DataType:
    """The kind of a column whose parts are of some kinds."""
    present = {kind for kind in kinds if not pa.types.is_null(kind)}
    if len(present) <= 1:
        return present.pop() if present else pa.string()
    return pa.float64() if present == {pa.int64(), pa.float64()} else pa.string()


def _cast(column: pa.Array, kind: pa.DataType) -> pa.Array:
    if column.type == kind:
        return column
    if pa.types.is_string(kind) and pa.types.is_floating(column.type):
        return pa.array([None if value is None else number_text(value) for value in column.to_pylist()], kind)
    return column.cast(kind, safe=False)


def _plain_kind(kind: pa.DataType) -> pa.DataType | None:
    types = pa.types
    if types.is_boolean(kind):
        return pa.bool_()
    if types.is_integer(kind):
        return pa.int64()
    if types.is_floating(kind) or types.is_decimal(kind):
        return pa.float64()
    if types.is_string(kind) or types.is_large_string(kind) or types.is_temporal(kind):
        return pa.string()
    return None


def flat_objects(column: pa.ChunkedArray | pa.Array) -> np.ndarray:
    """[N] Python values of a column, None for nulls."""
    values = np.empty(len(column), dtype=object)
    values[:] = column.to_pylist()
    return values
