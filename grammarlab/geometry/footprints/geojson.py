"""Outlines of GeoJSON (RFC 7946, and the member ``crs`` of GeoJSON 2008).

A file has one JSON document, one per line (GeoJSON lines), or one after each record separator (RFC 8142).
"""

from __future__ import annotations

import json
import math
import shlex
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import shapely

from grammarlab.errors import AssetError, TableError
from grammarlab.files import read_bounded
from grammarlab.geometry.footprints.crs import WGS_84, Crs, crs_of_member
from grammarlab.geometry.footprints.footprint import Outline, Remark, RemarkKind, Source
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
_MAX_DEPTH = 16
"""Largest depth of geometry collections in each other."""
_ABSENT = object()
"""Stands for a member that is absent, unlike one that is null."""
_LINEAR = frozenset({"Point", "MultiPoint", "LineString", "MultiLineString"})
_GEOMETRIES = _LINEAR | {"Polygon", "MultiPolygon", "GeometryCollection"}
_OTHER_FORMATS = {"Topology": "TopoJSON", "CityJSON": "CityJSON", "CityJSONFeature": "CityJSON"}
_TELLING_MEMBERS = {"spatialReference": "Esri JSON", "geometryType": "Esri JSON", "elements": "JSON of Overpass"}
"""Members of documents of other formats without a type."""
_CONVERSIONS = {
    "CityJSON": "Save it as GeoJSON in QGIS, with the plugin CityJSON Loader.",
    "JSON of Overpass": "Convert it: osmtogeojson {old} > {new}",
}
"""Advice for formats that ogr2ogr does not read."""
_JSON_FG = ("place", "coordRefSys", "conformsTo")
"""Members of OGC Features and Geometries JSON; what is in ``geometry`` there is GeoJSON."""


def read_geojson(path: Path) -> Source:
    """The outlines of a GeoJSON file, in the coordinates of the file.

    Raises:
        AssetError: If it is not GeoJSON, or its CRS is not known to be in true metres or degrees.
    """
    documents = _read_documents(path)
    outlines: list[Outline] = []
    remarks = list(documents.remarks)
    systems: dict[str, Crs] = {}
    for feature in _features(documents.values, path):
        values, unread = _plain_values(feature.properties)
        omissions: Counter[tuple[RemarkKind, str]] = Counter()
        has_geometry = isinstance(feature.geometry, dict)
        for shape in _shapes(feature.geometry, feature.crs, 0) if has_geometry else [feature.absence]:
            if isinstance(shape, str):
                omissions["geometry", shape] += 1
                continue
            _note_crs(systems, shape.crs, feature.name, path)
            if isinstance(shape.polygon, str):
                omissions["outline", shape.polygon] += 1
                continue
            outlines.append(Outline(shape.polygon, feature.name, values, unread))
            if len(outlines) > MAX_FOOTPRINTS:
                raise AssetError(f"{path}: expected at most {MAX_FOOTPRINTS} polygons. Cut out a smaller area.")
        for (kind, reason), count in omissions.items():
            remarks.append(Remark(feature.name, kind, reason if count == 1 else f"{reason} ({count:,} times)"))
    crs, *_ = systems.values() or [WGS_84]
    return Source(str(path), tuple(outlines), tuple(remarks), crs)


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
                Remark(f"{_well_formed(path.name)}, {kind} {number}", "record", f"this is not JSON ({error})")
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


def _well_formed(text: str) -> str:
    """A text without halves of characters, which no file can hold."""
    return text if text.isascii() else text.encode("utf-8", "replace").decode()


def _is_object(text: str) -> bool:
    try:
        return isinstance(_parsed(text), dict)
    except ValueError:
        return False


@dataclass(frozen=True, slots=True)
class _Feature:
    """One feature with the nearest member ``crs`` above its geometry."""

    name: str
    geometry: Any
    properties: Any
    crs: Any
    absence: str = "no geometry"
    """The remark about it if it has no geometry."""


def _features(documents: tuple[Any, ...], path: Path) -> Iterator[_Feature]:
    """The features of all documents, numbered from 0."""
    number = 0
    for document in documents:
        _refuse_other_formats(document, path)
        outer = _ABSENT
        features = document if isinstance(document, list) else [document]  # a bare list is no GeoJSON, but is written
        if isinstance(document, dict) and _kind_of(document) == "FeatureCollection":
            features, outer = document.get("features"), document.get("crs", _ABSENT)
        if not isinstance(features, list):
            raise AssetError(f"{path}: expected a list under 'features'.")
        if number + len(features) > MAX_FOOTPRINTS:
            raise AssetError(
                f"{path}: {number + len(features)} features; at most {MAX_FOOTPRINTS} are read. Cut out a smaller area."
            )
        for feature in features:
            yield _feature(feature, f"{_well_formed(path.name)}, feature {number}", outer)
            number += 1


