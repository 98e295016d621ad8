from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.evaluation import protocol, scenario
from grammarlab.evaluation.methods import METHODS, PAPER_FAMILIES, Method, methods_of
from grammarlab.evaluation.preparation import Source, prepare
from grammarlab.features.patterns.pattern import Formula
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.round import init
from grammarlab.learning.settings import FeatureOptions, Settings
from grammarlab.learning.targets.divergence import agreement
from tests.cases import takes_turns

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
DRAWN = """
attr h = rand(1, 9)
attr w = rand(1, 9)
Lot --> s(w, 0, w) extrude(h) split(y) { ~1 : Block | ~1 : Block }
Block --> 50% : A else : B
A --> Red.
B --> 50% : Red. else : Blue.
"""
PATHS = Settings(FeatureOptions(1, ("paths",)))


def source(text=TEXT, rules=RULES, **changes):
    return Source(replace(scenario.parse(text), **changes), GrammarSpace(Grammar.parse(rules), Path()))


def round_blocks(forest):
    """[models] how many, counted one by one."""
    counts = np.zeros(forest.num_models)
    for model, symbol in zip(forest.nodes.model, forest.nodes.symbol, strict=True):
        counts[model] += forest.symbols[symbol] == "Round"
    return counts


def test_the_labelled_set_is_that_of_the_seed_with_its_true_scores():
    material = prepare(source(seed=4), PATHS)
    forest = derive(Grammar.parse(RULES), 600, 4)
    assert np.array_equal(material.scores[:, 0], 50 * round_blocks(forest))
    assert np.array_equal(material.weights, np.ones(600))
    table = material.study.table(init(material.study))
    assert len(table.others) == len(table.rows) == len(material.study.pool) == 600
    assert table.others.shape[1] == table.rows.shape[1] == len(table.groups)
    assert table.groups.max() < len(table.group_names)


def test_the_pool_and_the_labelled_set_are_different_models():
    material = prepare(source(num_models=2000), PATHS)
    pool = material.true_scores(list(material.study.pool)[:1600])
    assert not np.array_equal(material.scores[:1600], pool)
    assert (pool == 100).mean() == pytest.approx(0.01, abs=0.01)


def test_each_person_has_a_pool_and_a_labelled_set_that_follow_from_both_seeds():
    persons = [source(seed=own).for_person(seed) for own in (0, 1) for seed in (0, 1, 2**64 - 1)]
    seeds = [seed for person in persons for seed in (person.scenario.seed, *person.pool.seeds)]
    own = source()
    assert len({*seeds, own.scenario.seed, *own.pool.seeds}) == len(seeds) + 3
    assert persons[1].scenario == source(seed=0).for_person(1).scenario
    assert len(persons[0].pool) == len(own.pool)


def test_a_model_may_be_asked_about_more_than_once():
    material = prepare(source(TEXT.replace("50 * {Round}", "30 * {Round} + 7 * {Red.}")), PATHS)
    first, second, *_ = material.study.pool
    one, two = (material.true_scores([address])[0, 0] for address in (first, second))
    assert one != two
    assert material.true_scores([first, first, second, second])[:, 0].tolist() == [one, one, two, two]


def test_equal_rows_have_equal_scores_where_the_features_tell():
    material = prepare(source(), PATHS)
    table = material.study.table(init(material.study))
    together = np.concatenate([table.others, table.rows])
    scores = np.concatenate([material.scores, material.true_scores(list(material.study.pool))])
    _, kind = np.unique(together, axis=0, return_inverse=True)
    for number in range(kind.max() + 1):
        assert np.ptp(scores[kind.ravel() == number]) == 0


def test_the_default_learns_alike_from_everybody_and_baselines_as_they_are_told():
    offered = FeatureOptions(2, ("paths", "siblings"))
    assert METHODS["default"].settings(offered) == Settings()
    assert Method("other", fit="paper").settings(offered).features == offered
    paper = METHODS["paper"].settings(offered)
    assert (paper.features.path_length, paper.features.families) == (2, PAPER_FAMILIES)
    assert (METHODS["default"].settings(offered).warm, paper.warm) == (False, True)


