"""Layers of GeoJSON files of any size, as columns.

Features are converted in chunks, by numpy where all positions of a chunk have as many numbers, otherwise one by one,
with the same result.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts
from grammarlab.errors import AssetError
from grammarlab.files import open_regular
from grammarlab.geometry.footprints.attribute_columns import NOT_USED, Columns, columns_of, united
from grammarlab.geometry.footprints.coordinates import UNPLACED
from grammarlab.geometry.footprints.crs import WGS_84, Crs
from grammarlab.geometry.footprints.footprint import Remark
from grammarlab.geometry.footprints.geojson_features import (
    ABSENT,
    LINEAR,
    Feature,
    feature_of,
    kind_of,
    note_crs,
    refuse_other_formats,
    shapes_of,
    well_formed,
)
from grammarlab.geometry.footprints.json_stream import Damage, Item, Member, json_parts
from grammarlab.geometry.footprints.map_layer import MAX_FEATURES, MAX_MAP_BYTES, MapLayer, bodies_of

_CHUNK = 8192
"""Features that are converted at a time."""
_MOST_REMARKS = 100
"""Largest number of remarks about broken lines."""
ID = "id"
"""Name of the attribute with the ids of features, if no property has this name."""


class _Reading:
    """What has been read of a file, in the order of its features.

    Args:
        path: the file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.num_features = 0
        self.bodies: list[pa.Array] = []
        self.columns: list[Columns] = []
        self.id_columns: list[Columns] = []
        self.unread: set[str] = set()
        self.remarks: list[Remark] = []
        self.num_damaged = 0
        self.members: dict[str, Any] = {}
        self.systems: dict[str, Crs] = {}  # of features and geometries that have their own
        self.has_plain_features = False  # some polygons have no own system
        self._features: list[Feature] = []
        self._ids: list[Any] = []

    def add(self, value: Any) -> None:
        """Add a feature, or a bare geometry."""
        self.num_features += 1
        if self.num_features > MAX_FEATURES:
            raise AssetError(f"{self.path}: expected at most {MAX_FEATURES:,} features. Cut out a smaller area.")
        name = f"{well_formed(self.path.name)}, feature {self.num_features - 1}"
        self._features.append(feature_of(value, name, ABSENT))
        self._ids.append(value.get("id") if isinstance(value, dict) else None)
        if len(self._features) == _CHUNK:
            self.convert()

    def convert(self) -> None:
        """Turn the features that are waiting into columns."""
        records = [one.properties if isinstance(one.properties, dict) else {} for one in self._features]
        columns, unread = columns_of(records)
        self.columns.append(columns)
        self.unread |= unread
        self.id_columns.append(columns_of([{ID: one} for one in self._ids])[0])
        self.bodies.append(bodies_of(_geometries(self._features)))
        for feature in self._features:
            if isinstance(feature.geometry, dict):
                member = feature.geometry.get("crs", feature.crs)
                if member is ABSENT:
                    self.has_plain_features = True
                else:
                    note_crs(self.systems, member, feature.name, self.path)
        self._features.clear()
        self._ids.clear()

    def damaged(self, damage: Damage) -> None:
        """Note a line that is not JSON."""
        self.num_damaged += 1
        if self.num_damaged <= _MOST_REMARKS:
            where = f"{well_formed(self.path.name)}, record {damage.number}"
            self.remarks.append(Remark(where, "record", f"this is not JSON ({damage.reason})"))


def read_geojson_layer(path: Path) -> MapLayer:
    """The features of a GeoJSON file, in the coordinates of the file.

    Raises:
        AssetError: If it is not GeoJSON, is too large, or has several coordinate systems.
    """
    reading = _Reading(path)
    with open_regular(path, MAX_MAP_BYTES) as file:
        for part in json_parts(path, file, "features"):
            if isinstance(part, Damage):
                reading.damaged(part)
            elif isinstance(part, Item):
                reading.add(part.value)
            elif isinstance(part, Member):
                reading.members[part.name] = part.value
            else:
                _add_document(reading, part.value)
    members = reading.members
    if members and not reading.num_features:
        refuse_other_formats(members, path)
        if kind_of(members) != "FeatureCollection":
            reading.add(members)
        elif "features" in members:
            raise AssetError(f"{path}: expected a list under 'features'.")
    if reading.num_damaged and not reading.num_features:
        raise AssetError(f"{path}: expected GeoJSON, but none of its {reading.num_damaged:,} records is JSON.")
    reading.convert()
    return _layer(reading)


def _add_document(reading: _Reading, document: Any) -> None:
    """Add the features of a line or record."""
    refuse_other_formats(document, reading.path)
    if kind_of(document) != "FeatureCollection":
        reading.add(document)
        return
    features = document.get("features")
    if not isinstance(features, list):
        raise AssetError(f"{reading.path}: expected a list under 'features'.")
    if "crs" in document:
        reading.members["crs"] = document["crs"]
    for feature in features:
        reading.add(feature)


