"""Footprints: ground polygons of models, from a size, from WKT or from a GeoJSON file.

A plan's x (east) becomes the world's x, its y (north) the world's -z, so that a counter-clockwise ring looks up (+y).
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.errors import AssetError, UsageError
from grammarlab.files import existing
from grammarlab.geometry.meshes.keyhole import keyhole

MAX_FILE_BYTES = 64 << 20
MAX_FOOTPRINTS = 100_000
MAX_CORNERS = 10_000
MAX_EXTENT = 20_000.0
"""Largest width or depth of one footprint in metres."""
MIN_AREA = 1e-4
"""Smallest area of a footprint in square metres."""

_SIZE = re.compile(r"\s*(\d+(?:\.\d+)?)\s*[xX×]\s*(\d+(?:\.\d+)?)\s*")
_EXPECTED = "expected WIDTHxDEPTH in metres (20x12), WKT (POLYGON ((0 0, 20 0, 20 12, 0 12, 0 0))) or a .geojson file"


@dataclass(frozen=True, slots=True)
class Footprint:
    """One polygon on the ground."""

    polygon: NDArray[np.float64]
    """[n, 3] corners in metres, counter-clockwise seen from above, y = 0; the first is not repeated. Holes are
    joined to the outline by doubled edges."""
    properties: Mapping[str, float | bool | str] = field(default_factory=dict)
    """Properties in the file; they set attributes of the grammar with the same names."""
    name: str = ""
    """Its source, for messages: ``lots.geojson, feature 3``."""


def read_footprints(text: str) -> tuple[Footprint, ...]:
    """Footprints from the text of an option: at least one.

    Args:
        text: ``20x12``, a WKT polygon or multipolygon in metres, or the path of a GeoJSON file.

    Raises:
        UsageError: If the text is none of these.
        AssetError: If a polygon is self-intersecting, degenerate or out of bounds, or a file is broken.

    >>> import grammarlab as gl
    >>> gl.read_footprints("20x12")[0].polygon[:, [0, 2]].tolist()
    [[0.0, 12.0], [20.0, 12.0], [20.0, 0.0], [0.0, 0.0]]
    """
    if size := _SIZE.fullmatch(text):
        width, depth = float(size[1]), float(size[2])
        plan = shapely.Polygon([(0, -depth), (width, -depth), (width, 0), (0, 0)])  # along +x and +z, as in `derive`
        return tuple(_polygons(plan, {}, text))
    if re.match(r"\s*(SRID|MULTI|POLYGON|POINT|LINESTRING|GEOMETRY|CURVE)", text, re.IGNORECASE):
        return _from_wkt(text)
    file = existing(text)
    if text.lower().endswith((".geojson", ".json")) or (file is not None and file.is_file()):
        return _from_geojson(Path(text))
    raise UsageError(f"footprint {text!r}: {_EXPECTED}.")


def _from_wkt(text: str) -> tuple[Footprint, ...]:
    try:
        with np.errstate(invalid="ignore"):  # not-a-number is reported below, with the name of the footprint
            shape = shapely.from_wkt(text)
    except shapely.errors.ShapelyError as error:
        raise AssetError(f"footprint: this is not well-formed WKT ({error}); {_EXPECTED}.") from error
    return tuple(_polygons(shape, {}, "footprint"))


def _from_geojson(path: Path) -> tuple[Footprint, ...]:
    if not path.is_file():
        raise AssetError(f"{path}: no such footprint file; {_EXPECTED}.")
    if (size := path.stat().st_size) > MAX_FILE_BYTES:
        raise AssetError(
            f"{path}: {size} bytes; footprint files may have {MAX_FILE_BYTES} at most. Cut out a smaller area."
        )
    try:
        document = json.loads(path.read_text(encoding="utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise AssetError(f"{path}: expected GeoJSON, but this is not JSON ({error}).") from error
    shapes = [(shape, properties, name) for shape, properties, name in _features(document, path.name)]
    if _is_geographic(document):
        shapes = _to_local_metres(shapes)
    footprints = [footprint for shape in shapes for footprint in _polygons(*shape)]
    if not footprints:
        raise AssetError(f"{path}: no Polygon or MultiPolygon in this file.")
    return tuple(footprints)


_Feature = tuple[shapely.Geometry, Mapping[str, float | bool | str], str]


def _features(document: Any, file: str) -> Iterator[_Feature]:
    """Polygons of a GeoJSON document with their properties; other kinds of geometry are ignored."""
    kind = document.get("type") if isinstance(document, dict) else None
    if kind == "FeatureCollection":
        features = document.get("features")
    elif kind == "Feature":
        features = [document]
    else:
        features = [{"geometry": document, "properties": {}}]
    if not isinstance(features, list):
        raise AssetError(f"{file}: expected a list under 'features'.")
    if len(features) > MAX_FOOTPRINTS:
        raise AssetError(
            f"{file}: {len(features)} features; at most {MAX_FOOTPRINTS} are read. Cut out a smaller area."
        )
    for index, feature in enumerate(features):
        name = f"{file}, feature {index}"
        geometry = feature.get("geometry") if isinstance(feature, dict) else None
        if isinstance(geometry, dict) and geometry.get("type") in ("Polygon", "MultiPolygon"):
            yield _shape(geometry, name), _plain_values(feature.get("properties")), name


def _shape(geometry: dict[str, Any], name: str) -> shapely.Geometry:
    try:
        polygons = geometry["coordinates"] if geometry["type"] == "MultiPolygon" else [geometry["coordinates"]]
        return shapely.MultiPolygon(
            [_polygon([np.array(ring, dtype=np.float64)[:, :2] for ring in p]) for p in polygons]
        )
    except (KeyError, TypeError, ValueError, IndexError, shapely.errors.ShapelyError) as error:
        raise AssetError(
            f"{name}: expected rings of [x, y] numbers: four positions or more, the first repeated at the end."
        ) from error


def _polygon(rings: list[NDArray[np.float64]]) -> shapely.Polygon:
    return shapely.Polygon(rings[0], rings[1:])


def _plain_values(properties: Any) -> dict[str, float | bool | str]:
    if not isinstance(properties, dict):
        return {}
    return {
        name: float(value) if isinstance(value, int) and not isinstance(value, bool) else value
        for name, value in properties.items()
        if isinstance(value, int | float | bool | str)
    }


def _is_geographic(document: Any) -> bool:
    """Whether coordinates are degrees, as in RFC 7946, unless a ``crs`` member (GeoJSON 2008) says otherwise."""
    if not isinstance(document, dict) or "crs" not in document:
        return True
    return bool(re.search(r"CRS84|EPSG:+(?:[\d.]*:)?4326", json.dumps(document["crs"])))


def _to_local_metres(shapes: list[_Feature]) -> list[_Feature]:
    """Longitude and latitude in degrees as metres east and north of the middle of all shapes.

    Uses the radii of curvature of the WGS 84 ellipsoid at that middle: accurate to a millimetre over a house, to a
    metre over a town.
    """
    if not shapes:
        return shapes
    west, south, east, north = shapely.total_bounds([shape for shape, _, _ in shapes])
    if not (west >= -180.0 and east <= 180.0 and south >= -89.0 and north <= 89.0):
        raise AssetError(
            f"{shapes[0][2]}: expected longitude and latitude in degrees, found x from {west:g} to {east:g} and y from "
            f'{south:g} to {north:g}. If these are metres, say so by adding "crs": null at the top of the file.'
        )
    longitude, latitude = (west + east) / 2, (south + north) / 2
    equator, flattening = 6378137.0, 1 / 298.257223563
    squared_eccentricity = flattening * (2 - flattening)
    curvature = 1 - squared_eccentricity * math.sin(math.radians(latitude)) ** 2
    to_east = math.radians(1) * equator / math.sqrt(curvature) * math.cos(math.radians(latitude))
    to_north = math.radians(1) * equator * (1 - squared_eccentricity) / curvature**1.5

    def project(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return (points - [longitude, latitude]) * [to_east, to_north]

    return [(shapely.transform(shape, project), properties, name) for shape, properties, name in shapes]


def _polygons(shape: shapely.Geometry, properties: Mapping[str, float | bool | str], name: str) -> Iterator[Footprint]:
    """The checked footprints of a polygon or multipolygon."""
    if not isinstance(shape, shapely.Polygon | shapely.MultiPolygon):
        raise AssetError(f"{name}: expected a polygon, found a {type(shape).__name__}.")
    parts = list(shape.geoms) if isinstance(shape, shapely.MultiPolygon) else [shape]
    if shape.is_empty:
        raise AssetError(f"{name}: expected a polygon with corners, found an empty one.")
    for part in parts:
        _check(part, name)
        yield Footprint(_corners(part), properties, name)


def _corners(polygon: shapely.Polygon) -> NDArray[np.float64]:
    """The corners [n, 3] of a polygon in the world; holes are joined to the outline by doubled edges."""
    rings = [_ring(polygon.exterior, counter_clockwise=True)]
    rings += [_ring(hole, counter_clockwise=False) for hole in polygon.interiors]
    walk = keyhole(rings)
    first_edge = np.flatnonzero((walk == 0) & (np.roll(walk, -1) == 1))[0]
    points = np.concatenate(rings)[np.roll(walk, -first_edge)]
    return np.column_stack([points[:, 0], np.zeros(len(points)), -points[:, 1]]) + 0.0


def _ring(ring: shapely.LinearRing, counter_clockwise: bool) -> NDArray[np.float64]:
    """Corners [n, 2] of a ring, reversed if necessary; the first edge stays first, since the scope is aligned to it."""
    corners = shapely.get_coordinates(shapely.remove_repeated_points(ring))[:-1]
    return corners if ring.is_ccw == counter_clockwise else np.roll(corners[::-1], 2, axis=0)


def _check(polygon: shapely.Polygon, name: str) -> None:
    corners = shapely.get_num_coordinates(polygon)
    if corners > MAX_CORNERS:
        raise AssetError(f"{name}: {corners} corners; a footprint may have {MAX_CORNERS} at most. Simplify it.")
    if not np.isfinite(shapely.get_coordinates(polygon)).all():
        raise AssetError(f"{name}: a coordinate is not a finite number.")
    if not polygon.is_valid:
        reason, _, place = shapely.is_valid_reason(polygon).partition("[")
        x, y = (float(value) for value in place.rstrip("]").split())
        raise AssetError(
            f"{name}: {reason.lower()} at x = {x:g}, y = {y:g} metres. Draw the ring without crossing itself."
        )
    if polygon.area < MIN_AREA:
        raise AssetError(f"{name}: an area of {polygon.area:g} square metres is too small to build on.")
    west, south, east, north = polygon.bounds
    if max(east - west, north - south) > MAX_EXTENT:
        raise AssetError(
            f"{name}: {east - west:g} x {north - south:g} metres; a footprint may have {MAX_EXTENT:g} at most. "
            'GeoJSON counts in degrees; if yours counts in metres, add "crs": null at the top of the file.'
        )
