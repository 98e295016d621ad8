"""``grammarlab city build``, ``layout``, ``learn`` and ``draw``: their output, and mistakes in words."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from PIL import Image

from grammarlab.runs.city.parcel_reading import read_parcel_table

PLAN = """
[layout]
size = "120x90"

[[zones]]
name = "all"
grammar = "rules.cga"
density = "zones.json"

[[zones]]
name = "rest"
grammar = "rules.cga"
"""
RULES = "Lot --> extrude(rand(4, 9)) Mass."


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    (tmp_path / "rules.cga").write_text(RULES)
    path = tmp_path / "plan.toml"
    path.write_text(PLAN.replace('density = "zones.json"\n', ""))
    return path


def test_a_plan_becomes_tiles_and_a_table(run, plan, tmp_path):
    told = json.loads(run("city", "build", plan, "-o", tmp_path / "city", "--workers", "1", "--json").stdout)
    assert told["parcels"] == told["built"] + sum(told["empty"].values()) > 0
    assert told["tiles"] > 0
    assert told["seconds"] > 0
    assert json.loads((tmp_path / "city" / "tileset.json").read_text())["asset"]["version"] == "1.1"
    again = run("city", "build", plan, "-o", tmp_path / "city", "--workers", "1")
    assert again.stdout.strip() == str(tmp_path / "city" / "tileset.json")


def test_pins_without_a_parcel_are_named_with_the_nearest_ids(run, plan, tmp_path):
    told = json.loads(run("city", "build", plan, "-o", tmp_path / "city", "--workers", "1", "--json").stdout)
    assert told["remarks"] == []
    name = min(read_parcel_table(tmp_path / "city" / "parcels.parquet").id)
    pins = tmp_path / "pins.csv"
    pins.write_text(f"id,reroll,zone\n{name},1,\n{name}x,,-\n")
    built = run("city", "build", plan, "-o", tmp_path / "city", "--workers", "1", "--json")
    (remark,) = json.loads(built.stdout)["remarks"]
    assert remark.startswith(f"{pins}: 1 of 2 pins change nothing")
    assert f"'{name}x' (near are '{name}'" in remark
    assert remark in built.stderr.replace("\n", " ")
    assert json.loads((tmp_path / "city" / "city.json").read_text())["remarks"] == [remark]


def test_a_layout_is_written_and_read_as_a_map(run, plan, tmp_path):
    told = run("city", "layout", plan, "-o", tmp_path / "p.geojson", "--streets", tmp_path / "s.geojson", "--json")
    number = json.loads(told.stdout)["parcels"]
    other = tmp_path / "other.toml"
    zones = '[[zones]]\nname = "all"\ngrammar = "rules.cga"\n'
    other.write_text(f'parcels = "p.geojson"\nstreets = "s.geojson"\ncrs = "local"\n{zones}')
    built = json.loads(run("city", "build", other, "-o", tmp_path / "city", "--workers", "1", "--json").stdout)
    assert built["parcels"] == number


def test_zones_are_learned_from_a_table_of_answers(run, plan, tmp_path):
    names = json.loads(run("city", "learn", plan, "--json").stdout)["questions"]
    answers = tmp_path / "answers.csv"
    answers.write_text("id,zone\n" + "".join(f"{name},{'all' if n % 2 else 'rest'}\n" for n, name in enumerate(names)))
    told = json.loads(run("city", "learn", plan, "--answers", answers, "-o", tmp_path / "zones.json", "--json").stdout)
    assert told["answers"] == len(names)
    plan.write_text(PLAN)
    assert json.loads(run("city", "build", plan, "-o", tmp_path / "c", "--workers", "1", "--json").stdout)["built"] > 0


def test_a_city_is_drawn(run, plan, tmp_path):
    run("city", "draw", plan, "-o", tmp_path / "above.png", "--size", "80x60")
    run("city", "draw", plan, "-o", tmp_path / "street.jpg", "--size", "80x60", "--at", "60,-4,0")
    for name in ("above.png", "street.jpg"):
        with Image.open(tmp_path / name) as picture:
            assert picture.size == (80, 60)


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("parcels = 3", 1, "plan.toml:1:11: error: expected parcels"),
        ('parcels = "gone.gpkg"\n[[zones]]\nname = "a"\ngrammar = "building"', 1, "no such map"),
        ('[layout]\nsize = "120x90"\n[[zones]]\nname = "a"\ngrammar = "buildin"', 2, "Did you mean 'building'"),
        ("zones = [", 1, "plan.toml:1"),
    ],
)
def test_mistakes_in_plans_are_told_in_words(run, plan, tmp_path, text, code, message):
    plan.write_text(text)
    assert message in run("city", "build", plan, "-o", tmp_path / "city", code=code).stderr
    assert not (tmp_path / "city").exists()


def test_odd_options_are_told_in_words(run, plan, tmp_path):
    assert "expected 3 numbers" in run("city", "draw", plan, "-o", tmp_path / "a.png", "--at", "1,2", code=2).stderr
    assert "name of a picture" in run("city", "draw", plan, "-o", tmp_path / "a.gif", code=2).stderr
    text = 'parcels = "x.geojson"\n[[zones]]\nname = "a"\ngrammar = "rules.cga"'
    plan.write_text(text)
    assert "expected [layout]" in run("city", "layout", plan, "-o", tmp_path / "p.geojson", code=2).stderr


def test_species_are_learned_from_a_map_of_trees(run, plan, tmp_path):
    points = [{"type": "Point", "coordinates": [7.0 * n, 5.0 * n % 80]} for n in range(17)]
    features = [
        {"type": "Feature", "properties": {"species": "oak" if n % 3 else "Tilia"}, "geometry": point}
        for n, point in enumerate(points)
    ]
    (tmp_path / "t.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features, "crs": None}))
    plan.write_text(plan.read_text() + '[tree_map]\nfile = "t.geojson"\n')
    learned = run("city", "learn", plan, "--trees")
    assert learned.stdout.strip() == str(tmp_path / "plan.trees.json")
    assert "11 oak" in learned.stderr
    assert "'Tilia' (6)" in learned.stderr
    report = json.loads(run("city", "learn", plan, "--trees", "--json").stdout)
    assert (report["trees"], report["unknown"]) == ({"oak": 11}, {"Tilia": 6})
    assert "both" in run("city", "learn", plan, "--trees", "--answers", plan, code=2).stderr


def test_levels_of_cityjson_are_chosen(run, plan, tmp_path):
    run("city", "build", plan, "-o", tmp_path / "city", "--workers", "1", "--cityjson-lods", "1")
    _, line, *_ = (tmp_path / "city" / "city.city.jsonl").read_text().splitlines()
    (thing,) = json.loads(line)["CityObjects"].values()
    assert [geometry["lod"] for geometry in thing["geometry"]] == ["1"]
    message = run("city", "build", plan, "-o", tmp_path / "city", "--cityjson-lods", "1,4", code=2).stderr
    assert "expected levels of detail among 1, 2, 3, such as 1,2, found '1,4'" in message
