"""Addresses depend on the id of a parcel and on its pin, and on nothing else."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from grammarlab.city.parcel_addresses import (
    EXCLUDED,
    Pin,
    Pins,
    addresses,
    excluded,
    model_indices,
    pinned,
    placed_in,
    read_pins,
    released,
    rerolled,
    save_pins,
)
from grammarlab.errors import AssetError, UsageError

IDS = np.array(["0012", "12", "é", "a,b", 'q"q', "x#1"], object)
SOME = Pins.of([Pin("é", seed=2**64 - 1, model=2**63 + 1), Pin("12", reroll=3, zone="park"), Pin("a,b", zone=EXCLUDED)])


def state(pins: Pins, ids: np.ndarray = IDS) -> dict[str, tuple[object, ...]]:
    """The address of each parcel."""
    table = addresses(ids, 5, pins)
    columns = (table.seed, table.model, table.reroll, table.zone, table.is_excluded)
    return {parcel: tuple(column[row] for column in columns) for row, parcel in enumerate(ids)}


def test_models_are_the_first_eight_bytes_of_the_hash():
    for parcel, reroll in (("0012", 0), ("é", 41)):
        digest = sha256(parcel.encode() + b"\0" + str(reroll).encode()).digest()
        assert model_indices([parcel], np.array([reroll])).tolist() == [int.from_bytes(digest[:8], "big")]


def test_the_address_of_a_parcel_does_not_depend_on_other_parcels():
    whole = state(SOME)
    assert state(SOME, IDS[::-1]) == whole
    assert all(state(SOME, IDS[[row]])[parcel] == whole[parcel] for row, parcel in enumerate(IDS))


def test_a_hundred_thousand_parcels_have_different_models():
    models = model_indices([f"{number:06}" for number in range(100_000)], np.zeros(100_000, np.int64))
    assert len(np.unique(models)) == len(models)


@pytest.mark.parametrize(
    "changed",
    [
        lambda pins: rerolled(pins, "0012"),
        lambda pins: rerolled(pins, "é"),
        lambda pins: pinned(pins, 'q"q', seed=1, model=2, zone="park"),
        lambda pins: placed_in(pins, "x#1", "park"),
        lambda pins: excluded(pins, "12"),
        lambda pins: released(pins, "a,b"),
    ],
)
def test_a_change_of_pins_changes_one_parcel(changed):
    before, after = state(SOME), state(changed(SOME))
    assert sum(before[parcel] != after[parcel] for parcel in IDS) == 1


def test_a_reroll_releases_a_pinned_building_and_keeps_the_zone():
    pins = pinned(SOME, "12", seed=7, model=8, zone="park")
    assert pins.get("12") == Pin("12", 7, 8, 3, "park")
    assert rerolled(pins, "12").get("12") == Pin("12", None, None, 4, "park")
    assert rerolled(excluded(pins, "12"), "12").get("12") == Pin("12", reroll=4)


def test_a_pinned_building_does_not_depend_on_the_seed_of_the_city():
    pins = pinned(Pins(), "12", seed=7, model=8, zone="park")
    for seed in (0, 9):
        table = addresses(IDS[1:2], seed, pins)
        assert (int(table.seed[0]), int(table.model[0])) == (7, 8)


def test_pins_are_written_and_read(tmp_path: Path):
    path = tmp_path / "pins.csv"
    save_pins(SOME, path)
    assert read_pins(path) == SOME
    save_pins(Pins.of(reversed(SOME.rows)), tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == path.read_bytes()


def test_pins_of_a_spreadsheet_are_read(tmp_path: Path):
    path = tmp_path / "pins.csv"
    path.write_bytes("sep=;\r\nZone;ID ;Reroll;note\r\nWohnen; é;2,0;x\r\n;;;\r\nPark;12\r\n".encode("cp1252"))
    assert read_pins(path) == Pins.of([Pin("é", reroll=2, zone="Wohnen"), Pin("12", zone="Park")])
    path.write_bytes(b"")
    assert read_pins(path) == read_pins(tmp_path / "missing.csv") == Pins()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("parcel,seed\n1,2", "missing id"),
        ("id,seed\n1,2\n1,3", r"line 3: parcel '1' has a pin on line 2"),
        ("id,seed\n1,-2", r"line 2: expected seed = a whole number"),
        ("id,model\n1,18446744073709551616", "line 2: expected model"),
        ("id,model\n1,1.8E+19", "line 2: .*lose"),
        ("id,model\n1,1.5", "line 2: expected model"),
        ("seed,id\n1", "line 2: expected the id"),
        ('id,seed\n"1,2', "not valid CSV"),
    ],
)
def test_bad_tables_are_refused_with_their_line(tmp_path: Path, text: str, message: str):
    path = tmp_path / "pins.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(AssetError, match=message):
        read_pins(path)


def test_pins_have_different_ids_and_numbers_in_range():
    with pytest.raises(UsageError, match="different ids"):
        Pins.of([Pin("1"), Pin("1", reroll=1)])
    with pytest.raises(UsageError, match="0 <= model"):
        pinned(Pins(), "1", seed=0, model=2**64, zone="park")
    for zone in ("", EXCLUDED):
        with pytest.raises(UsageError, match="the zone of the building"):
            pinned(Pins(), "1", seed=0, model=0, zone=zone)
