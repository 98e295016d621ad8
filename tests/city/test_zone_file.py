"""Files of zone densities: round trips, and strangers' files."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.city.fields import parcel_fields
from grammarlab.city.zone_density import Feature, ZoneDensity
from grammarlab.city.zone_file import MAX_BYTES, parse_zones, read_zones, save_zones, zones_text
from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.frame import Frame
from tests.city.quarters import quarter


def density(places: int = 5, zones: int = 3) -> ZoneDensity:
    rng = np.random.default_rng(1)
    return ZoneDensity(
        zones=tuple(f"Zone {number} Ü" for number in range(zones)),
        frame=Frame("EPSG:32631", (448000.0, 5412000.0)),
        features=(
            Feature("area", "m²", 5.5, 0.7, is_log=True),
            Feature("distance to a centre", "km", 1.0, 1.0, centre=(0.5, 0.25)),
        ),
        intercept=rng.normal(size=zones).round(6),
        slope=rng.normal(size=(2, zones)).round(6),
        places=rng.uniform(0, 2, (places, 2)).round(6),
        weights=rng.normal(0, 100, (places, zones)).round(6),
        length=0.75,
        scale=1.5,
        counts=rng.integers(0, 99, (places, zones)).astype(np.float64),
        offsets=rng.normal(0, 9, (places, zones)).round(3),
        answers="0f" * 32,
    )


def values(**changes: Any) -> bytes:
    return json.dumps({**json.loads(zones_text(density())), **changes}).encode()


@pytest.mark.parametrize("places", [0, 5])
def test_a_density_is_read_as_it_was_written(tmp_path: Path, places: int):
    model, fields = density(places), parcel_fields(quarter(50))
    save_zones(model, tmp_path / "a.zones.json")
    again = read_zones(tmp_path / "a.zones.json")
    np.testing.assert_array_equal(again.log_odds(fields), model.log_odds(fields))
    assert (again.zones, again.frame, again.features, again.answers) == (
        model.zones,
        model.frame,
        model.features,
        model.answers,
    )
    assert zones_text(again) == zones_text(model)


def test_a_file_of_the_largest_density_is_below_the_limit():
    assert len(zones_text(density(192, 16)).encode()) < MAX_BYTES
    assert len(zones_text(density(96, 32)).encode()) < MAX_BYTES


def test_a_density_that_is_too_large_is_refused(tmp_path: Path):
    with pytest.raises(AssetError, match="expected at most 100,000 bytes, found"):
        save_zones(density(1000, 30), tmp_path / "a.zones.json")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "this is not valid JSON"),
        (b"\xff\xfe\x00", "this is not valid JSON"),
        (b"[" * 90_000, "nested too deep"),
        (b"[1]", "file: expected an object, found a list of 1"),
        (b'{"format": ' + b"9" * 5000 + b"}", "this is not valid JSON"),
        (b"{}", "format: expected a value, found none"),
        (values(format="grammarlab facade"), "format: expected 'grammarlab zones', found 'grammarlab facade'"),
        (values(version=1), "version: expected 2, found 1: learn the file again, or update grammarlab"),
        (values(zones=["a"]), "zones: expected at least two different names, found 'a'"),
        (values(zones=["a", "a", "b"]), "zones: expected at least two different names"),
        (values(zones=["a", "b"]), "intercept: expected 2 numbers, found a list of 3"),
        (values(zones=["a\x1b[31m", "b", "c"]), r"zones\[0\]: expected a line of at most 256"),
        (values(zones=["\ud800", "b", "c"]), r"zones\[0\]: expected a line of at most 256"),
        (values(intercept=[0, 0, float("nan")]), r"intercept\[2\]: expected a number of at most 1e\+09, found nan"),
        (values(intercept=[0, 0, 10**400]), r"intercept\[2\]: expected a number of at most 1e\+09, found an integer"),
        (values(intercept=[0, 0, True]), r"intercept\[2\]: expected a number of at most 1e\+09, found True"),
        (values(slopes=[[0, 0, 0]]), "slopes: expected 2 rows, found 1"),
        (values(weights=[[0, 0]] * 5), r"weights\[0\]: expected 3 numbers, found a list of 2"),
        (values(places=[[0, 0]] * 4), "weights: expected 4 rows, found 5"),
        (values(places="abc"), "places: expected a list of at most 1024, found 'abc'"),
        (values(kernel={"kind": "rbf", "length": 1}), "kernel.kind: expected 'matern 3/2', found 'rbf'"),
        (
            values(kernel={"kind": "matern 3/2", "length": 0, "scale": 1}),
            "kernel.length: expected a number > 0, found 0",
        ),
        (values(features=[{"name": "a"}]), r"features\[0\].unit: expected a value, found none"),
        (
            values(kernel={"kind": "matern 3/2", "length": 1, "scale": -1}),
            "kernel.scale: expected a number from 0 to 100",
        ),
        (values(counts=[[0, -1, 0]] * 5), r"counts: expected numbers from 0 to 1e\+06, found -1"),
        (values(offsets=[]), "offsets: expected 5 rows, found 0"),
        (values(answers="x"), "answers: expected 64 hexadecimal digits, found 'x'"),
    ],
)
def test_a_file_of_a_stranger_is_refused_with_the_place_of_the_mistake(tmp_path: Path, content: bytes, message: str):
    file = tmp_path / "a.zones.json"
    file.write_bytes(content)
    with pytest.raises(AssetError, match=re.escape(str(file)) + ": .*" + message):
        read_zones(file)


def test_large_and_missing_files_are_refused(tmp_path: Path):
    (tmp_path / "a.zones.json").write_bytes(b" " * (MAX_BYTES + 1))
    with pytest.raises(AssetError, match="expected at most 100,000 bytes"):
        read_zones(tmp_path / "a.zones.json")
    with pytest.raises(AssetError, match="city learn"):
        read_zones(tmp_path / "b.zones.json")


LEAVES = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
JSON = st.recursive(
    LEAVES, lambda item: st.lists(item, max_size=4) | st.dictionaries(st.text(max_size=4), item), max_leaves=8
)


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(sorted(json.loads(zones_text(density())))), JSON)
def test_any_value_in_place_of_a_right_one_is_read_or_refused(key: str, value: Any):
    try:
        model = parse_zones(values(**{key: value}))
    except AssetError:
        return
    assert np.isfinite(model.log_odds(parcel_fields(quarter(3)))).all()
