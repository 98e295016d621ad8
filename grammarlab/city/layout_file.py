"""Layouts as GeoJSON, to be edited elsewhere and read again as a map of parcels or streets.

Coordinates are degrees (RFC 7946) if the frame has a place, else metres: a plan reads these with ``crs = "local"``.
One feature is on each line, so that changes can be compared.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.city.city_layout import Layout
from grammarlab.files import atomic_file
from grammarlab.geometry.footprints.frame import Frame

_DEGREE_DECIMALS = 9
"""Decimal places of degrees: 0.1 mm."""
_METRE_DECIMALS = 3


def write_parcels(layout: Layout, path: Path) -> None:
    """Write the parcels of a layout, with their ids, blocks, uses and frontages.

    Raises:
        OSError: If the file cannot be written.
        UsageError: If the frame has a place and the extra ``city`` is missing.
    """
    parcels = layout.parcels
    columns = {"id": parcels.id.tolist(), **parcels.attributes.to_pydict()}
    _write(path, parcels.outline, parcels.frame, columns)


def write_streets(layout: Layout, path: Path) -> None:
    """Write the streets of a layout, with their widths in metres.

    Raises:
        OSError: If the file cannot be written.
        UsageError: If the frame has a place and the extra ``city`` is missing.
    """
    columns = {"width": layout.streets.width.tolist()}
    _write(path, layout.streets.line, layout.parcels.frame, columns)


def _write(path: Path, shapes: NDArray[np.object_], frame: Frame, columns: Mapping[str, list[object]]) -> None:
    with atomic_file(path) as part, part.open("w", encoding="utf-8", newline="\n") as file:
        file.writelines(_lines(_placed(shapes, frame), columns))


def _lines(shapes: Iterable[shapely.Geometry], columns: Mapping[str, list[object]]) -> Iterator[str]:
    yield '{"type": "FeatureCollection", "features": [\n'
    names = list(columns)
    separator = ""
    for geometry, *values in zip(shapely.to_geojson(np.asarray(shapes)), *columns.values(), strict=True):
        properties = json.dumps(dict(zip(names, values, strict=True)), ensure_ascii=False)
        yield f'{separator}{{"type": "Feature", "properties": {properties}, "geometry": {geometry}}}'
        separator = ",\n"
    yield "\n]}\n"


def _placed(shapes: NDArray[np.object_], frame: Frame) -> NDArray[np.object_]:
    """Shapes in the coordinates of the file."""

    def degrees(points: Floats) -> Floats:
        return np.round(frame.longitude_latitude(points), _DEGREE_DECIMALS)

    def metres(points: Floats) -> Floats:
        return np.round(points + np.array(frame.origin), _METRE_DECIMALS)

    return shapely.transform(shapes, degrees if frame.has_place else metres)
