"""Parcels of maps: in true metres from any format and system, each feature listed once, in the order of their ids."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from pyproj import Geod

from grammarlab.city.parcel_map import ParcelMap, read_parcels
from grammarlab.city.parcel_reasons import REASONS
from grammarlab.errors import AssetError, UsageError
from tests.city.parcel_files import CORNER, UTM, block, moved, write_map
from tests.geometry.footprints.maps import BOW_TIE, SQUARE, collection, feature, named, polygon, written

FORMATS = ["map.geojson", "map.gpkg", "map.shp", "map.fgb", "map.city.json"]
SYSTEMS = ["EPSG:4326", "EPSG:3857", "EPSG:2263", "EPSG:32118", UTM]
"""Degrees, Web Mercator, US survey feet, and two in metres."""
IDS = [f"{number:03}" for number in range(12)]


def texts(parcels: ParcelMap) -> tuple[list[str], list[bytes], list[str], str]:
    """All that a map says, to the last bit."""
    values = parcels.parcels
    return (
        values.id.tolist(),
        shapely.to_wkb(values.outline).tolist(),
        values.reason.tolist(),
        str(values.attributes.to_pydict()),
    )


def base(name: str) -> str:
    """The id of the feature of a part."""
    return name.partition("#")[0]


@pytest.mark.parametrize("crs", SYSTEMS)
@pytest.mark.parametrize("name", FORMATS)
def test_areas_are_those_on_the_ground_in_any_format_and_system(tmp_path, name, crs):
    """To .1 %: UTM itself is .08 % too small at the middle of a zone."""
    outlines = block()
    degrees = moved(outlines, "EPSG:4326")
    path = write_map(tmp_path / name, moved(outlines, crs), crs, id=IDS, height=[*range(12)])
    parcels = read_parcels(path).parcels
    assert parcels.id.tolist() == IDS
    assert parcels.usable.all()
    geodesic = [abs(Geod(ellps="WGS84").geometry_area_perimeter(outline)[0]) for outline in degrees]
    assert parcels.area == pytest.approx(geodesic, rel=1e-3)
    assert parcels.attributes.column("height").to_pylist() == [*range(12)]
    centres = shapely.get_coordinates(shapely.centroid(parcels.outline))
    expected = shapely.get_coordinates(shapely.centroid(degrees))
    # 2 m: datums are taken to be equal where PROJ needs a grid to tell them apart.
    assert np.abs(parcels.frame.longitude_latitude(centres) - expected).max() < 2e-5


@pytest.mark.parametrize("name", FORMATS)
def test_the_order_of_rows_does_not_matter(tmp_path, name):
    outlines = [*moved(block(), "EPSG:4326")]
    outlines[3] = outlines[2]  # a copy
    order = np.random.default_rng(4).permutation(12)
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
    first = write_map(tmp_path / "a" / name, outlines, "EPSG:4326", id=IDS, use=["shop"] * 12)
    second = write_map(
        tmp_path / "b" / name,
        [outlines[row] for row in order],
        "EPSG:4326",
        id=[IDS[row] for row in order],
        use=["shop"] * 12,
    )
    assert texts(read_parcels(first)) == texts(read_parcels(second))
    assert Counter(read_parcels(first).parcels.reason) == {"": 11, "duplicate": 1}


def test_the_order_does_not_matter_without_ids(tmp_path):
    outlines = moved(block() * 2, UTM)  # flats: each outline twice
    order = np.random.default_rng(5).permutation(24)
    floor = [0] * 12 + [1] * 12
    first = write_map(tmp_path / "a.gpkg", outlines, UTM, floor=floor)
    second = write_map(tmp_path / "b.gpkg", [outlines[row] for row in order], UTM, floor=[floor[row] for row in order])
    assert texts(read_parcels(first)) == texts(read_parcels(second))
    assert len(set(read_parcels(first).parcels.id)) == 24


def test_formats_agree_to_the_last_bit(tmp_path):
    outlines = moved(block(), UTM)
    paths = [write_map(tmp_path / name, outlines, UTM, id=IDS) for name in ("map.gpkg", "map.shp", "map.fgb")]
    first, *others = [texts(read_parcels(path)) for path in paths]
    assert all(other == first for other in others)


def test_another_origin_moves_no_bit(tmp_path):
    """The corners of a parcel from its own rounded corner are the same in another frame."""
    outlines = [shapely.transform(one, lambda points: points * 1.001 + 0.123) for one in block()]
    far = shapely.box(40_000, 0, 40_020, 20)
    near = read_parcels(write_map(tmp_path / "a.gpkg", moved(outlines, UTM), UTM, id=IDS)).parcels
    others = [shapely.affinity.translate(far, 30.0 * index) for index in range(20)]
    everything = moved([*outlines, *others], UTM)
    wide = read_parcels(
        write_map(tmp_path / "b.gpkg", everything, UTM, id=[*IDS, *[f"x{index}" for index in range(20)]])
    ).parcels
    assert wide.frame.origin != near.frame.origin
    for one, other in zip(near.outline, wide.outline, strict=False):
        corner = np.round(shapely.get_coordinates(one)[0])
        other_corner = corner + np.array(near.frame.origin) - np.array(wide.frame.origin)
        assert (shapely.get_coordinates(one) - corner == shapely.get_coordinates(other) - other_corner).all()
    again = read_parcels(tmp_path / "a.gpkg", frame=wide.frame).parcels
    assert again.frame == wide.frame
    assert shapely.equals_exact(again.outline, wide.outline[:12]).all()


def local(tmp_path: Path, *features: dict, **options) -> ParcelMap:
    return read_parcels(written(tmp_path, collection(*features, crs=None)), **options)


def test_every_kind_of_fault_has_its_reason(tmp_path):
    wall = [[0, 200, 0], [20, 200, 0], [20, 200.5, 30], [0, 200.5, 30], [0, 200, 0]]
    shapes = {
        "a": polygon(SQUARE),
        "b": polygon(SQUARE),
        "c": polygon([[1, 1], [9, 1], [9, 7], [1, 7], [1, 1]]),
        "bow": polygon(BOW_TIE),
        "point": {"type": "Point", "coordinates": [1, 2]},
        "nothing": None,
        "empty": {"type": "Polygon", "coordinates": []},
        "nan": polygon([[0, 0], [float("nan"), 0], [9, 9], [0, 0]]),
        "far": polygon([[2e6, 0], [2e6 + 20, 0], [2e6 + 20, 20], [2e6, 0]]),
        "road": polygon([[0, -20], [400, -20], [400, -17], [0, -17], [0, -20]]),
        "small": polygon([[0, 100], [5, 100], [5, 105], [0, 105], [0, 100]]),
        "narrow": polygon([[0, 120], [100, 120], [100, 121.9], [0, 121.9], [0, 120]]),
        "wall": polygon(wall),
        "corners": polygon(shapely.get_coordinates(shapely.Point(0, 500).buffer(30, quad_segs=2600)).tolist()),
    }
    parcels = local(tmp_path, *[feature(shape, id=name) for name, shape in shapes.items()]).parcels
    assert dict(zip(parcels.id, parcels.reason, strict=True)) == {
        "a": "",
        "b": "duplicate",
        "c": "overlap",
        "bow": "invalid",
        "point": "geometry",
        "nothing": "geometry",
        "empty": "geometry",
        "nan": "geometry",
        "far": "coordinates",
        "road": "street",
        "small": "small",
        "narrow": "narrow",
        "wall": "tilted",
        "corners": "corners",
    }
    assert set(parcels.reason) <= {"", *REASONS}
    assert shapely.is_valid(parcels.outline[parcels.usable]).all()


def test_what_two_parcels_share_belongs_to_the_smaller_id(tmp_path):
    first, second = polygon(SQUARE), polygon([[8, 0], [30, 0], [30, 8], [8, 8], [8, 0]])
    parcels = local(tmp_path, feature(second, id="b"), feature(first, id="a")).parcels
    assert parcels.area.tolist() == [80.0, 160.0]
    nearly = polygon([[9.9, 0], [30, 0], [30, 8], [9.9, 8], [9.9, 0]])
    assert local(tmp_path, feature(nearly, id="b"), feature(first, id="a")).parcels.area[1] == pytest.approx(160.8)


def test_parts_are_numbered_by_their_places(tmp_path):
    rings = [[[40, 0], [50, 0], [50, 8], [40, 8], [40, 0]], SQUARE]
    parts = {"type": "MultiPolygon", "coordinates": [[ring] for ring in rings]}
    single = {"type": "MultiPolygon", "coordinates": [[[[x, y + 50] for x, y in SQUARE]]]}
    parcels = local(tmp_path, feature(parts, id="p", floors=3), feature(single, id="q", floors=4)).parcels
    assert parcels.id.tolist() == ["p#1", "p#2", "q"]
    assert shapely.bounds(parcels.outline)[:, 0].tolist() == [0, 40, 0]
    assert parcels.attributes.column("floors").to_pylist() == [3, 3, 4]


def test_an_id_is_not_that_of_a_part(tmp_path):
    rings = [[[x + 20 * row, y] for x, y in SQUARE] for row in range(4)]
    parts = {"type": "MultiPolygon", "coordinates": [[ring] for ring in rings[:2]]}
    features = [feature(parts, id="a"), feature(polygon(rings[2]), id="a#1"), feature(polygon(rings[3]), id="b#1")]
    ids = local(tmp_path, *features, id_field="id").parcels.id.tolist()
    assert ids[:3] == ["a#1", "a#2", "b#1"]
    assert ids[3].startswith("outline-")


def test_a_repair_keeps_the_area(tmp_path):
    spike = [[0, 0], [100, 0], [100, 100], [60, 100], [50, 101], [60, 101], [50, 100], [0, 100], [0, 0]]
    read = local(tmp_path, feature(polygon(spike), id=1))
    assert read.parcels.area.tolist() == pytest.approx([10_000], rel=0.001)
    assert [remark.kind for remark in read.remarks] == ["repair"]


def test_a_tangle_is_not_repaired_and_a_long_outline_is(tmp_path):
    """As many edges may cross in millions of places; one crossing of a long outline is repaired."""
    tangle = np.random.default_rng(1).uniform(0, 100, (3_000, 2))
    wave = shapely.get_coordinates(shapely.Point(500, 50).buffer(50, quad_segs=500))[:-1]
    wave = np.insert(wave, 1000, wave[1000] + [[0.0, -0.5], [0.01, 0.5]], axis=0)
    rings = [[*ring.tolist(), ring[0].tolist()] for ring in (tangle, wave)]
    assert not shapely.Polygon(rings[1]).is_valid
    parcels = local(tmp_path, *[feature(polygon(ring), id=row) for row, ring in enumerate(rings)]).parcels
    assert parcels.reason.tolist() == ["invalid", ""]
    assert parcels.area[1] == pytest.approx(np.pi * 2500, rel=1e-3)


def test_heights_of_the_corners_become_the_elevation(tmp_path):
    raised = [[x, y, 12.0 + 0.1 * x] for x, y in SQUARE]
    deep = [[x + 20, y, -1e30] for x, y in SQUARE]
    flat = [[x + 40, y] for x, y in SQUARE]
    features = [feature(polygon(ring), id=name) for name, ring in zip("abc", (raised, deep, flat), strict=True)]
    parcels = local(tmp_path, *features).parcels
    assert parcels.elevation[0] == pytest.approx(12.0 + 0.1 * np.mean([x for x, _ in SQUARE]))
    assert np.isnan(parcels.elevation[1:]).all()
    assert parcels.usable.all()
    (without,) = local(tmp_path, feature(polygon([[x, y, 0] for x, y in SQUARE]))).parcels.elevation
    assert np.isnan(without)


def test_heights_in_feet_become_metres(tmp_path):
    outlines = [shapely.force_3d(one, 100.0) for one in moved(block(), "EPSG:2263") if one]
    parcels = read_parcels(write_map(tmp_path / "map.gpkg", outlines, "EPSG:2263", id=IDS)).parcels
    assert parcels.elevation == pytest.approx(100 * 1200 / 3937)


def test_ids_are_those_of_the_named_attribute(tmp_path):
    names = ["7", "007", "7.50", " é ", None, "x", "x"]
    outlines = [polygon([[x + 20 * row, y] for x, y in SQUARE]) for row in range(7)]
    features = [feature(outline, lot=name) for outline, name in zip(outlines, names, strict=True)]
    read = local(tmp_path, *features, id_field="lot")
    assert [name for name in read.parcels.id if not name.startswith("outline-")] == ["007", "7", "7.50", "é"]
    (remark,) = read.remarks
    assert remark.kind == "identity"
    assert "3 of 7 parcels" in remark.reason
    assert "'x'" in remark.reason
    with pytest.raises(UsageError, match=r"no attribute 'plot'.*'lot'"):
        local(tmp_path, *features, id_field="plot")


def test_usual_ids_are_found_if_they_are_complete(tmp_path):
    squares = [polygon([[x + 20 * row, y] for x, y in SQUARE]) for row in range(2)]
    assert local(tmp_path, feature(squares[0], APN=1), feature(squares[1], APN=2)).parcels.id.tolist() == ["1", "2"]
    for row in (1, None):
        read = local(tmp_path, feature(squares[0], APN=1), feature(squares[1], APN=row))
        assert all(name.startswith("outline-") for name in read.parcels.id)
        assert "rerolls" in read.remarks[0].reason
    own = [{**feature(square), "id": f"way/{row}"} for row, square in enumerate(squares)]
    assert local(tmp_path, *own).parcels.id.tolist() == ["way/0", "way/1"]


def test_an_outline_keeps_its_id_however_it_is_drawn(tmp_path):
    turned = [*SQUARE[2:], *SQUARE[1:3]][::-1]
    names = [local(tmp_path, feature(polygon(ring))).parcels.id.tolist() for ring in (SQUARE, turned)]
    assert names[0] == names[1]


def in_degrees(swap: bool = False, scale: float = 1e-4) -> dict:
    ring = [[7.1 + scale * x, 50.9 + scale * y] for x, y in SQUARE]
    return polygon([point[::-1] for point in ring] if swap else ring)


def test_coordinates_that_cannot_be_right_are_refused(tmp_path):
    far = polygon([[x + 691_000, y + 5_334_000] for x, y in SQUARE])
    degrees, utm = named("EPSG:4258"), named("EPSG:25832")
    cases: list[tuple[Any, dict[str, Any], str]] = [
        (collection(feature(far)), {}, "does not name.*crs = .*local"),
        (collection(feature(far), crs=degrees), {}, "EPSG:4258, counts in degrees.*x = 6910"),
        (collection(feature(in_degrees(swap=True)), crs=degrees), {}, "only if x and y are swapped"),
        (collection(feature(polygon([p[::-1] for p in far["coordinates"][0]])), crs=utm), {}, "are swapped"),
        (collection(feature(in_degrees()), crs=None), {}, "median.*unit"),
        (collection(*[feature(in_degrees(scale=0.1))] * 2), {}, "median.*km².*unit"),
        (collection(feature(far)), {"crs": "nonsense"}, "CRS, nonsense, is not known"),
        (collection(feature(far)), {"crs": "EPSG:4978"}, "not one of places"),
        (collection(feature(far)), {"crs": "+proj=utm +zone=32 +nadgrids=/etc/passwd"}, "is not known"),
        (collection(feature({"type": "Point", "coordinates": [7, 50]})), {}, "expected polygons, found none"),
        (collection(feature(polygon(BOW_TIE)), crs=None), {}, "no outline can be used: 1 invalid"),
        (collection(), {}, "expected polygons"),
    ]
    for document, options, message in cases:
        with pytest.raises(AssetError, match=rf"(?s)lots\.geojson: .*{message}") as error:
            read_parcels(written(tmp_path, document), **options)
        assert len(str(error.value)) < 600


def test_one_wrong_place_does_not_stop_a_map(tmp_path):
    features = [
        feature(in_degrees(), id="a"),
        feature(in_degrees(scale=2e-4), id="b"),
        feature(polygon(SQUARE), id="c"),
    ]
    metres = polygon([[x + 691_000, y + 5_334_000] for x, y in SQUARE])
    parcels = local_degrees(tmp_path, *features, feature(metres, id="d")).parcels
    assert dict(zip(parcels.id, parcels.reason, strict=True)) == {
        "a": "",
        "b": "",
        "c": "coordinates",
        "d": "coordinates",
    }


def local_degrees(tmp_path: Path, *features: dict) -> ParcelMap:
    return read_parcels(written(tmp_path, collection(*features)))


def test_the_caller_may_name_the_system(tmp_path):
    far = polygon([[x + 691_000, y + 5_334_000] for x, y in SQUARE])
    path = written(tmp_path, collection(feature(far)))
    assert read_parcels(path, crs="EPSG:25832").parcels.frame.crs == "EPSG:25832"
    placeless = read_parcels(path, crs="local").parcels
    assert not placeless.frame.has_place
    assert placeless.frame.origin == (691_000.0, 5_334_000.0)
    path = written(tmp_path, collection(feature(far), crs=named("EPSG:25831")))
    assert "is used instead of EPSG:25831" in read_parcels(path, crs="EPSG:25832").remarks[0].reason


def test_a_shapefile_without_a_system_is_refused_with_the_option(tmp_path):
    path = write_map(tmp_path / "map.shp", moved(block(), UTM), None, id=IDS)
    with pytest.raises(AssetError, match=r"does not name its coordinate.*crs = "):
        read_parcels(path)
    assert read_parcels(path, crs=UTM).parcels.area == pytest.approx(600)
    with pytest.raises(AssetError, match=r"does not name its coordinate.*crs = "):
        read_parcels(write_map(tmp_path / "map.gpkg", moved(block(), UTM), None, id=IDS))


@pytest.mark.parametrize("name", ["map.gpkg", "map.shp", "map.fgb"])
def test_systems_without_a_code_are_read(tmp_path, name):
    """Many programs write definitions that are called unknown."""
    crs = "+proj=tmerc +lat_0=40 +lon_0=-74 +k=1 +x_0=100000 +y_0=0 +ellps=GRS80 +units=m"
    read = read_parcels(write_map(tmp_path / name, moved(block(), crs), crs, id=IDS))
    assert read.parcels.area == pytest.approx(600, rel=1e-3)
    assert read.parcels.frame.crs.startswith("PROJCRS[")
    assert read.remarks == ()
    assert np.isfinite(read.parcels.frame.longitude_latitude(np.zeros((1, 2)))).all()


def test_layers_are_named_behind_a_colon(tmp_path):
    path = write_map(tmp_path / "map.gpkg", moved(block(), UTM), UTM, "lots", id=IDS)
    write_map(path, moved(block(1, 1), UTM), UTM, "houses", id=["h"])
    with pytest.raises(UsageError, match=r"expected one layer of polygons, found 2.*'lots'.*map.gpkg:LAYER"):
        read_parcels(path)
    assert len(read_parcels(f"{path}:lots").parcels) == 12
    assert read_parcels(path, layer="houses").parcels.id.tolist() == ["h"]
    with pytest.raises(UsageError, match="unknown layer 'streets'"):
        read_parcels(f"{path}:streets")


def test_the_place_of_a_parcel_is_that_of_the_map(tmp_path):
    parcels = read_parcels(write_map(tmp_path / "map.gpkg", moved(block(), UTM), UTM, id=IDS)).parcels
    corner = shapely.bounds(parcels.outline)[0, :2] + parcels.frame.origin
    assert corner == pytest.approx(CORNER)


shapes = st.sampled_from(
    [
        polygon(SQUARE),
        polygon(BOW_TIE),
        polygon([[5, 5], [25, 5], [25, 15], [5, 15], [5, 5]], [[10, 8], [12, 8], [12, 10], [10, 8]]),
        {"type": "MultiPolygon", "coordinates": [[SQUARE], [[[30, 0], [60, 0], [60, 20], [30, 0]]]]},
        {"type": "Point", "coordinates": [0, 0]},
        None,
        polygon([[0, 0, 1], [60, 0, 1], [60, 50, 1], [0, 50, 1], [0, 0, 1]]),
        {"type": "GeometryCollection", "geometries": [polygon(SQUARE), polygon([[70, 0], [90, 0], [90, 20], [70, 0]])]},
    ]
)


@settings(max_examples=60)
@given(st.lists(st.tuples(shapes, st.integers(0, 9)), min_size=1, max_size=12), st.randoms(use_true_random=False))
def test_every_feature_is_listed_once_and_usable_ones_are_apart(tmp_path_factory, rows, random):
    features = [feature(shape, id=f"{number}.0") for shape, number in rows]
    features.append(feature(polygon([[200, 0], [220, 0], [220, 20], [200, 20], [200, 0]]), id="last"))
    shuffled = random.sample(features, len(features))
    folder = tmp_path_factory.mktemp("parcels")
    read = read_parcels(written(folder, collection(*features, crs=None)), id_field="id")
    assert texts(read) == texts(read_parcels(written(folder, collection(*shuffled, crs=None)), id_field="id"))
    parcels = read.parcels
    assert parcels.id.tolist() == sorted(set(parcels.id))
    assert len({base(name) for name in parcels.id}) == len(features)
    assert all(outline.is_valid for outline in parcels.outline[parcels.usable])
    usable = parcels.outline[parcels.usable]
    shared = sum(usable[i].intersection(usable[j]).area > 1 for i in range(len(usable)) for j in range(i))
    assert shared == 0
    assert Counter(parcels.reason)[""] >= 1


def test_a_table_of_attributes_is_always_there(tmp_path):
    parcels = local(tmp_path, feature(polygon(SQUARE))).parcels
    assert parcels.take(np.array([0])).attributes.equals(pa.table({"id": parcels.id.tolist()}))


def test_lines_of_json_are_a_map(tmp_path):
    lines = "\n".join(json.dumps(feature(in_degrees(), id=row)) for row in range(1))
    assert read_parcels(written(tmp_path, lines + "\n{broken\n", "lots.geojsonl")).parcels.id.tolist() == ["0"]