def test_a_flattened_set_measures_the_same_divergence_with_its_weights():
    plain = prepare(source(num_models=40_000), PATHS)
    flat = prepare(source(num_models=40_000, draws="flattened", seed=1), PATHS)
    assert (flat.scores == 100).mean() > 10 * (plain.scores == 100).mean()
    assert flat.js_original == pytest.approx(plain.js_original, abs=0.01)
    assert (flat.scores[:, 0] == 100).mean() == pytest.approx(0.25, abs=0.05)


def test_a_uniform_base_weighs_each_kind_of_model_by_how_rarely_it_is_drawn():
    material = prepare(source(num_models=20_000, base="uniform"), PATHS)
    kinds = material.scores[:, 0]
    total = [material.weights[kinds == score].sum() for score in (0, 50, 100)]
    # Each of the two blocks is one of four things: 4, 8 and 4 of the 16 towers have 0, 1 and 2 round blocks.
    assert np.array(total) / sum(total) == pytest.approx([0.25, 0.5, 0.25], abs=0.05)


def test_the_true_scores_are_at_no_distance_from_the_target():
    material = prepare(source(base="uniform", draws="flattened"), PATHS)
    assert agreement(material.target, material.scores[:, 0], material.weights).js == pytest.approx(0, abs=1e-12)


def test_a_preference_that_no_model_meets_is_refused():
    with pytest.raises(UsageError, match="none of its 600 labelled models"):
        prepare(source(TEXT.replace("50 * {Round}", "{Round} > 2")), PATHS)


def test_a_preference_about_other_things_is_refused():
    with pytest.raises(UsageError, match="tiny does not fit"):
        prepare(source(TEXT.replace("Round}", "Rounded}")), PATHS)


def test_whatever_matters_changes_the_key():
    assert source(title="Another title").key == source().key
    changed = (
        source(seed=1),
        source(num_models=599),
        source(base="uniform"),
        source(draws="flattened"),
        source(TEXT.replace("50", "40")),
        source(rules=RULES.replace("90", "80")),
    )
    assert len({source().key, *(other.key for other in changed)}) == 1 + len(changed)


def learned(preference, families, labels):
    """The state of a person who likes models of `DRAWN`, and the curve."""
    text = f'name = "tiny"\ntitle = "x"\ngrammar = "toy"\nnum_models = 500\npreference = "{preference}"'
    settings = Settings(FeatureOptions(1, families))
    return protocol.run(prepare(source(text, DRAWN), settings), 16, 1, labels)


@takes_turns
def test_a_bound_needs_no_other_column():
    state, curve = learned("100 * ($h < 4)", ("paths", "draws"), 64)
    assert state.columns.extra == ()
    assert curve.points[-1].js < 0.01


@takes_turns
def test_a_product_of_draws_is_found_as_one_column():
    state, curve = learned("100 * ($h * $w < 20)", ("paths", "draws"), 64)
    (product,) = state.columns.extra
    assert isinstance(product, Formula)
    assert str(product) in {"$h * $w", "$w * $h"}
    assert curve.points[-1].js < 0.01


@takes_turns
def test_a_relation_of_siblings_below_different_branches_is_found():
    _, curve = learned("100 * {Lot[Block >> Red. + Block >> Blue.]}", ("paths",), 64)
    assert curve.points[-1].js < 0.01


@pytest.mark.parametrize("name", ["default", "paper", "kde", "sklearn", "lightgbm"])
def test_every_method_learns_a_choice(name):
    (method,) = methods_of(name, batch=12)
    text = TEXT.replace("50 * {Round}", "100 * ({A} == 2)")
    material = prepare(source(text, DRAWN), method.settings(FeatureOptions(1, ("paths",))))
    _, curve = protocol.run(material, method.batch, 0, 24)
    assert curve.points[-1].js < material.js_original
