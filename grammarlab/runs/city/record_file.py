"""Records of what is finished: JSON with the hash of its values, so that a damaged one counts as missing."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from grammarlab.errors import AssetError
from grammarlab.export.model_files import write_whole
from grammarlab.files import file_below, read_bounded

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Record = TypeVar("Record", bound="DataclassInstance")
_DIGEST = "sha256"
_MAX_BYTES = 1 << 26
"""Largest size of a record in bytes."""


def write_record(folder: Path, name: str, record: DataclassInstance) -> None:
    """Write a record atomically, after the files that it is about.

    Args:
        folder: a folder.
        name: path of the record below it.
        record: fields of texts, numbers, flags, tuples and dictionaries.
    """
    values = asdict(record)
    content = json.dumps({_DIGEST: _digest(values), **values}, ensure_ascii=False)
    write_whole(folder / name, content.encode(errors="backslashreplace"))


def read_record(folder: Path, name: str, kind: type[Record]) -> Record | None:
    """A record of some kind; None if it is missing or damaged."""
    path = file_below(folder, name)
    try:
        values = json.loads(read_bounded(path, _MAX_BYTES)) if path else {}
        is_whole = values.pop(_DIGEST) == _digest(values)
        fields = {key: tuple(value) if isinstance(value, list) else value for key, value in values.items()}
        return kind(**fields) if is_whole else None
    except (AssetError, OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None


def _digest(values: Mapping[str, Any]) -> str:
    return sha256(json.dumps(values).encode()).hexdigest()
