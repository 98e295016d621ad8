"""Cities after a change: the bytes of a city from nothing, though only the squares that it concerns are made again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.city.parcel_addresses import Pins, excluded, pinned, placed_in, read_pins, rerolled, save_pins
from grammarlab.city.sites import Sites
from grammarlab.export.cityjson import LEVELS
from grammarlab.runs.city import quad_buildings, shard
from grammarlab.runs.city.build import build_city
from grammarlab.runs.city.parcel_reading import read_parcel_table
from grammarlab.runs.city.rebuild import rebuild
from grammarlab.runs.city.zone_rules import MadeBuildings, ZoneRules
from grammarlab.runs.work.executors import Processes
from tests.cases import some
from tests.export.cityjson_checks import Feature, features_of, geometry_of, surfaces_of
from tests.runs.city.plans import boxes, write_map, write_plan

FAR = {f"far-{number}": shapely.box(900 + 22 * number, 300, 922 + 22 * number, 330) for number in range(3)}
"""Parcels in the same shard as those of `boxes`, in another square of 1,024 m."""
ELSEWHERE = {f"else-{number}": shapely.box(5000 + 22 * number, 0, 5022 + 22 * number, 30) for number in range(2)}
"""Parcels in another shard."""
EVERYWHERE = {**boxes(), **FAR, **ELSEWHERE}


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    return write_plan(tmp_path / "plan", EVERYWHERE)


@pytest.fixture
def derived(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Numbers of sites that are derived together, in the order of derivation."""
    counts = []
    make_buildings = quad_buildings.make_buildings

    def counted(rules: ZoneRules, sites: Sites) -> MadeBuildings:
        counts.append(len(sites))
        return make_buildings(rules, sites)

    monkeypatch.setattr(quad_buildings, "make_buildings", counted)
    return counts


