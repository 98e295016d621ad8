"""Counting for people: texts are patterns, draws and expressions, and what a grammar lacks is said."""

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.features.named_features import count, pattern
from grammarlab.features.patterns import counts
from grammarlab.features.patterns.pattern import Draw, Present
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.features.patterns.tree_index import Trees
from grammarlab.language.grammar import Grammar

GRAMMAR = Grammar.parse("""
attr height = rand(3, 9)
House --> 100% : extrude(height) Porch else : Tower
Porch --> Wall. Wall.
Tower --> Wall.
""")
FOREST = derive(GRAMMAR, 5, seed=1)


def test_texts_are_counted_as_their_patterns():
    texts = ["Porch", "House > Porch", "Porch[Wall.]"]
    np.testing.assert_array_equal(count(FOREST, texts), counts.count(FOREST, [parse(text) for text in texts]))
    mixed = count(Trees(FOREST), ["Wall.", parse("Wall."), Draw("height"), Present(parse("Porch"))])
    np.testing.assert_array_equal(mixed[:, 0], np.full(5, 2.0))
    np.testing.assert_array_equal(mixed[:, 1], mixed[:, 0])


def test_draws_and_expressions_are_what_numpy_makes_of_the_columns():
    height, porches, walls = count(FOREST, ["$height", "Porch", "Wall."]).T
    below, ratio, wide = count(FOREST, ["$height < 5", "{Porch} / {Wall.}", "$height >= 4 and {Wall.} == 2"]).T
    np.testing.assert_array_equal(below, height < 5)
    np.testing.assert_array_equal(ratio, porches / walls)
    np.testing.assert_array_equal(wide, (height >= 4) & (walls == 2))


@pytest.mark.parametrize("text", ["Porch", "House:0 > Porch@0", "$height", "$height < 5", "{Porch} + 2 * $height"])
def test_the_text_of_a_feature_is_read_as_an_equal_one(text):
    feature = pattern(text)
    again = f"${feature}" if isinstance(feature, Draw) else str(feature)
    assert pattern(again) == feature


def test_a_symbol_that_is_not_derived_is_counted_zero_times():
    np.testing.assert_array_equal(count(FOREST, ["Tower"]), np.zeros((5, 1)))


@pytest.mark.parametrize(
    ("feature", "message"),
    [
        ("Proch", "no symbol 'Proch'; did you mean 'Porch'"),
        ("House > Wall", "no symbol 'Wall'; did you mean 'Wall.'"),
        ("House:7", "has no branch :7"),
        (Draw("hight"), "no random expression 'hight'; did you mean 'height'"),
        (Present(parse("Proch")), "no symbol 'Proch'"),
        ("Porch >", "expected a symbol"),
        ("$hight < 5", "no random expression 'hight'; did you mean 'height'"),
        ("{Proch} > 1", "no symbol 'Proch'; did you mean 'Porch'"),
        ("height < 5", r"found '<'\n  height < 5\n         \^\n  hint: .* draws begin with \$"),
        ("{Porch} +", "expected a value"),
        (None, r"features\[1\]: expected a pattern such as gl.pattern\(\"Porch\"\), or its text, found NoneType"),
        (3, r"features\[1\]: .* found int"),
    ],
)
def test_what_the_grammar_lacks_is_named_with_the_nearest(feature, message):
    with pytest.raises(UsageError, match=message):
        count(FOREST, ["Porch", feature])


@pytest.mark.parametrize("features", ["Porch", parse("Porch"), None])
def test_one_feature_is_not_a_list_of_features(features):
    with pytest.raises(UsageError, match="features: expected a list such as"):
        count(FOREST, features)


def test_something_else_than_models_is_refused():
    with pytest.raises(UsageError, match=r"forest: expected Forest such as .* found Grammar"):
        count(GRAMMAR, ["Porch"])  # ty: ignore[invalid-argument-type]  # pyright: ignore[reportArgumentType]  # that is the mistake
