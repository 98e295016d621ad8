"""Choices that are made alike, found among all pairs of places."""

import numpy as np
import pytest

from grammarlab.density.exact.compile import Exactness
from grammarlab.derivation.derive import derive
from grammarlab.derivation.selection import select_models
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.features.search.equal_choices import MAX_EQUALITIES, find_equalities
from grammarlab.language.grammar import Grammar

GRAMMAR = Grammar.parse(
    """
    Lot --> Left Right Tower Frieze Beam
    Left --> 40% : A 30% : B else : C
    Right --> 50% : A 20% : B else : C
    Tower --> 30% : Floor else : Floor Floor
    Floor --> Bay Bay
    Bay --> Pane Sill
    Pane --> 30% : A 30% : B 20% : C else : NIL
    Sill --> 50% : A else : B
    Frieze --> Tile Tile Tile Tile
    Tile --> 40% : A 30% : B else : C
    Beam --> 50% : A else : Beam2
    Beam2 --> A
    """
)
FOREST = derive(GRAMMAR, 160, 3)


def taken(forest, path):
    """The alternative of the choice at a path of successors from the root, for each model; None without this choice."""
    nodes = forest.nodes
    below = {(parent, child): row for row, (parent, child) in enumerate(zip(nodes.parent, nodes.child, strict=True))}
    found = []
    for root in np.flatnonzero(nodes.parent < 0).tolist():
        row = root
        for child in path:
            row = below.get((row, child))
        found.append(None if row is None else forest.rules[nodes.rule[row]].branch)
    return found


def alike(forest, one, other):
    pairs = zip(taken(forest, one), taken(forest, other), strict=True)
    return np.array([float(first is not None and first == second) for first, second in pairs])


PLACES = [
    ((0,), (1,)),  # two symbols below the root
    ((2, 0, 0, 0), (2, 1, 0, 0)),  # one symbol, two floors
    ((2, 0, 0, 0), (2, 0, 1, 0)),  # one floor, two bays
    ((3, 0), (3, 3)),  # tiles that are not adjacent
]


@pytest.mark.parametrize("noise", [0.0, 20.0])
@pytest.mark.parametrize("places", PLACES, ids=str)
def test_what_is_alike_is_found_first(places, noise):
    few = select_models(FOREST, np.arange(96))
    same = alike(few, *places)
    scores = 100.0 * same + np.random.default_rng(0).normal(0.0, 1.0, len(same)) * noise
    equalities, _ = find_equalities([few], scores)
    np.testing.assert_array_equal(count(few, equalities[:1])[:, 0], same)


def test_equal_neighbours_are_counted():
    tiles = np.stack([[branch[0] for branch in taken(FOREST, (3, place)) if branch] for place in range(4)])
    number = (tiles[1:] == tiles[:-1]).sum(axis=0)
    equalities, _ = find_equalities([FOREST], 100.0 * (number == 3))
    np.testing.assert_array_equal(count(FOREST, equalities[:1])[:, 0], number)


def test_every_equality_says_what_its_places_say_in_models_that_were_not_scored():
    others = derive(GRAMMAR, 60, 9)
    for one, other in PLACES:
        equalities, _ = find_equalities([FOREST], 100.0 * alike(FOREST, one, other))
        np.testing.assert_array_equal(count(others, equalities[:1])[:, 0], alike(others, one, other))


def test_a_grammar_can_say_them():
    for one, other in PLACES:
        (best, *_), _ = find_equalities([FOREST], 100.0 * alike(FOREST, one, other))
        assert not Exactness(GRAMMAR, FOREST).reason_against(best)


def test_models_may_lie_in_several_forests_and_in_any_order():
    scores = 100.0 * alike(FOREST, (0,), (1,)) + np.arange(160) % 7
    halves = [select_models(FOREST, np.arange(start, start + 80)) for start in (0, 80)]
    turned = np.random.default_rng(1).permutation(160)
    expected = find_equalities([FOREST], scores)
    assert find_equalities(halves, scores) == expected
    assert find_equalities([select_models(FOREST, turned)], scores[turned])[0][0] == expected[0][0]


def test_one_choice_that_explains_the_scores_has_no_equalities():
    left = np.array([branch == (1,) for branch in taken(FOREST, (0,))])
    equalities, price = find_equalities([FOREST], 100.0 * left)
    assert not any("Left" in str(each) for each in equalities)
    assert price > 0.0


def test_chance_gives_a_few_at_most():
    for seed in range(5):
        scores = np.random.default_rng(seed).uniform(0.0, 100.0, 160)
        assert len(find_equalities([FOREST], scores)[0]) <= MAX_EQUALITIES


@pytest.mark.parametrize("text", ["Lot --> A", "Lot --> 50% : A else : B", "Lot --> Left  Left --> 50% : A else : B"])
def test_fewer_than_two_choices_have_no_equalities(text):
    forest = derive(Grammar.parse(text), 40, 1)
    assert find_equalities([forest], np.arange(40.0)) == ([], 0.0)


def test_equal_scores_tell_nothing():
    assert find_equalities([FOREST], np.full(160, 40.0)) == ([], 0.0)
    assert find_equalities([select_models(FOREST, np.arange(1))], np.ones(1)) == ([], 0.0)


def test_choices_of_recursive_and_overloaded_symbols_do_no_harm():
    forest = derive(
        Grammar.parse("Lot --> A(1) A  A(x) --> 50% : B else : C  A --> 50% : Lot2 else : B  Lot2 --> A A"), 64, 1
    )
    equalities, _ = find_equalities([forest], count(forest, [parse("B")])[:, 0])
    assert np.isfinite(count(forest, equalities)).all()
