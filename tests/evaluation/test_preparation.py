from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.evaluation import scenario
from grammarlab.learning.agreement import agreement
from grammarlab.learning.flattening import flattened
from grammarlab.evaluation.material import Columns
from grammarlab.evaluation.methods import PAPER_FAMILIES
from grammarlab.evaluation.pool import WIDER
from grammarlab.evaluation.preparation import Source, labelled_program, pool_address, prepare
from grammarlab.language.grammar import Grammar

RULES = """
Lot --> extrude(6) split(y) { ~1 : Block | ~1 : Block }
Block --> 90% : Box else : Round
Box --> 50% : Red. else : Blue.
Round --> 50% : Red. else : Blue.
"""
TEXT = """
name = "tiny"
title = "Round ones"
grammar = "toy"
num_models = 600
preference = "50 * {Round}"
"""


def source(text=TEXT, **changes):
    return Source(replace(scenario.parse(text), **changes), Grammar.parse(RULES), Path())


def round_blocks(forest):
    """[models] how many, counted one by one."""
    counts = np.zeros(forest.num_models)
    for model, symbol in zip(forest.nodes.model, forest.nodes.symbol, strict=True):
        counts[model] += forest.symbols[symbol] == "Round"
    return counts


def test_the_labelled_set_is_that_of_the_seed_with_its_true_scores():
    material = prepare(source(seed=4))
    forest = derive(Grammar.parse(RULES), 600, 4)
    assert np.array_equal(material.scores[:, 0], 50 * round_blocks(forest))
    assert np.array_equal(material.weights, np.ones(600))
    table = material.table(Columns(1))
    assert len(table.labelled) == len(table.pool) == len(material.pool_scores) == 600
    assert table.labelled.shape[1] == table.pool.shape[1] == len(table.groups)
    assert table.groups.max() < len(table.group_names)


def test_the_pool_holds_other_models_and_rare_ones_from_the_flattened_grammar():
    material = prepare(source(num_models=2000))
    plain = material.pool_from_grammar
    assert plain.sum() == 1600
    assert (material.pool_scores[plain] == 100).mean() == pytest.approx(0.01, abs=0.01)
    assert (material.pool_scores[~plain] == 100).mean() == pytest.approx(0.25, abs=0.05)
    assert not np.array_equal(material.scores[:1600], material.pool_scores[plain])


def test_weighted_models_of_both_parts_of_the_pool_stand_for_the_grammar():
    material = prepare(source(num_models=2000))
    liked = material.pool_scores[:, 0] == 100
    assert material.pool_weights.mean() == pytest.approx(1.0, abs=0.05)
    assert (material.pool_weights * liked).mean() == pytest.approx(0.01, abs=0.002)
    assert material.pool_weights.max() <= 1.25
    assert material.pool_weights[liked].max() < material.pool_weights[~liked].max()


def test_a_wider_pool_goes_on_where_the_pool_ends():
    material = prepare(source())
    assert material.wider is not None
    wider = material.wider()
    assert wider is material.wider()
    assert wider.wider is None
    size = len(material.pool_scores)
    assert (~wider.pool_from_grammar).sum() == WIDER * (~material.pool_from_grammar).sum()
    assert np.array_equal(wider.pool_scores[:size], material.pool_scores)
    assert np.array_equal(wider.pool_from_grammar[:size], material.pool_from_grammar)
    assert np.array_equal(wider.scores, material.scores)
    assert wider.pool_weights.mean() == pytest.approx(1.0, abs=0.1)
    last = len(wider.pool_scores) - 1
    flat, seed, index = pool_address(replace(source(), wide=True), last)
    (example,) = wider.examples(np.array([last]))
    again = derive(flattened(Grammar.parse(RULES)).program, 1, seed, first_model=index)
    assert flat
    assert np.array_equal(example.draws.value, again.draws.value)
    assert wider.pool_scores[last, 0] == 50 * round_blocks(again)[0]


