"""GeoJSON, GeoJSON lines and text sequences: what is read, and what is listed."""

import codecs
import json
import os
from collections import Counter

import pytest

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints import geojson
from grammarlab.geometry.footprints.footprint_text import read_footprint_map
from tests.geometry.footprints.maps import BOW_TIE, SQUARE, area, collection, feature, moved, named, polygon, written

LINE = {"type": "LineString", "coordinates": SQUARE}
POINT = {"type": "Point", "coordinates": [1, 2]}


def read(folder, document, name="lots.geojson"):
    return read_footprint_map(written(folder, document, name))


def test_all_that_is_not_an_outline_is_listed_with_its_feature(tmp_path):
    parts = [polygon(SQUARE), LINE, POINT, POINT, {"type": "MultiPolygon", "coordinates": [[moved(SQUARE, 20, 0)], []]}]
    plan = read(
        tmp_path,
        collection(
            feature({"type": "GeometryCollection", "geometries": parts}, height=3),
            feature(LINE),
            feature(None),
            None,
            feature({"type": "Polygon", "coordinates": []}),
            feature({"type": "Circle"}),
            feature(polygon(BOW_TIE)),
            feature(polygon([[0, 0], [1, "a"], [1, 1], [0, 0]])),
            crs=None,
        ),
    )
    assert [area(footprint) for footprint in plan.footprints] == [80, 80]
    assert all(footprint.properties == {"height": 3} for footprint in plan.footprints)
    assert [f"{remark.kind}, {remark}".replace("lots.geojson, feature ", "") for remark in plan.remarks] == [
        "geometry, 0: a LineString is not an outline",
        "geometry, 0: a Point is not an outline (2 times)",
        "geometry, 0: an empty MultiPolygon",
        "geometry, 1: a LineString is not an outline",
        "geometry, 2: no geometry",
        "geometry, 3: no geometry",
        "geometry, 4: an empty Polygon",
        "geometry, 5: a geometry of type 'Circle' is not an outline",
        "outline, 7: expected rings of [x, y] numbers: four positions or more, the first repeated at the end",
        "outline, 6: self-intersection at x = 45, y = 4",
    ]


def test_if_nothing_remains_the_reasons_are_the_error(tmp_path):
    features = [feature(polygon(moved(BOW_TIE, 100 * k, 0))) for k in range(12)]
    with pytest.raises(AssetError, match=r"(?s)no outline can be used.*feature 7: self.*at x = 745, y = 4.*and 4 more"):
        read(tmp_path, collection(*features, crs=None))
    with pytest.raises(AssetError, match=r"(?s)no Polygon or MultiPolygon.*feature 0: a LineString"):
        read(tmp_path, collection(feature(LINE)))


def as_lines(features):
    return "".join(json.dumps(one) + "\r\n\n" for one in features)


def as_sequence(features):
    return "".join(f"\x1e{json.dumps(one, indent=1)}\n" for one in features)


@pytest.mark.parametrize("form", [as_lines, as_sequence])
@pytest.mark.parametrize("name", ["lots.geojsonl", "lots.geojsons", "lots.ndjson", "lots.geojson", "lots.json", "lots"])
def test_lines_and_sequences_are_read_as_a_collection_is(tmp_path, form, name):
    features = [feature(polygon(moved(SQUARE, 20 * k, 0, 1e-5)), height=k) for k in range(3)]
    whole, parts = read(tmp_path, collection(*features), "whole.json"), read(tmp_path, form(features), name)
    for one, other in zip(whole.footprints, parts.footprints, strict=True):
        assert (one.polygon.tolist(), one.properties) == (other.polygon.tolist(), other.properties)
    assert [footprint.name for footprint in parts.footprints] == [f"{name}, feature {k}" for k in range(3)]
    assert parts.georeference == whole.georeference


