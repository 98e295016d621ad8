"""Terrain: heights of GeoTIFF files at points, by windows, in any coordinate system and unit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import rasterio
from hypothesis import given, settings
from hypothesis import strategies as st
from pyproj import Transformer
from rasterio.crs import CRS
from rasterio.errors import NotGeoreferencedWarning
from rasterio.transform import Affine
from scipy.interpolate import RegularGridInterpolator

from grammarlab.city import terrain as terrain_module
from grammarlab.city.terrain import read_terrain
from grammarlab.errors import AssetError, UsageError
from grammarlab.geometry.footprints.frame import Frame

FRAME = Frame("EPSG:32631", (448_000.0, 5_412_000.0))
WEST, NORTH = 447_900.0, 5_412_300.0


def from_origin(west, north, width, height):
    return Affine(width, 0.0, west, 0.0, -height, north)


def written(path, values, transform=None, crs: str | None = "EPSG:32631", **options):
    values = np.asarray(values)
    rows, columns = values.shape
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=columns,
        height=rows,
        count=1,
        dtype=values.dtype,
        crs=crs and CRS.from_string(crs),
        transform=transform or from_origin(WEST, NORTH, 10, 10),
        **options,
    ) as file:
        file.write(values, 1)
    return path


def plane(east, north):
    return 0.02 * np.asarray(east) - 0.03 * np.asarray(north) + 70.0


def raster(rows=50, columns=40):
    """Heights of the plane at the middles of pixels."""
    east, north = np.meshgrid(np.arange(columns) * 10.0 - 95, 295 - np.arange(rows) * 10.0)
    return plane(east, north).astype(np.float64)


points = st.lists(st.tuples(st.floats(-94, 294), st.floats(-194, 294)), min_size=1, max_size=20)


@settings(max_examples=30)
@given(points, st.sampled_from([1, 7, 1024]))
def test_a_plane_is_exact_whatever_the_windows(tmp_path_factory, places, window):
    places = np.array(places)
    terrain = read_terrain(written(tmp_path_factory.mktemp("terrain") / "a.tif", raster()))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(terrain_module, "_WINDOW", window)
        heights = terrain.heights(FRAME, places)
    assert heights == pytest.approx(plane(*places.T), abs=1e-9)


def test_heights_are_those_of_another_interpolator(tmp_path):
    values = np.random.default_rng(2).normal(100, 10, (50, 40))
    terrain = read_terrain(written(tmp_path / "a.tif", values))
    rows, columns = np.arange(50) * -10.0 + 295, np.arange(40) * 10.0 - 95
    oracle = RegularGridInterpolator((rows[::-1], columns), values[::-1])
    places = np.random.default_rng(3).uniform((-94, -194), (294, 294), (500, 2))
    assert terrain.heights(FRAME, places) == pytest.approx(oracle(places[:, ::-1]))
    alone = [terrain.heights(FRAME, place[None])[0] for place in places[:20]]
    assert terrain.heights(FRAME, places)[:20].tolist() == alone


def test_another_system_is_transformed(tmp_path):
    """A raster in degrees and one in Web Mercator, from a plane over the points in their own coordinates."""
    places = np.random.default_rng(4).uniform(-90, 190, (50, 2))
    for crs, step in (("EPSG:4326", 1e-4), ("EPSG:3857", 15.0), ("EPSG:4326+5773", 1e-4)):
        transformer = Transformer.from_crs("EPSG:32631", crs.partition("+")[0], always_xy=True)
        x, y = transformer.transform(*(places + np.array(FRAME.origin)).T)
        west, north = x.min() - 3 * step, y.max() + 3 * step
        u, v = np.meshgrid(west + (np.arange(60) + 0.5) * step, north - (np.arange(60) + 0.5) * step)
        slope = 0.1 / step
        values = 50 + slope * (u - west) - slope * (v - north)
        path = written(tmp_path / "a.tif", values, from_origin(west, north, step, step), crs)
        heights = read_terrain(path).heights(FRAME, places)
        assert heights == pytest.approx(50 + slope * (x - west) - slope * (y - north), abs=1e-6)


def test_missing_values_count_nothing(tmp_path):
    values = raster().astype(np.float32)
    values[10:20, 10:20] = -9999
    values[0, 0] = np.nan
    choices: list[dict[str, Any]] = [{"nodata": -9999.0}, {}, {"nodata": float("nan")}]
    for options in choices:  # such heights are not those of land
        terrain = read_terrain(written(tmp_path / "a.tif", values, **options))
        middle, edge, corner, outside = [[55.0, 145.0]], [[4.0, 145.0]], [[-99.0, 299.0]], [[1000.0, 0.0]]
        heights = terrain.heights(FRAME, np.array([*middle, *edge, *corner, *outside]))
        assert np.isnan(heights).tolist() == [True, False, True, True]
        assert heights[1] == pytest.approx(plane(-5.0 + 0.0, 145.0), abs=0.2)
    assert len(read_terrain(tmp_path / "a.tif").heights(FRAME, np.empty((0, 2)))) == 0


def test_units_scales_and_turned_rasters(tmp_path):
    path = written(tmp_path / "a.tif", np.full((5, 5), 100, dtype=np.int16))
    with rasterio.open(path, "r+") as file:
        file.scales, file.offsets, file.units = (0.1,), (5.0,), ("ft",)
    centre = np.array([[-75.0, 275.0]])
    assert read_terrain(path).heights(FRAME, centre) == pytest.approx(15 * 0.3048)
    turn = Affine.translation(WEST + 100, NORTH - 100) @ Affine.rotation(30) @ Affine.scale(5, -5)
    rows, columns = np.mgrid[:20, :20]
    x, y = turn @ (columns + 0.5, rows + 0.5)
    values = plane(x - FRAME.origin[0], y - FRAME.origin[1])
    inside = np.array(turn @ (7.3, 11.1)) - np.array(FRAME.origin)
    heights = read_terrain(written(tmp_path / "b.tif", values, turn)).heights(FRAME, inside[None])
    assert heights == pytest.approx(plane(*inside), abs=1e-9)
    single = read_terrain(written(tmp_path / "c.tif", np.full((1, 1), 7.0)))
    assert single.heights(FRAME, np.array([[-95.0, 295.0], [-99.0, 291.0]])).tolist() == [7.0, 7.0]


def test_a_place_is_needed(tmp_path):
    path = written(tmp_path / "a.tif", raster(), crs=None)
    with pytest.raises(AssetError, match=r"does not name its coordinate.*crs ="):
        read_terrain(path)
    unplaced = Frame("", FRAME.origin)
    local = read_terrain(path, crs="local")
    assert local.heights(unplaced, np.zeros((1, 2))) == pytest.approx(70)
    assert read_terrain(path, crs="EPSG:32631").heights(FRAME, np.zeros((1, 2))) == pytest.approx(70)
    with pytest.raises(UsageError, match="has a place on the earth, and the map has none"):
        read_terrain(path, crs="EPSG:32631").heights(unplaced, np.zeros((1, 2)))


def test_what_is_no_terrain_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(terrain_module, "_MAX_BLOCK_BYTES", 1000)
    with pytest.raises(AssetError, match="too large to read: tile it"):
        read_terrain(written(tmp_path / "strip.tif", raster(4, 400)))
    (tmp_path / "a.tif").write_text("<VRTDataset/>")
    for name, message in (("a.tif", "expected a GeoTIFF"), ("missing.tif", "no such terrain")):
        with pytest.raises(AssetError, match=message):
            read_terrain(tmp_path / name)
    monkeypatch.undo()
    with pytest.raises(AssetError, match="complex"):
        read_terrain(written(tmp_path / "complex.tif", raster().astype(np.complex64)))
    picture = tmp_path / "picture.tif"
    profile = {"width": 2, "height": 2, "transform": from_origin(WEST, NORTH, 10, 10), "crs": CRS.from_epsg(32631)}
    with rasterio.open(picture, "w", driver="GTiff", count=3, dtype="uint8", **profile) as file:
        file.write(np.zeros((3, 2, 2), dtype=np.uint8))
    with pytest.raises(AssetError, match="picture of 3 bands"):
        read_terrain(picture)
    with pytest.warns(NotGeoreferencedWarning):
        path = written(tmp_path / "nowhere.tif", raster(), Affine.identity())
    with pytest.raises(AssetError, match="does not say where"):
        read_terrain(path)


@settings(max_examples=100)
@given(st.data())
def test_damaged_files_are_read_or_refused(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("terrain")
    path = written(folder / "a.tif", raster(20, 20), compress="deflate")
    content = bytearray(path.read_bytes())
    start = data.draw(st.integers(4, len(content) - 1))
    content[start : start + data.draw(st.integers(1, 8))] = data.draw(st.binary(max_size=8))
    path.write_bytes(bytes(content[: data.draw(st.sampled_from([len(content), len(content) // 2, 100, 8]))]))
    try:
        heights = read_terrain(path).heights(FRAME, np.random.default_rng(1).uniform(-200, 300, (50, 2)))
    except (AssetError, UsageError):
        return
    assert heights.shape == (50,)
    assert not np.isinf(heights).any()


def test_a_file_without_a_system_has_the_default_one(tmp_path):
    path = written(tmp_path / "a.tif", raster(), crs=None)
    here = np.array([[100.0, 100.0]])
    placed = read_terrain(path, default_crs="EPSG:32631")
    assert placed.heights(FRAME, here) == pytest.approx(plane(*here.T))
    named = read_terrain(written(tmp_path / "b.tif", raster()), default_crs="local")
    assert named.crs == "EPSG:32631"
