"""Pins of parcels that a city does not have are named, with the ids that may be meant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grammarlab.city.parcel_addresses import EXCLUDED, Pin, Pins
from grammarlab.city.unknown_pins import nearest_ids, unknown_pins

RANDOM = np.random.default_rng(5)
LETTERS = list("0123456789ABCDEFGHJK")
IDS = np.array(sorted({f"75{''.join(row)}" for row in RANDOM.choice(LETTERS, (20_000, 10)).tolist()}), object)
FILE = Path("pins.csv")


def test_pins_of_parcels_give_no_remark():
    pins = Pins.of([Pin(IDS[0], reroll=1), Pin(IDS[-1], zone=EXCLUDED), Pin(IDS[7], seed=1, model=2, zone="a")])
    assert unknown_pins(pins, IDS, FILE) == []
    assert unknown_pins(Pins(), IDS, FILE) == []


@pytest.mark.parametrize("fixed", [{"reroll": 1}, {"zone": EXCLUDED}, {"seed": 1, "model": 2, "zone": "a"}])
def test_whatever_a_pin_fixes_its_unknown_id_is_named(fixed):
    pins = Pins.of([Pin("of another map", **fixed), Pin(IDS[0], **fixed)])
    (remark,) = unknown_pins(pins, IDS, FILE)
    assert str(remark).startswith("pins.csv: 1 of 2 pins change nothing")
    assert "'of another map'" in remark.reason
    assert IDS[0] not in remark.reason


def damaged(text: str, random: np.random.Generator) -> list[str]:
    """Forms of an id as tables have them by mistake."""
    place = int(random.integers(1, len(text)))
    return [
        f"{text[:place]}{text[place + 1 :]}",
        f"{text[:place]}x{text[place:]}",
        f"{text[:place]}x{text[place + 1 :]}",
        f"{text[: place - 1]}{text[place]}{text[place - 1]}{text[place + 1 :]}",
        text.casefold(),
        f"{text}#1",
        f"000{text}",
        text[3:],
    ]


def test_the_id_that_is_meant_is_the_first_of_the_nearest():
    random = np.random.default_rng(8)
    for meant in random.choice(IDS, 40).tolist():
        known = frozenset(IDS.tolist())
        names = [name for name in damaged(meant, random) if name not in known]
        assert [near[0] for near in nearest_ids(names, IDS.tolist())] == [meant] * len(names)


def test_lost_zeros_and_lost_parts_are_found():
    ids = [*(f"{number:08}" for number in range(0, 500_000, 9)), "lot 7#1", "lot 7#2"]
    zeros, parts = nearest_ids(["123453", "lot 7"], ids)
    assert zeros[0] == "00123453"
    assert sorted(parts) == ["lot 7#1", "lot 7#2"]


def test_nearest_ids_do_not_depend_on_the_order_and_are_few():
    names = [IDS[3][:-1], "nothing like it", IDS[9][1:]]
    found = nearest_ids(names, IDS.tolist())
    assert found == nearest_ids(names, IDS[::-1].tolist())
    assert found[1] == []
    assert all(1 <= len(near) <= 3 for near in (found[0], found[2]))


def test_a_remark_counts_what_it_does_not_name():
    pins = Pins.of([Pin(f"other {number:04}", reroll=1) for number in range(1_500)])
    (remark,) = unknown_pins(pins, IDS, FILE)
    assert "1,500 of 1,500 pins" in remark.reason
    named = [number for number in range(1_500) if f"'other {number:04}'" in remark.reason]
    assert named == [*range(20)]
    assert remark.reason.endswith("and 1,480 more")
    assert unknown_pins(pins, np.array([], object), FILE)[0].reason == remark.reason
