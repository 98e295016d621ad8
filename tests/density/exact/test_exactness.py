"""Features that exact grammars can express."""

import pytest

from grammarlab.density.exact.compile import Exactness, compile_density
from grammarlab.derivation.derive import derive
from grammarlab.errors import InexactError
from grammarlab.features.patterns.pattern import Draw, Formula, Present, Threshold
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar

GRAMMAR = Grammar.parse("""
attr width = rand(3, 9)
attr depth = rand(3, 9)
Lot --> 50% : A A else : A B
A --> 50% : Round else : s(width, 3, depth) split(x) { ~1 : Bay }*
""")
EXACTNESS = Exactness(GRAMMAR, derive(GRAMMAR, 50, 1))
ROUND, LOT, BAY = parse("A:0"), parse("Lot:1"), parse("Bay")


@pytest.mark.parametrize(
    "feature",
    [
        ROUND,
        Present(ROUND),
        Threshold("width", 4.0),
        Formula.of("-", ROUND, Formula.of("*", 2.0, LOT)),
        Formula.of("!=", ROUND, 0.0),
        Formula.of("and", Threshold("width", 4.0), LOT),
    ],
    ids=str,
)
def test_counts_of_choices_and_bounds_on_a_draw_are_exact(feature):
    assert EXACTNESS.reason_against(feature) == ""


@pytest.mark.parametrize(
    "feature",
    [
        BAY,
        Formula.of("+", ROUND, BAY),
        Formula.of("+", Draw("width"), Draw("depth")),
        Formula.of("<", Draw("width"), Draw("depth")),
    ],
    ids=str,
)
def test_numbers_that_geometry_decides_and_sums_of_draws_are_not(feature):
    assert EXACTNESS.reason_against(feature)


def test_a_formula_is_compiled_by_what_it_reads():
    with pytest.raises(InexactError, match="a function of other features"):
        compile_density(GRAMMAR, [Formula.of("+", ROUND, LOT)], lambda values: values[:, 0])
    learned = compile_density(GRAMMAR, [ROUND, LOT], lambda values: values.sum(axis=1) % 2.0)
    assert learned.mean_preference == pytest.approx(0.5)
