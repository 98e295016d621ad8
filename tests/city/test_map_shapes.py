"""Shapes of maps in a frame: in place, in metres, with widths as maps write them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from pyproj import Transformer

from grammarlab.city.map_shapes import read_shapes, read_streets
from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.frame import Frame

PARIS = Frame("EPSG:32631", (452000.0, 5412000.0))
NOWHERE = Frame("", (0.0, 0.0))


def write(path: Path, geometries: list[Any], properties: list[dict[str, Any]], **members: Any) -> Path:
    features = [
        {"type": "Feature", "properties": values, "geometry": json.loads(shapely.to_geojson(geometry))}
        for geometry, values in zip(geometries, properties, strict=True)
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features, **members}))
    return path


def test_lines_in_degrees_become_metres_in_place(tmp_path: Path):
    metres = shapely.LineString([(100.0, 50.0), (180.0, -20.0)])
    back = Transformer.from_crs("EPSG:32631", "OGC:CRS84", always_xy=True)
    east, north = np.array(metres.coords).T
    degrees = shapely.LineString(np.column_stack(back.transform(east + 452000.0, north + 5412000.0)))
    streets = read_streets(write(tmp_path / "s.geojson", [degrees], [{"width": "12 m"}]), PARIS)
    assert np.allclose(shapely.get_coordinates(streets.line), shapely.get_coordinates(metres), atol=1e-3)
    assert streets.width.tolist() == [12.0]


def test_widths_are_numbers_texts_or_unknown_and_points_are_no_streets(tmp_path: Path):
    line = shapely.LineString([(0, 0), (9, 0)])
    several = shapely.MultiLineString([[(0, 0), (1, 0)], [(2, 0), (3, 0)]])
    shapes = [line, line, line, several, shapely.Point(3, 3)]
    rows = [{"width": 7}, {"width": "wide"}, {}, {"width": "8.5"}, {"width": 4}]
    streets = read_streets(write(tmp_path / "s.geojson", shapes, rows, crs=None), NOWHERE)
    assert np.allclose(streets.width, [7, np.nan, np.nan, 8.5, 8.5], equal_nan=True)


def test_a_map_without_a_system_is_in_the_metres_of_a_frame_without_a_place(tmp_path: Path):
    path = write(tmp_path / "a.geojson", [shapely.box(1, 2, 30, 40)], [{}])
    assert read_shapes(path, NOWHERE).geometry[0].bounds == (1, 2, 30, 40)


def test_places_of_both_or_of_none_are_known(tmp_path: Path):
    line = shapely.LineString([(0, 0), (9, 0)])
    local = write(tmp_path / "local.geojson", [line], [{}], crs=None)
    with pytest.raises(AssetError, match="place of parcels is known"):
        read_shapes(local, PARIS)
    named = {"type": "name", "properties": {"name": "EPSG:32631"}}
    placed = write(tmp_path / "placed.geojson", [line], [{}], crs=named)
    with pytest.raises(AssetError, match="place of it is known"):
        read_shapes(placed, NOWHERE)


def test_a_map_without_lines_is_no_map_of_streets(tmp_path: Path):
    path = write(tmp_path / "a.geojson", [shapely.box(0, 0, 9, 9)], [{}], crs=None)
    with pytest.raises(AssetError, match="expected lines"):
        read_streets(path, NOWHERE)
