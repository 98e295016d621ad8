"""Footprints from a size, from WKT and from GeoJSON."""

import json
import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import AssetError, UsageError
from grammarlab.geometry.footprints.footprint import Footprint
from grammarlab.geometry.footprints.footprint_text import read_footprints

SQUARE = [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]
BOW_TIE = [[0, 0], [10, 10], [10, 0], [0, 10], [0, 0]]


def signed_area_from_above(footprint: Footprint) -> float:
    """Shoelace formula in the (x, -z) plane: positive when counter-clockwise seen from +y."""
    x, y = footprint.polygon[:, 0], -footprint.polygon[:, 2]
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)


def write_geojson(path, geometry, properties=None, **members):
    feature = {"type": "Feature", "geometry": geometry, "properties": properties}
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [feature], **members}))
    return str(path)


@given(st.floats(0.1, 9_000), st.floats(0.1, 9_000))
def test_a_size_is_a_rectangle_whose_first_edge_is_its_width(width, depth):
    width, depth = round(width, 3), round(depth, 3)
    (footprint,) = read_footprints(f"{width:.3f}x{depth:.3f}")
    edges = np.diff(footprint.polygon, axis=0, append=footprint.polygon[:1])
    assert np.linalg.norm(edges, axis=1) == pytest.approx([width, depth, width, depth])
    assert edges[0] == pytest.approx([width, 0, 0])
    assert signed_area_from_above(footprint) == pytest.approx(width * depth)


@given(st.integers(3, 40), st.booleans(), st.randoms(use_true_random=False))
def test_wkt_keeps_area_and_corners_and_turns_every_ring_to_look_up(corners, clockwise, random):
    angles = sorted(random.uniform(0, 2 * math.pi) for _ in range(corners))
    ring = [(20 * math.cos(a), 20 * math.sin(a)) for a in angles]
    polygon = shapely.Polygon(ring[::-1] if clockwise else ring)
    if polygon.area < 1 or not polygon.is_valid:
        return
    (footprint,) = read_footprints(polygon.wkt)
    assert signed_area_from_above(footprint) == pytest.approx(polygon.area)
    read, written = footprint.polygon[:, [0, 2]] * [1, -1], np.array(polygon.exterior.coords)
    apart = np.abs(read[:, None] - written).max(axis=2)
    assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-6


def test_turning_a_clockwise_ring_keeps_its_first_edge_first():
    (footprint,) = read_footprints("POLYGON ((0 0, 0 5, 20 5, 20 0, 0 0))")
    assert {tuple(p) for p in footprint.polygon[:2, [0, 2]]} == {(0, 0), (0, -5)}


@pytest.mark.parametrize("hole", ["2 2, 4 2, 4 5, 2 5, 2 2", "2 2, 2 5, 4 5, 4 2, 2 2"])
def test_holes_are_joined_to_the_outline_and_taken_from_the_area(hole):
    text = f"POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), ({hole}), (6 6, 8 6, 7 8, 6 6))"
    (footprint,) = read_footprints(text)
    assert signed_area_from_above(footprint) == pytest.approx(shapely.from_wkt(text).area)
    assert footprint.polygon[:2] == pytest.approx(np.array([[0, 0, 0], [10, 0, 0]]))


def test_a_multipolygon_gives_one_footprint_each():
    footprints = read_footprints("MULTIPOLYGON (((0 0, 1 0, 1 1, 0 0)), ((5 5, 7 5, 7 7, 5 5)))")
    assert [signed_area_from_above(f) for f in footprints] == pytest.approx([0.5, 2.0])


def test_geojson_properties_of_plain_type_are_kept(tmp_path):
    properties = {"height": 12, "style": "old", "shop": True, "ids": [1, 2], "none": None}
    path = write_geojson(tmp_path / "lots.geojson", {"type": "Polygon", "coordinates": [SQUARE]}, properties, crs=None)
    (footprint,) = read_footprints(path)
    assert footprint.properties == {"height": 12.0, "style": "old", "shop": True}
    assert footprint.name == "lots.geojson, feature 0"


def test_geojson_with_a_null_crs_counts_in_metres(tmp_path):
    path = write_geojson(tmp_path / "a.json", {"type": "Polygon", "coordinates": [SQUARE]}, crs=None)
    assert signed_area_from_above(read_footprints(path)[0]) == pytest.approx(100)


