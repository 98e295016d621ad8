"""Shapes of any kind on maps, in the frame of a city: streets, areas of zones, what distances are measured to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.city.street_lines import StreetLines
from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.coordinates import UNPLACED, transformed
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.geometry.footprints.map_file import read_layer, split_layer

if TYPE_CHECKING:
    import pyarrow as pa

_WIDTH = "width"
"""Attribute of streets with their width in metres."""
_MAX_DEGREES = 180.0


@dataclass(frozen=True, eq=False)
class MapShapes:
    """N shapes of a map."""

    geometry: NDArray[np.object_]
    """[N] geometries of shapely, valid, x to the east and y to the north of the frame's origin, in metres."""
    attributes: pa.Table
    """[N] columns of the map."""


def read_shapes(path: Path, frame: Frame) -> MapShapes:
    """All shapes of a map.

    Args:
        path: file of a vector format; ``:LAYER`` may follow. If it names no system, it has that of its format, or the
            frame's if its place is unknown.
        frame: frame of the city.

    Raises:
        AssetError: If the file cannot be read, or its coordinate system and that of the frame do not fit.
        UsageError: If the layer is unknown, or the extra ``city`` is missing.
    """
    file, name = split_layer(str(path)) or (path, None)
    layer = read_layer(file, name)
    shapes = layer.geometry
    rows = np.flatnonzero(~shapely.is_missing(shapes) & ~shapely.is_empty(shapes))
    geometry = shapely.force_2d(shapes[rows])
    crs = layer.crs or (layer.default_crs if frame.has_place and _may_be_degrees(geometry) else UNPLACED)
    if (crs == UNPLACED) == frame.has_place:
        known, unknown = ("parcels", "it") if frame.has_place else ("it", "parcels")
        raise AssetError(f"{layer.name}: the place of {known} is known, and that of {unknown} is not: name its CRS.")
    if frame.has_place:
        geometry = shapely.transform(geometry, lambda points: transformed(points, crs, frame.crs))
    moved = shapely.transform(geometry, lambda points: points - np.array(frame.origin))
    finite = np.isfinite(shapely.bounds(moved)).all(axis=1)
    attributes = layer.attributes.take(rows[finite]) if layer.attributes.num_columns else layer.attributes
    return MapShapes(shapely.make_valid(moved[finite]), attributes)


def _may_be_degrees(geometry: NDArray[np.object_]) -> bool:
    return bool(np.abs(shapely.total_bounds(geometry)).max() <= _MAX_DEGREES)


def read_streets(path: Path, frame: Frame) -> StreetLines:
    """The lines of a map as streets; their attribute ``width``, if there is one, is their width in metres.

    Args:
        path: file of a vector format.
        frame: frame of the city.

    Raises:
        AssetError: See `read_shapes`; and if it has no lines.
    """
    shapes = read_shapes(path, frame)
    parts, row = shapely.get_parts(shapes.geometry, return_index=True)
    is_line = shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING
    if not is_line.any():
        raise AssetError(f"{path}: expected lines of streets, found none.")
    widths = np.full(len(shapes.geometry), np.nan)
    if _WIDTH in shapes.attributes.column_names:
        values = shapes.attributes[_WIDTH].to_pylist()
        widths = np.array([_metres(value) for value in values])
    return StreetLines(parts[is_line], widths[row[is_line]])


def _metres(value: object) -> float:
    """A width in metres, as maps write it: ``7``, ``"7.5"``, ``"12 m"``; NaN if it says nothing."""
    try:
        width = float(str(value).strip().lower().removesuffix("m").strip())
    except ValueError:
        return float("nan")
    return width if 0.0 < width < float("inf") else float("nan")
