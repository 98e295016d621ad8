"""Learning from finished models."""

import re

import numpy as np
import pytest

from grammarlab.density.samples.examples import learn_from_examples
from grammarlab.density.targets.target import Target
from grammarlab.derivation.derive import derive
from grammarlab.derivation.selection import select_models
from grammarlab.errors import UsageError
from grammarlab.language.grammar import Grammar
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.runs.sample.shipped import shipped_examples
from tests.cases import some
from tests.density.samples.test_sampled import STYLE, STYLES, score


def divergence(one, other):
    forest = derive(STYLES, 4_000, 77)
    return jensen_shannon(one.ratio(forest), other.ratio(forest))


def compiled(grammar, liked):
    return Target.of_score(grammar, liked).compiled()


@pytest.mark.parametrize("method", ["tied", "structure"])
def test_styles_are_found_in_examples(method):
    wanted = compiled(STYLES, STYLE)
    learned = learn_from_examples(STYLES, wanted.sample(2_000, 5), method)
    assert divergence(learned, wanted) < 0.002
    assert len(learned.components) == 2
    assert ("// How it is planted does not matter.\nGarden --> 50% : Trees" in learned.text) == (method == "tied")
    assert Grammar.parse(learned.text).tree == learned.grammar.tree


def test_styles_are_found_although_each_part_is_as_frequent_as_before():
    mixed = "{OldWall} + {NewDoor} == 1 or {NewWall} + {OldDoor} == 1"
    even = compiled(STYLES, score((0, mixed), (50, "{Lot}")))
    learned = learn_from_examples(STYLES, even.sample(3_000, 5))
    assert divergence(learned, even) < 0.01
    assert len(learned.components) > 1


def test_models_of_the_grammar_teach_nothing():
    learned = learn_from_examples(STYLES, derive(STYLES, 2_000, 3))
    assert learned.text == STYLES.text
    assert "2,000 examples: 0 of 6" in learned.findings[0]


def test_symbols_are_split_where_places_differ():
    grammar = Grammar.parse("Lot --> A A B\nA --> 50% : Red else : Blue\nB --> A")
    forest = compiled(grammar, score((100, "{Lot > A@0:0}"), (10, "{Lot > A@0:1}"))).sample(1_000, 2)
    learned = learn_from_examples(grammar, forest, "structure")
    assert len(learned.components) == 1
    some = derive(grammar, 2_000, 4)
    wanted = compiled(grammar, score((100, "{Lot > A@0:0}"), (10, "{Lot > A@0:1}")))
    assert jensen_shannon(learned.ratio(some), wanted.ratio(some)) < 0.002


def test_drawn_numbers_become_histograms():
    grammar = Grammar.parse("attr height = rand(0, 8)\nLot --> extrude(height) A")
    forest = compiled(grammar, score((90, "$height < 2"), (10, "$height >= 2"))).sample(2_000, 2)
    learned = learn_from_examples(grammar, forest)
    assert "rand(0, 0.5)" in learned.text
    some = derive(grammar, 2_000, 4)
    wanted = compiled(grammar, score((90, "$height < 2"), (10, "$height >= 2")))
    assert jensen_shannon(learned.ratio(some), wanted.ratio(some)) < 0.005


@pytest.mark.parametrize("method", ["tied", "parameters"])
def test_learned_percentages_have_one_decimal_and_others_stay(method):
    rules = "Lot --> A A A\nA --> 33% : Red 33% : Green else : Blue\nUnused --> 12.3456% : Red else : Blue"
    learned = learn_from_examples(Grammar.parse(rules), derive(Grammar.parse(rules), 3, 1), method)
    percentages = re.findall(r"([0-9.]+)%", learned.text)
    assert percentages[-1] == "12.3456"
    assert len(percentages) >= 3
    assert all(len(number.partition(".")[2]) <= 1 for number in percentages[:-1])


def test_weights_say_how_much_examples_count():
    forest = derive(STYLES, 6_000, 8)
    wanted = compiled(STYLES, STYLE)
    learned = learn_from_examples(STYLES, forest, weights=wanted.ratio(forest))
    assert divergence(learned, wanted) < 0.02


def test_one_example_is_not_enough_to_change_anything():
    assert learn_from_examples(STYLES, derive(STYLES, 1, 8)).text == STYLES.text


@pytest.mark.parametrize("number", [1, 4, 16, 60])
def test_held_out_examples_are_not_less_likely_than_before(number):
    wanted = compiled(STYLES, STYLE)
    held = wanted.sample(500, 99)
    gains = [np.log(learn_from_examples(STYLES, wanted.sample(number, seed)).ratio(held)).mean() for seed in range(5)]
    assert np.mean(gains) >= -1e-9
    assert number < 60 or np.mean(gains) > 0.3


@pytest.mark.parametrize("source", some(list(shipped_examples())), ids=lambda source: source.name)
@pytest.mark.parametrize("number", [1, 12])
def test_any_examples_of_a_shipped_grammar_give_a_file_that_samples(source, number):
    grammar = Grammar.parse(source.text(), source.name)
    forest = derive(grammar, number, 4, assets=source.assets)
    equal = select_models(forest, np.zeros(number, dtype=np.int64))
    for examples in (forest, equal):
        learned = learn_from_examples(grammar, examples, assets=source.assets)
        assert learned.rules_after <= 2 * learned.rules_before
        assert learned.sample(5, 1).num_models == 5
        assert (learned.ratio(forest) > 0.0).all()


def test_wrong_examples_are_refused():
    forest = derive(STYLES, 5, 8)
    with pytest.raises(UsageError, match="not models of this grammar"):
        learn_from_examples(Grammar.parse("Lot --> 50% : A else : B"), forest)
    with pytest.raises(UsageError, match="none with a weight"):
        learn_from_examples(STYLES, forest, weights=np.zeros(5))
    with pytest.raises(UsageError, match="a weight for each"):
        learn_from_examples(STYLES, forest, weights=np.ones(4))
