"""Sums of draws: liked in an interval, of draws that not all models make use of."""

from itertools import combinations

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Draw, HalfSpace, Sum, Term
from grammarlab.features.search.attribute_readers import readers_of
from grammarlab.features.search.sums import MAX_DRAWS, explained, find_steps, find_sum
from grammarlab.language.grammar import Grammar

GRAMMAR = Grammar.parse("""
attr one = rand(3, 6)
attr two = rand(2, 6)
attr three = rand(2, 5)
attr width = rand(1, 9)
attr depth = rand(1, 9)
attr gap = rand(1, 9)
Lot --> s(width, 0, depth + gap) Tower
Tower -->
    40% : [ s('1, one, '1) Box ]
    30% : [ s('1, one, '1) Box ] [ s('1, two, '1) Box ]
    else : [ s('1, one, '1) Box ] [ s('1, two, '1) Box ] [ s('1, three, '1) Box ]
""")
NAMES = list(GRAMMAR.attributes)
HEIGHT = Sum(tuple(Term(name, 1.0, readers_of(GRAMMAR)[name]) for name in NAMES[:3]))


def liked(forest, low, high, noise=10.0):
    height = count(forest, [HEIGHT])[:, 0]
    meant = np.where((height >= low) & (height < high), 100.0, 0.0)
    return np.clip(meant + np.random.default_rng(0).normal(size=len(meant)) * noise, 0.0, 100.0)


@pytest.mark.parametrize("num", [96, 200])
def test_a_band_of_a_sum_of_as_many_draws_as_there_are_is_found(num):
    forest = derive(GRAMMAR, num, 4)
    found = find_sum([forest], liked(forest, 5.0, 8.0), NAMES, readers_of(GRAMMAR))
    assert found is not None
    found = found.sum
    assert set(found.terms) >= {term for term in HEIGHT.terms if term[0] != "one"}
    assert np.atleast_2d(np.corrcoef(count(forest, [found, HEIGHT]).T))[0, 1] > 0.95
    assert str(found) == "one + two where used + three where used"


@pytest.mark.parametrize("num", [96, 200])
def test_floors_of_one_height_are_multiplied_by_their_number(num):
    names = ["ground", "floor", *(f"other{number}" for number in range(12))]
    text = "attr ground = rand(3.7, 4.2)\nattr floor = rand(2.9, 3.4)\n"
    text += "".join(f"attr {name} = rand(1, 2)\n" for name in names[2:])
    text += f"Lot --> s({' + '.join(names[2:])}, ground, 1) Floors(1)\n"
    text += "Floors(a) --> 20% : Low(1) 20% : Low(2) 20% : Low(3) 20% : High(4) else : High(5)\n"
    text += "Low(n) --> extrude(n * floor) Box\nHigh(n) --> extrude(n * floor) Box\n"
    grammar = Grammar.parse(text)
    forest = derive(grammar, num, 4)
    drawn = count(forest, [Draw("ground"), Draw("floor"), Draw("Floors")]).T
    height = drawn[0] + (drawn[2] + 1.0) * drawn[1]
    meant = np.where((height >= 10.1) & (height < 13.3), 100.0, 0.0)
    scores = np.clip(meant + np.random.default_rng(0).normal(size=num) * 5.0, 0.0, 100.0)
    found = find_sum([forest], scores, list(grammar.attributes), readers_of(grammar))
    assert found is not None
    found = found.sum
    assert np.atleast_2d(np.corrcoef(count(forest, [found])[:, 0], height))[0, 1] > 0.995
    assert "floor * (choice 0 to 4 of Floors)" in str(found)
    times = next(term.times for term in found.terms if term.times)
    assert [(str(pattern), weight) for pattern, weight in times] == [(f"Floors/1:{n}", n) for n in range(1, 5)]


def test_a_number_that_says_all_where_a_draw_is_used_is_no_multiple():
    text = "attr tone = rand(0.9, 1)\nattr other = rand(0, 9)\nLot --> s(other, 1, 1) Top Legs\n"
    text += "Top --> 50% : color(tone, tone, tone) Marble else : Wood\n"
    text += "Legs --> 40% : Low 30% : Middle else : High\n"
    grammar = Grammar.parse(text)
    forest = derive(grammar, 200, 4)
    top, legs = count(forest, [Draw("Top"), Draw("Legs")]).T
    scores = np.where((top == 0.0) & (legs >= 1.0), 60.0, 0.0)
    assert find_sum([forest], scores, list(grammar.attributes), readers_of(grammar)) is None


