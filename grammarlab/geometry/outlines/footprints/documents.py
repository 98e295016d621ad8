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
_SEPARATOR = "\x1e"
_MAX_DIGITS = 400
"""Digits of the longest whole number; a longer one is infinite, as a float is."""


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
        raise AssetError(f"{path}: expected GeoJSON: {error} {_advice(path)}") from error
    if _SEPARATOR in text:
        before, *records = text.split(_SEPARATOR)
        records = [before, *records] if before.strip() else records
        return _of_records(path, "record", [(number, record) for number, record in enumerate(records, 1)])
    try:
        return Documents((_parsed(text),))
    except ValueError as error:
        lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
        if len(lines) < 2 or not _is_object(lines[0][1]):
            raise AssetError(f"{path}: expected GeoJSON, but this is not JSON ({error}). {_advice(path)}") from error
    return _of_records(path, "line", lines)


def _of_records(path: Path, kind: str, records: list[tuple[int, str]]) -> Documents:
    values, remarks = [], []
    for number, record in records:
        if not record.strip():
            continue
        try:
            values.append(_parsed(record))
        except ValueError as error:
            remarks.append(Remark(f"{path.name}, {kind} {number}", "record", f"this is not JSON ({error})"))
    if not values:
        raise AssetError(f"{path}: expected GeoJSON, but none of its {len(remarks)} {kind}s is JSON. {_advice(path)}")
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
    if path.suffix.lower() in {
        ".shp",
        ".gpkg",
        ".kml",
        ".kmz",
        ".gml",
        ".fgb",
        ".dxf",
        ".gdb",
        ".zip",
        ".parquet",
        ".gz",
    }:
        return f"Convert it: ogr2ogr -f GeoJSON -t_srs EPSG:4326 {path.stem}.geojson {path.name}"
    return ""
