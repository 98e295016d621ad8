"""The text of a learned grammar alone tells which trees of the original it makes, and how often."""

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given
from hypothesis import strategies as st

from grammarlab.density.exact.compile import compile_density
from grammarlab.density.exact.recovery import recovered
from grammarlab.density.samples import sampled
from grammarlab.density.targets.target import Target
from grammarlab.derivation.derive import derive
from grammarlab.errors import GrammarlabError
from grammarlab.features.patterns.pattern import Threshold
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar
from tests.cases import bulk
from tests.density.exact.test_compile import Preference
from tests.density.samples.test_sampled import STYLE, STYLES, score
from tests.density.trees import grammars, patterns, text_of

few = bulk(40, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])

SIZES = Grammar.parse(
    """
attr height = 40%: rand(1, 3) else: rand(5, 9)
attr style = 30%: "old" else: "new"
Lot --> case style == "old" : extrude(height) Wall else : t(1, 0, 0) Wall
Wall --> 50% : Brick. else : 50% : Stone. else : Glass.
"""
)


def same_density(original, learned, forest):
    found = recovered(original, learned.text)
    assert found is not None
    np.testing.assert_allclose(found.ratio(forest), learned.ratio(forest), rtol=1e-11, atol=1e-14)
    return found


@few
@given(grammars(), st.lists(patterns(), min_size=1, max_size=3), st.integers(0, 1000))
def test_what_is_recovered_has_the_density_that_was_learned(rules, features, seed):
    grammar = Grammar.parse(text_of(rules))
    forest = derive(grammar, 50, seed)
    preference = Preference(seed)
    try:
        learned = compile_density(grammar, features, preference)
    except GrammarlabError:
        assume(False)
        return
    found = recovered(grammar, learned.text)
    if found is not None:
        np.testing.assert_allclose(found.ratio(forest), learned.ratio(forest), rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("method", sampled.METHODS)
def test_mixtures_and_splits_are_recovered(method):
    target = Target.of_score(STYLES, score((40, "{Lot > Wall:0} and {OldDoor}"), (20, "{NewWall} and {NewDoor}")))
    learned = sampled.learn(target, method, num_samples=500)
    found = same_density(STYLES, learned, derive(STYLES, 200, 3))
    assert len(found.components) == len(learned.components)
    forest = found.sample(100, 5)
    assert forest.rules == derive(STYLES, 1, 1).rules


def test_ranges_and_choices_of_attributes_are_recovered():
    reads = (Threshold("height", 2.0), Threshold("height", 6.0), parse("Wall:0"))
    learned = compile_density(SIZES, reads, lambda v: 1.0 + v[:, 0] * v[:, 2] + 3.0 * v[:, 1])
    assert len(learned.components) > 1
    same_density(SIZES, learned, derive(SIZES, 300, 3))


def test_a_grammar_is_recovered_from_itself_and_from_other_percentages():
    forest = derive(SIZES, 200, 3)
    found = recovered(SIZES, SIZES.text)
    assert found is not None
    assert found.ratio(forest) == pytest.approx(1.0)
    other = Grammar.parse(
        SIZES.text.replace("50% : Brick", "20% : Brick").replace("40%: rand(1, 3)", "10%: rand(1, 3)")
    )
    found = recovered(SIZES, other.text)
    assert found is not None
    assert found.ratio(forest).mean() == pytest.approx(1.0, abs=0.2)
    assert derive(other, 50, 1).num_models == 50


@pytest.mark.parametrize(
    "change",
    [
        ("Brick.", "Timber."),
        ("extrude(height)", "extrude(2)"),
        ('style == "old"', 'style == "new"'),
        ("rand(1, 3)", "rand(1, 4)"),
        ("attr style", "attr width = 3\nattr style"),
        ("attr style", "attr width = rand(1, 2)\nattr style"),
        ("t(1, 0, 0) Wall", "t(1, 0, 0) Wall Wall"),
        ('30%: "old"', '30%: "older"'),
    ],
)
def test_what_was_not_made_from_a_grammar_is_told(change):
    assert recovered(SIZES, SIZES.text.replace(*change)) is None


def test_ends_that_say_the_same_cannot_be_told_apart():
    twice = Grammar.parse("Lot --> 50% : A 30% : A else : B\nA --> 50% : C else : D")
    learned = Target.of_score(twice, score((100, "{Lot:0} and {C}"), (10, "{B}"))).compiled()
    assert recovered(twice, learned.text) is None


def test_styles_are_recovered():
    same_density(STYLES, Target.of_score(STYLES, STYLE).compiled(), derive(STYLES, 300, 3))
