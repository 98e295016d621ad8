"""Two models of one seed that differ in one choice alone."""

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Below, Draw, Formula, Pattern, Present
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.contrasts import choice_of, contrasted
from grammarlab.learning.designs.grammar_space import GrammarSpace

GRAMMAR = Grammar.parse("""
attr height = rand(3, 9)
Lot --> extrude(height) split(y) { ~1 : Part | ~1 : Part }
Part --> 50% : Wall else : case scope.sy > 2 : 30% : Glass 20% : Brick else : Wall else : Stone
Wall --> 20% : Plain. 80% : split(x) { rand(1, 2) : Brick }
Glass --> scope.sx * 1% : Clear. else : Dark.
""")


@pytest.mark.parametrize("choice", [Pattern("Part", branch=(0,)), Pattern("Part", branch=(1, 0, 0))])
def test_a_choice_is_always_or_never_taken_and_all_other_draws_stay(choice):
    programs = contrasted(GRAMMAR, choice)
    assert programs is not None
    forests = [derive(program, 200, 5) for program in programs]
    taken = [count(forest, [choice]).sum() for forest in forests]
    assert (taken[0], taken[1] > 50) == (0.0, True)
    places = [count(forest, [Pattern("Part", branch=choice.branch[:-1])]).sum() for forest in forests]
    assert places[0] == places[1] == taken[1]
    without, with_it = (forest.draws.value[forest.draws.site == forest.sites.index(site(forest))] for forest in forests)
    np.testing.assert_array_equal(without, with_it)


def site(forest):
    return next(site for site in forest.sites if site.name == "height")


def test_a_design_without_the_place_of_a_choice_has_no_contrast():
    space = GrammarSpace(GRAMMAR)
    pairs = {}
    for model in range(12):
        address = Address(False, 3, model)
        pairs[model] = space.contrast(address, Pattern("Wall", branch=(0,)))
        has_wall = any(space.make([address]).symbols[symbol] == "Wall" for symbol in space.make([address]).nodes.symbol)
        assert (pairs[model] is not None) == has_wall
        if pairs[model] is not None:
            assert pairs[model].scene.num_models == 2  # ty: ignore[missing-union-attribute]
    assert len({pair is None for pair in pairs.values()}) == 2
    assert space.contrast(Address(True, 3, 0), Pattern("Wall", branch=(0,))) is None


@pytest.mark.parametrize(
    ("feature", "choice"),
    [
        (Present(Pattern("Part", branch=(0,))), Pattern("Part", branch=(0,))),
        (Formula.of("!", Pattern("Part", branch=(0,))), Pattern("Part", branch=(0,))),
        (Formula.of("&", Pattern("Part", branch=(0,)), Pattern("Wall", branch=(0,))), None),
        (Pattern("Part"), None),
        (Pattern("Lot", below=(Below((Pattern("Part", branch=(0,)),)),)), None),
        (Draw("height"), None),
    ],
)
def test_features_are_about_one_choice_or_not(feature, choice):
    assert choice_of(feature) == choice


@pytest.mark.parametrize(
    "choice",
    [
        Pattern("Nothing", branch=(0,)),
        Pattern("Part", branch=(1,)),  # reached by chance, but itself a condition only below it
        Pattern("Part", branch=(1, 0)),
        Pattern("Glass", branch=(0,)),
        Pattern("Part", branch=(7,)),
        Pattern("Part", parameters=2, branch=(0,)),
    ],
)
def test_what_is_not_chosen_by_constant_percentages_has_no_contrast(choice):
    expected = None if choice != Pattern("Part", branch=(1,)) else contrasted(GRAMMAR, Pattern("Part", branch=(0,)))
    found = contrasted(GRAMMAR, choice)
    assert (found is None) == (expected is None)
    if found is not None and expected is not None:
        for one, other in zip(found, reversed(expected), strict=True):
            np.testing.assert_array_equal(derive(one, 20, 1).nodes.symbol, derive(other, 20, 1).nodes.symbol)
