"""Features of GeoJSON: their geometries, properties and coordinate systems, as parsed values."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import shapely

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.crs import WGS_84, Crs, crs_of_member, excerpt

_MAX_DEPTH = 16
"""Largest depth of geometry collections in each other."""
ABSENT = object()
"""Stands for a member that is absent, unlike one that is null."""
LINEAR = frozenset({"Point", "MultiPoint", "LineString", "MultiLineString"})
"""Kinds of geometries without an area."""
_GEOMETRIES = LINEAR | {"Polygon", "MultiPolygon", "GeometryCollection"}
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


def well_formed(text: str) -> str:
    """A text without halves of characters, which no file can hold."""
    return text if text.isascii() else text.encode("utf-8", "replace").decode()


@dataclass(frozen=True, slots=True)
class Feature:
    """One feature with the nearest member ``crs`` above its geometry."""

    name: str
    geometry: Any
    properties: Any
    crs: Any
    absence: str = "no geometry"
    """The remark about it if it has no geometry."""


def refuse_other_formats(document: Any, path: Path) -> None:
    """Refuse a document of another format of JSON.

    Raises:
        AssetError: It names the format and a program that converts it.
    """
    kind = kind_of(document)
    members = () if kind or not isinstance(document, dict) else document
    untyped = (name for member, name in _TELLING_MEMBERS.items() if member in members)
    other = next(untyped, _OTHER_FORMATS.get(kind, ""))
    if other:
        advice = _CONVERSIONS.get(other, "Convert it: ogr2ogr -f GeoJSON -t_srs EPSG:4326 {new} {old}")
        raise AssetError(f"{path}: expected GeoJSON, found {other}. {advice.format_map(_new_and_old(path))}")


def kind_of(value: Any) -> str:
    """The member ``type`` of an object; empty if there is none."""
    kind = value.get("type") if isinstance(value, dict) else None
    return well_formed(kind) if isinstance(kind, str) else ""


def _new_and_old(path: Path) -> dict[str, str]:
    """Names of a converted file and of a file, for a command."""
    return {"new": shlex.quote(f"{path.stem}-degrees.geojson"), "old": shlex.quote(path.name)}


def conversion(path: Path) -> str:
    """Command that converts a map to degrees."""
    return "ogr2ogr -t_srs EPSG:4326 {new} {old}".format_map(_new_and_old(path))


def feature_of(feature: Any, name: str, outer: Any) -> Feature:
    """A feature, or a bare geometry.

    Args:
        feature: parsed JSON.
        name: its place in the file.
        outer: the member ``crs`` around it.
    """
    if not isinstance(feature, dict):
        return Feature(name, None, None, outer)
    if kind_of(feature) in _GEOMETRIES:
        return Feature(name, feature, None, outer)
    absence = "no geometry"
    if any(member in feature for member in _JSON_FG):
        absence = "no geometry of GeoJSON, but perhaps one of JSON-FG. Convert it: ogr2ogr -t_srs EPSG:4326"
    elif "geometry" not in feature and kind_of(feature) not in ("", "Feature"):
        absence = f"expected a Feature, found a {kind_of(feature)[:40]!r}"
    return Feature(name, feature.get("geometry"), feature.get("properties"), feature.get("crs", outer), absence)


def plain_values(properties: Any) -> tuple[Mapping[str, float | bool | str], tuple[str, ...]]:
    """The plain values among properties, and the names of all others but null."""
    values: dict[str, float | bool | str] = {}
    unread = []
    for name, value in properties.items() if isinstance(properties, dict) else ():
        if isinstance(value, str):
            values[well_formed(name)] = well_formed(value)
        elif isinstance(value, bool):
            values[well_formed(name)] = value
        elif isinstance(value, int | float) and abs(value) <= sys.float_info.max:
            values[well_formed(name)] = float(value)
        elif value is not None:
            unread.append(well_formed(name))
    return values, tuple(unread)


@dataclass(frozen=True, slots=True)
class Shape:
    """One polygon of a geometry."""

    polygon: shapely.Polygon | str
    """The polygon, or the reason why it cannot be read."""
    crs: Any


def shapes_of(geometry: Any, outer: Any, depth: int) -> Iterator[Shape | str]:
    """The polygons of a geometry, and descriptions of what else it has."""
    if not isinstance(geometry, dict):
        yield "no geometry"
        return
    kind, crs = kind_of(geometry), geometry.get("crs", outer)
    members = geometry.get("geometries" if kind == "GeometryCollection" else "coordinates")
    if kind not in _GEOMETRIES:
        yield f"a geometry of type {kind[:40]!r} is not an outline"
    elif not members and isinstance(members, list):
        yield f"an empty {kind}"
    elif kind in LINEAR:
        yield f"a {kind} is not an outline"
    elif kind == "GeometryCollection":
        if depth == _MAX_DEPTH or not isinstance(members, list):
            yield "expected a list of geometries, not too deeply nested"
            return
        for member in members:
            yield from shapes_of(member, crs, depth + 1)
    else:
        for rings in [members] if kind == "Polygon" else members if isinstance(members, list) else [None]:
            yield f"an empty {kind}" if rings == [] else Shape(_polygon(rings), crs)


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


def note_crs(systems: dict[str, Crs], member: Any, feature: str, path: Path) -> None:
    """Add the CRS of an outline to those of a file, of which there may be one."""
    key = "" if member is ABSENT else repr(member)
    if key in systems:
        return
    try:
        crs = WGS_84 if member is ABSENT else crs_of_member(member)
    except AssetError as error:
        raise AssetError(f"{path}: {error}. Convert it: {conversion(path)}") from error
    systems[key] = crs
    names = {system.name for system in systems.values()}
    if len(names) > 1:
        first, second = (excerpt(name) or "none" for name in sorted(names))
        raise AssetError(
            f"{path}: expected one CRS, found {first} and {second} ({feature}). Convert it to one of them."
        )