def contents(folder: Path) -> dict[str, bytes]:
    """All files of a city by name."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def pin(plan: Path, change: Callable[[Pins], Pins]) -> None:
    pins = plan.parent / "pins.csv"
    save_pins(change(read_pins(pins) if pins.is_file() else Pins()), pins)


def map_of(plan: Path, parcels: dict[str, shapely.Polygon]) -> None:
    write_map(plan.parent / "map.geojson", parcels)


def replace_in(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))


CHANGES: dict[str, Callable[[Path], None]] = {
    "reroll": lambda plan: pin(plan, lambda pins: rerolled(pins, "1-1")),
    "pin": lambda plan: pin(plan, lambda pins: pinned(pins, "far-1", seed=9, model=7, zone="rest")),
    "other zone": lambda plan: pin(plan, lambda pins: placed_in(pins, "0-1", "rest")),
    "exclude": lambda plan: pin(plan, lambda pins: excluded(pins, "2-2")),
    "exclude a square": lambda plan: pin(
        plan, lambda pins: excluded(excluded(excluded(pins, "far-0"), "far-1"), "far-2")
    ),
    "one parcel more": lambda plan: map_of(plan, {**EVERYWHERE, "more": shapely.box(400, 0, 422, 30)}),
    "one shard more": lambda plan: map_of(plan, {**EVERYWHERE, "more": shapely.box(-400, 0, -378, 30)}),
    "one parcel less": lambda plan: map_of(plan, {name: box for name, box in EVERYWHERE.items() if name != "0-0"}),
    "one shard less": lambda plan: map_of(plan, {**boxes(), **FAR}),
    "one square less": lambda plan: map_of(plan, {**boxes(), **ELSEWHERE}),
    "attribute": lambda plan: replace_in(plan, "height = 12", "height = 13"),
    "rules": lambda plan: replace_in(plan.parent / "chance.cga", "rand(4, 8)", "rand(4, 7)"),
    "all fail": lambda plan: replace_in(plan.parent / "chance.cga", "Lot -->", "Lot --> extrude(1 / 0)\nNoLot -->"),
}


@pytest.mark.parametrize("name", some(list(CHANGES)))
def test_a_changed_city_is_one_from_nothing(plan: Path, tmp_path: Path, name: str):
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    before = contents(tmp_path / "city")
    CHANGES[name](plan)
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    build_city(plan, tmp_path / "new", cityjson=LEVELS)
    assert contents(tmp_path / "city") == contents(tmp_path / "new") != before


def test_other_files_and_workers_change_nothing(plan: Path, tmp_path: Path):
    build_city(plan, tmp_path / "city", cityjson=LEVELS, implicit=True)
    CHANGES["one shard less"](plan)
    build_city(plan, tmp_path / "city", implicit=True, executor=Processes(2))
    build_city(plan, tmp_path / "new", implicit=True)
    assert contents(tmp_path / "city") == contents(tmp_path / "new")
    build_city(plan, tmp_path / "city")
    build_city(plan, tmp_path / "explicit")
    assert contents(tmp_path / "city") == contents(tmp_path / "explicit")


def test_a_reroll_derives_its_square_alone(plan: Path, tmp_path: Path, derived: list[int]):
    folder = tmp_path / "city"
    build_city(plan, folder)
    assert sum(derived) == len(EVERYWHERE)
    derived.clear()
    pin(plan, lambda pins: rerolled(pins, "far-1"))
    tiles = rebuild(folder, ["far-1"])
    assert derived == [len(FAR)]
    rows = read_parcel_table(folder / "parcels.parquet")
    own = rows.tile[np.isin(rows.id, list(FAR))]
    assert set(own) <= set(tiles)
    assert set(tiles).isdisjoint(set(rows.tile) - set(own))


def test_a_parcel_more_derives_its_square_alone(plan: Path, tmp_path: Path, derived: list[int]):
    build_city(plan, tmp_path / "city")
    derived.clear()
    map_of(plan, {**EVERYWHERE, "more": shapely.box(900, 360, 922, 390)})
    build_city(plan, tmp_path / "city")
    assert derived == [len(FAR) + 1]


def test_nothing_is_derived_without_a_change(plan: Path, tmp_path: Path, derived: list[int]):
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    derived.clear()
    before = contents(tmp_path / "city")
    assert build_city(plan, tmp_path / "city", cityjson=LEVELS).num_reused == 2
    assert derived == []
    assert contents(tmp_path / "city") == before


def flip(path: Path) -> None:
    """Change one bit in the middle of a file."""
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-1])


@pytest.mark.parametrize("damage", [flip, cut, Path.unlink])
@pytest.mark.parametrize(
    "kind", some(["branches/*.branch", "quads/*.json", "quads/*.zst", "record.json", "tileset.json"])
)
def test_damaged_files_are_made_again(plan: Path, tmp_path: Path, damage: Callable[[Path], None], kind: str):
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    whole = contents(tmp_path / "city")
    damaged = list((tmp_path / "city" / "shards").glob(f"*/{kind}"))
    assert damaged
    for path in damaged:
        damage(path)
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    assert contents(tmp_path / "city") == whole


@pytest.mark.parametrize("damage", some([cut, Path.unlink]))
def test_damaged_tiles_are_made_again(plan: Path, tmp_path: Path, damage: Callable[[Path], None]):
    build_city(plan, tmp_path / "city")
    whole = contents(tmp_path / "city")
    for path in (tmp_path / "city" / "t").rglob("*.glb"):
        damage(path)
        build_city(plan, tmp_path / "city")
        assert contents(tmp_path / "city") == whole


def test_files_of_another_city_are_not_taken(plan: Path, tmp_path: Path):
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    own = contents(tmp_path / "city")
    CHANGES["rules"](plan)
    build_city(plan, tmp_path / "other", cityjson=LEVELS)
    foreign = contents(tmp_path / "other")
    replace_in(plan.parent / "chance.cga", "rand(4, 7)", "rand(4, 8)")
    for pattern in ("branches/*", "quads/*", "record.json", "tileset.json"):
        for path in (tmp_path / "city" / "shards").glob(f"*/{pattern}"):
            path.write_bytes(foreign[path.relative_to(tmp_path / "city").as_posix()])
        build_city(plan, tmp_path / "city", cityjson=LEVELS)
        assert contents(tmp_path / "city") == own


def test_a_stopped_build_goes_on_from_its_last_square(
    plan: Path, tmp_path: Path, derived: list[int], monkeypatch: pytest.MonkeyPatch
):
    build_city(plan, tmp_path / "new")
    derived.clear()
    with monkeypatch.context() as context:
        context.setattr(quad_buildings, "_BUILDINGS_AT_ONCE", 1)
        stop_after(context, 2)
        with pytest.raises(KeyboardInterrupt):
            build_city(plan, tmp_path / "city")
    derived_twice = derived[-1]
    (tmp_path / "city" / "shards" / "16_16" / "quads" / ".part-0123456789abcdef.json").write_text("{")
    build_city(plan, tmp_path / "city")
    assert contents(tmp_path / "city") == contents(tmp_path / "new")
    assert sum(derived) == len(EVERYWHERE) + derived_twice


def test_a_change_that_is_taken_back_after_a_stop_leaves_nothing(
    plan: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    before = contents(tmp_path / "city")
    CHANGES["rules"](plan)
    with monkeypatch.context() as context:
        stop_after(context, 1)
        with pytest.raises(KeyboardInterrupt):
            build_city(plan, tmp_path / "city", cityjson=LEVELS)
    replace_in(plan.parent / "chance.cga", "rand(4, 7)", "rand(4, 8)")
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    assert contents(tmp_path / "city") == before


def stop_after(context: pytest.MonkeyPatch, number: int) -> None:
    """Interrupt a build when so many squares have their tiles, before the last one has its record."""
    write_quad = shard.write_quad
    calls = []

    def stopping(*arguments):
        calls.append(write_quad(*arguments))
        if len(calls) == number:
            raise KeyboardInterrupt
        return calls[-1]

    context.setattr(shard, "write_quad", stopping)


def test_missing_meshes_are_those_of_the_square(plan: Path, tmp_path: Path):
    """What a square says does not depend on the others that are derived with it."""
    rules = 'attr name = "" Lot --> case find(name, "far", 0) >= 0 : i("far.obj") else : extrude(3) Low.'
    (plan.parent / "chance.cga").write_text(rules)
    replace_in(plan, 'grammar = "chance.cga"', 'grammar = "chance.cga"\nattributes = { name = "= id" }')
    result = build_city(plan, tmp_path / "city")
    assert result.missing_assets == ("far.obj",)
    before = contents(tmp_path / "city")
    squares = [name for name, content in before.items() if "/quads/" in name and b"far.obj" in content]
    assert len(squares) == 1
    pin(plan, lambda pins: rerolled(pins, "1-1"))
    build_city(plan, tmp_path / "city")
    build_city(plan, tmp_path / "new")
    assert contents(tmp_path / "city") == contents(tmp_path / "new")


def test_cityjson_has_the_levels_that_are_asked_for(tmp_path: Path):
    plan = write_plan(tmp_path / "plan", boxes())
    build_city(plan, tmp_path / "all", cityjson=LEVELS)
    build_city(plan, tmp_path / "few", cityjson=LEVELS)
    assert build_city(plan, tmp_path / "few", cityjson=("1", "2")).num_reused == 0
    every, few = (features_of(tmp_path / name / "city.city.jsonl") for name in ("all", "few"))
    assert len(every) == len(few) > 0
    for whole, part in zip(every, few, strict=True):
        (thing,) = part["CityObjects"].values()
        assert [geometry["lod"] for geometry in thing["geometry"]] == ["1", "2"]
        for level in ("1", "2"):
            assert points_of(part, level) == points_of(whole, level)
    # A change of a parcel keeps the levels of the city.
    save_pins(rerolled(Pins(), "1-1"), plan.parent / "pins.csv")
    rebuild(tmp_path / "few", ["1-1"])
    again = features_of(tmp_path / "few" / "city.city.jsonl")
    assert again != few
    assert [len(thing["geometry"]) for part in again for thing in part["CityObjects"].values()] == [2] * len(few)


def points_of(feature: Feature, level: str) -> list:
    """The rings of a level as points."""
    surfaces = surfaces_of(geometry_of(feature, level))
    return [[[feature["vertices"][row] for row in ring] for ring in surface] for surface in surfaces]
