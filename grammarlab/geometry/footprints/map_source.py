"""Layers of maps as sources of footprints, and sources of any coordinate system in metres."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from grammarlab.errors import AssetError, UsageError
from grammarlab.geometry.footprints.coordinates import metric_system
from grammarlab.geometry.footprints.crs import Crs, crs_of_name
from grammarlab.geometry.footprints.footprint import Outline, Remark, Source
from grammarlab.geometry.footprints.geojson import MAX_FOOTPRINTS
from grammarlab.geometry.footprints.geojson_features import conversion, well_formed
from grammarlab.geometry.footprints.map_file import read_layer
from grammarlab.geometry.footprints.map_layer import MapLayer

_POLYGON = shapely.GeometryType.POLYGON
_KINDS = {kind.value: kind.name.lower() for kind in shapely.GeometryType}


def read_map(path: Path, layer: str | None) -> Source:
    """The outlines of a layer of a map, in the coordinates of the file.

    Raises:
        AssetError: If the file is broken, has no coordinate system, or too many outlines.
        UsageError: If the layer is unknown, or the extra ``city`` is missing.
    """
    read = read_layer(path, layer)
    if read.crs is None:
        raise AssetError(
            f"{path}: it does not name its coordinate reference system. "
            f"Add it: ogr2ogr -a_srs EPSG:CODE NEW {path.name}"
        )
    parts, rows = _polygons(read.geometry)
    if len(parts) > MAX_FOOTPRINTS:
        raise AssetError(
            f"{path}: {len(parts):,} polygons; at most {MAX_FOOTPRINTS:,} are read. Cut out a smaller area."
        )
    values = _values(read, rows)
    outlines = tuple(
        Outline(part, _name(path, row), value) for part, row, value in zip(parts, rows.tolist(), values, strict=True)
    )
    advice = f"Convert it: {conversion(path)}"
    return Source(
        str(path), outlines, (*read.remarks, *_omissions(path, read)), crs_of_name(read.crs), conversion=advice
    )


def in_metres(source: Source) -> Source:
    """A source whose system is neither degrees nor true metres, in metres.

    Raises:
        AssetError: If the system is unknown, or the extra ``city`` is missing.
    """
    fault = f"{source.name}: {source.crs.fault}. {source.conversion}"
    polygons = np.array([outline.polygon for outline in source.outlines], dtype=object)
    centres = shapely.get_coordinates(shapely.centroid(polygons))
    centres = centres[np.isfinite(centres).all(axis=1)]
    if len(centres) == 0:
        return replace(source, crs=Crs(source.crs.name, "metres"))
    try:
        system = metric_system(source.crs.name, centres)
    except UsageError as error:
        raise AssetError(f"{fault.rstrip('.')}. Or install what reads it: {error}") from error
    except AssetError as error:
        is_unknown = str(error).endswith("is not known")
        raise AssetError(fault if is_unknown else f"{source.name}: {error}. {source.conversion}") from error
    moved = shapely.transform(polygons, system.metres)
    outlines = tuple(replace(outline, polygon=polygon) for outline, polygon in zip(source.outlines, moved, strict=True))
    remarks = (*source.remarks, *([Remark(source.name, "coordinates", system.note)] if system.note else ()))
    return replace(source, outlines=outlines, remarks=remarks, crs=Crs(system.target, "metres"))


def _polygons(geometry: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All polygons of geometries without heights, and the row of each."""
    parts, rows = shapely.get_parts(geometry, return_index=True)
    parts, inner = shapely.get_parts(parts, return_index=True)  # several may be in a collection
    rows = rows[inner]
    is_polygon = (shapely.get_type_id(parts) == _POLYGON) & ~shapely.is_empty(parts)
    return shapely.force_2d(parts[is_polygon]), rows[is_polygon]


def _values(layer: MapLayer, rows: np.ndarray) -> list[Mapping[str, float | bool | str]]:
    """Properties of the features of some rows, without nulls."""
    if not layer.attributes.num_columns:
        return [{} for _ in rows]
    return [
        {name: _plain(value) for name, value in record.items() if value is not None}
        for record in layer.attributes.take(rows).to_pylist()
    ]


def _plain(value: Any) -> float | bool | str:
    return value if isinstance(value, bool | str) else float(value)


def _omissions(path: Path, layer: MapLayer) -> list[Remark]:
    """Remarks about features without polygons."""
    geometry = layer.geometry
    _, rows = _polygons(geometry)
    others = np.setdiff1d(np.arange(len(layer)), rows)
    remarks = []
    kinds = shapely.get_type_id(geometry[others]).tolist()
    for row, kind in zip(others.tolist(), kinds, strict=True):
        reason = "no geometry" if kind < 0 else f"a {_KINDS[kind]} is not an outline"
        remarks.append(Remark(_name(path, row), "geometry", reason))
    return remarks


def _name(path: Path, row: int) -> str:
    return f"{well_formed(path.name)}, feature {row}"
