"""Maps of parcels for tests, in all formats and coordinate systems."""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import shapely
from pyogrio.raw import write_arrow
from pyproj import Transformer

UTM = "EPSG:32618"
CORNER = np.array([586_000.0, 4_507_000.0])
"""Easting and northing in New York, in metres of `UTM`: there all systems of the tests are defined."""
DRIVERS = {".gpkg": "GPKG", ".shp": "ESRI Shapefile", ".fgb": "FlatGeobuf", ".geojson": "GeoJSON"}


def block(rows: int = 3, columns: int = 4, width: float = 20.0, depth: float = 30.0) -> list[shapely.Polygon]:
    """Rectangular parcels beside each other, in metres from a corner."""
    return [
        shapely.box(width * column, depth * row, width * (column + 1), depth * (row + 1))
        for row in range(rows)
        for column in range(columns)
    ]


def moved(outlines: Sequence[Any], crs: str) -> list[Any]:
    """Outlines in metres from the corner, in the coordinates of a system."""
    transformer = Transformer.from_crs(UTM, crs, always_xy=True)

    def project(points: np.ndarray) -> np.ndarray:
        east, north = (points[:, :2] + CORNER).T
        return np.column_stack([*transformer.transform(east, north), points[:, 2:]])

    return [one and shapely.transform(one, project, include_z=one.has_z) for one in outlines]


def write_map(
    path: Path,
    outlines: Sequence[Any],
    crs: str | None,
    layer: str | None = None,
    /,
    **columns: Any,
) -> Path:
    """Write outlines and columns by GDAL, or as CityJSON: the outlines as ground surfaces of buildings."""
    if path.name.endswith(".city.json"):
        path.write_text(json.dumps(city(outlines, crs, columns)), encoding="utf-8")
        return path
    table = pa.table(columns | {"geometry": pa.array(shapely.to_wkb(np.array(outlines, dtype=object)), pa.binary())})
    options: dict[str, Any] = {"layer": layer} if layer else {}
    if path.suffix == ".geojson":
        options["COORDINATE_PRECISION"] = 12
    kind = "Polygon" if all(isinstance(one, shapely.Polygon) for one in outlines) else "Unknown"
    if outlines and outlines[0] is not None and outlines[0].has_z:
        kind += " Z"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a map without a system is meant
        write_arrow(
            table,
            path,
            driver=DRIVERS[path.suffix],
            geometry_name="geometry",
            geometry_type=kind,
            crs=crs,
            append=path.exists(),
            **options,
        )
    return path


def city(outlines: Sequence[Any], crs: str | None, columns: dict[str, Any]) -> dict[str, Any]:
    """A CityJSON document: each outline is the ground of a solid of 9 units of height."""
    points: list[list[float]] = []
    objects: dict[str, Any] = {}
    ids = columns.get("id", range(len(outlines)))
    for row, (name, outline) in enumerate(zip(ids, outlines, strict=True)):
        attributes = {key: values[row] for key, values in columns.items() if key != "id"}
        objects[str(name)] = {"type": "Building", "attributes": attributes, "geometry": [_solid(outline, points)]}
    code = (crs or "").removeprefix("EPSG:")
    metadata = {"referenceSystem": f"https://www.opengis.net/def/crs/EPSG/0/{code}"} if code else {}
    transform = {"scale": [1e-3] * 3, "translate": [0.0, 0.0, 0.0]}
    if crs == "EPSG:4326":
        transform["scale"] = [1e-12, 1e-12, 1e-3]
    vertices = np.round(np.array(points).reshape(-1, 3) / transform["scale"]).tolist()
    return {
        "type": "CityJSON",
        "version": "2.0",
        "transform": transform,
        "metadata": metadata,
        "CityObjects": objects,
        "vertices": vertices,
    }


def _solid(outline: Any, points: list[list[float]]) -> dict[str, Any]:
    assert isinstance(outline, shapely.Polygon)
    corners = shapely.get_coordinates(outline)[:-1]
    first, number = len(points), len(corners)
    for height in (5.0, 14.0):
        points += [[x, y, height] for x, y in corners.tolist()]
    ground = [first + number - 1 - index for index in range(number)]
    roof = [first + number + index for index in range(number)]
    walls = [
        [first + index, first + (index + 1) % number, first + number + (index + 1) % number, first + number + index]
        for index in range(number)
    ]
    return {
        "type": "Solid",
        "lod": "2.2",
        "boundaries": [[[ground], [roof], *[[wall] for wall in walls]]],
        "semantics": {
            "surfaces": [{"type": "GroundSurface"}, {"type": "RoofSurface"}, {"type": "WallSurface"}],
            "values": [[0, 1, *[2] * number]],
        },
    }
