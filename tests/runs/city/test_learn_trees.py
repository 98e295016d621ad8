"""Species are learned from a map of trees, and the parks and streets of the plan are planted with them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.city.plan import read_plan
from grammarlab.city.tree_file import parse_trees, read_trees
from grammarlab.errors import AssetError, UsageError
from grammarlab.runs.city.build import build_city
from grammarlab.runs.city.learn_trees import learn_trees
from grammarlab.runs.city.survey import surveyed
from grammarlab.runs.city.tree_places import TreePlaces, tree_places
from grammarlab.runs.city.zone_rules import ZoneRules
from grammarlab.runs.sample.shipped import examples_folder
from tests.city.test_map_shapes import write
from tests.runs.city.test_tree_tiles import SPECIES

PLAN = """
[layout]
size = "300x200"
park_share = 0.4
[street_trees]
species = "town.trees.json"
spacing = 10
[tree_map]
file = "trees.geojson"
field = "art"
[tree_map.species]
"pole.toml" = ["Quercus"]
"post.toml" = ["Tilia"]
[[zones]]
name = "parks"
grammar = "town.trees.json"
match = { use = "park" }
[[zones]]
name = "rest"
grammar = "rules.cga"
"""
NAMES = ("Quercus robur", "Tilia cordata", "stump")


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A town whose map has oaks in the west and limes in the east, and a stump here and there."""
    folder = tmp_path_factory.mktemp("town")
    for name in ("pole", "post"):
        (folder / f"{name}.toml").write_text(SPECIES)
    (folder / "rules.cga").write_text("Lot --> extrude(6) Mass.")
    (folder / "plan.toml").write_text(PLAN)
    points = np.random.default_rng(0).uniform((0, 0), (300, 200), (500, 2))
    kinds = np.where(np.arange(500) % 10 == 0, 2, points[:, 0] > 150)
    write(
        folder / "trees.geojson",
        [*map(shapely.Point, points.tolist()), shapely.Point(9000, 0)],
        [{"art": NAMES[kind]} for kind in [*kinds.tolist(), 0]],
        crs=None,
    )
    learn_trees(folder / "plan.toml")
    return folder / "plan.toml"


def planted(plan: Path, *, along_streets: bool = True) -> list[TreePlaces]:
    read = read_plan(plan)
    zones = tuple(ZoneRules.of(zone) for zone in read.zones)
    assert read.street_trees is not None
    streets = ZoneRules.along_streets(read.street_trees) if along_streets else None
    return tree_places(surveyed(read, zones), zones, streets)


def test_what_was_learned_is_reported(plan: Path, tmp_path: Path):
    result = learn_trees(plan, tmp_path / "b.trees.json")
    report = result.as_json()
    assert json.loads(json.dumps(report)) == report
    assert sum(result.trees.values()) == 450
    assert {Path(name).name for name in result.trees} == {"pole.toml", "post.toml"}
    assert (result.unknown, result.num_outside) == ({"stump": 50}, 1)
    assert 6.0 < result.hectares < 12.0  # 300 by 200 m, and what is near
    other = parse_trees((plan.parent / "town.trees.json").read_bytes())
    again = parse_trees(read_trees(tmp_path / "b.trees.json").encode())
    assert other.species == ("pole.toml", "post.toml")
    assert [(tmp_path / name).resolve() for name in again.species] == [plan.parent / name for name in other.species]
    np.testing.assert_array_equal(again.weights, other.weights)


def test_parks_and_streets_have_the_species_of_their_place(plan: Path):
    trees = planted(plan)
    assert [places.rules.name for places in trees] == ["pole", "post"] * 2
    for oaks, limes in (trees[:2], trees[2:]):
        assert min(len(oaks), len(limes)) > 10
        assert np.median(oaks.place[:, 0]) < 100
        assert np.median(limes.place[:, 0]) > 200


def test_another_park_changes_no_tree_of_the_others(plan: Path):
    text = plan.read_text()
    fewer = plan.with_name("fewer.toml")
    west = 'polygon = "POLYGON ((0 0, 150 0, 150 200, 0 200, 0 0))"'
    fewer.write_text(text.replace('{ use = "park" }', '{ use = "park" }\n' + west))
    whole, part = (
        {(places.rules.name, *row) for places in planted(file, along_streets=False) for row in places.place.tolist()}
        for file in (plan, fewer)
    )
    assert 0 < len(part) < len(whole)
    assert part < whole


def test_a_city_is_built_with_learned_trees(plan: Path, tmp_path: Path):
    result = build_city(plan, tmp_path / "city")
    assert (tmp_path / "city" / "trees.json").is_file()
    assert result.num_built > 0


def test_the_area_of_the_plan_is_where_the_map_has_all_trees(plan: Path, tmp_path: Path):
    other = plan.with_name("area.toml")
    area = '[tree_map]\narea = "POLYGON ((0 0, 150 0, 150 200, 0 200, 0 0))"'
    other.write_text(plan.read_text().replace("[tree_map]", area))
    result = learn_trees(other, tmp_path / "c.trees.json")
    assert result.hectares == pytest.approx(3.0)
    assert {Path(name).name for name in result.trees} == {"pole.toml"}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (PLAN[PLAN.index("[tree_map]") : PLAN.index("[[zones]]")], "", r"give \[tree_map\] with file"),
        ('"pole.toml" = ["Quercus"]\n"post.toml" = ["Tilia"]', "", r'\(\d+\).*\[tree_map.species\] oak = \["'),
        ('"pole.toml" = ["Quercus"]', 'building = ["Quercus"]', "expected a species, found the rules 'building'"),
        ('field = "art"', 'field = "name"', "found the fields art"),
    ],
)
def test_mistakes_say_what_to_do(plan: Path, tmp_path: Path, old: str, new: str, message: str):
    other = plan.with_name("mistake.toml")
    other.write_text(plan.read_text().replace(old, new))
    with pytest.raises((AssetError, UsageError), match=message):
        learn_trees(other, tmp_path / "d.trees.json")
    assert not (tmp_path / "d.trees.json").exists()


def test_learned_trees_need_their_species_and_their_place(plan: Path):
    file = plan.with_name("bad.trees.json")
    text = (plan.parent / "town.trees.json").read_text()
    other = plan.with_name("bad.toml")
    other.write_text(plan.read_text().replace('grammar = "town.trees.json"', 'grammar = "bad.trees.json"'))
    file.write_text(text.replace('"pole.toml"', '"rules.cga"'))
    with pytest.raises(AssetError, match="expected species, found the rules 'rules"):
        planted(other)
    file.write_text(text.replace('"crs": ""', '"crs": "EPSG:32631"'))
    with pytest.raises(UsageError, match="learned in EPSG:32631, and the parcels are in local metres"):
        planted(other)


def test_the_shipped_park_has_the_trees_of_its_sketch(tmp_path: Path):
    shipped = examples_folder() / "city" / "park.plan.toml"
    result = learn_trees(shipped, tmp_path / "park.trees.json")
    intensity = parse_trees((shipped.parent / "park.trees.json").read_bytes())
    assert (intensity.species, intensity.trees) == (result.intensity.species, result.intensity.trees)
    points = np.random.default_rng(0).uniform((0, 0), (200, 140), (100, 2))
    np.testing.assert_allclose(intensity.at(points), result.intensity.at(points), rtol=1e-3)
