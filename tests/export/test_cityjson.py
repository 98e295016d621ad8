"""Files of CityJSON have closed solids in place, at every level, whatever the order of buildings."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import derive
from grammarlab.errors import UsageError
from grammarlab.export.cityjson import CityBuilding, CityJsonWriter, building_line, head_line
from grammarlab.export.surface_labels import SurfaceLabels
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.scene import realize
from tests.export.cityjson_checks import (
    assert_closed_manifold,
    assert_well_formed,
    features_of,
    geometry_of,
    types_of,
    volume,
)

GRAMMARS = Path(__file__).parents[2] / "grammars"
FRAME = Frame("EPSG:32631", (448000.0, 5412000.0))
TOWER = "Lot --> extrude(6) comp(f) { bottom : Floor | top : Top | side : Side }"
COURT = shapely.Polygon(shapely.box(0, 0, 20, 20).exterior, [shapely.box(5, 5, 15, 15).exterior])


@cache
def building(text: str = TOWER, name: str = "a", east: float = 0.0, footprint: shapely.Polygon | None = None):
    grammar = load(GRAMMARS / f"{text}.cga") if text.isidentifier() else Grammar.parse(text)
    scene = realize(derive(grammar, 1, 5, assets=AssetFolder(GRAMMARS / "assets")))
    return CityBuilding(
        id=name,
        footprint=footprint or shapely.box(east, -20, east + 20, 0),
        ground=2.0,
        scene=scene,
        corner=np.array([east, 2.0, 0.0]),
        labels=SurfaceLabels.none(len(scene)),
        attributes={"seed": 2**63, "zone": "centre", "height": 6.0, "reason": None},
    )


def test_a_block_is_a_closed_solid_with_its_courtyard():
    feature = json.loads(building_line(building(footprint=COURT), ["1"]))
    geometry = geometry_of(feature, "1")
    assert_closed_manifold(geometry)
    assert volume(geometry, feature) == pytest.approx(300 * 6)
    assert types_of(geometry) == ["GroundSurface", *["WallSurface"] * 8, "RoofSurface"]


@pytest.mark.parametrize("name", ["building", "skyscraper"])
def test_features_of_shipped_grammars_are_well_formed(name):
    assert_well_formed(json.loads(building_line(building(name))))


def test_the_surfaces_of_a_model_are_those_of_the_scene_in_place():
    feature = json.loads(building_line(building(east=40.0), ["3"]))
    geometry = geometry_of(feature, "3")
    assert sorted(types_of(geometry)) == ["GroundSurface", "RoofSurface", *["WallSurface"] * 4]
    assert np.min(feature["vertices"], axis=0).tolist() == [40000, -20000, 2000]
    assert np.max(feature["vertices"], axis=0).tolist() == [60000, 0, 8000]
    assert_closed_manifold(geometry)


def test_a_file_is_its_lines_whoever_made_them(tmp_path):
    path = tmp_path / "city.city.jsonl"
    with CityJsonWriter(path, FRAME) as writer:
        writer.add(building()).add_lines(building_line(building(name="b", east=40.0)))
    parts = [head_line(FRAME), building_line(building()), building_line(building(name="b", east=40.0))]
    assert path.read_bytes() == b"".join(parts)
    assert [feature["id"] for feature in features_of(path)] == ["a", "b"]


def test_a_file_that_fails_is_not_there(tmp_path):
    path = tmp_path / "city.city.jsonl"
    with pytest.raises(ZeroDivisionError), CityJsonWriter(path, FRAME) as writer:
        writer.add(building()).add_lines(b" " * (1 // 0))
    assert list(tmp_path.iterdir()) == []


def test_large_integers_are_texts_and_the_others_numbers():
    feature = json.loads(building_line(building(), ["1"]))
    expected = {"seed": str(2**63), "zone": "centre", "height": 6.0, "reason": None}
    assert feature["CityObjects"]["a"]["attributes"] == expected


def test_labels_belong_to_instances():
    whole = building()
    fewer = CityBuilding(**{**vars(whole), "labels": SurfaceLabels.none(1)})
    with pytest.raises(UsageError, match="label for each of its 6"):
        building_line(fewer)


@pytest.mark.parametrize(
    ("crs", "code"),
    [("EPSG:28992", "7415"), ("EPSG:2154", "5698"), ("EPSG:32631", "32631"), ("", None)],
    ids=["only system with heights", "the one in use there", "no system with heights", "no place"],
)
def test_the_reference_system_has_heights_where_epsg_has_one(crs, code):
    origin = {"EPSG:28992": (85000.0, 447000.0), "EPSG:2154": (652000.0, 6862000.0)}.get(crs, FRAME.origin)
    head = json.loads(head_line(Frame(crs, origin)))
    assert head["transform"]["translate"] == [*origin, 0.0]
    url = None if code is None else f"https://www.opengis.net/def/crs/EPSG/0/{code}"
    assert head.get("metadata", {}).get("referenceSystem") == url
