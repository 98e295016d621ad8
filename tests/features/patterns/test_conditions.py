"""Bounds on features as texts: the expression says what the feature counts."""

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.conditions import at_least
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Draw, Present, Threshold
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar

GRAMMAR = Grammar.parse(
    """
attr width = rand(-1, 4)
attr depth = rand(1, 3)
attr style = 40% : 1 else : 2
Lot --> 50% : extrude(3) A A else : extrude(4) B
"""
)
FEATURES = [
    (parse("A"), 2.0),
    (parse("Lot:1 > B@0"), 1.0),
    (Present(parse("A")), 1.0),
    (Threshold("width", 0.1 + 0.2), 1.0),
    (Draw("width"), 1.2345678901234567),
    (Draw("style", 1), 1.0),
    *[
        (Expression.parse(text).formula, bound)
        for text, bound in (
            ("$width - 0.3 * $depth", 0.123456789),
            ("$width < $depth", 1.0),
            ("2 * log($width) + log($depth)", 0.2),
            ("({A} + 2.5 * {B}) * $width - $depth", 3.0),
            ("{A} - ({B} != 0) + 2 * $style:1", 2.0),
            ("({B} > 0) * $depth", 1.5),
        )
    ],
]


@pytest.mark.parametrize(("feature", "bound"), FEATURES, ids=str)
def test_the_condition_holds_where_the_feature_reaches_the_bound(feature, bound):
    forest = derive(GRAMMAR, 400, 3)
    wanted = count(forest, [feature])[:, 0] >= bound
    condition = Expression.parse(at_least(feature, bound))
    assert 0.0 < wanted.mean() < 1.0
    np.testing.assert_array_equal(condition.evaluate(count(forest, condition.features)) != 0.0, wanted)
