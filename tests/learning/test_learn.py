"""A Python function in the place of a person."""

import re

import numpy as np
import pytest

from grammarlab.density.targets.accepted import AcceptedGrammar
from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Draw
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.learn import learn
from tests.cases import takes_turns

GRAMMAR = Grammar.parse(
    """
Lot --> extrude(6) split(y) { ~1 : Part | ~1 : Part }
Part --> 50% : color("#ff0000") Wall else : color("#0000ff") Wall
Wall --> 20% : Glass. 30% : Brick. else : Stone.
"""
)
SMALL = Pool(0, 400)


def red_below(forest):
    return 60.0 * count(forest, [parse("Lot > Part@0:0")])[:, 0]


def ratio_of(found):
    """How much likelier the learned grammar makes models whose lower part is red, and the others."""
    forest = derive(GRAMMAR, 400, 99)
    ratio, liked = found.learned.ratio(forest), red_below(forest) > 0
    return ratio[liked], ratio[~liked]


@takes_turns
def test_what_a_function_of_derivations_likes_is_learned():
    found = learn(GRAMMAR, red_below, 48, pool=SMALL)
    liked, others = ratio_of(found)
    assert liked == pytest.approx(2.0)
    assert not others.any()


@takes_turns
def test_a_function_may_look_at_meshes():
    def red_down_there(scene):
        red = scene.materials.channels[scene.material, 0] > scene.materials.channels[scene.material, 2]
        low = red & (scene.position[:, 1] < 1.0)
        return 100.0 * np.isin(np.arange(scene.num_models), scene.model[low])

    liked, others = ratio_of(learn(GRAMMAR, red_down_there, 48, sees="scene", pool=SMALL))
    assert liked == pytest.approx(2.0)
    assert not others.any()


def test_the_function_is_asked_for_as_many_scores_as_the_budget_allows():
    asked = []

    def count_them(forest):
        asked.append(forest.num_models)
        return red_below(forest)

    learn(GRAMMAR, count_them, 20, pool=SMALL)
    assert asked == [8, 8, 4]


@pytest.mark.parametrize(
    ("score", "budget", "message"),
    [
        (red_below, 0, "at least 1 score"),
        (lambda _forest: 50.0, 8, "expected 8 numbers for 8 models"),
        (lambda forest: np.full((forest.num_models, 1), 50.0), 8, r"found an array of shape \(8, 1\)"),
        (lambda forest: np.full(forest.num_models, 101.0), 8, "from 0 to 100"),
        (lambda forest: np.full(forest.num_models, np.inf), 8, "from 0 to 100, found inf to inf"),
        (
            lambda forest: np.where(np.isin(np.arange(forest.num_models), [3, 5]), np.nan, 50.0),
            8,
            r"score: 2 of 8 scores are not numbers \(NaN\), the first is of model 3\.",
        ),
        (lambda forest: np.full(forest.num_models, np.nan), 8, "8 of 8 scores are not numbers"),
        (lambda forest: np.zeros(forest.num_models), 8, "none of the 8 models"),
    ],
)
def test_what_cannot_be_learned_from_is_refused_in_words(score, budget, message):
    with pytest.raises(UsageError, match=message):
        learn(GRAMMAR, score, budget, pool=SMALL)


@takes_turns
def test_truth_is_the_highest_score_and_falsehood_the_lowest():
    told = learn(GRAMMAR, lambda forest: red_below(forest) > 0.0, 16, pool=SMALL)
    scored = learn(GRAMMAR, lambda forest: 100.0 * (red_below(forest) > 0.0), 16, pool=SMALL)
    assert told.learned.text == scored.learned.text
    assert told.predicted.words == scored.predicted.words
    assert told.predicted.words.likes


@takes_turns
def test_scores_without_a_pattern_leave_the_grammar_as_it_was():
    """Few people who flip coins seem to like something."""

    def learned_by(seed):
        coins = np.random.default_rng(seed)
        return learn(GRAMMAR, lambda forest: 100.0 * (coins.random(forest.num_models) < 0.5), 32, pool=SMALL)

    people = [learned_by(seed) for seed in range(3, 6)]
    kept = [each for each in people if all(factor.unexplained == 1.0 for factor in each.predicted.factors)]
    assert len(kept) >= 2
    found = kept[0]
    np.testing.assert_allclose(found.learned.ratio(derive(GRAMMAR, 100, 99)), 1.0)
    assert found.learned.rules_after == found.learned.rules_before
    (line,) = found.predicted.words.lines
    assert line == "No pattern yet: the original is kept."
    assert line in repr(found)
    assert found.features == ()


@takes_turns
def test_a_learned_comparison_reads_like_one():
    grammar = Grammar.parse("attr a = rand(0, 10)\nattr b = rand(0, 10)\nLot --> s(1 + a, 1 + b, 1) A")
    draws = [Draw("a"), Draw("b")]
    found = learn(grammar, lambda forest: 80.0 * (count(forest, draws) @ [1.0, 1.0] > 12.3), 96)
    (liked,) = found.predicted.words.likes
    assert re.fullmatch(r"a \+ b: at least 1[12](\.\d)? m \(80; others 0\)", liked)
    assert not found.predicted.words.dislikes
    # Ranges of the draws say as much as they can, and the rule says the rest.
    assert found.names == ("a", "b", "a + b")
    assert isinstance(found.learned, AcceptedGrammar)
    assert re.search(r'@Acceptance\("choose\(\(\$a \+ \$b\) >= 1[12][.\d]*, 1, 0\)"\)', found.learned.text)
