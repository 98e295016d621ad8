"""The comment at the top of a learned file: true sentences, whatever names hold."""

from __future__ import annotations

import re

import numpy as np
import pytest

from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.checking.check import check_text
from grammarlab.language.formatting import format_grammar
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.learn import learn
from grammarlab.learning.targets.explanation import Words
from grammarlab.learning.targets.file_head import head, without_earlier_head
from grammarlab.learning.targets.simplification import Predicted, SimplifiedFactor
from grammarlab.learning.targets.unknown_part import CHANCE
from grammarlab.runs.sample.checks import SUPPORTED
from tests.cases import takes_turns

GRAMMAR = Grammar.parse("Lot --> 50% : extrude(3) Low else : extrude(9) High")
ONE = np.ones(1)
NOTHING = Words((), ())


def predicted(words=NOTHING, **factor):
    part = SimplifiedFactor(factor.pop("name", "overall"), factor.pop("num_labels", 20), (), ONE, **factor)
    return Predicted((part,), ONE, ONE, words)


def high(forest):
    return 100.0 * count(forest, [parse("High")])[:, 0]


def test_a_learned_file_begins_with_what_is_liked():
    text = learn(GRAMMAR, high, 16, pool=Pool(0, 200)).learned.text
    lines = text.partition("\n\n")[0].splitlines()
    assert all(line.startswith("//") for line in lines)
    assert "//   - Lot = Low (0; others 100)" in lines
    assert lines[-1] == "// Method compile, base grammar"
    assert lines[0].startswith("// Learned by grammarlab ")
    assert GRAMMAR.hash[:16] in lines[0]
    assert any(line.startswith("// Learned from 16 scores.") for line in lines)
    again = format_grammar(Grammar.parse(text))
    assert again.partition("\n\n")[0].splitlines() == lines
    assert format_grammar(Grammar.parse(again)) == again
    assert check_text(text, "learned.cga", SUPPORTED) == ()


@pytest.mark.parametrize(
    ("factor", "sentence"),
    [
        ({"unexplained": 1.0}, "No pattern yet in 20 scores: the original is kept."),
        ({"unexplained": 1.0, "num_labels": 1}, "No pattern yet in 1 score: the original is kept."),
        ({"unexplained": 0.3}, "Learned from 20 scores. 30% of the original is mixed in, since there are not enough"),
        ({"explained": 0.934, "num_labels": 40}, "Learned from 40 scores. This explains 93% of held-out scores."),
        ({"explained": 0.0}, "Learned from 20 scores."),
        ({"are_equal": True, "unexplained": 0.48}, "All 20 scores are equal: the original is kept."),
        ({"are_equal": True, "num_labels": 1}, "There is only 1 score: the original is kept."),
        ({"num_labels": 20, "num_comparisons": 20}, "Learned from 20 comparisons."),
        ({"num_labels": 20, "num_comparisons": 19}, "Learned from 1 score and 19 comparisons."),
    ],
)
def test_the_head_says_how_much_is_known(factor, sentence):
    assert any(line.startswith(sentence) for line in head([], predicted(**factor), 5))


def test_a_share_of_the_original_is_named_only_where_there_is_one():
    lines = head([], predicted(explained=0.5, num_labels=40), 5)
    assert not any("original" in line for line in lines)


def test_the_head_says_that_scores_are_not_of_one_taste():
    sentence = "Your scores before no. 61 contradict the later ones; the later ones count."
    assert sentence in head([], predicted(Words(("Door (90)",), (), (sentence,), voices=(sentence,))), 0)


def test_values_learned_from_comparisons_alone_are_relative():
    words = Words(("Door (100; others 3)",), ())
    assert "Likes (with the mean value, 100 for the best):" in head([], predicted(words, num_comparisons=20), 0)
    assert "Likes (with the mean score, 0 to 100):" in head([], predicted(words, num_comparisons=19), 0)


def test_kinds_that_no_held_out_score_confirms_are_called_so_as_in_what_is_known():
    """It is decided once, where the kinds are known (`tests/learning/test_heard.py`), and for each factor."""
    for knowledge in ((CHANCE,), (f"Not enough yet: 70% of the original is kept. {CHANCE}",), (f"shape: {CHANCE}",)):
        assert CHANCE in head([], predicted(Words(("Door (90)",), (), knowledge)), 0)
    lines = head([], predicted(Words(("Door (90)",), ()), explained=0.0, num_labels=96), 0)
    assert not any("may be chance" in line for line in lines)


@pytest.mark.parametrize("name", ["flat (+)", "W = (-5) m", "x (+20) y"])
def test_points_are_those_at_the_end(name):
    def title(end):
        return next(line for line in head([], predicted(Words((f"{name} {end}",), ())), 0) if line.startswith("Likes"))

    assert title("(90)") == title("(90; others 3)") == "Likes (with the mean score, 0 to 100):"
    assert title("(+20)") == title("(-3)") == "Likes (points that each part adds):"


def test_equal_scores_leave_the_original_and_say_so():
    result = learn(GRAMMAR, lambda forest: np.full(forest.num_models, 100.0), 16, pool=Pool(0, 200))
    assert "// All 16 scores are equal: the original is kept." in result.learned.text.splitlines()
    assert result.predicted.words.knowledge == ("All scores are equal: the original is kept.",)
    assert Grammar.parse(result.learned.text).rules == GRAMMAR.rules


def test_few_different_designs_have_no_share_of_held_out_scores():
    """Equal designs are held out together, so of two of them nothing says what the other one is worth."""
    result = learn(GRAMMAR, high, 64, pool=Pool(0, 200))
    assert [factor.explained for factor in result.predicted.factors] == [None]
    assert "// Learned from 64 scores." in result.learned.text.splitlines()

    text = f"attr h = rand(1, 9) {GRAMMAR.text.replace('extrude(3)', 'extrude(h)')}"
    (factor,) = learn(Grammar.parse(text), high, 64, pool=Pool(0, 200)).predicted.factors
    assert factor.explained == pytest.approx(1.0, abs=0.2)


def test_no_name_leaves_the_comment():
    wild = "a\nInjected --> Wall\r\u2028// \x85*/ " + "x" * 5_000
    lines = head([f"Labels {wild}"], predicted(Words((wild,), (wild,)), name=wild), 0)
    assert all(len(line.splitlines()) <= 1 for line in lines)
    assert sum(map(len, lines)) < 8_000
    text = "".join(f"// {line}\n" for line in lines) + "\n" + GRAMMAR.text
    assert list(Grammar.parse(text).rules) == list(GRAMMAR.rules)
    assert not check_text(text, "head.cga", SUPPORTED)


@takes_turns
def test_learning_from_a_learned_file_replaces_its_head():
    first = learn(GRAMMAR, high, 16, pool=Pool(0, 200)).learned
    both = Grammar.parse(first.text.replace("Lot --> extrude(9) High", "Lot --> 40% : extrude(9) High else : Low"))
    again = learn(both, high, 16, pool=Pool(0, 200)).learned.text
    assert both.text.startswith("// Learned by")
    assert again.count("Learned by grammarlab") == 1
    assert len(re.findall(r"^// Method ", again, re.MULTILINE)) == 1


def test_comments_of_the_original_are_kept():
    text = "// Learned by grammarlab 1\n//\n// Method compile\n\n// Houses\n\n// of Old Town\nLot --> Low"
    assert without_earlier_head(text) == text
    assert without_earlier_head(f"// own\n\n{text}") == "// own\n\n// Houses\n\n// of Old Town\nLot --> Low"
