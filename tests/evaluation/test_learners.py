from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.evaluation import protocol, scenario
from grammarlab.evaluation.learners import learner_of
from grammarlab.evaluation.material import Columns
from grammarlab.evaluation.methods import METHODS, checked, methods_of
from grammarlab.evaluation.preparation import Source, prepare
from grammarlab.features.pattern import HalfSpace, Threshold
from grammarlab.language.grammar import Grammar
from tests.evaluation.doubles import LEARNER

RULES = """
attr h = rand(1, 9)
attr w = rand(1, 9)
Lot --> s(w, 0, w) extrude(h) split(y) { ~1 : Block | ~1 : Block }
Block --> 50% : A else : B
A --> Red.
B --> 50% : Red. else : Blue.
"""
TEXT = """
name = "tiny"
title = "Low ones"
grammar = "toy"
num_models = 500
preference = "100 * ($h < 4)"
[features]
path_length = 1
families = ["paths", "draws", "thresholds"]
"""


def source(text=TEXT):
    return Source(scenario.parse(text), Grammar.parse(RULES), Path())


def searching(text):
    found = source(text)
    return prepare(found), replace(LEARNER, search=learner_of(METHODS["default"], found.feature_options).search)


def test_a_bound_is_found_and_narrowed_until_little_is_wrong():
    material, learner = searching(TEXT)
    state, curve = protocol.run(material, learner, 1, 64)
    (bound,) = state.columns.extra
    assert isinstance(bound, Threshold)
    assert bound.bound == pytest.approx(4, abs=0.05)
    _, without = protocol.run(material, replace(learner, search=None), 1, 64)
    assert curve.points[-1].js < without.points[-1].js
    labels = material.table(state.columns)
    assert labels.labelled.shape[1] == material.table(Columns(2)).labelled.shape[1] + 1
    assert labels.group_names[-1].startswith("h <")


def test_a_product_of_draws_is_found_as_one_bound():
    material, learner = searching(TEXT.replace("$h < 4", "$h * $w < 20"))
    state, _ = protocol.run(material, learner, 1, 96)
    (bound,) = state.columns.bounds
    assert isinstance(bound, HalfSpace)
    assert (bound.logarithmic, np.exp(bound.bound)) == (True, pytest.approx(20, rel=0.03))


def test_a_relation_of_siblings_below_different_branches_is_found():
    text = TEXT.replace("$h < 4", "{Lot[Block >> Red. + Block >> Blue.]}").replace('"thresholds"', '"subtrees"')
    material, learner = searching(text)
    state, _ = protocol.run(material, learner, 1, 48)
    asked = material.table(state.columns).pool[state.factors[0].asked]
    extra = asked[:, -len(state.columns.extra) :]
    together = np.column_stack([extra, state.factors[0].scores])
    assert len(np.unique(together, axis=0)) == len(np.unique(extra, axis=0))


def test_an_example_is_the_model_that_the_pool_counts():
    material = prepare(source())
    indices = np.array([0, 7, 399, 400, 499])
    (together,) = material.examples(indices)
    assert together.num_models == len(material.examples(indices[:3])[0].lots) + 2
    heights = together.draws.value[together.draws.site == 0].tolist()
    assert np.array_equal(np.array(heights) < 4, material.pool_scores[indices, 0] > 0)
    assert np.allclose(material.margins(Threshold("h", 4.0))[indices], np.array(heights) - 4)
    assert not np.array_equal(heights[:1], derive(Grammar.parse(RULES), 1, 0).draws.value[:1])


def test_only_methods_that_may_look_at_searched_features_search():
    offered = source().feature_options
    assert learner_of(METHODS["default"], offered).search is not None
    paper = replace(source(), families=METHODS["paper"].families)
    assert learner_of(METHODS["paper"], paper.feature_options).search is None


@pytest.mark.parametrize("name", ["default", "paper", "kde", "sklearn"])
def test_every_method_learns_a_choice(name):
    found = source(TEXT.replace("$h < 4", "{A} == 2").replace(', "draws", "thresholds"', ""))
    material = prepare(found)
    (method,) = methods_of(name, batch=12)
    _, curve = protocol.run(material, learner_of(checked(method), found.feature_options), 0, 24)
    assert curve.points[-1].js < material.js_original