@given(st.floats(-80, 80), st.floats(-179, 179))
def test_degrees_become_metres_as_the_published_series_has_it(tmp_path_factory, latitude, longitude):
    step = 1e-4
    west, south, east, north = (longitude - step, latitude - step, longitude + step, latitude + step)
    ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
    path = tmp_path_factory.mktemp("geo") / "lot.geojson"
    (footprint,) = read_footprints(write_geojson(path, {"type": "Polygon", "coordinates": [ring]}))
    extent = np.ptp(footprint.polygon, axis=0)
    phi = math.radians(latitude)
    # Length of one degree in metres, series of the WGS 84 ellipsoid (US National Geospatial-Intelligence Agency).
    per_latitude = 111132.92 - 559.82 * math.cos(2 * phi) + 1.175 * math.cos(4 * phi) - 0.0023 * math.cos(6 * phi)
    per_longitude = 111412.84 * math.cos(phi) - 93.5 * math.cos(3 * phi) + 0.118 * math.cos(5 * phi)
    assert extent == pytest.approx([2 * step * per_longitude, 0, 2 * step * per_latitude], rel=1e-5)


def test_neighbours_in_one_file_keep_their_places(tmp_path):
    rings = [[[x + u, 47.0 + v] for u, v in np.array(SQUARE) * 1e-5] for x in (8.0, 8.001)]
    geometry = {"type": "MultiPolygon", "coordinates": [[ring] for ring in rings]}
    first, second = read_footprints(write_geojson(tmp_path / "two.geojson", geometry))
    gap = second.polygon[0] - first.polygon[0]
    assert gap == pytest.approx([76.06, 0, 0], abs=0.05)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("POLYGON ((0 0, 10 10, 10 0, 0 10, 0 0))", "self-intersection at x = 5, y = 5"),
        ("POLYGON ((0 0, 10 0, 20 0, 0 0))", "x = "),
        ("POLYGON ((0 0, 0.001 0, 0 0.001, 0 0))", "too small"),
        ("POLYGON EMPTY", "empty"),
        ("POLYGON ((0 0, 10 0", "well-formed WKT"),
        ("LINESTRING (0 0, 10 0)", "found a LineString"),
        ("POLYGON ((0 0, 30000 0, 30000 10, 0 0))", "20000 at most"),
        ("POLYGON ((0 0, nan 0, 9 9, 0 9, 0 0))", "finite"),
        ("0x10", "footprint|0x10"),
    ],
)
def test_bad_polygons_are_refused_with_the_place(text, message):
    with pytest.raises(AssetError, match=message):
        read_footprints(text)


@pytest.mark.parametrize("text", ["", "20", "20 by 30", "-3x4", "lots.shp"])
def test_anything_else_says_what_is_expected(text):
    with pytest.raises(UsageError, match="WIDTHxDEPTH"):
        read_footprints(text)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ("[]", "no Polygon"),
        ('{"type": "FeatureCollection", "features": 3}', "list under 'features'"),
        ('{"type": "FeatureCollection", "features": [3, null, {}]}', "no Polygon"),
        ('{"type": "Polygon", "coordinates": [[[0, 0], [1, "a"]]]}', "expected rings"),
        ('{"type": "Polygon", "coordinates": []}', "an empty Polygon"),
        ('{"type": "Polygon"}', "expected rings"),
        ('{"type": "Polygon", "coordinates": [[[0, 0], [1e999, 0], [1, 1], [0, 0]]]}', "finite|degrees"),
        (
            json.dumps(
                {"type": "Polygon", "coordinates": [[[500000, 5e6], [500010, 5e6], [5e5, 5e6 + 9], [5e5, 5e6]]]}
            ),
            "crs",
        ),
        (json.dumps({"type": "Polygon", "coordinates": [BOW_TIE], "crs": None}), "self-intersection at x = 5, y = 5"),
        (json.dumps({"type": "Polygon", "coordinates": [SQUARE]}), "counts in degrees"),
    ],
)
def test_broken_geojson_says_what_is_wrong(tmp_path, content, message):
    path = tmp_path / "lots.geojson"
    path.write_text(content)
    with pytest.raises(AssetError, match=message):
        read_footprints(str(path))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(AssetError, match="no such footprint file"):
        read_footprints(str(tmp_path / "nowhere.geojson"))


@given(st.text(max_size=60))
def test_no_text_ends_in_a_traceback(text):
    try:
        footprints = read_footprints(text)
    except (AssetError, UsageError):
        return
    assert len(footprints) > 0
