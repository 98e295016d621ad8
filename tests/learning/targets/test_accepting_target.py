"""Which draws of an acceptance rule have the same names and meanings in the rules that a grammar learned."""

import numpy as np
import pytest

from grammarlab.density.exact.attributes import AttributeParts
from grammarlab.density.exact.grammar_text import Origin
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.pattern import Draw, Present, Threshold
from grammarlab.language.grammar import Grammar
from grammarlab.learning.targets.accepting_target import _countable

ORIGINAL = Grammar.parse("""
attr tall = rand(3, 9)
attr gap = 50% : rand(0, 2) else : rand(3, 6)
attr tone = 50% : 1 else : 2
Lot --> extrude(tall) Wing Porch
Wing --> split(x) { '(rand(0.2, 0.8)) : A | ~1 : B }
Porch --> 30% : t(rand(1), 0, 0) Open. else : Closed.
""")


def learned(rule, attribute):
    """A grammar in which a rule is new and the draws of an attribute are cut into parts."""
    return LearnedGrammar(
        text=ORIGINAL.text,
        original=ORIGINAL,
        method="compile",
        base="grammar",
        origins={(f"{rule}_wide", 0): Origin((rule, 0), {})},
        start=("Lot", 0),
        components=(),
        attributes=(AttributeParts(attribute, (), np.zeros((0, 0), np.int64)),),
        mean_preference=1.0,
    )


@pytest.mark.parametrize(
    ("feature", "rule", "attribute", "is_countable"),
    [
        (Draw("Wing"), "Wing", "tall", False),
        (Draw("Porch#2"), "Porch", "tall", False),
        (Draw("Porch#2"), "Wing", "tall", True),
        (Present(Draw("Porch#1", 0)), "Porch", "tall", False),
        (Threshold("Wing", 0.5), "Wing", "tall", False),
        (Draw("tall"), "Wing", "tall", True),
        (Draw("tone", 0), "Wing", "tone", False),
        (Draw("gap#1", 0), "Wing", "gap", False),
        (Draw("gap"), "Wing", "gap", True),
        (Draw("tone", 0), "Wing", "tall", True),
        (Expression.parse("{Porch:0} * $Wing").formula, "Wing", "tall", False),
        (Expression.parse("{Porch:0} * $tall").formula, "Porch", "tall", True),
    ],
)
def test_draws_are_counted_in_a_new_grammar_only_where_they_mean_the_same(feature, rule, attribute, is_countable):
    grammar = learned(rule, attribute)
    assert _countable([feature], ORIGINAL, grammar) == is_countable
    assert _countable([Draw("tall"), feature], ORIGINAL, grammar) == is_countable
