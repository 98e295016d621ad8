"""Files of tree intensities: round trips, and strangers' files."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.city.tree_file import MAX_BYTES, parse_trees, read_trees, save_trees, trees_text
from grammarlab.city.tree_intensity import TreeIntensity
from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.frame import Frame
from tests.city.test_zone_file import JSON

POINTS = np.random.default_rng(0).uniform(-2000, 2000, (50, 2))


def intensity(places: int = 5, species: int = 3) -> TreeIntensity:
    rng = np.random.default_rng(1)
    return TreeIntensity(
        species=tuple(f"sorte {number} Ü" for number in range(species)),
        frame=Frame("EPSG:32631", (448000.0, 5412000.0)),
        intercept=rng.normal(size=species).round(6),
        places=rng.uniform(0, 2, (places, 2)).round(6),
        weights=rng.normal(0, 100, (places, species)).round(6),
        length=rng.uniform(0.1, 2, species).round(6),
        trees="0f" * 32,
    )


def values(**changes: Any) -> bytes:
    return json.dumps({**json.loads(trees_text(intensity())), **changes}).encode()


@pytest.mark.parametrize("places", [0, 5])
def test_an_intensity_is_read_as_it_was_written(tmp_path: Path, places: int):
    model = intensity(places)
    save_trees(model, tmp_path / "a.trees.json")
    text = read_trees(tmp_path / "a.trees.json")
    again = parse_trees(text.encode())
    np.testing.assert_array_equal(again.at(POINTS), model.at(POINTS))
    assert trees_text(again) == text == trees_text(model)
    assert (again.species, again.frame, again.trees) == (model.species, model.frame, model.trees)


def test_a_file_of_the_largest_intensity_is_below_the_limit():
    assert len(trees_text(intensity(64, 32)).encode()) < MAX_BYTES


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "this is not valid JSON"),
        (values(format="grammarlab zones"), "format: expected 'grammarlab trees', found 'grammarlab zones'"),
        (values(version=9), "version: expected 1, found 9"),
        (values(species=[]), "species: expected different names"),
        (values(species=["oak", "oak", "lime"]), "species: expected different names, found 'oak, oak, lime'"),
        (values(species=["oak"]), r"kernel.lengths: expected 1 numbers, found a list of 3"),
        (values(kernel={"kind": "rbf"}), "kernel.kind: expected 'matern 3/2', found 'rbf'"),
        (values(kernel={"kind": "matern 3/2", "lengths": [1, 0, 1]}), "kernel.lengths: expected numbers > 0, found 0"),
        (values(weights=[[0, 0, 0]] * 4), "weights: expected 5 rows, found 4"),
        (values(trees="x"), "trees: expected 64 hexadecimal digits, found 'x'"),
    ],
)
def test_a_file_of_a_stranger_is_refused_with_the_place_of_the_mistake(tmp_path: Path, content: bytes, message: str):
    file = tmp_path / "a.trees.json"
    file.write_bytes(content)
    with pytest.raises(AssetError, match=re.escape(str(file)) + ": .*" + message):
        read_trees(file)


def test_large_and_missing_files_are_refused(tmp_path: Path):
    (tmp_path / "a.trees.json").write_bytes(b" " * (MAX_BYTES + 1))
    with pytest.raises(AssetError, match="expected at most 100,000 bytes"):
        read_trees(tmp_path / "a.trees.json")
    with pytest.raises(AssetError, match="city learn --trees"):
        read_trees(tmp_path / "b.trees.json")


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(sorted(json.loads(trees_text(intensity())))), JSON)
def test_any_value_in_place_of_a_right_one_is_read_or_refused(key: str, value: Any):
    try:
        model = parse_trees(values(**{key: value}))
    except AssetError:
        return
    assert np.isfinite(model.at(POINTS)).all()
