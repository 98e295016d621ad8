"""Trees of a city: in parks and along streets, in place, in tiles of their own that the city refers to."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.city.plan import read_plan
from grammarlab.runs.city import tree_places as tree_places_module
from grammarlab.runs.city.build import build_city
from grammarlab.runs.city.survey import surveyed
from grammarlab.runs.city.tree_places import NUM_GROWN, tree_places
from grammarlab.runs.city.zone_rules import ZoneRules
from tests.cases import some
from tests.runs.city.plans import files_of

SPECIES = """about = "A bare pole with a few branches."
[tree]
levels = 2
scale = { value = 4.0, unit = "m" }
ratio = 0.02
[level_1]
branches_1 = 6
[leaves]
leaves = 0
"""
PLAN = """
[layout]
size = "260x180"
park_share = 0.3
[street_trees]
species = "pole.toml"
spacing = 20
[[zones]]
name = "parks"
grammar = "pole.toml"
match = { use = "park" }
trees_per_hectare = 40
[[zones]]
name = "rest"
grammar = "rules.cga"
"""


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    (tmp_path / "pole.toml").write_text(SPECIES)
    (tmp_path / "rules.cga").write_text("Lot --> extrude(6) Mass.")
    (tmp_path / "plan.toml").write_text(PLAN)
    return tmp_path / "plan.toml"


def test_trees_stand_in_parks_and_along_streets(plan: Path):
    read = read_plan(plan)
    zones = tuple(ZoneRules.of(zone) for zone in read.zones)
    survey = surveyed(read, zones)
    assert read.street_trees is not None
    parks, streets = tree_places(survey, zones, ZoneRules.along_streets(read.street_trees))
    use = np.array(survey.parcels.attributes["use"].to_pylist())
    park = shapely.union_all(survey.parcels.outline[use == "park"])
    points = shapely.points(parks.place[:, [0, 2]] * (1.0, -1.0))
    assert len(parks) > 5
    assert (shapely.distance(points, park) < 0.01).all()
    along = shapely.points(streets.place[:, [0, 2]] * (1.0, -1.0))
    assert len(streets) > 5
    assert (shapely.distance(along, shapely.union_all(survey.parcels.outline)) > 1.0).all()
    assert set(np.concatenate([parks.grown, streets.grown]).tolist()) <= set(range(NUM_GROWN))


def test_a_city_refers_to_its_buildings_and_trees(plan: Path, tmp_path: Path):
    folder = tmp_path / "city"
    build_city(plan, folder)
    root = json.loads((folder / "tileset.json").read_text())["root"]
    assert [child["content"]["uri"] for child in root["children"]] == ["buildings.json", "trees.json"]
    whole = np.array(root["boundingVolume"]["box"])
    for child in root["children"]:
        box = np.array(child["boundingVolume"]["box"])
        reach, inner = whole[[3, 7, 11]], box[[3, 7, 11]]
        assert (np.abs(box[:3] - whole[:3]) + inner <= reach + 1e-9).all()
    trees = json.loads((folder / "trees.json").read_text())["root"]
    names = [child["children"][0]["content"]["uri"] for child in trees["children"]]
    assert names
    assert all((folder / name).read_bytes()[:4] == b"glTF" for name in names)
    before = files_of(folder)
    build_city(plan, folder)
    assert files_of(folder) == before


def test_a_city_without_trees_any_more_has_none(plan: Path, tmp_path: Path):
    folder = tmp_path / "city"
    build_city(plan, folder)
    text = plan.read_text()
    plan.write_text(text[: text.index("[street_trees]")] + '[[zones]]\nname = "rest"\ngrammar = "rules.cga"\n')
    build_city(plan, folder)
    assert not (folder / "trees.json").exists()
    assert not (folder / "trees").exists()
    assert not list((folder / "parks").iterdir())
    assert not (folder / "buildings.json").exists()
    assert "content" in json.loads((folder / "tileset.json").read_text())["root"]


CHANGES = {
    "density": ("trees_per_hectare = 40", "trees_per_hectare = 30"),
    "parks": ("park_share = 0.3", "park_share = 0.4"),
    "species": ("branches_1 = 6", "branches_1 = 9"),
    "street trees": ("spacing = 20", "spacing = 30"),
    "parcels": ('size = "260x180"', 'size = "260x180"\nparcels = { area = 300 }'),
    "kind of tileset": ("", ""),
}


@pytest.mark.parametrize("name", some(list(CHANGES)))
def test_changed_trees_are_those_of_a_city_from_nothing(plan: Path, tmp_path: Path, name: str):
    build_city(plan, tmp_path / "city")
    old, new = CHANGES[name]
    for file in (plan, plan.parent / "pole.toml"):
        file.write_text(file.read_text().replace(old, new) if old else file.read_text())
    implicit = name == "kind of tileset"
    build_city(plan, tmp_path / "city", implicit=implicit)
    build_city(plan, tmp_path / "new", implicit=implicit)
    assert files_of(tmp_path / "city") == files_of(tmp_path / "new")


def test_parks_are_planted_once(plan: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    build_city(plan, tmp_path / "city")
    calls = []
    monkeypatch.setattr(tree_places_module, "planted", lambda *_arguments, **_density: calls.append(1))
    build_city(plan, tmp_path / "city")
    assert calls == []


@pytest.mark.parametrize("pattern", some(["parks/*.trees", "trees/*.glb", "trees/record.json", "trees.json"]))
def test_damaged_trees_are_made_again(plan: Path, tmp_path: Path, pattern: str):
    build_city(plan, tmp_path / "city")
    whole = files_of(tmp_path / "city")
    for path in (tmp_path / "city").glob(pattern):
        path.write_bytes(path.read_bytes()[:-1])
    assert files_of(tmp_path / "city") != whole
    build_city(plan, tmp_path / "city")
    assert files_of(tmp_path / "city") == whole


def test_an_implicit_city_has_its_trees_beside_it(plan: Path, tmp_path: Path):
    build_city(plan, tmp_path / "city", implicit=True)
    root = json.loads((tmp_path / "city" / "tileset.json").read_text())["root"]
    assert "implicitTiling" in root
    assert (tmp_path / "city" / "trees.json").is_file()
