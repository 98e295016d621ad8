import json
from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.city.city_layout import Layout, laid_out
from grammarlab.city.layout_file import write_parcels, write_streets
from grammarlab.city.layout_request import LayoutRequest
from grammarlab.city.map_shapes import read_streets
from grammarlab.city.parcel_map import read_parcels
from grammarlab.geometry.footprints.frame import Frame

FRAMES = {"local": Frame("", (0.0, 0.0)), "placed": Frame("EPSG:32631", (448_000.0, 5_412_000.0))}


def layout_in(frame: Frame) -> Layout:
    return laid_out(LayoutRequest(outline=shapely.box(0, 0, 420, 360), frame=frame, seed=3, park_share=0.3))


@pytest.mark.parametrize("name", FRAMES)
def test_parcels_are_read_as_they_were_written(name: str, tmp_path: Path):
    frame = FRAMES[name]
    layout = layout_in(frame)
    write_parcels(layout, tmp_path / "parcels.geojson")
    crs = None if frame.has_place else "local"
    read = read_parcels(tmp_path / "parcels.geojson", crs=crs, id_field="id", frame=frame).parcels
    assert read.id.tolist() == layout.parcels.id.tolist()
    assert read.usable.all()
    assert shapely.hausdorff_distance(read.outline, layout.parcels.outline).max() < 0.002
    for column in ("block", "use"):
        assert read.attributes[column].to_pylist() == layout.parcels.attributes[column].to_pylist()


@pytest.mark.parametrize("name", FRAMES)
def test_streets_are_read_as_they_were_written(name: str, tmp_path: Path):
    layout = layout_in(FRAMES[name])
    write_streets(layout, tmp_path / "streets.geojson")
    read = read_streets(tmp_path / "streets.geojson", FRAMES[name])
    assert sorted(read.width) == sorted(layout.streets.width)
    lines, written = (shapely.union_all(streets.line) for streets in (read, layout.streets))
    assert shapely.hausdorff_distance(lines, written) < 0.002


def test_a_feature_is_on_each_line(tmp_path: Path):
    layout = layout_in(FRAMES["local"])
    write_parcels(layout, tmp_path / "parcels.geojson")
    text = (tmp_path / "parcels.geojson").read_text(encoding="utf-8")
    features = json.loads(text)["features"]
    assert len(features) == len(layout.parcels) == text.count("\n") - 2
    coordinates = shapely.get_coordinates([shapely.from_geojson(json.dumps(f["geometry"])) for f in features])
    assert (coordinates == np.round(coordinates, 3)).all()
