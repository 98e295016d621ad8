"""The layer of a map, in a file of any of the formats that are read."""

from __future__ import annotations

import mmap
import re
from pathlib import Path

from grammarlab.errors import AssetError, UsageError
from grammarlab.files import existing, open_regular
from grammarlab.geometry.footprints.map_layer import MapLayer

VECTOR_SUFFIXES = (".gpkg", ".fgb", ".shp", ".zip")
"""Suffixes of the formats that need the extra ``city``."""
_HEAD_BYTES = 64 << 10
_CITYJSON = re.compile(rb'"type"\s*:\s*"CityJSON(?:Feature)?"')
_GEOJSON = re.compile(rb'"type"\s*:\s*"(?:Feature|FeatureCollection|Polygon|MultiPolygon)"')


def split_layer(text: str) -> tuple[Path, str | None] | None:
    """The file of a text, and the layer behind a colon: ``quarter.gpkg:parcels``; None if there is no such file.

    >>> split_layer("nowhere.gpkg:parcels")
    """
    file = existing(text)
    if file is not None:
        return file, None
    for match in re.finditer(":", text):
        file = existing(text[: match.start()])
        if file is not None and file.is_file():
            return file, text[match.end() :]
    return None


def is_cityjson(path: Path) -> bool:
    """Whether a regular file is CityJSON, which says so anywhere in it."""
    if path.suffix.lower() not in (".json", ".jsonl"):
        return False
    with open_regular(path) as file:
        head = file.read(_HEAD_BYTES)
        if _CITYJSON.search(head):
            return True
        if _GEOJSON.search(head) or len(head) < _HEAD_BYTES:
            return False
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            return _CITYJSON.search(content) is not None


def read_layer(path: Path, layer: str | None = None) -> MapLayer:
    """The features of a layer, in the coordinates of the file.

    Args:
        path: GeoJSON, GeoPackage, Shapefile (also zipped), FlatGeobuf or CityJSON.
        layer: name of the layer, for CityJSON the type of the objects; None if there is only one.

    Raises:
        AssetError: If there is no such file, or it is broken or too large.
        UsageError: If the layer is unknown; if the extra ``city`` is missing.
    """
    if not path.is_file():
        raise AssetError(f"{path}: no such map: expected a file of GeoJSON, CityJSON, {', '.join(VECTOR_SUFFIXES)}.")
    if path.suffix.lower() in VECTOR_SUFFIXES:
        from grammarlab.geometry.footprints.vector_file import read_vector_layer  # noqa: PLC0415  # needs GDAL

        return read_vector_layer(path, layer)
    if is_cityjson(path):
        from grammarlab.geometry.footprints.cityjson_ground import read_cityjson_layer  # noqa: PLC0415  # needs Arrow

        return read_cityjson_layer(path, layer)
    if layer is not None:
        raise UsageError(f"{path}: GeoJSON has no layers; leave out ':{layer}'.")
    from grammarlab.geometry.footprints.geojson_columns import read_geojson_layer  # noqa: PLC0415  # needs Arrow

    return read_geojson_layer(path)
