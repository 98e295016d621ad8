"""Drawn attributes in exact compile: thresholds, choices, and values that go with a part of the tree."""

import numpy as np
import pytest

from grammarlab.density.exact.compile import compile_density
from grammarlab.density.targets.target import Target
from grammarlab.derivation.derive import derive
from grammarlab.errors import GrammarlabError
from grammarlab.features.model_score import Score
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Draw, Threshold
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar

BOX = """
attr h = rand(1, 5)
attr roof = 30% : "flat" 50% : "hip" else : "gable"
Lot --> extrude(h) 40% : Low else : High
Low --> NIL
High --> NIL
"""
MIXED = BOX.replace("extrude(h) 40% : Low else : High", "40% : extrude(h) Low else : extrude(h) High")


def learn(text, reads, preference, **options):
    return compile_density(Grammar.parse(text), reads, preference, **options)


def test_a_threshold_cuts_the_range_of_a_draw():
    learned = learn(MIXED, [Threshold("h", 2.0)], lambda v: np.where(v[:, 0] > 0, 1.0, 3.0))
    assert "attr h =\n    10% : rand(1, 2)\n    else : rand(2, 5)" in learned.text
    assert learned.mean_preference == pytest.approx(2.5)


def test_a_range_that_is_not_liked_goes():
    learned = learn(MIXED, [Threshold("h", 2.0), Threshold("h", 3.0)], lambda v: v[:, 1] * (v[:, 0] == 0))
    assert "attr h = rand(2, 3)" in learned.text


def test_a_choice_gets_new_percentages():
    learned = learn(MIXED, [Draw("roof", 0), Draw("roof", 1)], lambda v: v @ [2.0, 1.0])
    assert "attr roof =\n    54.54545454545454" in learned.text
    assert '"gable"' not in learned.text


def test_attributes_that_go_with_the_tree_make_a_mixture():
    reads = [Threshold("h", 2.0), parse("Low")]
    learned = learn(MIXED, reads, lambda v: 1.0 * (v[:, 0] == v[:, 1]))
    assert "attr component" in learned.text
    grammar = Grammar.parse(MIXED)
    forest = derive(grammar, 500, 3)
    values = count(forest, reads)
    wanted = 1.0 * (values[:, 0] == values[:, 1])
    assert learned.ratio(forest) == pytest.approx(wanted / learned.mean_preference, rel=1e-12)
    assert learned.mean_preference == pytest.approx(0.4 * 0.25 + 0.6 * 0.75)
    sampled = count(learned.sample(2000, 4), reads)
    assert (sampled[:, 0] == sampled[:, 1]).all()
    assert sampled[:, 1].mean() == pytest.approx(0.1 / 0.55, abs=0.03)


def test_a_score_over_a_threshold_and_a_pattern_compiles():
    score = Score.of_text("choose($h < 2 and {Low}, 100, $h >= 4 and not {Low}, 50, 0)")
    grammar = Grammar.parse(MIXED)
    learned = Target.of_score(grammar, score).compiled()
    forest = derive(grammar, 300, 1)
    values = score.evaluate(count(forest, score.features))
    assert learned.ratio(forest) == pytest.approx(values / learned.mean_preference, rel=1e-12)
    again = learned.sample(300, 2)
    assert (score.evaluate(count(again, score.features)) > 0).all()


@pytest.mark.parametrize(
    ("text", "reads", "message"),
    [
        (MIXED, [Draw("h")], "needs thresholds"),
        (MIXED.replace("rand(1, 5)", "2 * rand(1, 5)"), [Threshold("h", 3)], "not rand"),
        (MIXED.replace("rand(1, 5)", "case 2 > 1 : 1 else : rand(1, 5)"), [Threshold("h", 3)], "by a condition"),
        ("Lot --> extrude(rand(1, 5)) A", [Threshold("Lot", 3)], "inside rules"),
    ],
)
def test_what_cannot_be_cut_is_told(text, reads, message):
    with pytest.raises(GrammarlabError, match=message):
        learn(text, reads, lambda v: 1.0 + v[:, 0])