def test_draws_of_parts_that_say_all_by_being_used_are_no_sum():
    parts = ("Plan", "Finish", "Legs", "Rail", "Shelf")
    text = "".join(f"attr size{part} = rand(0.9, 1.1)\n" for part in parts) + f"Lot --> {' '.join(parts)}\n"
    text += "".join(f"{part} --> 50% : s(size{part}, 1, 1) Some{part} else : No{part}\n" for part in parts)
    grammar = Grammar.parse(text)
    forest = derive(grammar, 128, 4)
    used = count(forest, [Draw(part) for part in parts]) == 0.0
    for least in (2, 3):
        scores = np.where(used[:, :4].sum(axis=1) >= least, 100.0, 0.0)
        assert find_sum([forest], scores, list(grammar.attributes), readers_of(grammar)) is None


def test_of_many_draws_and_scores_some_are_enough():
    names = [f"other{number}" for number in range(100)]
    text = (
        "".join(f"attr {name} = rand(0, 9)\n" for name in names) + "attr a = rand(0, 9)\nattr b = rand(0, 9)\nLot --> "
    )
    grammar = Grammar.parse(text + " + ".join(["s(a", *names]) + ", b, 1) Box")
    forest = derive(grammar, 2_000, 4)
    total = count(forest, [Sum.of(("a", "b"), (1.0, 1.0))])[:, 0]
    found = find_sum([forest], np.where(total < 9.0, 100.0, 0.0), list(grammar.attributes), readers_of(grammar))
    assert found is not None
    assert found.sum == Sum.of(("a", "b"), (1.0, 1.0))
    assert found.price == pytest.approx(2.0 * np.log(MAX_DRAWS))


def test_the_order_of_models_does_not_matter():
    forest = derive(GRAMMAR, 96, 4)
    scores = liked(forest, 5.0, 8.0)
    parts = [derive(GRAMMAR, 48, 4, first_model=48), derive(GRAMMAR, 48, 4)]
    other = find_sum(parts, np.concatenate([scores[48:], scores[:48]]), NAMES, readers_of(GRAMMAR))
    assert other == find_sum([forest], scores, NAMES, readers_of(GRAMMAR))


def test_no_sum_is_found_where_there_is_none():
    forest = derive(GRAMMAR, 200, 4)
    readers = readers_of(GRAMMAR)
    assert find_sum([forest], np.random.default_rng(1).uniform(0.0, 100.0, 200), NAMES, readers) is None
    assert find_sum([forest], np.full(200, 50.0), NAMES, readers) is None
    # That there are three blocks says all: the sum of their heights knows it too.
    three = count(forest, readers["three"])[:, 0] * 100.0
    assert find_sum([forest], three, NAMES, readers) is None
    # One draw is no sum.
    width = count(forest, [Sum.of(("width",), (1.0,))])[:, 0]
    assert find_sum([forest], np.where(abs(width - 5.0) < 2.0, 100.0, 0.0), NAMES, readers) is None
    assert find_sum([forest], width, ["width"], readers) is None
    assert find_sum([], np.zeros(0), NAMES, readers) is None


def test_a_half_space_has_a_sum_where_scores_have_further_steps():
    forest = derive(GRAMMAR, 200, 4)
    space = HalfSpace(("width", "depth"), (-1.0, -1.0), -10.0)
    total = count(forest, [Sum.of(("width", "depth"), (1.0, 1.0))])[:, 0]
    noise = np.random.default_rng(0).normal(size=200) * 10.0
    two, three = np.where(total > 10.0, 90.0, 0.0), 40.0 * (total > 7.0) + 50.0 * (total > 10.0)
    for errors in (0.0 * noise, noise):
        assert find_steps([forest], two + errors, space) is None
        assert find_steps([forest], three + errors, space) == Sum.of(("width", "depth"), (-1.0, -1.0))
    assert find_steps([forest], np.full(200, 100.0 / 3.0), space) is None


def test_the_explained_part_is_that_of_the_best_three_intervals():
    randomness = np.random.default_rng(3)
    for _ in range(20):
        column = randomness.integers(0, 6, 9).astype(float)
        scores = randomness.uniform(0.0, 100.0, 9)
        best = 0.0
        for low, high in combinations(np.arange(-0.5, 6.0), 2):
            parts = [column < low, (column >= low) & (column < high), column >= high]
            best = max(
                best, sum(part.sum() * (scores[part].mean() - scores.mean()) ** 2 for part in parts if part.any())
            )
        total = ((scores - scores.mean()) ** 2).sum()
        assert explained(column[:, None], scores)[0] == pytest.approx(best / total)