def _layer(reading: _Reading) -> MapLayer:
    lengths = [len(chunk) for chunk in reading.bodies]
    attributes = united(reading.columns, lengths)
    if ID not in attributes.column_names:
        ids = united(reading.id_columns, lengths)
        if ids.num_columns and ids[ID].null_count < len(ids):
            position = sum(name < ID for name in attributes.column_names)
            attributes = attributes.add_column(position, ID, ids[ID]) if attributes.num_columns else ids
    remarks = list(reading.remarks)
    if reading.unread:
        names = ", ".join(sorted(reading.unread)[:8])
        remarks.append(Remark(str(reading.path), "property", f"{NOT_USED}: {names}"))
    return MapLayer(
        name=str(reading.path),
        bodies=reading.bodies,
        attributes=attributes if attributes.num_columns else pa.table({}),
        crs=_crs(reading),
        default_crs=WGS_84.name,
        remarks=tuple(remarks),
    )


def _crs(reading: _Reading) -> str | None:
    """The name of the system of all features; None if none has one."""
    systems = reading.systems
    if "crs" in reading.members and (reading.has_plain_features or not systems):
        note_crs(systems, reading.members["crs"], "the collection", reading.path)
    elif reading.has_plain_features and systems:
        note_crs(systems, ABSENT, "another feature", reading.path)
    if not systems:
        return None
    crs, *_ = systems.values()
    return crs.name or UNPLACED


def _geometries(features: Sequence[Feature]) -> NDArray[np.object_]:
    """[n] geometries of features, None where there are none."""
    geometry = np.full(len(features), None, dtype=object)
    rows, coordinates = [], []
    for row, feature in enumerate(features):
        polygons = _coordinates(feature.geometry)
        if polygons is not None:
            rows.append(row)
            coordinates.append(polygons)
    columns = _multipolygons(coordinates) if rows else None
    if columns is not None:
        geometry[rows] = columns
    for row, feature in enumerate(features):
        if geometry[row] is None:
            single = _multipolygons([polygons]) if (polygons := _coordinates(feature.geometry)) else None
            geometry[row] = _geometry(feature.geometry) if single is None else single[0]
    return geometry


def _coordinates(geometry: Any) -> list[Any] | None:
    """The coordinates of a polygon or of several as those of several, unchecked; None for other geometries."""
    if not isinstance(geometry, dict):
        return None
    coordinates, kind = geometry.get("coordinates"), geometry.get("type")
    if not isinstance(coordinates, list) or not coordinates:
        return None
    return [coordinates] if kind == "Polygon" else coordinates if kind == "MultiPolygon" else None


def _multipolygons(coordinates: Sequence[list[Any]]) -> NDArray[np.object_] | None:
    """[n] multipolygons of coordinates; None if a position has other than the usual numbers, or a ring is open."""
    try:
        polygons = [polygon for parts in coordinates for polygon in parts]
        rings = [ring for polygon in polygons for ring in polygon]
        points = np.array([position for ring in rings for position in ring])
    except (TypeError, ValueError, OverflowError):
        return None
    lengths = np.array([len(ring) for ring in rings])
    if points.ndim != 2 or points.shape[1] not in (2, 3) or points.dtype.kind not in "if":
        return None
    if lengths.min(initial=4) < 4 or not all(polygons) or not np.isfinite(points).all():
        return None
    ring_offsets = offsets_from_counts(lengths)
    if (points[ring_offsets[:-1]] != points[ring_offsets[1:] - 1]).any():
        return None
    polygon_offsets = offsets_from_counts(np.array([len(polygon) for polygon in polygons]))
    part_offsets = offsets_from_counts(np.array([len(parts) for parts in coordinates]))
    kind = shapely.GeometryType.MULTIPOLYGON
    return shapely.from_ragged_array(kind, points.astype(np.float64), (ring_offsets, polygon_offsets, part_offsets))


def _geometry(geometry: Any) -> shapely.Geometry | None:
    """The polygons of a geometry that has unusual parts, or its lines or points; None if none can be read."""
    if not isinstance(geometry, dict):
        return None
    polygons = [
        shape.polygon
        for shape in shapes_of(geometry, ABSENT, 0)
        if not isinstance(shape, str) and not isinstance(shape.polygon, str)
    ]
    return shapely.MultiPolygon(polygons) if polygons else _lines_or_points(geometry)


def _lines_or_points(geometry: dict[str, Any]) -> shapely.Geometry | None:
    """A geometry without areas; None if it has areas or cannot be read."""
    if kind_of(geometry) not in LINEAR:
        return None
    try:
        text = json.dumps({"type": geometry["type"], "coordinates": geometry.get("coordinates")})
    except RecursionError:
        return None
    return shapely.from_geojson(text, on_invalid="ignore")
