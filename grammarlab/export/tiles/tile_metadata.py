"""Properties of the models of a tile: a table of EXT_structural_metadata, whose rows feature ids refer to."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts
from grammarlab.export.gltf_document import GltfDocument

if TYPE_CHECKING:
    import pyarrow as pa

EXTENSION = "EXT_structural_metadata"
FEATURE_IDS = "_FEATURE_ID_0"
"""Name of the attribute of rows of the table. Its numbers are floats: glTF has 32-bit integers only for indices."""
_CLASS = "building"
_NO_NUMBER = float(np.finfo(np.float32).min)
"""Number for null and NaN, which JSON does not have."""
_ALIGNMENT = 8


@dataclass(frozen=True, slots=True)
class _Values:
    """A column as bytes."""

    kind: dict[str, Any]
    """Property of the class: its type, and the value that stands for null."""
    views: dict[str, bytes]
    """Content of buffer views by their names in the property of the table; none if all values are null."""


def add_properties(document: GltfDocument, table: pa.Table) -> None:
    """Add the table of a tile to its document.

    Texts are strings, flags and whole numbers as well: numbers of 64 bits do not fit JavaScript. Other numbers have 64
    bits. Columns keep their names in the field ``name``, since ids of properties are words.

    Args:
        document: the document.
        table: [B] columns of texts, numbers and flags, with nulls; at least one row.
    """
    properties, columns = {}, {}
    for name, column, word in zip(table.column_names, table.columns, words(table.column_names), strict=True):
        values = _numbers(column) if _is_float(column) else _texts(column)
        properties[word] = {"name": name, **values.kind}
        views = {key: document.add_bytes(content, _ALIGNMENT) for key, content in values.views.items()}
        if views:
            columns[word] = views
    schema = {"id": "grammarlab", "classes": {_CLASS: {"properties": properties}}}
    entry = {"class": _CLASS, "count": len(table), "properties": columns}
    document.use(EXTENSION, {"schema": schema, "propertyTables": [entry]})


def feature_ids(values: NDArray[np.floating], **source: int) -> dict[str, Any]:
    """A set of feature ids of EXT_mesh_features or EXT_instance_features.

    Args:
        values: [n] the ids, n >= 1.
        source: ``attribute``: number of the attribute that stores them.
    """
    count = int(np.count_nonzero(np.bincount(values.astype(np.int64))))
    return {"featureIds": [{"featureCount": count, **source, "propertyTable": 0}]}


def words(names: Sequence[str]) -> list[str]:
    """Ids of properties: names with an underscore for each letter that ids cannot have, and numbered if equal.

    >>> words(["id", "Straße", "Stra e", "2nd"])
    ['id', 'Stra_e', 'Stra_e_2', '_2nd']
    """
    result: dict[str, None] = {}
    for name in names:
        word = stem = re.sub(r"^(?=[^a-zA-Z_])|[^a-zA-Z0-9_]", "_", name) or "_"
        number = 1
        while word in result:
            number += 1
            word = f"{stem}_{number}"
        result[word] = None
    return list(result)


def _is_float(column: pa.ChunkedArray) -> bool:
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    return pa.types.is_floating(column.type)


def _numbers(column: pa.ChunkedArray) -> _Values:
    values = column.cast("float64").to_numpy(zero_copy_only=False)
    filled = np.where(np.isfinite(values), values, _NO_NUMBER)
    kind = {"type": "SCALAR", "componentType": "FLOAT64", "noData": _NO_NUMBER}
    return _Values(kind, {"values": filled.tobytes()})


def _texts(column: pa.ChunkedArray) -> _Values:
    texts = [b"" if value is None else value.encode() for value in column.cast("string").to_pylist()]
    content = b"".join(texts)
    offsets = offsets_from_counts(np.array([len(text) for text in texts], dtype=np.int64)).astype(np.uint32)
    views = {"values": content, "stringOffsets": offsets.tobytes()} if content else {}
    return _Values({"type": "STRING", "noData": ""}, views)
