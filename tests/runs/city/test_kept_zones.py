"""A pinned building keeps its seed, model and zone: not a byte changes when zones are drawn or learned again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.city.parcel_addresses import Pins, pinned, rerolled, save_pins
from grammarlab.city.zone_density import ZoneDensity
from grammarlab.city.zone_file import save_zones
from grammarlab.export.cityjson import LEVELS
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.runs.city.build import build_city
from grammarlab.runs.city.parcel_reading import read_parcel_table
from tests.cases import some
from tests.export.cityjson_checks import features_of
from tests.runs.city.plans import boxes, write_plan

ALONE = "alone"
"""A parcel far from all others: the tiles of its shard have its building and no other."""
ZONES = ("west", "rest")


def write_zones(plan: Path, chance: float) -> None:
    """Learned zones with a probability of the first one."""
    density = ZoneDensity(
        zones=ZONES,
        frame=Frame("", (0.0, 0.0)),
        features=(),
        intercept=np.log([chance, 1.0 - chance]),
        slope=np.zeros((0, 2)),
        places=np.zeros((0, 2)),
        weights=np.zeros((0, 2)),
        length=1.0,
        scale=0.0,
        counts=np.zeros((0, 2)),
        offsets=np.zeros((0, 2)),
        answers="0" * 64,
    )
    save_zones(density, plan.parent / "zones.json")


def replace_in(plan: Path, old: str, new: str) -> None:
    text = plan.read_text()
    assert old in text
    plan.write_text(text.replace(old, new))


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    path = write_plan(tmp_path / "plan", {**boxes(), ALONE: shapely.box(5000, 0, 5022, 30)})
    replace_in(path, 'match = { side = "west" }', 'density = "zones.json"')
    write_zones(path, 1e-9)
    return path


CHANGES: dict[str, Callable[[Path], None]] = {
    "learned zones": lambda plan: write_zones(plan, 1.0 - 1e-9),
    "expression": lambda plan: replace_in(plan, 'density = "zones.json"', ""),
    "a zone before": lambda plan: replace_in(
        plan, '[[zones]]\nname = "west"', '[[zones]]\nname = "new"\ngrammar = "rules.cga"\n[[zones]]\nname = "west"'
    ),
}


def building(folder: Path) -> dict[str, object]:
    """All that files have of the building of `ALONE`."""
    rows = read_parcel_table(folder / "parcels.parquet", ids=np.array([ALONE], object))
    (feature,) = [one for one in features_of(folder / "city.city.jsonl") if one["id"] == ALONE]
    tiles = sorted((folder / rows.tile[0]).parent.glob("*.glb"))
    return {
        "address": (rows.zone[0], rows.seed[0], rows.model[0], rows.grammar[0]),
        "feature": feature,
        "tiles": {path.name: path.read_bytes() for path in tiles},
    }


@pytest.mark.parametrize("name", some(list(CHANGES)))
@pytest.mark.parametrize("rerolls", [0, 2])
def test_a_pinned_building_stays_when_its_zone_would_change(plan: Path, tmp_path: Path, name: str, rerolls: int):
    pins = Pins()
    for _ in range(rerolls):
        pins = rerolled(pins, ALONE)
    save_pins(pins, plan.parent / "pins.csv")
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    before = building(tmp_path / "city")
    rows = read_parcel_table(tmp_path / "city" / "parcels.parquet", ids=np.array([ALONE], object))
    seed, model, zone = int(rows.seed[0]), int(rows.model[0]), str(rows.zone[0])
    CHANGES[name](plan)
    build_city(plan, tmp_path / "free", cityjson=LEVELS)
    free = building(tmp_path / "free")
    assert all(free[key] != before[key] for key in before)
    save_pins(pinned(pins, ALONE, seed=seed, model=model, zone=zone), plan.parent / "pins.csv")
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    assert building(tmp_path / "city") == before


def test_a_pinned_building_stays_under_another_seed(plan: Path, tmp_path: Path):
    write_zones(plan, 0.5)
    build_city(plan, tmp_path / "city", cityjson=LEVELS)
    before = building(tmp_path / "city")
    rows = read_parcel_table(tmp_path / "city" / "parcels.parquet", ids=np.array([ALONE], object))
    pins = pinned(Pins(), ALONE, seed=int(rows.seed[0]), model=int(rows.model[0]), zone=str(rows.zone[0]))
    save_pins(pins, plan.parent / "pins.csv")
    zones = set()
    for seed in range(4, 8):
        replace_in(plan, f"seed = {seed - 1}", f"seed = {seed}")
        result = build_city(plan, tmp_path / "city", cityjson=LEVELS)
        assert building(tmp_path / "city") == before
        zones.add(tuple(read_parcel_table(result.table).zone))
    assert len(zones) == 4
