"""How long paths grow: no longer than it takes to explain what can be explained."""

from pathlib import Path

import numpy as np
import pytest
from grammarlab.learning.column_growth import further, num_conflicts, path_length
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Draw, HalfSpace, Pattern, Sum, Total
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.grammar_space import GrammarSpace
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


def test_a_choice_far_below_an_edge_is_added_where_scores_need_it():
    forest, features = derive(STACKS, 120, 1), FeatureOptions(2, ("paths", "symbols"))
    top_black = scored(forest, parse("Stack > *@1 >> Paint:0"))
    found = further(SPACE, [forest], top_black, features, ())
    assert {str(feature).split(">>")[0] for feature in found} == {"Stack:0 > *@1 ", "Stack:1 > *@1 "}
    assert further(SPACE, [forest], top_black, features, found) == ()
    assert further(SPACE, [forest], scored(forest, parse("Piece:0")), features, ()) == ()


def test_counts_and_comparisons_of_draws_are_added_where_scores_need_them():
    grammar = Grammar.parse(
        """
attr width = rand(1, 9)
attr depth = rand(1, 9)
attr tall = rand(90, 99)
Lot --> s(width, tall, depth) split(x) { ~1 : split(z) { ~1 : Bay }* }*
Bay --> Window.
"""
    )
    space, forest = GrammarSpace(grammar, Path()), derive(grammar, 80, 1)
    features = FeatureOptions(2, ("paths", "symbols", "draws"))
    width, depth = space.values([forest], [Draw("width"), Draw("depth")]).T
    (found,) = further(space, [forest], np.where(width < depth, 100.0, 0.0), features, ())
    assert found == HalfSpace(("width", "depth"), (1.0, -1.0), 0.0)
    assert space.margins([forest], found) is None
    bays = count(forest, [Pattern("Bay")])
    (found,) = further(space, [forest], np.where(bays[:, 0] > 24.0, 100.0, 0.0), features, ())
    assert np.array_equal(count(forest, [found]), bays)


@pytest.mark.parametrize("noise", [0.0, 15.0])
def test_an_odd_number_of_parts_and_a_ratio_are_added_where_scores_need_them(noise):
    parts = [f"Part{number}" for number in range(5)]
    text = "attr width = rand(1, 9)\nattr depth = rand(1, 9)\n" + f"Lot --> s(width, 3, depth) {' '.join(parts)}\n"
    text += "".join(f"{part} --> 40% : Gilded{part} else : Plain{part}\n" for part in parts)
    space = GrammarSpace(Grammar.parse(text), Path())
    forest, errors = derive(space.program, 80, 1), noise * np.random.default_rng(0).normal(size=80)
    features = FeatureOptions(2, ("paths", "symbols", "draws"))

    def found(meant):
        return further(space, [forest], np.clip(meant + errors, 0.0, 100.0), features, ())

    gilded = count(forest, [parse(f"{part}:0") for part in parts]).sum(axis=1)
    (total,) = found(100.0 * (gilded % 2.0))
    assert isinstance(total, Total)
    assert np.array_equal(count(forest, [total])[:, 0] % 2.0, gilded % 2.0)
    width, depth = space.values([forest], [Draw("width"), Draw("depth")]).T
    assert found(np.where(width > 1.6 * depth, 100.0, 0.0)) == (Sum.of(("width", "depth"), (1.0, -1.0), True),)
    assert found(np.where(width > 5.0, 100.0, 0.0)) == ()


@pytest.mark.parametrize("noise", [0.0, 10.0])
def test_points_of_many_parts_are_added_where_they_explain_more_than_cells(noise):
    parts = [f"Part{number}" for number in range(8)]
    text = f"Lot --> {' '.join(parts)}\n" + "".join(
        f"{part} --> 50% : Gilded{part} else : Plain{part}\n" for part in parts
    )
    space, features = GrammarSpace(Grammar.parse(text), Path()), FeatureOptions(2, ("paths", "symbols"))
    forest = derive(space.program, 96, 1)
    gilded = count(forest, [parse(f"{part}:0") for part in parts])

    def found(meant):
        errors = noise * np.random.default_rng(0).normal(size=len(meant))
        return further(space, [forest], np.clip(meant + errors, 0.0, 100.0), features, ())

    points = np.array([30.0, 25.0, 20.0, 15.0])
    *_, total = found(5.0 + gilded[:, :4] @ points)
    assert np.corrcoef(count(forest, [total])[:, 0], gilded[:, :4] @ points)[0, 1] > 0.97
    assert found(100.0 * gilded[:, :3].all(axis=1)) == ()
    assert found(np.where(gilded[:, 2] > 0.0, 90.0, 20.0)) == ()


@pytest.mark.parametrize("noise", [0.0, 15.0])
def test_that_parts_are_alike_is_added_where_scores_need_it(noise):
    forest = derive(STACKS, 120, 1)
    alike = count(forest, [parse(f"Stack[Piece@0:{branch}, Piece@1:{branch}]") for branch in range(2)]).sum(axis=1)
    scores = np.clip(100.0 * alike + noise * np.random.default_rng(0).normal(size=120), 0.0, 100.0)
    (total,) = further(SPACE, [forest], scores, FeatureOptions(2, ("paths", "symbols")), ())
    np.testing.assert_array_equal(count(forest, [total])[:, 0], alike)
