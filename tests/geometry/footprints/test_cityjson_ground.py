"""Footprints of CityJSON: ground surfaces of objects and their parts, from documents and text sequences."""

from __future__ import annotations

import json

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.errors import AssetError, UsageError
from grammarlab.geometry.footprints.cityjson_ground import read_cityjson_layer
from tests.city.parcel_files import city

HOUSES = [shapely.box(0, 0, 10, 8), shapely.Polygon([(20, 0), (30, 0), (30, 9), (25, 4), (20, 9)])]


def written(folder, document, name="map.city.json"):
    path = folder / name
    lines = document if isinstance(document, list) else [document]
    path.write_text("\n".join(json.dumps(line) for line in lines), encoding="utf-8")
    return path


def sequence(document):
    """The lines of a document as a text sequence: each object with its own vertices."""
    first = document | {"CityObjects": {}, "vertices": []}
    lines = []
    for name, value in document["CityObjects"].items():
        objects = {name: value}
        feature = {"type": "CityJSONFeature", "id": name, "CityObjects": objects, "vertices": document["vertices"]}
        lines.append(feature)
    return [first, *lines]


def test_the_ground_of_a_solid_is_its_outline_at_its_height(tmp_path):
    document = city(HOUSES, "EPSG:28992", {"id": ["a", "b"], "year": [1900, 2000]})
    for path in (written(tmp_path, document), written(tmp_path, sequence(document), "map.city.jsonl")):
        layer = read_cityjson_layer(path)
        assert shapely.equals(shapely.force_2d(layer.geometry), HOUSES).all()
        assert {float(z) for z in shapely.get_coordinates(layer.geometry, include_z=True)[:, 2]} == {5.0}
        assert layer.attributes.to_pydict() == {"id": ["a", "b"], "year": [1900, 2000]}
        assert layer.crs == "https://www.opengis.net/def/crs/EPSG/0/28992"


def test_without_semantics_the_lowest_faces_are_the_ground(tmp_path):
    document = city(HOUSES, None, {"id": ["a", "b"]})
    for value in document["CityObjects"].values():
        del value["geometry"][0]["semantics"]
    layer = read_cityjson_layer(written(tmp_path, document))
    assert shapely.equals(shapely.force_2d(layer.geometry), HOUSES).all()
    assert layer.crs is None


def test_parts_belong_to_their_building(tmp_path):
    """Only the outermost object is listed, with the ground of all its parts, even if they name each other."""
    document = city(HOUSES, None, {"id": ["a", "b"]})
    objects = document["CityObjects"]
    objects["whole"] = {"type": "Building", "children": ["a", "b", "missing"], "attributes": {"name": "w"}}
    for name in ("a", "b"):
        objects[name] |= {"type": "BuildingPart", "parents": ["whole"], "children": ["whole", name]}
    layer = read_cityjson_layer(written(tmp_path, document))
    assert layer.attributes.column("id").to_pylist() == ["whole"]
    assert layer.geometry[0].area == pytest.approx(sum(house.area for house in HOUSES))


def test_the_finest_level_with_ground_counts(tmp_path):
    fine = city([HOUSES[0]], None, {"id": ["a"]})
    coarse = city([shapely.box(-5, -5, 50, 50)], None, {"id": ["a"]})["CityObjects"]["a"]["geometry"][0]
    number = len(fine["vertices"])
    fine["vertices"] += city([shapely.box(-5, -5, 50, 50)], None, {"id": ["a"]})["vertices"]

    def shifted(value):
        return [shifted(one) for one in value] if isinstance(value, list) else value + number

    geometry = fine["CityObjects"]["a"]["geometry"]
    geometry.insert(0, coarse | {"lod": 1, "boundaries": shifted(coarse["boundaries"])})
    assert read_cityjson_layer(written(tmp_path, fine)).geometry[0].area == pytest.approx(80)


def test_types_of_objects_are_layers(tmp_path):
    document = city(HOUSES, None, {"id": ["a", "b"]})
    document["CityObjects"]["b"]["type"] = "LandUse"
    path = written(tmp_path, document)
    assert read_cityjson_layer(path).attributes.column("id").to_pylist() == ["a"]
    assert read_cityjson_layer(path, "LandUse").attributes.column("id").to_pylist() == ["b"]
    with pytest.raises(UsageError, match="no objects of type 'Road'; its types are Building, LandUse"):
        read_cityjson_layer(path, "Road")
    for name, kind in (("a", "Road"), ("b", "Bridge")):
        document["CityObjects"][name]["type"] = kind
    with pytest.raises(UsageError, match=r"found Bridge, Road\. Name one"):
        read_cityjson_layer(written(tmp_path, document))


def test_broken_lines_are_counted(tmp_path):
    lines = sequence(city(HOUSES, None, {"id": ["a", "b"]}))
    path = written(tmp_path, [*lines, {"CityObjects": 3}, [], {"CityObjects": {}, "vertices": [[1]]}], "map.city.jsonl")
    path.write_text(path.read_text() + "\n{broken\n")
    layer = read_cityjson_layer(path)
    assert len(layer) == 2
    assert "4 lines" in layer.remarks[0].reason


@pytest.mark.parametrize("text", ["", "{", "[]", "3", '{"type": "CityJSON"}', '{"CityObjects": []}', "[" * 100_000])
@pytest.mark.parametrize("name", ["map.city.json", "map.city.jsonl"])
def test_other_documents_are_refused(tmp_path, text, name):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(AssetError, match=r"CityJSON|city objects"):
        read_cityjson_layer(path)


DOCUMENT = city(HOUSES, "EPSG:28992", {"id": ["a", "b"], "year": [1900, 2000]})
HOSTILE = [
    *(None, True, 0, -1, 10**30, 1e308, float("nan"), "", "Solid", "\ud800", "x" * 1000),
    *(
        [],
        {},
        [[]],
        [[[]]],
        [[[[]]]],
        [[[[0, 1, 2]]]],
        [-1],
        [10**9],
        {"type": "Building"},
        {"a": {"type": "Building"}},
    ),
]


def places(value, path=()):
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


PLACES = [path for path in places(DOCUMENT) if path]


@settings(max_examples=150)
@given(st.sampled_from(PLACES), st.sampled_from(HOSTILE))
def test_any_value_in_any_place_is_read_or_refused(tmp_path_factory, path, value):
    document = json.loads(json.dumps(DOCUMENT))
    inner = document
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    try:
        layer = read_cityjson_layer(written(tmp_path_factory.mktemp("mutant"), document))
    except (AssetError, UsageError):
        return
    for shape in layer.geometry:
        assert shape is None or np.isfinite(shapely.get_coordinates(shape)).all()
