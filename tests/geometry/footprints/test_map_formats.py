"""Footprints from maps of other formats and coordinate systems, by the same door as GeoJSON."""

from __future__ import annotations

import json
import sys
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
import shapely

from grammarlab.city.parcel_outlines import polygons_of
from grammarlab.errors import AssetError, UsageError
from grammarlab.geometry.footprints.attribute_columns import plain_columns
from grammarlab.geometry.footprints.footprint import Georeference
from grammarlab.geometry.footprints.footprint_text import read_footprint_map
from grammarlab.geometry.footprints.geojson_columns import read_geojson_layer
from grammarlab.geometry.footprints.map_file import is_cityjson, read_layer
from grammarlab.geometry.footprints.vector_file import read_vector_layer
from tests.city.parcel_files import UTM, block, city, moved, write_map
from tests.geometry.footprints.maps import SQUARE, area, collection, feature, named, polygon, written

NAMES = ["map.gpkg", "map.shp", "map.fgb", "map.city.json"]


@pytest.mark.parametrize("name", NAMES)
def test_degrees_in_any_format_give_the_footprints_of_geojson(tmp_path, name):
    outlines = moved(block(), "EPSG:4326")
    rows = {"id": [f"{row:02}" for row in range(12)], "height": [float(row) for row in range(12)]}
    geojson = read_footprint_map(str(write_map(tmp_path / "map.geojson", outlines, "EPSG:4326", **rows)))
    other = read_footprint_map(str(write_map(tmp_path / name, outlines, "EPSG:4326", **rows)))
    assert other.georeference is not None
    assert geojson.georeference is not None
    assert other.georeference.longitude == pytest.approx(geojson.georeference.longitude, abs=1e-9)
    key = [footprint.properties["id"] for footprint in other.footprints]
    for row in range(12):
        one, same = geojson.footprints[row], other.footprints[key.index(f"{row:02}")]
        assert same.properties == one.properties
        corners = [np.array(sorted(map(tuple, np.round(two.polygon, 3)))) for two in (same, one)]
        assert corners[0] == pytest.approx(corners[1], abs=2e-3)


@pytest.mark.parametrize("crs", ["EPSG:3857", "EPSG:2263", "EPSG:6933"])
def test_other_systems_become_metres_in_place(tmp_path, crs):
    """Web Mercator, US survey feet, and an equal-area map of the world."""
    features = [feature(shapely.geometry.mapping(outline)) for outline in moved(block(), crs)]
    plan = read_footprint_map(written(tmp_path, collection(*features, crs=named(crs))))
    assert [area(footprint) for footprint in plan.footprints] == pytest.approx([600] * 12, rel=2e-3)
    assert plan.georeference in (Georeference(UTM), Georeference("EPSG:32118"))
    (remark,) = plan.remarks
    assert remark.kind == "coordinates"
    assert crs in remark.reason


def test_wkt_of_any_system_is_placed():
    (outline,) = moved(block(1, 1), "EPSG:3857")
    plan = read_footprint_map(f"SRID=3857;{outline}")
    assert area(plan.footprints[0]) == pytest.approx(600, rel=1e-3)
    assert plan.georeference == Georeference(UTM)


def test_maps_without_the_extra_are_refused_as_before_and_with_its_name(tmp_path, monkeypatch):
    files = [write_map(tmp_path / name, moved(block(), UTM), UTM) for name in NAMES[:3]]
    mercator = written(tmp_path, collection(feature(polygon(SQUARE)), crs=named("EPSG:3857")), "mercator.geojson")
    for package in ("pyogrio", "pyproj"):
        monkeypatch.setitem(sys.modules, package, None)
    for file in files:
        with pytest.raises(AssetError, match=r"expected GeoJSON.*ogr2ogr -f GeoJSON.*pip install 'grammarlab\[city\]'"):
            read_footprint_map(str(file))
    with pytest.raises(AssetError, match=r"Web Mercator.*ogr2ogr.*pip install 'grammarlab\[city\]'"):
        read_footprint_map(mercator)
    with pytest.raises(AssetError, match=r"Web Mercator.*ST_Transform.*pip install 'grammarlab\[city\]'"):
        read_footprint_map("SRID=3857;POLYGON ((0 0, 9 0, 9 9, 0 0))")


def test_plain_maps_do_not_depend_on_the_extra(tmp_path, monkeypatch):
    documents = [
        collection(*[feature(shapely.geometry.mapping(one), height=3) for one in moved(block(), "EPSG:4326")]),
        collection(*[feature(shapely.geometry.mapping(one)) for one in moved(block(), UTM)], crs=named(UTM)),
    ]
    files = [written(tmp_path, document, f"{row}.geojson") for row, document in enumerate(documents)]

    def values():
        plans = [read_footprint_map(file) for file in files]
        return [
            ([(one.polygon.tobytes(), one.properties) for one in plan.footprints], plan.georeference) for plan in plans
        ]

    installed = values()
    for package in ("pyogrio", "pyproj", "rasterio"):
        monkeypatch.setitem(sys.modules, package, None)
    assert values() == installed


