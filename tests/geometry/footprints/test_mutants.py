"""Damaged maps: every one is read, in finite polygons, or refused in words."""

import json

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import AssetError, UsageError
from grammarlab.geometry.footprints.footprint_text import read_footprint_map
from tests.geometry.footprints.maps import BOW_TIE, SQUARE, area, collection, feature, moved, named, polygon

MAP = collection(
    feature(polygon(SQUARE, [[2, 2], [4, 2], [4, 4], [2, 2]]), height="12 m"),
    feature({"type": "GeometryCollection", "geometries": [polygon(moved(SQUARE, 20, 0)), {"type": "Point"}]}),
    feature({"type": "MultiPolygon", "coordinates": [[moved(SQUARE, 40, 0)], [BOW_TIE]]}, levels=[3]),
    crs=named("EPSG:25832"),
)
HOSTILE = [
    *(None, True, 0, -1, 1e308, 1e-308, 7.1, 10**350, float("nan"), float("inf")),
    *("", "Polygon", "EPSG:3857", "\ud800", "12 m", "x" * 5000),
    *([], {}, [[]], [[[]]], [1], [[1, 2]], {"type": "Polygon"}, {"type": "name"}, [[[0, 0]] * 4]),
    *(None, named("EPSG:4326"), SQUARE, BOW_TIE, MAP["features"][0]["geometry"]),
]
WKT = (
    "SRID=25832;GEOMETRYCOLLECTION Z (POLYGON ((0 0 1, 10 0 1, 10 8 1, 0 0 1)), MULTISURFACE (((0 0, 9 0, 9 9, 0 0))))"
)
TOKENS = [
    "(",
    ")",
    ",",
    " ",
    ";",
    "SRID=4326;",
    "EMPTY",
    "Z",
    "M",
    "nan",
    "1e999",
    "-",
    "CURVEPOLYGON",
    "TIN",
    "0",
    "\x00",
]


def places(value, path=()):
    """Paths to all values in a document."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


PLACES = [path for path in places(MAP) if path]


def replaced(path, value):
    document = json.loads(json.dumps(MAP))
    inner = document
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return document


def check(text):
    """Read a map, or be refused; what is read can be built on."""
    try:
        plan = read_footprint_map(text)
    except (AssetError, UsageError):
        return
    assert plan.footprints
    for footprint in plan.footprints:
        assert np.isfinite(footprint.polygon).all()
        assert area(footprint) > 0
    for remark in plan.remarks:
        assert len(str(remark)) < 500


@given(st.sampled_from(PLACES), st.sampled_from(HOSTILE))
def test_a_map_with_any_value_in_any_place_is_read_or_refused(tmp_path_factory, path, value):
    file = tmp_path_factory.mktemp("mutant") / "lots.geojson"
    file.write_text(json.dumps(replaced(path, value)))
    check(str(file))


@given(st.data())
def test_a_map_with_any_text_changed_is_read_or_refused(tmp_path_factory, data):
    text = data.draw(st.sampled_from([json.dumps(MAP), "\n".join(map(json.dumps, MAP["features"]))]))
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(start + 40, len(text))))
    middle = data.draw(
        st.sampled_from(["", "\x1e", "\n", "9" * 5000, "NaN", "]", "}", '"', "\ufeff", "[" * 2000, "\\ud800"])
    )
    file = tmp_path_factory.mktemp("mutant") / "lots.geojson"
    file.write_text(text[:start] + middle + text[end:], encoding=data.draw(st.sampled_from(["utf-8", "utf-16"])))
    check(str(file))


@given(st.data())
def test_wkt_with_any_token_changed_is_read_or_refused(data):
    start = data.draw(st.integers(0, len(WKT)))
    end = data.draw(st.integers(start, min(start + 12, len(WKT))))
    check(WKT[:start] + data.draw(st.sampled_from(TOKENS)) + WKT[end:])


rings = st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)).map(list), min_size=3, max_size=9)


@given(st.lists(st.lists(rings, min_size=1, max_size=3), min_size=1, max_size=3), st.sampled_from([None, "EPSG:4326"]))
def test_any_rings_are_read_or_listed(tmp_path_factory, polygons, crs):
    """Rings on a small grid touch, cross, repeat and contain each other."""
    scale = 1.0 if crs is None else 1e-4
    lots = [polygon(*(moved(ring, 7 * (scale < 1), 50 * (scale < 1), scale) for ring in rings)) for rings in polygons]
    file = tmp_path_factory.mktemp("rings") / "lots.geojson"
    file.write_text(json.dumps(collection(*map(feature, lots), crs=crs and named(crs))))
    check(str(file))
