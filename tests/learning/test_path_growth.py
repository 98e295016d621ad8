"""How long paths grow: no longer than it takes to explain what can be explained."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.path_growth import num_conflicts, path_length
from grammarlab.learning.settings import FeatureOptions

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
SPACE = GrammarSpace(STACKS, Path())
COLOUR = parse("Stack > *@0 > * > Paint:0")


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 1), st.integers(0, 2)), max_size=12))
def test_conflicts_are_counted_in_every_set_of_equal_rows(models):
    rows = np.array([m[:2] for m in models], dtype=float).reshape(-1, 2)
    scores = np.array([m[2] for m in models], dtype=float)
    kinds = {tuple(row) for row in rows}
    assert num_conflicts(rows, scores) == sum(np.ptp(scores[(rows == kind).all(axis=1)]) > 0 for kind in kinds)


def scored(forest, pattern):
    return np.asarray(100.0 * (count(forest, [pattern])[:, 0] > 0), dtype=np.float64)


def length_for(pattern, start=1, extra=(), families=("paths", "symbols")):
    forest = derive(STACKS, 300, 1)
    return path_length(
        SPACE, [forest], [(np.arange(300), scored(forest, pattern))], FeatureOptions(start, families), extra
    )


@pytest.mark.parametrize(("text", "length"), [("Piece:0", 1), ("Stack > Piece@0:0", 2)])
def test_paths_are_as_long_as_they_must_be(text, length):
    assert length_for(parse(text)) == length
    assert length_for(parse(text), start=3) == 3


def test_a_feature_that_was_found_makes_longer_paths_needless():
    assert length_for(COLOUR) == 4
    assert length_for(COLOUR, extra=(COLOUR,)) == 1


def test_all_factors_count():
    forest = derive(STACKS, 300, 1)
    both = [(np.arange(300), scored(forest, pattern)) for pattern in (parse("Piece:0"), COLOUR)]
    assert path_length(SPACE, [forest], both[:1], FeatureOptions(1), ()) == 1
    assert path_length(SPACE, [forest], both, FeatureOptions(1), ()) == 4


def test_paths_do_not_grow_for_scores_that_no_path_explains():
    forest = derive(STACKS, 100, 1)
    scores = np.random.default_rng(0).uniform(0.0, 100.0, 200)
    twice = [(np.arange(200), scores)]
    length = path_length(SPACE, [forest, forest], twice, FeatureOptions(4, ("paths",)), ())
    assert length == 4