def test_equal_rows_have_equal_scores_where_the_features_tell():
    table, material = prepare(source()).table(Columns(1)), prepare(source())
    together = np.concatenate([table.labelled, table.pool])
    scores = np.concatenate([material.scores, material.pool_scores])
    _, kind = np.unique(together, axis=0, return_inverse=True)
    for number in range(kind.max() + 1):
        assert np.ptp(scores[kind == number]) == 0


def test_longer_paths_have_more_columns_and_families_can_be_left_out():
    material = prepare(source())
    assert material.table(Columns(2)).labelled.shape[1] > material.table(Columns(1)).labelled.shape[1]
    with_symbols = source(features=scenario.FeatureOptions(1, ("paths", "draws")))
    without = replace(with_symbols, families=("paths",))
    assert (
        prepare(without).table(Columns(1)).labelled.shape[1]
        <= prepare(with_symbols).table(Columns(1)).labelled.shape[1]
    )


def test_a_method_with_kinds_of_features_of_its_own_looks_at_those():
    offered = source(features=scenario.FeatureOptions(2, ("paths", "siblings")))
    assert offered.feature_options.families == ("paths", "siblings")
    paper = replace(offered, families=PAPER_FAMILIES).feature_options
    assert (paper.path_length, paper.families) == (2, PAPER_FAMILIES)


def test_a_flattened_set_measures_the_same_divergence_with_its_weights():
    plain = prepare(source(num_models=40_000))
    flat = prepare(source(num_models=40_000, draws="flattened", seed=1))
    assert (flat.scores == 100).mean() > 10 * (plain.scores == 100).mean()
    assert flat.js_original == pytest.approx(plain.js_original, abs=0.01)
    program = labelled_program(source(draws="flattened"))
    assert (round_blocks(derive(program, 1000, 1)) == 2).mean() == pytest.approx(0.25, abs=0.05)


def test_a_uniform_base_weighs_each_kind_of_model_by_how_rarely_it_is_drawn():
    material = prepare(source(num_models=20_000, base="uniform"))
    kinds = material.scores[:, 0]
    total = [material.weights[kinds == score].sum() for score in (0, 50, 100)]
    # Each of the two blocks is one of four things: 4, 8 and 4 of the 16 towers have 0, 1 and 2 round blocks.
    assert np.array(total) / sum(total) == pytest.approx([0.25, 0.5, 0.25], abs=0.05)


def test_the_true_scores_are_at_no_distance_from_the_target():
    material = prepare(source(base="uniform", draws="flattened"))
    assert agreement(material.target, material.scores[:, 0], material.weights).js == pytest.approx(0, abs=1e-12)


def test_a_preference_that_no_model_meets_is_refused():
    with pytest.raises(UsageError, match="none of its 600 labelled models"):
        prepare(source(TEXT.replace("50 * {Round}", "{Round} > 2")))


def test_a_preference_about_other_things_is_refused():
    with pytest.raises(UsageError, match="tiny does not fit"):
        prepare(source(TEXT.replace("Round}", "Rounded}")))


def test_what_is_kept_is_not_made_again_and_whatever_matters_changes_its_key():
    kept, made = {}, []

    def keep(key, make):
        if key not in kept:
            made.append(key)
            kept[key] = make()
        return kept[key]

    one = prepare(source(), keep)
    one.table(Columns(1))
    again = prepare(source(title="Another title"), keep)
    assert np.array_equal(again.table(Columns(1)).pool, one.table(Columns(1)).pool)
    assert len(made) == 2
    for changed in (
        source(seed=1),
        source(num_models=599),
        source(base="uniform"),
        source(draws="flattened"),
        source(TEXT.replace("50", "40")),
        replace(source(), grammar=Grammar.parse(RULES.replace("90", "80"))),
    ):
        number = len(made)
        prepare(changed, keep)
        assert len(made) == number + 1
