"""Maps of 100,000 parcels, in the formats and with the errors of public ones."""

from __future__ import annotations

import json
from pathlib import Path
from time import process_time

import numpy as np
import pyarrow as pa
import pytest
import shapely
from pyogrio.raw import write_arrow

from grammarlab.city.parcel_map import read_parcels

SIDE = 316
"""Parcels in a row: 99,856 in all."""
MOST_SECONDS = 10.0
"""Target: processor time for 100,000 parcels."""


def outlines() -> np.ndarray:
    """Parcels of 14 x 25 m with 12 corners each, beside each other, in degrees; some overlap or cross themselves."""
    row, column = np.divmod(np.arange(SIDE**2), SIDE)
    boxes = shapely.segmentize(shapely.box(14.0 * column, 25.0 * row, 14.0 * (column + 1), 25.0 * (row + 1)), 8.0)
    boxes[::1000] = shapely.box(
        14.0 * column[::1000] - 3, 25.0 * row[::1000], 14.0 * column[::1000] + 9, 25 * row[::1000] + 20
    )
    bow_tie = np.array([[0, 0], [10, 20], [10, 0], [0, 20], [0, 0]], dtype=np.float64)
    for index in range(500, SIDE**2, 5000):
        boxes[index] = shapely.Polygon(bow_tie + np.array([14.0 * column[index], 25.0 * row[index]]))
    return shapely.transform(boxes, lambda points: points / [73_000.0, 111_200.0] + [2.3, 48.8])


def write(path: Path) -> Path:
    ids = [f"75118000AB{index:06}" for index in range(SIDE**2)]
    shapes = outlines()
    if path.suffix == ".geojson":
        lines = (
            {"type": "Feature", "properties": {"id": name, "floors": 3}, "geometry": json.loads(shape)}
            for name, shape in zip(ids, shapely.to_geojson(shapes), strict=True)
        )
        path.write_text('{"type": "FeatureCollection", "features": [' + ",\n".join(map(json.dumps, lines)) + "]}")
        return path
    table = pa.table({"id": ids, "floors": [3] * len(ids), "geometry": pa.array(shapely.to_wkb(shapes), pa.binary())})
    driver = {".gpkg": "GPKG", ".shp": "ESRI Shapefile"}[path.suffix]
    write_arrow(table, path, driver=driver, geometry_name="geometry", geometry_type="Polygon", crs="EPSG:4326")
    return path


@pytest.mark.parametrize("name", ["map.gpkg", "map.shp", "map.geojson"])
def test_read_100000_parcels(benchmark, tmp_path, name):
    path = write(tmp_path / name)
    start = process_time()
    read = benchmark.pedantic(read_parcels, (path,), rounds=1)
    seconds = process_time() - start
    parcels = read.parcels
    assert len(parcels) == SIDE**2
    assert (parcels.reason == "invalid").sum() == 20
    benchmark.extra_info |= {"cpu_seconds": seconds, "usable": int(parcels.usable.sum())}
    assert seconds < MOST_SECONDS
