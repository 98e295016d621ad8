"""Outlines of GeoJSON (RFC 7946, and the member ``crs`` of GeoJSON 2008).

A file has one JSON document, one per line (GeoJSON lines), or one after each record separator (RFC 8142).
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grammarlab.errors import AssetError, TableError
from grammarlab.files import read_bounded
from grammarlab.geometry.footprints.crs import WGS_84, Crs
from grammarlab.geometry.footprints.footprint import Outline, Remark, RemarkKind, Source
from grammarlab.geometry.footprints.geojson_features import (
    ABSENT,
    Feature,
    conversion,
    feature_of,
    kind_of,
    note_crs,
    plain_values,
    refuse_other_formats,
    shapes_of,
    well_formed,
)
from grammarlab.tables import decoded

_MAX_FILE_BYTES = 64 << 20
"""Largest size of a file in bytes."""
_MAX_RECORDS = 200_000
"""Largest number of lines or records of a file."""
_SEPARATOR = "\x1e"
_OTHER_MAPS = {".shp", ".gpkg", ".kml", ".kmz", ".gml", ".fgb", ".dxf", ".gdb", ".zip", ".parquet", ".gz"}
_MAX_DIGITS = 300
"""Digits of the longest whole number; a longer one is read as a float, which may be infinite."""
MAX_FOOTPRINTS = 100_000
"""Largest number of features or polygons of a file."""


def read_geojson(path: Path) -> Source:
    """The outlines of a GeoJSON file, in the coordinates of the file.

    Raises:
        AssetError: If it is not GeoJSON, or has several coordinate systems.
    """
    documents = _read_documents(path)
    outlines: list[Outline] = []
    remarks = list(documents.remarks)
    systems: dict[str, Crs] = {}
    for feature in _features(documents.values, path):
        values, unread = plain_values(feature.properties)
        omissions: Counter[tuple[RemarkKind, str]] = Counter()
        has_geometry = isinstance(feature.geometry, dict)
        for shape in shapes_of(feature.geometry, feature.crs, 0) if has_geometry else [feature.absence]:
            if isinstance(shape, str):
                omissions["geometry", shape] += 1
                continue
            note_crs(systems, shape.crs, feature.name, path)
            if isinstance(shape.polygon, str):
                omissions["outline", shape.polygon] += 1
                continue
            outlines.append(Outline(shape.polygon, feature.name, values, unread))
            if len(outlines) > MAX_FOOTPRINTS:
                raise AssetError(f"{path}: expected at most {MAX_FOOTPRINTS} polygons. Cut out a smaller area.")
        for (kind, reason), count in omissions.items():
            remarks.append(Remark(feature.name, kind, reason if count == 1 else f"{reason} ({count:,} times)"))
    crs, *_ = systems.values() or [WGS_84]
    return Source(str(path), tuple(outlines), tuple(remarks), crs, conversion=f"Convert it: {conversion(path)}")


@dataclass(frozen=True, slots=True)
class _Documents:
    """The documents of a file."""

    values: tuple[Any, ...]
    remarks: tuple[Remark, ...] = ()
    """Lines or records that are not JSON."""


def _read_documents(path: Path) -> _Documents:
    """The JSON documents of a file in UTF-8 or UTF-16.

    Raises:
        AssetError: If it has none, is not a regular file, or is too large.
    """
    content = read_bounded(path, _MAX_FILE_BYTES)
    try:
        text = decoded(content).lstrip("\ufeff")
    except TableError as error:
        raise AssetError(f"{path}: expected GeoJSON: {error} {_advice(path)}".rstrip()) from error
    if not text.strip():
        raise AssetError(f"{path}: expected GeoJSON, found an empty file.")
    if _SEPARATOR in text:
        return _of_records(path, "record", text, _SEPARATOR)
    try:
        return _Documents((_parsed(text),))
    except ValueError as error:
        first, _, rest = text.lstrip().partition("\n")
        if not (rest.strip() and _is_object(first)):
            message = f"{path}: expected GeoJSON, but this is not JSON ({error}). {_advice(path)}"
            raise AssetError(message.rstrip()) from error
    return _of_records(path, "line", text, "\n")


def _advice(path: Path) -> str:
    """Command that converts a map of another format."""
    if path.suffix.lower() in _OTHER_MAPS:
        return f"Convert it: ogr2ogr -f GeoJSON -t_srs EPSG:4326 {path.stem}.geojson {path.name}"
    return ""


def _of_records(path: Path, kind: str, text: str, separator: str) -> _Documents:
    if text.count(separator) > _MAX_RECORDS:
        raise AssetError(f"{path}: expected at most {_MAX_RECORDS:,} {kind}s. Cut out a smaller area.")
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
    return _Documents(tuple(values), tuple(remarks))


def _parsed(text: str) -> Any:
    try:
        return json.loads(text, parse_int=_whole_number)
    except RecursionError as error:
        raise ValueError("it is nested too deeply") from error


def _whole_number(digits: str) -> float:
    return int(digits) if len(digits) <= _MAX_DIGITS else float(digits)


def _is_object(text: str) -> bool:
    try:
        return isinstance(_parsed(text), dict)
    except ValueError:
        return False


def _features(documents: tuple[Any, ...], path: Path) -> Iterator[Feature]:
    """The features of all documents, numbered from 0."""
    number = 0
    for document in documents:
        refuse_other_formats(document, path)
        outer = ABSENT
        features = document if isinstance(document, list) else [document]  # a bare list is no GeoJSON, but is written
        if isinstance(document, dict) and kind_of(document) == "FeatureCollection":
            features, outer = document.get("features"), document.get("crs", ABSENT)
        if not isinstance(features, list):
            raise AssetError(f"{path}: expected a list under 'features'.")
        if number + len(features) > MAX_FOOTPRINTS:
            raise AssetError(
                f"{path}: {number + len(features)} features; at most {MAX_FOOTPRINTS} are read. Cut out a smaller area."
            )
        for feature in features:
            yield feature_of(feature, f"{well_formed(path.name)}, feature {number}", outer)
            number += 1
