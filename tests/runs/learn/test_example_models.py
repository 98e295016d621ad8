"""Finished models from anybody: read as they were written, or refused with a reason."""

import json
import shutil

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.derivation.selection import join_forests
from grammarlab.errors import AssetError, UsageError
from grammarlab.language.grammar import Grammar
from grammarlab.runs.learn import example_models as module
from grammarlab.runs.learn.example_models import example_models
from grammarlab.runs.learn.from_examples import learn_from_files
from grammarlab.runs.sample.derivations import save_forest
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.run import sample_run

RULES = """version "2023.0"
attr height = rand(3, 9)
Lot --> extrude(height) split(y) { ~1 : Part | ~1 : Part }
Part --> 50% : color("#ff0000") Wall else : color("#0000ff") Wall
Wall --> 20% : Glass. 30% : Brick. else : [ Stone. ] Stone.
"""
GRAMMAR = Grammar.parse(RULES)


@pytest.fixture
def folder(tmp_path):
    save_forest(derive(GRAMMAR, 40, 3), tmp_path / "derivations" / "00000")
    save_forest(derive(GRAMMAR, 8, 3, first_model=40), tmp_path / "derivations" / "00001")
    return tmp_path


def same_trees(one, other):
    for name in ("model", "parent", "symbol", "rule", "child", "repeat"):
        np.testing.assert_array_equal(getattr(one.nodes, name), getattr(other.nodes, name))
    assert (one.num_models, one.symbols, one.rules, one.sites) == (
        other.num_models,
        other.symbols,
        other.rules,
        other.sites,
    )


def test_what_was_sampled_is_read_again_from_every_folder(folder):
    last = derive(GRAMMAR, 8, 3, first_model=40)
    whole = join_forests([derive(GRAMMAR, 40, 3), last])
    for place in (folder, folder / "derivations"):
        found = example_models(place, GRAMMAR)
        same_trees(found, whole)
        np.testing.assert_array_equal(found.draws.value, whole.draws.value)
        np.testing.assert_array_equal(found.log_probability(), whole.log_probability())
    for place in ("", "nodes.parquet", "draws.parquet"):
        same_trees(example_models(folder / "derivations" / "00001" / place, GRAMMAR), last)


def test_the_unfinished_folder_of_a_killed_batch_is_not_read(folder):
    batches = folder / "derivations"
    shutil.copytree(batches / "00001", batches / ".part-0123456789abcdef")
    assert example_models(folder, GRAMMAR).num_models == 48


def test_a_table_of_nodes_alone_is_numbered_as_the_grammar_is(folder, tmp_path):
    (tmp_path / "forest.parquet").write_bytes((folder / "derivations" / "00000" / "nodes.parquet").read_bytes())
    found = example_models(tmp_path / "forest.parquet", GRAMMAR)
    same_trees(found, derive(GRAMMAR, 40, 3))
    assert not len(found.draws.node)


def test_rules_may_stand_in_other_lines_with_other_percentages(folder):
    moved = Grammar.parse("\n\n" + RULES.replace("20%", "70%"))
    found = example_models(folder, moved)
    assert found.num_models == 48
    assert [rule.line for rule in found.rules] == [rule.line + 2 for rule in derive(GRAMMAR, 1, 3).rules]


@pytest.mark.parametrize(
    "rules",
    [
        "Lot --> 50% : A else : B",
        RULES.replace("Brick.", "Timber."),
        RULES.replace("20% : Glass. 30% : Brick.", "20% : Brick. 30% : Glass."),
        RULES.replace("20% : Glass. 30% : Brick. else", "50% : Glass. else"),
        RULES.replace("Lot -->", "Plot -->"),
        RULES.replace("Lot -->", "Plot --> Lot\nLot -->"),
    ],
)
def test_models_of_another_grammar_are_refused(folder, rules):
    with pytest.raises(UsageError, match="not models of this grammar"):
        example_models(folder, Grammar.parse(rules))


def rewrite(path, **changes):
    """Changes some columns of a table."""
    table = pq.read_table(path)
    for name, change in changes.items():
        column = table.column(name).to_numpy().copy()
        table = table.set_column(table.column_names.index(name), name, pa.array(change(column)))
    pq.write_table(table, path)


def filled(value):
    return lambda column: np.full_like(column, value)


def put(place, value):
    def change(column):
        column[place] = value
        return column

    return change


@pytest.mark.parametrize(
    ("column", "change"),
    [
        ("model", filled(-1)),
        ("model", put(3, 10_000)),
        ("model", put(0, 1)),
        ("parent", put(1, 1)),
        ("parent", put(0, 2_000_000_000)),
        ("parent", put(5, -7)),
        ("parent", put(50, -1)),
        ("symbol", filled(30_000)),
        ("rule", put(2, 30_000)),
        ("rule", put(2, -2)),
        ("repeat", put(2, -1)),
        ("symbol", lambda column: column.astype(np.float64)),
        ("symbol", lambda column: [None] * len(column)),
        ("symbol", lambda column: [[1]] * len(column)),
    ],
)
def test_damaged_nodes_are_refused(folder, column, change):
    rewrite(folder / "derivations" / "00000" / "nodes.parquet", **{column: change})
    with pytest.raises(AssetError, match=r"nodes\.parquet: these derivations are damaged"):
        example_models(folder, GRAMMAR)


