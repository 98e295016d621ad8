"""Forests on disk."""

import copy
import json
import os
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.derivation.forest import Forest
from grammarlab.errors import AssetError
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.derivations import load_forest, save_forest
from tests.runs.forests import assert_same, random_forest


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 5), st.integers(1, 60), st.integers(0, 40), st.integers(0, 40))
def test_a_forest_comes_back_to_the_last_bit_and_is_left_untouched(
    tmp_path_factory, seed, models, nodes, leaves, draws
):
    forest = random_forest(np.random.default_rng(seed), models, nodes, leaves, draws)
    before = copy.deepcopy(forest)
    folder = tmp_path_factory.mktemp("forest") / "derivations"
    save_forest(forest, folder)
    assert_same(forest, before)
    assert_same(load_forest(folder), forest)


def test_other_programs_read_the_columns(tmp_path):
    forest = random_forest(np.random.default_rng(1), 3, 50, 20, 30)
    save_forest(forest, tmp_path / "d")
    draws = pq.read_table(tmp_path / "d" / "draws.parquet").to_pydict()
    assert draws["log_density"] == forest.draws.log_density.tolist()
    assert (
        pq.read_table(tmp_path / "d" / "leaves.parquet").column("position")[3].as_py()
        == forest.leaves.position[3].tolist()
    )


def test_equal_forests_make_equal_files(tmp_path):
    for name in "ab":
        save_forest(random_forest(np.random.default_rng(7), 3, 50, 20, 30), tmp_path / name)
    for file in (tmp_path / "a").iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes(), file.name


def test_saving_again_replaces_the_tables_and_no_file_of_another_name(tmp_path):
    save_forest(random_forest(np.random.default_rng(1), 3, 50, 20, 30), tmp_path / "d")
    (tmp_path / "d" / "notes.txt").write_text("mine")
    second = random_forest(np.random.default_rng(2), 1, 5, 2, 3)
    save_forest(second, tmp_path / "d")
    assert_same(load_forest(tmp_path / "d"), second)
    assert [p.name for p in tmp_path.iterdir()] == ["d"]
    assert (tmp_path / "d" / "notes.txt").read_text() == "mine"


@pytest.fixture
def saved(tmp_path):
    save_forest(random_forest(np.random.default_rng(1), 3, 50, 20, 30), tmp_path / "d")
    return tmp_path / "d"


def test_a_missing_table_is_named(saved):
    (saved / "draws.parquet").unlink()
    with pytest.raises(AssetError, match=r"draws\.parquet is missing"):
        load_forest(saved)


@pytest.mark.parametrize("name", ["forest.json", "nodes.parquet", "meshes.parquet", "materials.parquet"])
@pytest.mark.parametrize("damage", [b"", b"PAR1", b"{}", b"[1]", b"[" * 100_000])
def test_damage_is_reported(saved, name, damage):
    (saved / name).write_bytes(damage)
    with pytest.raises(AssetError, match="damaged"):
        load_forest(saved)


def test_a_later_format_is_refused(saved):
    header = json.loads((saved / "forest.json").read_text())
    (saved / "forest.json").write_text(json.dumps({**header, "format": 99}))
    with pytest.raises(AssetError, match="found format 99"):
        load_forest(saved)


ADDRESSES = {"seed": 5, "first_model": 7, "num_models": 3}
"""What headers held before there were lots."""


def test_a_stored_forest_of_the_third_format_is_what_its_grammar_derives_today():
    data = Path(__file__).parents[1] / "data"
    derived = derive(Grammar.parse((data / "format-3.cga").read_text()), 3, 5, first_model=7)
    stored = load_forest(data / "format-3")
    # Since then, faces of extruded shapes and roofs have another order, roofs are sheets that share no points, and
    # equal meshes are one.
    assert solids_of(stored) == solids_of(derived)
    leaves = replace(stored.leaves, mesh=derived.leaves.mesh)
    same = replace(derived, prints=(), missing_assets=())
    assert_same(replace(stored, meshes=derived.meshes, leaves=leaves), same)


def solids_of(forest: Forest) -> list[Counter[tuple[tuple[float, ...], ...]]]:
    """For each leaf the faces of its mesh in any order: the points of each, from its least one on."""
    meshes = forest.meshes
    point = meshes.corners + np.repeat(meshes.mesh_points[:-1], np.diff(meshes.face_offsets[meshes.mesh_faces]))
    rings = [list(map(tuple, ring.tolist())) for ring in np.split(meshes.points[point], meshes.face_offsets[1:-1])]
    turned = [tuple(ring[(first := ring.index(min(ring))) :] + ring[:first]) for ring in rings]
    faces = [Counter(turned[first:end]) for first, end in pairwise(meshes.mesh_faces.tolist())]
    return [faces[mesh] for mesh in forest.leaves.mesh.tolist()]


@pytest.mark.parametrize(
    ("file", "column", "value"),
    [
        ("lots", "footprint", 3),
        ("lots", "start_rule", -1),
        ("lots", "model", None),
        ("lots", "seed", None),
        ("footprints", "points", None),
    ],
)
def test_lots_that_point_nowhere_are_damage(saved, file, column, value):
    table = pq.read_table(saved / f"{file}.parquet")
    place, values = table.column_names.index(column), [value] * len(table)
    table = table.set_column(place, column, pa.array(values, type=table.schema.field(column).type))
    pq.write_table(table, saved / f"{file}.parquet")
    with pytest.raises(AssetError, match="damaged"):
        load_forest(saved)


def test_the_first_format_is_still_read(saved):
    header = json.loads((saved / "forest.json").read_text())
    header |= {"format": 1, **ADDRESSES, "sites": ["choice of 3 (line 12)", "rand (line 4)"]}
    (saved / "forest.json").write_text(json.dumps(header))
    sites = load_forest(saved).sites
    assert [(site.kind, site.line, site.choices) for site in sites] == [("choice", 12, 3), ("uniform", 4, 0)]
    (saved / "forest.json").write_text(json.dumps(header | {"sites": ["dice"]}))
    with pytest.raises(AssetError, match="damaged"):
        load_forest(saved)


@pytest.mark.parametrize("version", [1, 2])
def test_formats_without_texture_coordinates_are_still_read(tmp_path, version):
    forest = random_forest(np.random.default_rng(1), 3, 50, 20, 30)
    save_forest(forest, tmp_path / "d")
    (tmp_path / "d" / "maps.parquet").unlink()
    leaves = pq.read_table(tmp_path / "d" / "leaves.parquet").drop_columns("texture_map")
    pq.write_table(leaves, tmp_path / "d" / "leaves.parquet")
    header = json.loads((tmp_path / "d" / "forest.json").read_text())
    with pytest.raises(AssetError, match=r"maps\.parquet is missing"):
        load_forest(tmp_path / "d")
    (tmp_path / "d" / "forest.json").write_text(json.dumps({**header, **ADDRESSES, "format": version, "sites": []}))
    read = load_forest(tmp_path / "d")
    assert (read.leaves.texture_map == -1).all()
    np.testing.assert_array_equal(read.leaves.mesh, forest.leaves.mesh)


def test_a_folder_may_have_a_name_that_is_no_text_and_no_table_of_arrow(tmp_path):
    forest = random_forest(np.random.default_rng(5), 2, 9, 4, 4)
    for name in (b"b\xff", b"s3:\xff", b"seed=7"):
        folder = tmp_path / os.fsdecode(name)
        try:
            folder.mkdir()
        except OSError:  # a file system of Unicode names
            continue
        save_forest(forest, folder)
        assert_same(load_forest(folder), forest)
