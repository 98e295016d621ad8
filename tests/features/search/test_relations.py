"""Ratios and differences of two draws, found among many."""

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Draw, Sum
from grammarlab.features.search.thresholds import MAX_RELATIONS, find_relations
from grammarlab.language.grammar import Grammar

NAMES = [f"side{number}" for number in range(10)]
GRAMMAR = Grammar.parse(
    "".join(f"attr {name} = rand(1, 9)\n" for name in NAMES) + f"attr level = rand(-3, 3)\n"
    f"Lot --> s({' + '.join(NAMES)}, level, 1) Box"
)
FOREST = derive(GRAMMAR, 160, 3)
DRAWS = count(FOREST, [Draw(name) for name in NAMES])


def found(scores, names=(*NAMES, "level")):
    return find_relations([FOREST], scores, names)[0]


def test_a_ratio_is_found_first():
    scores = 100.0 * (DRAWS[:, 2] > 1.7 * DRAWS[:, 6])
    assert found(scores)[0] == Sum.of(("side2", "side6"), (1.0, -1.0), logarithmic=True)


def test_a_difference_is_found_first():
    scores = 100.0 * (np.abs(DRAWS[:, 2] - DRAWS[:, 6] - 1.5) < 1.0)
    assert found(scores)[0] == Sum.of(("side2", "side6"), (1.0, -1.0))


def test_draws_that_can_be_negative_have_no_ratios():
    level = count(FOREST, [Draw("level")])[:, 0]
    relations = found(100.0 * (level > DRAWS[:, 0] - 4.0))
    assert Sum.of(("side0", "level"), (1.0, -1.0)) in relations
    assert not any("level" in str(relation) and relation.logarithmic for relation in relations)


def test_each_explains_more_than_either_draw():
    relations = found(100.0 * (DRAWS[:, 2] > 5.0))
    assert not any(term.site == "side2" for relation in relations for term in relation.terms)
    assert len(found(np.random.default_rng(0).uniform(0.0, 100.0, len(DRAWS)))) == MAX_RELATIONS


@pytest.mark.parametrize("names", [(), ("side0",)])
def test_one_draw_has_no_relations(names):
    assert find_relations([FOREST], DRAWS[:, 0], names) == ([], 0.0)
