"""Features that are searched for: subtree patterns, bounds."""

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.features.columns.vocabulary import Options, extract
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import HalfSpace, Threshold
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.features.search.thresholds import find_half_space, find_thresholds, margins
from grammarlab.features.search.tree_patterns import search_patterns
from grammarlab.language.grammar import Grammar

STACKS = Grammar.parse(
    """
Lot --> Stack Sign
Stack --> 50% : Piece Piece else : Piece Piece Piece
Piece --> 50% : Cube else : Cylinder
Cube --> Paint
Cylinder --> Paint
Paint --> 30% : Black. 30% : Green. else : Blue.
Sign --> 50% : Big else : Small
"""
)
BOXES = Grammar.parse(
    "attr w = rand(1, 10)\nattr d = rand(1, 10)\nattr h = rand(1, 10)\nattr z = rand(1, 10)\nLot --> Box"
)


def wanted(forest, text):
    """100 where a pattern occurs, else 0."""
    return np.where(count(forest, [parse(text)])[:, 0] > 0, 100.0, 0.0)


@pytest.mark.parametrize(
    "text",
    [
        "Stack[Piece:0 + Piece:1]",
        "Stack[Piece:0 >> Paint:1 + Piece:1]",
        "Stack[Piece:0 >> Paint:1 + Piece:1 >> Paint:0]",
        "Piece:1 >> Paint:0",
    ],
)
def test_the_pattern_behind_the_scores_is_found(text):
    forest = derive(STACKS, 250, 3)
    scores = wanted(forest, text)
    best = search_patterns([forest], scores)[0]
    expected = parse(text) if text.startswith("Piece") else parse(text.replace("Stack", "*"))
    assert best == expected


def test_nothing_is_found_in_noise():
    forest = derive(STACKS, 100, 3)
    rng = np.random.default_rng(1)
    found = [search_patterns([forest], rng.uniform(0.0, 100.0, 100)) for _ in range(10)]
    assert sum(map(len, found)) <= 2
    assert search_patterns([forest], np.full(100, 50.0)) == ()
    assert search_patterns([], np.zeros(0)) == ()


def test_models_derived_one_by_one_are_searched_like_a_batch():
    whole = derive(STACKS, 80, 3)
    single = [derive(STACKS, 1, 3, first_model=model) for model in range(80)]
    scores = wanted(whole, "Stack[Piece:0 + Piece:1]")
    assert search_patterns(single, scores) == search_patterns([whole], scores)
    np.testing.assert_array_equal(extract(single, Options(3)).rows(), extract(whole, Options(3)).rows())


@pytest.mark.parametrize("name", ["h", "w"])
def test_a_bound_is_found_between_the_nearest_models(name):
    forest = derive(BOXES, 64, 1)
    values = count(forest, [Threshold(name, 5.0)])[:, 0]
    (found, *_) = find_thresholds([forest], 100.0 * values, ["d", "h", "w", "z"])
    assert found.site == name
    assert (count(forest, [found])[:, 0] == values).all()
    assert (margins([forest], found) < 0).tolist() == (values > 0).tolist()


def test_no_bound_is_found_in_noise():
    forest = derive(BOXES, 64, 1)
    scores = np.random.default_rng(0).uniform(0.0, 100.0, 64)
    assert find_thresholds([forest], scores, ["w", "d", "h", "z"]) == ()
    assert find_thresholds([forest], np.full(64, 3.0), ["w", "d"]) == ()
    assert find_thresholds([], np.zeros(0), ["w"]) == ()


def test_few_high_scores_among_many_low_ones_have_no_bound():
    names = [f"size{number}" for number in range(40)]
    forest = derive(Grammar.parse("".join(f"attr {name} = rand(1, 10)\n" for name in names) + "Lot --> Box"), 64, 1)
    high = np.repeat([100.0, 0.0], [4, 60])
    found = [find_thresholds([forest], np.random.default_rng(seed).permutation(high), names) for seed in range(100)]
    assert sum(map(bool, found)) <= 3


def test_a_volume_is_found():
    forest = derive(BOXES, 64, 1)
    truth = HalfSpace(("w", "d", "h"), (1.0, 1.0, 1.0), float(np.log(125.0)), logarithmic=True)
    inside = count(forest, [truth])[:, 0] > 0
    found = find_half_space([forest], inside, ["w", "d", "h", "z"])
    assert found is not None
    assert (found.sites, found.weights, found.logarithmic) == (truth.sites, truth.weights, True)
    assert np.exp(found.bound) == pytest.approx(125.0, rel=0.1)
    assert ((margins([forest], found) < 0) == inside).all()


def test_a_sum_is_found():
    forest = derive(BOXES, 64, 2)
    inside = count(forest, [HalfSpace(("w", "h"), (1.0, -1.0), 1.0)])[:, 0] > 0
    found = find_half_space([forest], inside, ["w", "d", "h", "z"])
    assert found is not None
    assert (found.sites, found.weights, found.logarithmic) == (("w", "h"), (1.0, -1.0), False)


def test_no_half_space_is_found_where_there_is_none():
    forest = derive(BOXES, 200, 2)
    assert find_half_space([forest], np.random.default_rng(0).random(200) < 0.5, ["w", "d", "h", "z"]) is None
    assert find_half_space([forest], np.ones(200, bool), ["w"]) is None
    assert find_half_space([forest], np.zeros(200, bool), []) is None