def _refuse_other_formats(document: Any, path: Path) -> None:
    kind = _kind_of(document)
    members = () if kind or not isinstance(document, dict) else document
    untyped = (name for member, name in _TELLING_MEMBERS.items() if member in members)
    other = next(untyped, _OTHER_FORMATS.get(kind, ""))
    if other:
        advice = _CONVERSIONS.get(other, "Convert it: ogr2ogr -f GeoJSON -t_srs EPSG:4326 {new} {old}")
        raise AssetError(f"{path}: expected GeoJSON, found {other}. {advice.format_map(_files(path))}")


def _kind_of(value: Any) -> str:
    """The member ``type`` of an object; empty if there is none."""
    kind = value.get("type") if isinstance(value, dict) else None
    return _well_formed(kind) if isinstance(kind, str) else ""


def _files(path: Path) -> dict[str, str]:
    """Names of a converted file and of a file, for a command."""
    return {"new": shlex.quote(f"{path.stem}-degrees.geojson"), "old": shlex.quote(path.name)}


def _feature(feature: Any, name: str, outer: Any) -> _Feature:
    if not isinstance(feature, dict):
        return _Feature(name, None, None, outer)
    if _kind_of(feature) in _GEOMETRIES:
        return _Feature(name, feature, None, outer)
    absence = "no geometry"
    if any(member in feature for member in _JSON_FG):
        absence = "no geometry of GeoJSON, but perhaps one of JSON-FG. Convert it: ogr2ogr -t_srs EPSG:4326"
    elif "geometry" not in feature and _kind_of(feature) not in ("", "Feature"):
        absence = f"expected a Feature, found a {_kind_of(feature)[:40]!r}"
    return _Feature(name, feature.get("geometry"), feature.get("properties"), feature.get("crs", outer), absence)


def _plain_values(properties: Any) -> tuple[Mapping[str, float | bool | str], tuple[str, ...]]:
    """The plain values among properties, and the names of all others but null."""
    values: dict[str, float | bool | str] = {}
    unread = []
    for name, value in properties.items() if isinstance(properties, dict) else ():
        if isinstance(value, str):
            values[_well_formed(name)] = _well_formed(value)
        elif isinstance(value, bool):
            values[_well_formed(name)] = value
        elif isinstance(value, int | float) and abs(value) <= sys.float_info.max:
            values[_well_formed(name)] = float(value)
        elif value is not None:
            unread.append(_well_formed(name))
    return values, tuple(unread)


@dataclass(frozen=True, slots=True)
class _Shape:
    """One polygon of a geometry."""

    polygon: shapely.Polygon | str
    """The polygon, or the reason why it cannot be read."""
    crs: Any


def _shapes(geometry: Any, outer: Any, depth: int) -> Iterator[_Shape | str]:
    """The polygons of a geometry, and descriptions of what else it has."""
    if not isinstance(geometry, dict):
        yield "no geometry"
        return
    kind, crs = _kind_of(geometry), geometry.get("crs", outer)
    members = geometry.get("geometries" if kind == "GeometryCollection" else "coordinates")
    if kind not in _GEOMETRIES:
        yield f"a geometry of type {kind[:40]!r} is not an outline"
    elif not members and isinstance(members, list):
        yield f"an empty {kind}"
    elif kind in _LINEAR:
        yield f"a {kind} is not an outline"
    elif kind == "GeometryCollection":
        if depth == _MAX_DEPTH or not isinstance(members, list):
            yield "expected a list of geometries, not too deeply nested"
            return
        for member in members:
            yield from _shapes(member, crs, depth + 1)
    else:
        for rings in [members] if kind == "Polygon" else members if isinstance(members, list) else [None]:
            yield f"an empty {kind}" if rings == [] else _Shape(_polygon(rings), crs)


def _polygon(rings: Any) -> shapely.Polygon | str:
    try:
        outer, *holes = [[_position(point) for point in ring] for ring in rings]
        if not all(math.isfinite(number) for ring in (outer, *holes) for point in ring for number in point):
            return "a coordinate is not a finite number"
        return shapely.Polygon(outer, [hole for hole in holes if hole])
    except (TypeError, ValueError, IndexError, KeyError, OverflowError, shapely.errors.ShapelyError):
        return "expected rings of [x, y] numbers: four positions or more, the first repeated at the end"


def _position(point: Any) -> tuple[float, float]:
    x, y = point[0], point[1]
    if isinstance(x, bool) or isinstance(y, bool) or not (isinstance(x, int | float) and isinstance(y, int | float)):
        raise TypeError
    return float(x), float(y)


def _note_crs(systems: dict[str, Crs], member: Any, feature: str, path: Path) -> None:
    """Add the CRS of an outline to those of a file, of which there may be one."""
    key = "" if member is _ABSENT else repr(member)
    if key in systems:
        return
    try:
        crs = WGS_84 if member is _ABSENT else crs_of_member(member)
    except AssetError as error:
        command = "ogr2ogr -t_srs EPSG:4326 {new} {old}".format_map(_files(path))
        raise AssetError(f"{path}: {error}. Convert it: {command}") from error
    systems[key] = crs
    names = {system.name for system in systems.values()}
    if len(names) > 1:
        first, second = (name or "none" for name in sorted(names))
        raise AssetError(
            f"{path}: expected one CRS, found {first} and {second} ({feature}). Convert it to one of them."
        )