def test_a_broken_line_or_record_is_listed_and_the_others_are_read(tmp_path):
    one = json.dumps({**feature(polygon(SQUARE)), "crs": None})
    lines = read(tmp_path, f"{one}\n{one[:50]}\n{one}\n")
    assert (len(lines.footprints), lines.remarks[0].source) == (2, "lots.geojson, line 2")
    records = read(tmp_path, f"\x1e{one}\n\x1e{one[:-9]}")
    assert (len(records.footprints), records.remarks[0].source) == (1, "lots.geojson, record 2")
    with pytest.raises(AssetError, match="not JSON"):  # a large file that was cut is no list of lines
        read(tmp_path, json.dumps(collection(feature(polygon(SQUARE))), indent=1)[:-20])


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_encodings_of_text_are_read(tmp_path, encoding):
    text = json.dumps(collection(feature(polygon(SQUARE), name="Schloß"), crs=None), ensure_ascii=False)
    (footprint,) = read(tmp_path, text.encode(encoding)).footprints
    assert footprint.properties == {"name": "Schloß"}
    assert encoding != "utf-16" or text.encode(encoding)[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def test_positions_may_have_heights_or_not_and_rings_need_not_be_closed(tmp_path):
    rings = [[[0, 0, 5], [10, 0], [10, 8, 7, 9], [0, 8]], SQUARE[::-1], [*SQUARE[:2], *SQUARE[1:], SQUARE[0]]]
    plan = read(tmp_path, collection(*(feature(polygon(ring)) for ring in rings), crs=None))
    assert [area(footprint) for footprint in plan.footprints] == [80, 80, 80]
    assert [len(footprint.polygon) for footprint in plan.footprints] == [4, 4, 4]


def test_values_that_are_not_plain_are_named(tmp_path):
    text = '{"type": "Feature", "properties": {"a": NaN, "b": [1], "c": {}, "d": null, "e": %s, "f": "\\ud800"'
    text += f', "g": 1e999}}, "geometry": {json.dumps({**polygon(SQUARE), "crs": None})}}}'
    (footprint,) = read(tmp_path, text % ("9" * 5000)).footprints
    assert footprint.unread == ("a", "b", "c", "e", "g")
    assert footprint.properties == {"f": "?"}


def test_numbers_of_thousands_of_digits_are_not_finite(tmp_path):
    text = json.dumps(collection(feature(polygon([["X", 0], [1, 0], [1, 1], ["X", 0]])), crs=None))
    for digits in ("9" * 5000, "9" * 350, "1e400", "NaN"):
        with pytest.raises(AssetError, match="finite"):
            read(tmp_path, text.replace('"X"', digits))


def test_a_list_of_features_is_read(tmp_path):
    square = {**polygon(SQUARE), "crs": None}
    assert len(read(tmp_path, [feature(square), square]).footprints) == 2


def test_other_formats_of_json_are_named(tmp_path):
    esri = {"geometryType": "esriGeometryPolygon", "spatialReference": {"wkid": 102100}, "features": []}
    overpass = {"version": 0.6, "elements": []}
    cases = [
        (
            {"type": "Topology"},
            "TopoJSON.*ogr2ogr -f GeoJSON -t_srs [^ ]* 'my lots-degrees.geojson' 'my lots.json'",
        ),
        (esri, "Esri JSON.*ogr2ogr"),
        (overpass, "JSON of Overpass.*osmtogeojson 'my lots.json' > 'my lots-degrees.geojson'"),
    ]
    for document, message in cases:
        with pytest.raises(AssetError, match=f"found {message}"):
            read(tmp_path, document, "my lots.json")


def test_geometries_that_only_other_formats_have_are_named(tmp_path):
    place = {**feature(None), "coordRefSys": "http://www.opengis.net/def/crs/EPSG/0/28992", "place": polygon(SQUARE)}
    curve = {"type": "CurvePolygon", "geometries": []}
    square = feature(polygon(SQUARE))
    plan = read(tmp_path, collection(square, place, curve, collection(square), {**square, "place": None}, crs=None))
    assert [area(footprint) for footprint in plan.footprints] == [80, 80]
    assert [remark.reason.partition(",")[2] or remark.reason for remark in plan.remarks] == [
        " but perhaps one of JSON-FG. Convert it: ogr2ogr -t_srs EPSG:4326",
        " found a 'CurvePolygon'",
        " found a 'FeatureCollection'",
    ]


def test_files_are_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(geojson, "MAX_FOOTPRINTS", 3)
    square = feature(polygon(SQUARE))
    many = {"type": "MultiPolygon", "coordinates": [[SQUARE]] * 4}
    for document in (collection(*[square] * 4), as_lines([square] * 4), collection(feature(many))):
        with pytest.raises(AssetError, match="at most 3"):
            read(tmp_path, document)
    plan = read(tmp_path, collection(square, feature({"type": "MultiPoint", "coordinates": [[0, 0]] * 99}), crs=None))
    empty = {"type": "GeometryCollection", "geometries": [POINT] * 10_000}
    assert Counter(remark.kind for remark in plan.remarks) == {"geometry": 1}
    assert len(read(tmp_path, collection(square, feature(empty), crs=None)).remarks) == 1
    deep = '{"type": "GeometryCollection", "geometries": [' * 300 + "]}" * 300
    with pytest.raises(AssetError, match="too deeply"):
        read(tmp_path, deep)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes")
def test_pipes_and_devices_are_refused(tmp_path):
    os.mkfifo(tmp_path / "lots.geojson")
    with pytest.raises(AssetError, match="pipe or a device"):
        read_footprint_map(str(tmp_path / "lots.geojson"))


def test_the_name_of_a_file_may_begin_like_wkt(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("polygons.geojson", "multi.json", "POLYGON (1).geojson"):
        assert len(
            read_footprint_map(written(tmp_path, collection(feature(polygon(SQUARE)), crs=None), name)).footprints
        )
        assert len(read_footprint_map(name).footprints) == 1
    with pytest.raises(AssetError, match="no such footprint file"):
        read_footprint_map("polygon_lots.geojson")


def test_a_crs_is_asked_for_only_where_there_is_an_outline(tmp_path):
    assert read(tmp_path, collection(feature({**POINT, "crs": named("EPSG:3857")}), feature(polygon(SQUARE)), crs=None))