@pytest.mark.parametrize(
    ("column", "change"),
    [
        ("child", put(50, 9)),
        ("child", put(50, -1)),
        ("child", put(50, 32_767)),
        ("rule", put(0, -1)),
        ("rule", put(0, 2)),
    ],
)
def test_trees_that_no_rule_makes_are_refused(folder, column, change):
    rewrite(folder / "derivations" / "00000" / "nodes.parquet", **{column: change})
    with pytest.raises(UsageError, match="not models of this grammar"):
        example_models(folder, GRAMMAR)


@pytest.mark.parametrize(
    ("column", "change"),
    [
        ("node", filled(2_000_000)),
        ("site", filled(-1)),
        ("value", filled(np.nan)),
        ("value", filled(0.5)),
        ("log_density", filled(np.nan)),
    ],
)
def test_damaged_draws_are_refused(folder, column, change):
    rewrite(folder / "derivations" / "00000" / "draws.parquet", **{column: change})
    with pytest.raises(AssetError, match="damaged"):
        example_models(folder, GRAMMAR)


@pytest.mark.parametrize(
    "header",
    [
        b"",
        b"\xff",
        b"[" * 100_000,
        b"[]",
        b"{}",
        b'{"num_models": -1, "symbols": [], "rules": [], "sites": []}',
        b'{"num_models": 1e9, "symbols": [], "rules": [], "sites": []}',
        b'{"num_models": 40, "symbols": 7, "rules": [], "sites": []}',
        b'{"num_models": 40, "symbols": [], "rules": [[]], "sites": []}',
        b'{"num_models": 40, "symbols": [], "rules": [["A", 0, [[1]]]], "sites": []}',
        b'{"num_models": 40, "symbols": [], "rules": [["A", [], [1]]], "sites": []}',
    ],
)
def test_hostile_headers_are_refused(folder, header):
    (folder / "derivations" / "00000" / "forest.json").write_bytes(header)
    with pytest.raises(AssetError, match="damaged"):
        example_models(folder, GRAMMAR)


def test_hostile_tables_are_refused(folder):
    nodes = folder / "derivations" / "00000" / "nodes.parquet"
    for data in (b"", b"PAR1", nodes.read_bytes()[:-20], b"x" * 1_000):
        nodes.write_bytes(data)
        with pytest.raises(AssetError, match="damaged"):
            example_models(folder, GRAMMAR)


def test_too_much_is_refused(folder, monkeypatch):
    monkeypatch.setattr(module, "MAX_MODELS", 45)
    with pytest.raises(AssetError, match="48 models"):
        example_models(folder, GRAMMAR)
    monkeypatch.setattr(module, "MAX_ROWS", 30)
    with pytest.raises(AssetError, match="more than 30 rows"):
        example_models(folder, GRAMMAR)


def test_places_without_derivations_are_told(tmp_path):
    with pytest.raises(UsageError, match="no examples at"):
        example_models(tmp_path / "nowhere", GRAMMAR)
    with pytest.raises(UsageError, match="found none"):
        example_models(tmp_path, GRAMMAR)
    (tmp_path / "models.csv").write_text("a")
    with pytest.raises(UsageError, match="a Parquet file"):
        example_models(tmp_path / "models.csv", GRAMMAR)


def test_sites_of_the_first_version_are_left_out(folder):
    header = folder / "derivations" / "00000" / "forest.json"
    values = json.loads(header.read_text())
    header.write_text(json.dumps(values | {"sites": ["rand (line 2)"] * len(values["sites"])}))
    found = example_models(folder / "derivations" / "00000", GRAMMAR)
    assert not len(found.draws.node)


def test_examples_are_chosen_by_the_numbers_of_models(folder, tmp_path):
    (tmp_path / "house.cga").write_text(RULES)
    result = learn_from_files(str(tmp_path / "house.cga"), folder, tmp_path / "new.cga", models="3, 41-43,41")
    assert (result.num_examples, result.held_out) == (4, None)
    for models, message in (("48", "models 0 to 47"), ("5-3", "smaller number first"), ("first", "such as 3,7,9-12")):
        with pytest.raises(UsageError, match=message):
            learn_from_files(str(tmp_path / "house.cga"), folder, tmp_path / "new.cga", models=models)
    request = SampleRequest(
        name="house", text=RULES, assets=tmp_path, num_models=48, seed=3, models=(3, 41, 42, 43, 44), image=False
    )
    some = sample_run(request, tmp_path / "some")
    again = learn_from_files(str(tmp_path / "house.cga"), some.folder, tmp_path / "again.cga", models="3, 41-43")
    assert again.learned.text == result.learned.text.replace(folder.name, some.folder.name)
    with pytest.raises(UsageError, match="has no model 40, only some of its run"):
        learn_from_files(str(tmp_path / "house.cga"), some.folder, tmp_path / "again.cga", models="40-41")
    shutil.rmtree(folder / "derivations" / "00000")
    with pytest.raises(UsageError, match="sample --resume"):
        learn_from_files(str(tmp_path / "house.cga"), folder, tmp_path / "new.cga", models="3")
