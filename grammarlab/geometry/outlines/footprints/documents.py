"""JSON documents of a file: one, one per line (GeoJSON lines), or one after each record separator (RFC 8142)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grammarlab.errors import AssetError, TableError
from grammarlab.files import read_bounded
from grammarlab.geometry.outlines.footprints.footprint import Remark
from grammarlab.tables import decoded

MAX_FILE_BYTES = 64 << 20
MAX_RECORDS = 200_000
_SEPARATOR = "\x1e"
_OTHER_MAPS = {".shp", ".gpkg", ".kml", ".kmz", ".gml", ".fgb", ".dxf", ".gdb", ".zip", ".parquet", ".gz"}
_MAX_DIGITS = 300
"""Digits of the longest whole number; a longer one is read as a float, which may be infinite."""


@dataclass(frozen=True, slots=True)
class Documents:
    """The documents of a file."""

    values: tuple[Any, ...]
    remarks: tuple[Remark, ...] = ()
    """Lines or records that are not JSON."""


def read_documents(path: Path) -> Documents:
    """The JSON documents of a file in UTF-8 or UTF-16.

    Raises:
        AssetError: If it has none, is not a regular file, or is too large.
    """
    content = read_bounded(path, MAX_FILE_BYTES)
    try:
        text = decoded(content).lstrip("\ufeff")
    except TableError as error:
        raise AssetError(f"{path}: expected GeoJSON: {error} {_advice(path)}".rstrip()) from error
    if not text.strip():
        raise AssetError(f"{path}: expected GeoJSON, found an empty file.")
    if _SEPARATOR in text:
        return _of_records(path, "record", text, _SEPARATOR)
    try:
        return Documents((_parsed(text),))
    except ValueError as error:
        first, _, rest = text.lstrip().partition("\n")
        if not (rest.strip() and _is_object(first)):
            message = f"{path}: expected GeoJSON, but this is not JSON ({error}). {_advice(path)}"
            raise AssetError(message.rstrip()) from error
    return _of_records(path, "line", text, "\n")


def well_formed(text: str) -> str:
    """A text without halves of characters, which no file can hold."""
    return text if text.isascii() else text.encode("utf-8", "replace").decode()


def _of_records(path: Path, kind: str, text: str, separator: str) -> Documents:
    if text.count(separator) > MAX_RECORDS:
        raise AssetError(f"{path}: expected at most {MAX_RECORDS:,} {kind}s. Cut out a smaller area.")
    values, remarks = [], []
    first = 1 if separator == "\n" else 0
    for number, record in enumerate(text.split(separator), first):
        if not record.strip():
            continue
        try:
            values.append(_parsed(record))
        except ValueError as error:
            remarks.append(
                Remark(f"{well_formed(path.name)}, {kind} {number}", "record", f"this is not JSON ({error})")
            )
    if not values:
        raise AssetError(f"{path}: expected GeoJSON, but none of its {len(remarks)} {kind}s is JSON.")
    return Documents(tuple(values), tuple(remarks))


def _parsed(text: str) -> Any:
    try:
        return json.loads(text, parse_int=_whole_number)
    except RecursionError as error:
        raise ValueError("it is nested too deeply") from error


def _is_object(text: str) -> bool:
    try:
        return isinstance(_parsed(text), dict)
    except ValueError:
        return False


def _whole_number(digits: str) -> float:
    return int(digits) if len(digits) <= _MAX_DIGITS else float(digits)


def _advice(path: Path) -> str:
    """How to convert a map of another format."""
    if path.suffix.lower() in _OTHER_MAPS:
        return f"Convert it: ogr2ogr -f GeoJSON -t_srs EPSG:4326 {path.stem}.geojson {path.name}"
    return ""
