"""Built cities: each parcel once, the same bytes however they are made, and only what changed is made again."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.city.parcel_addresses import Pins, excluded, rerolled, save_pins
from grammarlab.errors import UsageError
from grammarlab.export.cityjson import LEVELS
from grammarlab.runs.city.build import FAILED, build_city
from grammarlab.runs.city.parcel_reading import read_parcel_table
from grammarlab.runs.city.rebuild import rebuild
from grammarlab.runs.work.executors import Processes
from tests.runs.city.plans import boxes, files_of, write_map, write_plan


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    return write_plan(tmp_path / "plan", boxes())


ENDLESS = "Endless --> case scope.sx > 0 : Endless else : X."


def test_every_parcel_is_listed_once(plan: Path, tmp_path: Path):
    result = build_city(plan, tmp_path / "city", cityjson=LEVELS)
    rows = read_parcel_table(tmp_path / "city" / "parcels.parquet")
    assert sorted(rows.id) == sorted(boxes())
    assert result.num_parcels == len(boxes()) == result.num_built + sum(result.empty.values())
    assert result.num_built == int((rows.reason == "").sum()) > 0
    assert set(rows.zone[rows.reason == ""]) == {"west", "rest"}
    assert (rows.reports["height"][(rows.zone == "west") & (rows.reason == "")] == 12).all()
    tiles = {path.relative_to(result.folder).as_posix() for path in (result.folder / "t").rglob("*.glb")}
    assert set(rows.tile[rows.reason == ""]) <= tiles
    lines = (tmp_path / "city" / "city.city.jsonl").read_text().splitlines()
    assert {json.loads(line)["id"] for line in lines[1:]} == set(rows.id[rows.reason == ""])


def test_the_order_of_the_map_and_of_workers_changes_nothing(plan: Path, tmp_path: Path):
    build_city(plan, tmp_path / "one", cityjson=LEVELS)
    order = list(np.random.default_rng(1).permutation(list(boxes())))
    other = write_plan(tmp_path / "other", boxes(), order)
    build_city(other, tmp_path / "two", cityjson=LEVELS, executor=Processes(2))
    assert files_of(tmp_path / "one") == files_of(tmp_path / "two")


def test_a_second_build_keeps_what_is_there(plan: Path, tmp_path: Path):
    first = build_city(plan, tmp_path / "city")
    before = files_of(tmp_path / "city")
    again = build_city(plan, tmp_path / "city")
    assert (first.num_reused, again.num_reused) == (0, again.num_reused)
    assert again.num_reused > 0
    assert files_of(tmp_path / "city") == before


def test_a_damaged_record_is_made_again(plan: Path, tmp_path: Path):
    build_city(plan, tmp_path / "city")
    before = files_of(tmp_path / "city")
    for record in (tmp_path / "city").rglob("record.json"):
        record.write_text("{")
    assert build_city(plan, tmp_path / "city").num_reused == 0
    assert files_of(tmp_path / "city") == before


def addresses(folder: Path) -> dict[str, tuple]:
    rows = read_parcel_table(folder / "parcels.parquet")
    lots = [None if lot is None else lot.wkb for lot in rows.lot]
    columns = zip(rows.id, rows.zone, rows.reason, rows.seed, rows.model, rows.reroll, lots, strict=True)
    return {name: tuple(values) for name, *values in columns}


def test_reroll_and_exclusion_change_one_building_each(plan: Path, tmp_path: Path):
    folder = tmp_path / "city"
    build_city(plan, folder)
    before = addresses(folder)
    save_pins(excluded(rerolled(Pins(), "1-1"), "2-2"), plan.parent / "pins.csv")
    tiles = rebuild(folder, ["1-1", "2-2"])
    after = addresses(folder)
    assert {name for name in before if before[name] != after[name]} == {"1-1", "2-2"}
    assert after["2-2"][1] == "excluded"
    assert tiles
    assert all((folder / tile).is_file() for tile in tiles)


def test_one_parcel_more_changes_only_those_that_it_touches(plan: Path, tmp_path: Path):
    folder = tmp_path / "city"
    build_city(plan, folder)
    before = addresses(folder)
    parcels = {**boxes(), "new": shapely.box(0, -90, 22, -60)}
    write_map(plan.parent / "map.geojson", parcels)
    build_city(plan, folder)
    after = addresses(folder)
    assert {name: after[name] for name in before} == before
    assert after["new"][1] == ""


def test_a_building_that_cannot_be_derived_stops_no_other(plan: Path, tmp_path: Path):
    rules = f"Lot --> case scope.sx > 0 && p(0.5) : Endless else : extrude(3) Y.\n{ENDLESS}"
    (plan.parent / "chance.cga").write_text(rules)
    result = build_city(plan, tmp_path / "city")
    rows = read_parcel_table(tmp_path / "city" / "parcels.parquet")
    assert set(result.failures) == set(rows.id[rows.reason == FAILED])
    assert 0 < len(result.failures) < result.num_parcels
    assert result.num_built > 0


def test_an_unknown_attribute_and_a_folder_without_a_city_are_named(plan: Path, tmp_path: Path):
    text = plan.read_text()
    plan.write_text(text.replace("height = 12", "hight = 12"))
    with pytest.raises(UsageError, match=r"'west'.*no attribute 'hight'.*height"):
        build_city(plan, tmp_path / "city")
    with pytest.raises(UsageError, match="expected a city"):
        rebuild(tmp_path, ["1-1"])


def test_a_city_in_which_nothing_can_be_built_lists_every_parcel(plan: Path, tmp_path: Path):
    build_city(plan, tmp_path / "city")
    (plan.parent / "chance.cga").write_text(f"Lot --> Endless\n{ENDLESS}")
    (plan.parent / "rules.cga").write_text(f"attr height = 1\nLot --> Endless\n{ENDLESS}")
    result = build_city(plan, tmp_path / "city", cityjson=LEVELS)
    assert (result.num_built, result.num_tiles) == (0, 0)
    assert sum(result.empty.values()) == len(boxes())
    assert not list((tmp_path / "city").rglob("*.glb"))
    assert not result.tileset.exists()


def test_rules_that_make_nothing_make_an_empty_city(plan: Path, tmp_path: Path):
    for name in ("chance.cga", "rules.cga"):
        (plan.parent / name).write_text("attr height = 1\nLot --> NIL")
    result = build_city(plan, tmp_path / "city")
    assert result.num_built + sum(result.empty.values()) == len(boxes())


def test_a_city_that_shrinks_leaves_no_tiles_and_no_other_file_is_touched(plan: Path, tmp_path: Path):
    far = {**boxes(), **{f"far-{n}": shapely.box(5000 + 22 * n, 0, 5022 + 22 * n, 30) for n in range(3)}}
    write_map(plan.parent / "map.geojson", far)
    build_city(plan, tmp_path / "city")
    (tmp_path / "city" / "shards" / "mine").mkdir()
    (tmp_path / "city" / "shards" / "mine" / "notes.txt").write_text("keep")
    write_map(plan.parent / "map.geojson", boxes())
    build_city(plan, tmp_path / "city")
    shrunk = files_of(tmp_path / "city")
    assert shrunk.pop("shards/mine/notes.txt") == b"keep"
    build_city(plan, tmp_path / "new")
    assert shrunk == files_of(tmp_path / "new")