def test_a_layer_is_named_behind_a_colon(tmp_path):
    path = write_map(tmp_path / "map.gpkg", moved(block(), UTM), UTM, "lots")
    write_map(path, moved(block(1, 1), UTM), UTM, "houses")
    assert len(read_footprint_map(f"{path}:lots").footprints) == 12
    assert len(read_footprint_map(f"{path}:houses").footprints) == 1
    with pytest.raises(UsageError, match=r"found 2.*'lots', 'houses'.*map\.gpkg:LAYER"):
        read_footprint_map(str(path))
    geojson = written(tmp_path, collection(feature(polygon(SQUARE)), crs=None))
    with pytest.raises(UsageError, match="GeoJSON has no layers; leave out ':lots'"):
        read_footprint_map(f"{geojson}:lots")


def test_zipped_shapefiles_are_read(tmp_path):
    for name in ("lots", "houses"):
        write_map(tmp_path / f"{name}.shp", moved(block(), UTM), UTM)
    archive = tmp_path / "map.zip"
    for names in (("lots",), ("lots", "houses")):
        with zipfile.ZipFile(archive, "w") as file:
            for name in names:
                for suffix in (".shp", ".shx", ".dbf", ".prj"):
                    file.write(tmp_path / f"{name}{suffix}", f"deep/{name}{suffix}")
        if len(names) == 1:
            assert len(read_footprint_map(str(archive)).footprints) == 12
    with pytest.raises(UsageError, match="expected one Shapefile, found 'houses', 'lots'"):
        read_footprint_map(str(archive))
    assert len(read_footprint_map(f"{archive}:lots").footprints) == 12


def test_a_file_is_read_only_as_what_its_name_says(tmp_path):
    """GDAL would follow references to other files, or run the command in a file."""
    secret = write_map(tmp_path / "secret.gpkg", moved(block(), UTM), UTM)
    layer = f"<OGRVRTLayer name='secret'><SrcDataSource>{secret}</SrcDataSource></OGRVRTLayer>"
    alien = f"<OGRVRTDataSource>{layer}</OGRVRTDataSource>"
    command = json.dumps({"type": "gdal_streamed_alg", "command_line": f"gdal vector pipeline ! read {secret}"})
    for content in (alien, command, "", "SQLite format 3\0", "PK", "fgb"):
        for name in ("a.gpkg", "a.fgb", "a.shp", "a.zip", "a.geojson", "a.json", "a.jsonl"):
            (tmp_path / name).write_text(content)
            with suppress(AssetError, UsageError):  # of JSON, any object is a feature, perhaps without an outline
                assert read_layer(tmp_path / name).geometry.tolist() == [None]


def test_names_that_mean_something_to_gdal_are_refused(tmp_path):
    path = write_map(tmp_path / "map.gpkg", moved(block(), UTM), UTM)
    for letter in "!;?":
        other = path.rename(path.with_name(f"a{letter}b.gpkg"))
        with pytest.raises(UsageError, match="rename"):
            read_vector_layer(other)
        path = other.rename(path.with_name("map.gpkg"))


def test_kinds_of_attributes_do_not_depend_on_the_format(tmp_path):
    columns = {"flag": [True, None], "number": [1.5, None], "text": ["a", None], "whole": [2**40, None]}
    for name in ("map.gpkg", "map.fgb", "map.geojson"):
        layer = read_layer(write_map(tmp_path / name, moved(block(1, 2), UTM), UTM, **columns))
        rows = sorted(layer.attributes.to_pylist(), key=str)
        assert rows == sorted([{key: values[row] for key, values in columns.items()} for row in (0, 1)], key=str)
        assert [str(kind) for kind in layer.attributes.schema.types] == ["bool", "double", "string", "int64"]


@pytest.mark.parametrize("name", ["map.gpkg", "map.geojson", "map.city.json"])
def test_lists_of_numbers_are_texts_and_others_are_named(tmp_path, name):
    columns = {
        "widths": [[8.0, 0.0, 5.5], None, [2.0]],
        "whole": [[1, 2], [], [2**40]],
        "words": [["a"], ["b", "c"], None],
    }
    layer = read_layer(write_map(tmp_path / name, moved(block(1, 3), UTM), UTM, **columns))
    assert layer.attributes.column("widths").to_pylist() == ["[8, 0, 5.5]", None, "[2]"]
    assert layer.attributes.column("whole").to_pylist() == ["[1, 2]", None, f"[{2**40}]"]
    assert layer.attributes.column("words").to_pylist() == [None] * 3
    (remark,) = layer.remarks
    assert (remark.kind, remark.reason.partition(": ")[2]) == ("property", "whole, words")


def test_lists_among_numbers_are_texts_in_any_order(tmp_path):
    values = [[8, 0.5], 12.0, None, "x", [1, None], [True], [float("nan")], {"a": 1}, 3]
    expected = ["[8, 0.5]", "12", None, "x", None, None, None, None, "3"]
    for order in (range(9), range(8, -1, -1)):
        features = [feature(polygon(SQUARE), value=values[row]) for row in order]
        layer = read_geojson_layer(Path(written(tmp_path, collection(*features))))
        assert layer.attributes.column("value").to_pylist() == [expected[row] for row in order]


