"""Tables of features against enumeration by hand and against patterns."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import derive, derive_chunks
from grammarlab.errors import UsageError
from grammarlab.features.columns import vocabulary as vocabularies
from grammarlab.features.columns.feature_table import distinguishable
from grammarlab.features.columns.paths import count_paths, count_sequences
from grammarlab.features.columns.vocabulary import Options, Vocabulary, extract
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.node_labels import KeyIndex, NodeLabels
from grammarlab.features.patterns.pattern import Draw, Pattern, Present, Threshold
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.features.patterns.tree_index import Trees
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from tests.features.forests import RULES, forest_of, random_forest
from tests.whole_grammars import WHOLE

SEEDS = st.integers(0, 2**32)
EVERYTHING = Options(3, far_pairs=True, adjacent_pairs=True)
GRAMMARS = Path(__file__).parents[2] / "grammars"
TOWERS = """
attr height = rand(3, 9)
Lot --> extrude(height) Tower Ground
Tower --> 50% : Block Block Crown  30% : Block Crown  else : Block Block Block Crown
Block --> 40% : Box  else : i("builtin:cylinder") Glass
Glass --> 30% : color("#ff0000") Pane
  30% : color("#00ff00") Pane  else : Pane
Crown --> 50% : Mast else : NIL
Ground --> split(x) { ~1.1 : Shop }*
Shop --> 1% : Red else : Blue
"""


def paths_by_hand(forest, length, rows=None):
    """For every path, how often each model has it: node by node, one ancestor after the other."""
    nodes = forest.nodes
    found = Counter()
    for row in range(len(nodes)) if rows is None else rows:
        model, rule = int(nodes.model[row]), int(nodes.rule[row])
        end = () if rule < 0 else ((rule, -1),)
        above, edges = row, ()
        for edge in range(length + 1):
            if edges:
                found[model, edges] += 1
            if end and edge < length:
                found[model, edges + end] += 1
            parent = int(nodes.parent[above])
            if parent < 0:
                break
            edges = ((int(nodes.rule[parent]), int(nodes.child[above])), *edges)
            above = parent
    return found


@given(SEEDS, st.integers(1, 3), st.integers(2, 8), st.floats(0, 1))
def test_successors_are_those_of_all_edges(seed, num_models, nodes_per_model, depth):
    forest = random_forest(np.random.default_rng(seed), num_models, nodes_per_model, depth)
    labels = NodeLabels.of([forest])
    nodes = forest.nodes
    edges = {
        (int(nodes.rule[parent]), int(nodes.child[row]), forest.symbols[nodes.symbol[row]])
        for row, parent in enumerate(nodes.parent.tolist())
        if parent >= 0
    }
    rows = [(rule, child, symbol) for rule, part in enumerate(labels.successors) for child, symbol in part.items()]
    assert {edge[:2] for edge in edges} == {row[:2] for row in rows}
    assert set(rows) <= edges


def test_successors_of_a_batch_hold_those_of_each_model():
    # Root and remainder have one symbol and one place, and the rule of the last node is that of the root.
    grammar = Grammar.parse("Lot --> setback(1) { all : NIL | remainder : Lot }")
    batch = NodeLabels.of([derive(grammar, num_models=4, seed=1)]).successors
    for num in range(1, 4):
        assert NodeLabels.of([derive(grammar, num_models=num, seed=1)]).successors == batch == ({0: "Lot"},)


@given(SEEDS, st.integers(1, 6), st.floats(0, 1))
def test_all_paths_are_counted(seed, length, depth):
    forest = random_forest(np.random.default_rng(seed), 3, 15, depth)
    labels, index = NodeLabels.of([forest]), KeyIndex()
    counts = count_paths(count_sequences(Trees(forest), labels, length, index, grow=True), len(index)).counts.toarray()
    meaning = vocabularies.Meaning(labels, index.keys, ())
    found = {
        (model, meaning.steps(index.keys[column])): counts[model, column] for model, column in np.argwhere(counts > 0)
    }
    assert found == paths_by_hand(forest, length)


@given(SEEDS, st.integers(1, 4), st.floats(0, 1))
def test_paths_that_geometry_repeats_are_told(seed, length, depth):
    forest = random_forest(np.random.default_rng(seed), 3, 15, depth)
    labels, index = NodeLabels.of([forest]), KeyIndex()
    repeated = count_paths(count_sequences(Trees(forest), labels, length, index, grow=True), len(index)).repeated
    meaning = vocabularies.Meaning(labels, index.keys, ())
    rows = []
    for row, parent in enumerate(forest.nodes.parent):
        if forest.nodes.repeat[row] > 0 or parent in rows:
            rows.append(row)
    paths = {path for _, path in paths_by_hand(forest, length, rows)}
    assert {meaning.steps(index.keys[column]) for column in np.flatnonzero(repeated)} == paths


@given(SEEDS, st.integers(1, 4), st.floats(0, 1), st.integers(0, len(RULES) - 1))
def test_known_paths_are_counted_among_others(seed, length, depth, other):
    rng = np.random.default_rng(seed)
    forest, new = random_forest(rng, 3, 15, depth), random_forest(rng, 4, 15, depth)
    labels, index = NodeLabels.of([forest]), KeyIndex()
    count_sequences(Trees(forest), labels, length, index, grow=True)
    unknown = replace(RULES[other], symbol="Other")
    new = replace(new, rules=(*RULES[:other], unknown, *RULES[other + 1 :]), symbols=("A", "B", "Other"))
    counts = count_paths(count_sequences(Trees(new), labels, length, index, grow=False), len(index)).counts.toarray()
    found = paths_by_hand(new, length)
    meaning = vocabularies.Meaning(labels, index.keys, ())
    for column, key in enumerate(index.keys):
        steps = meaning.steps(key)
        known = all(rule != other for rule, _ in steps)
        assert counts[:, column].tolist() == [found[model, steps] * known for model in range(4)]


def features_of_all_keys(vocabulary):
    meaning = vocabularies.Meaning(vocabulary.labels, vocabulary.index.keys, vocabulary.options.extra)
    return [meaning.feature(key) for key in vocabulary.index.keys]


@given(SEEDS, st.floats(0, 1))
def test_every_column_met_holds_what_its_feature_counts(seed, depth):
    forest = random_forest(np.random.default_rng(seed), 3, 15, depth)
    vocabulary = Vocabulary.find(forest, EVERYTHING)
    counts = vocabularies._collect(forest, vocabulary.labels, EVERYTHING, vocabulary.index, grow=False).counts
    np.testing.assert_allclose(counts.toarray(), count(forest, features_of_all_keys(vocabulary)), rtol=1e-15)


@given(SEEDS, st.floats(0, 1), st.sampled_from(["present", "count"]))
def test_a_table_holds_what_its_features_count_on_new_models_too(seed, depth, repeats):
    rng = np.random.default_rng(seed)
    forest, other = random_forest(rng, 6, 12, depth), random_forest(rng, 4, 14, depth)
    options = Options(
        2, far_pairs=True, adjacent_pairs=True, repeats=repeats, extra=(parse("A[A + B]"), Threshold("h", 1.5))
    )
    vocabulary = Vocabulary.find(forest, options)
    for models in (forest, other):
        table = vocabulary.apply(models)
        np.testing.assert_allclose(table.counts.toarray(), count(models, table.features), rtol=1e-15)
    assert extract(forest, options).counts.toarray().tolist() == vocabulary.apply(forest).counts.toarray().tolist()


def towers(num_models, seed=1):
    return derive(Grammar.parse(TOWERS), num_models, seed, footprint=(9.0, 9.0))


def test_batches_make_the_table_of_the_whole():
    whole = extract(towers(200), EVERYTHING)
    parts = list(derive_chunks(Grammar.parse(TOWERS), 200, 1, footprint=(9.0, 9.0), nodes_per_chunk=500))
    assert len(parts) > 3
    table = extract(parts, EVERYTHING)
    assert (table.features, table.names, table.group_names) == (whole.features, whole.names, whole.group_names)
    np.testing.assert_array_equal(table.rows(), whole.rows())
    np.testing.assert_array_equal(table.groups, whole.groups)


def test_a_grammar_with_more_rules_meets_the_same_columns():
    vocabulary = Vocabulary.find(towers(200))
    forest = derive(Grammar.parse("New --> 50% : Old else : NIL\nOld --> Pane " + TOWERS.replace("Mast", "New")), 50, 3)
    table = vocabulary.apply(forest)
    np.testing.assert_allclose(table.counts.toarray(), count(forest, table.features), rtol=1e-15)


def test_columns_that_say_the_same_are_one_and_rules_come_first():
    table = extract(towers(300), Options(1))
    features = [str(feature) for feature in table.features]
    assert [f for f in features if f.startswith("Tower")] == ["Tower:0", "Tower:1", "Tower:2"]
    # Two alternatives say one thing; so do Box and Block:0, Mast and the crown that carries it.
    assert [f for f in features if f.startswith("Crown")] == ["Crown:0"]
    assert not {"Box", "Mast", "Block:0 > *@0"} & set(features)
    # Windows, shops and the like: their number follows from sizes.
    assert [f for f in features if "Shop" in f or "Red" in f] == ["Shop:0 present"]
    assert "Shop:0" in [str(f) for f in extract(towers(300), Options(1, repeats="count")).features]


@given(SEEDS, st.integers(1, 30), st.integers(1, 5), st.integers(0, 5))
def test_columns_kept_differ_and_those_left_out_follow_from_them(seed, width, models, cut):
    values = np.random.default_rng(seed).integers(0, 3, (models, width)).astype(float)
    kept = distinguishable([sparse.csr_array(part) for part in (values[:cut], values[cut:])], np.arange(width))

    def canonical(column):
        centred = values[:, column] - values[0, column]
        return tuple(max(centred.tolist(), (-centred).tolist()))

    zero = (0.0,) * models
    expected = {}
    for column in range(width):
        if canonical(column) != zero:
            expected.setdefault(canonical(column), column)
    assert kept.tolist() == list(expected.values())


def test_names_say_what_a_column_is():
    table = extract(towers(300), Options(2, far_pairs=True, adjacent_pairs=True))
    names = {str(feature): name for feature, name in zip(table.features, table.names, strict=True)}
    groups = {str(f): table.group_names[g] for f, g in zip(table.features, table.groups, strict=True)}
    assert names["Tower:2"] == "Tower → 3 Block"
    assert names["Tower:2 > Block@2:0"] == "Tower (3 Block) › Block 3 → Box"
    assert groups["Tower:2 > Block@2:0"] == "Tower (3 Block) › Block 3"
    assert names["Glass:0"] == "Glass → 30%, line 6"
    assert names["Glass:2"] == "Glass → 40%"
    assert names["Shop:0 present"] == "any Shop → Red"
    assert names["Tower:2 > *@2 >> Glass:0"] == "Tower (3 Block) › Block 3 ⋯ Glass → 30%, line 6"
    assert names["*[Block:0 + Block:1]"] == "Block → Box then Block → Glass"
    assert names["height"] == groups["height"] == "height"
    assert len(set(names.values())) == len(names)


def test_a_branch_has_no_percentage_in_its_name_if_models_differ_in_it():
    rules = "Lot --> Part Part  Part -->\n{}% : Wall(1)\n{}% : Wall(2)\nelse : Wall(3)\nWall(n) --> extrude(n) Box."
    forests = [derive(Grammar.parse(rules.format(*shares)), 60, 1) for shares in ((40, 35), (30, 40))]
    for some, expected in ((forests[:1], {"40%", "35%", "25%"}), (forests, {"line 2", "line 3", "line 4"})):
        table = Vocabulary.find(some, Options(1)).apply(some)
        found = {name.split(" → ")[1] for name in table.names if name.startswith("Part → ")}
        assert found == expected


def test_a_branch_is_named_after_what_it_makes_together_if_no_other_one_makes_that():
    rules = "Lot --> Part Part  Part --> 25% : L R 25% : L 25% : R else : NIL  L --> Stone. R --> Stone."
    table = extract(derive(Grammar.parse(rules), 60, 1), Options(1))
    found = {name.split(" → ")[1] for name in table.names if name.startswith("Part → ")}
    assert found == {"L and R", "only L", "only R", "nothing"}


def test_each_pair_of_adjacent_siblings_is_a_group_of_its_own():
    table = extract(towers(300), Options(1, draws=False, adjacent_pairs=True))
    pairs = [column for column, feature in enumerate(table.features) if " + " in str(feature)]
    assert len(pairs) > 2
    names = [table.names[column].removeprefix("any ") for column in pairs]
    assert [table.group_names[group] for group in table.groups[pairs]] == names
    assert all((table.groups == group).sum() == 1 for group in table.groups[pairs])


def test_alternatives_of_one_choice_in_one_context_share_a_group():
    table = extract(towers(300), Options(2, draws=False))
    members = {}
    for feature, group in zip(table.features, table.groups, strict=True):
        members.setdefault(table.group_names[group], []).append(str(feature))
    assert members["Tower"] == ["Tower:0", "Tower:1", "Tower:2"]
    assert members["Glass"] == ["Glass:0", "Glass:1", "Glass:2"]
    assert len(members) == len(table.group_names) == int(table.groups.max()) + 1


def test_symbols_that_choices_are_between_share_a_group():
    text = """
    Lot --> 50% : Old Roof else : New Roof
    Old --> color("#ff0000") OnOld
    New --> color("#00ff00") OnNew
    OnOld --> 80% : Brick else : Glass
    OnNew --> 20% : Brick 70% : Glass else : Steel
    Brick --> color("#0000ff") Wall
    Roof --> 50% : Flat else : Wall Wall
    """
    table = extract([derive(Grammar.parse(text), 500, seed=1)])
    groups = dict(zip(table.names, (table.group_names[group] for group in table.groups), strict=True))
    materials = "number of Brick / Glass / Steel"
    assert [name for name, group in groups.items() if group == materials] == ["number of Brick", "number of Glass"]
    assert groups["OnOld → Brick"] == "OnOld"
    assert groups["Roof → Flat"] == "Roof"


def test_scales_bring_draws_to_one():
    table = extract(towers(300), Options(1))
    rows = table.rows()
    assert np.ptp(rows[:, table.names.index("height")]) == pytest.approx(1.0)
    assert set(rows[:, table.names.index("Tower → 3 Block")]) == {0.0, 1.0}


def test_draws_of_functions_and_means_are_columns():
    text = "tint = 30% : 1 else : 2\nLot --> extrude(9) split(y) { ~1 : t(rand(1), tint, 0) A | ~1 : t(0, tint, 0) A }"
    table = extract(derive(Grammar.parse(text), 100, 1))
    assert set(table.features) == {Draw("tint", 0), Draw("Lot")}


def test_few_models_and_none():
    empty = extract(towers(1))
    assert (empty.counts.shape, empty.features, empty.groups.tolist()) == ((1, 0), (), [])
    assert extract(forest_of([])).counts.shape == (0, 0)
    assert extract([]).counts.shape == (0, 0)
    vocabulary = Vocabulary.find(towers(100))
    assert vocabulary.apply(forest_of([])).rows().shape == (0, len(vocabulary.features))
    assert not vocabulary.apply(forest_of([], num_models=3)).rows().any()


@pytest.mark.parametrize("length", [0, -1, 21])
def test_lengths_out_of_range_are_refused(length):
    with pytest.raises(UsageError, match="1 to 20"):
        Options(length)


@pytest.mark.parametrize("path", WHOLE, ids=lambda path: path.stem)
def test_tables_of_the_shipped_grammars_hold_what_their_features_count(path):
    grammar, assets = load(path), AssetFolder(GRAMMARS / "assets")
    vocabulary = Vocabulary.find(derive(grammar, 60, 1, assets=assets), Options(3, far_pairs=True, adjacent_pairs=True))
    forest = derive(grammar, 20, 2, assets=assets)
    table = vocabulary.apply(forest)
    counted = count(forest, table.features)
    np.testing.assert_allclose(table.counts.toarray(), counted, rtol=1e-12)
    for feature in table.features:
        inner = feature.feature if isinstance(feature, Present) else feature
        assert not isinstance(inner, Pattern) or parse(str(inner)) == inner
    assert len(set(table.names)) == len(table.names)
