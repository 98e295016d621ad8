"""Damaged maps: every one is read, with each feature listed once, or refused in words."""

from __future__ import annotations

import json
import sqlite3
import zipfile
from contextlib import closing
from random import Random

import numpy as np
import pyarrow as pa
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.city.parcel_map import read_parcels
from grammarlab.errors import AssetError, UsageError
from tests.city.parcel_files import UTM, block, moved, write_map
from tests.geometry.footprints.maps import BOW_TIE, SQUARE, collection, feature, named, polygon
from tests.geometry.footprints.maps import moved as moved_ring

MAP = collection(
    feature(polygon(SQUARE, [[2, 2], [4, 2], [4, 4], [2, 2]]), id="a", height="12 m", floors=3, flat=True),
    feature({"type": "MultiPolygon", "coordinates": [[moved_ring(SQUARE, 40, 0)], [BOW_TIE]]}, id="b", floors=2.5),
    feature(polygon(moved_ring(SQUARE, 20, 0)), id="c", floors=None),
    {**feature(polygon(moved_ring(SQUARE, 60, 0))), "id": 7},
    crs=named("EPSG:25832"),
)
HOSTILE = [
    *(None, True, 0, -1, 1e308, 1e-308, 7.1, 10**350, 2**63, float("nan"), float("inf")),
    *("", "Polygon", "EPSG:3857", "\ud800", "12 m", "x" * 5000, "a"),
    *([], {}, [[]], [[[]]], [1], [[1, 2]], {"type": "Polygon"}, {"type": "name"}, [[[0, 0]] * 4]),
    *(named("EPSG:4326"), SQUARE, BOW_TIE, MAP["features"][0]["geometry"], {str(n): n for n in range(1001)}),
]


def places(value, path=()):
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


PLACES = [path for path in places(MAP) if path]


def check(path, num_features: int | None = None, **options):
    """Read a map, or be refused; what is read can be built on."""
    try:
        read = read_parcels(path, **options)
    except (AssetError, UsageError):
        return
    parcels = read.parcels
    assert parcels.id.tolist() == sorted(set(parcels.id))
    if num_features is not None:
        assert len({name.partition("#")[0] for name in parcels.id}) == num_features
    usable = parcels.outline[parcels.usable]
    assert shapely.is_valid(usable).all()
    assert np.isfinite(shapely.get_coordinates(usable)).all()
    assert (shapely.get_type_id(parcels.outline) == shapely.GeometryType.POLYGON).all()
    assert (shapely.area(usable) > 0).all()
    kinds = {pa.int64(), pa.float64(), pa.bool_(), pa.string()}
    assert set(parcels.attributes.schema.types) <= kinds
    assert parcels.attributes.column_names == sorted(parcels.attributes.column_names)


@settings(max_examples=150)
@given(st.sampled_from(PLACES), st.sampled_from(HOSTILE))
def test_a_map_with_any_value_in_any_place_is_read_or_refused(tmp_path_factory, path, value):
    document = json.loads(json.dumps(MAP))
    inner = document
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    features = document["features"]
    file = tmp_path_factory.mktemp("mutant") / "lots.geojson"
    file.write_text(json.dumps(document))
    check(file, len(features) if isinstance(features, list) else None)


@pytest.fixture(scope="module")
def contents(tmp_path_factory):
    """Bytes of the files of a map in each format."""
    folder = tmp_path_factory.mktemp("whole")
    outlines = moved(block(2, 2), UTM)
    for name in ("a.gpkg", "a.fgb", "a.shp"):
        write_map(folder / name, outlines, UTM, id=["1", "2", "3", "4"], height=[1.0, 2.0, None, 4.0])
    with zipfile.ZipFile(folder / "a.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for suffix in (".shp", ".shx", ".dbf", ".prj"):
            archive.write(folder / f"a{suffix}", f"a{suffix}")
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("seed", range(8))
def test_damaged_binary_maps_are_read_or_refused(tmp_path, contents, seed):
    random = Random(seed)
    for _ in range(15):
        for name, content in contents.items():
            (tmp_path / name).write_bytes(content)
        name = random.choice(sorted(contents))
        content = bytearray(contents[name])
        for _ in range(random.randint(1, 3)):
            start = random.randrange(len(content))
            content[start : start + random.randint(1, 8)] = random.randbytes(random.choice([0, 1, 8]))
        end = random.choice([len(content), len(content), random.randrange(len(content) + 1)])
        (tmp_path / name).write_bytes(bytes(content[:end]))
        check(tmp_path / (name if name in ("a.gpkg", "a.fgb", "a.zip") else "a.shp"))


@pytest.mark.parametrize("text", ["caf\xe9", "é" * 40])
def test_texts_in_a_false_encoding_are_read(tmp_path, text):
    """Tables of Shapefiles cut texts in the middle of a letter, and have a wrong or no code page."""
    path = write_map(tmp_path / "a.shp", moved(block(1, 1), UTM), UTM, id=[text])
    table = path.with_suffix(".dbf").read_bytes()
    path.with_suffix(".dbf").write_bytes(table.replace("é".encode(), b"\xe9 "))
    (name,) = read_parcels(path).parcels.id
    assert name.encode().decode() == name


ENDLESS = """
CREATE VIEW {} AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n)
SELECT x AS fid, NULL AS geom FROM n WHERE x < 0
"""


def test_a_geopackage_computes_nothing(tmp_path):
    """A view may take for ever, also in place of a table that every reader opens."""
    path = write_map(tmp_path / "a.gpkg", moved(block(), UTM), UTM, "lots", id=["x"] * 12)
    assert len(read_parcels(path).parcels) == 12
    with closing(sqlite3.connect(path)) as database:
        database.execute(ENDLESS.format("endless"))
        database.execute(
            "INSERT INTO gpkg_contents (table_name, data_type, srs_id) VALUES ('endless', 'features', 4326)"
        )
        database.execute("INSERT INTO gpkg_geometry_columns VALUES ('endless', 'geom', 'POLYGON', 4326, 0, 0)")
        database.commit()
    for layer in ("", ":lots", ":endless"):
        with pytest.raises(AssetError, match=r"found views.*'endless'.*ogr2ogr"):
            read_parcels(f"{path}{layer}")


def test_files_of_hostile_size_are_refused(tmp_path, monkeypatch):
    from grammarlab.geometry.footprints import geojson_columns, vector_file

    path = write_map(tmp_path / "a.fgb", moved(block(), UTM), UTM)
    for module in (geojson_columns, vector_file):
        monkeypatch.setattr(module, "MAX_FEATURES", 11)
    geojson = write_map(tmp_path / "a.geojson", moved(block(), UTM), "EPSG:4326")
    for file in (path, geojson):
        with pytest.raises(AssetError, match="at most 11 features"):
            read_parcels(file)
    bomb = tmp_path / "bomb.zip"
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.shp", b"\0" * (2 << 20))
    for module in (geojson_columns, vector_file):
        monkeypatch.setattr(module, "MAX_MAP_BYTES", 1 << 20)
    with pytest.raises(AssetError, match="at most 1,048,576 bytes"):
        read_parcels(bomb)
    (tmp_path / "b.geojson").write_bytes(b" " * (2 << 20))
    with pytest.raises(AssetError, match="at most 1,048,576 bytes"):
        read_parcels(tmp_path / "b.geojson")