@pytest.mark.parametrize("kind", [pa.list_(pa.float64()), pa.large_list(pa.int16()), pa.list_(pa.float32(), 2)])
def test_lists_of_any_kind_are_texts(kind):
    batch = pa.record_batch({"list": pa.array([[8, 0], None], kind), "bytes": pa.array([b"a", b"b"])})
    columns, unread = plain_columns(batch)
    assert columns["list"].to_pylist() == ["[8, 0]", None]
    assert unread == {"bytes"}


def curve(kind: int, *members: bytes) -> bytes:
    return b"\1" + kind.to_bytes(4, "little") + len(members).to_bytes(4, "little") + b"".join(members)


def arcs(*points: tuple[float, float]) -> bytes:
    return curve(8, *(np.array(point, dtype="<f8").tobytes() for point in points))


def line(*points: tuple[float, float]) -> bytes:
    return curve(2, *(np.array(point, dtype="<f8").tobytes() for point in points))


def test_arcs_become_edges():
    from grammarlab.geometry.footprints.curved_wkb import straightened

    circle = curve(10, arcs((0, 0), (10, 0), (0, 0)))
    halves = curve(10, arcs((0, 0), (5, 5), (10, 0), (5, -5), (0, 0)))
    stadium = curve(
        10,
        curve(
            9,
            line((0, 0), (20, 0)),
            arcs((20, 0), (25, 5), (20, 10)),
            line((20, 10), (0, 10)),
            arcs((0, 10), (-5, 5), (0, 0)),
        ),
    )
    flat = curve(10, arcs((0, 0), (5, 0), (10, 0), (10, 5), (10, 10), (5, 10), (0, 10), (0, 5), (0, 0)))
    expected = [np.pi * 25, np.pi * 25, 200 + np.pi * 25, 100]
    for body, size in zip((circle, halves, stadium, flat), expected, strict=True):
        for whole in (body, curve(12, body)):
            shape = straightened(whole)
            assert shapely.is_valid(shape)
            assert shapely.area(shape) == pytest.approx(size, rel=2e-3)
    for end in range(len(stadium)):
        assert straightened(stadium[:end]) is None
    assert straightened(arcs((0, 0), (5, 5), (10, 0))) is None


def test_cityjson_is_recognised_wherever_it_says_so(tmp_path):
    document = city(moved(block(), UTM), UTM, {})
    last = {key: value for key, value in document.items() if key != "type"} | {"padding": "x" * 200_000}
    for name, content in (("a.json", document), ("b.json", last | {"type": "CityJSON"})):
        path = tmp_path / name
        path.write_text(json.dumps(content))
        assert is_cityjson(path)
        assert len(read_layer(path)) == 12
    assert not is_cityjson(write_map(tmp_path / "map.geojson", moved(block(), UTM), UTM))


def test_large_and_small_readers_of_geojson_agree(tmp_path):
    """One converts columns, the other one feature after the other; documents, lines and records are the same map."""
    shapes = [
        polygon(SQUARE),
        polygon([[x, y, 5] for x, y in SQUARE]),
        polygon([[*SQUARE[0], "x"], *SQUARE[1:]]),
        polygon(SQUARE[:3]),
        polygon(SQUARE[:-1]),
        polygon(SQUARE, [[1, 1], [2, 1], [2, 2], [1, 1]], []),
        {"type": "MultiPolygon", "coordinates": [[SQUARE], [[[20, 0], [30, 0], [30, 9], [20, 0]]]]},
        {"type": "GeometryCollection", "geometries": [polygon(SQUARE), {"type": "Point", "coordinates": [1, 2]}]},
        {"type": "LineString", "coordinates": SQUARE},
        {"type": "MultiPolygon", "coordinates": [[]]},
        {"type": "Polygon", "coordinates": 3},
        None,
    ]
    features = [feature(shape, number=row, text=f"{row}") for row, shape in enumerate(shapes)]
    collected = collection(*features, crs=named(UTM))
    lines = [{**one, "crs": named(UTM)} for one in features]
    texts = [
        json.dumps(collected),
        json.dumps(collected, indent=1),
        "\n".join(map(json.dumps, lines)),
        "".join(f"\x1e{json.dumps(one)}\n" for one in lines),
    ]
    plain = read_footprint_map(written(tmp_path, texts[0]))
    for text in texts:
        (tmp_path / "lots.geojson").write_text(text)
        layer = read_geojson_layer(tmp_path / "lots.geojson")
        assert layer.crs == UTM
        assert layer.attributes.column("number").to_pylist() == [*range(12)]
        parts, rows = polygons_of(layer.geometry)
        assert [f"lots.geojson, feature {row}" for row in rows] == [one.name for one in plain.footprints]
        assert shapely.area(parts) == pytest.approx([area(one) for one in plain.footprints])
        assert shapely.has_z(layer.geometry).tolist()[:2] == [False, True]
