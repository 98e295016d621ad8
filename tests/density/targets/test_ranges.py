"""Preferences that change with every value of a drawn number: as near as ranges come, with the reason."""

import numpy as np
import pytest

from grammarlab.density.samples.sampled import compile_nearest
from grammarlab.density.targets.ranges import even_cuts, range_ends, with_ranges
from grammarlab.density.targets.target import Target
from grammarlab.derivation.derive import derive
from grammarlab.errors import InexactError
from grammarlab.features.patterns.pattern import Draw, Threshold
from grammarlab.language.grammar import Grammar
from grammarlab.learning.targets.divergence import jensen_shannon
from tests.density.samples.test_sampled import score

BOX = Grammar.parse(
    "attr width = rand(1, 9)\nattr height = rand(1, 9)\nLot --> extrude(height) Wall\nWall --> 50%: A else: B"
)
FOREST = derive(BOX, 400, 0)


def divergence(learned, target):
    forest = derive(BOX, 5_000, 8)
    return jensen_shannon(target.of_models(forest), learned.ratio(forest))


def test_each_range_gets_the_mean_of_the_preference_in_it():
    reads, preference = with_ranges(BOX, (Draw("width"),), lambda values: values[:, 0], 4)
    assert reads == (Threshold("width", 3.0), Threshold("width", 5.0), Threshold("width", 7.0))
    inside = np.array([[1, 1, 1], [0, 1, 1], [0, 0, 1], [0, 0, 0]], dtype=float)
    assert preference(inside) == pytest.approx([2.0, 4.0, 6.0, 8.0], abs=0.01)


def test_what_is_not_read_by_its_value_stays():
    reads = (Threshold("width", 3.0),)
    given = with_ranges(BOX, reads, np.sum, 4)
    assert given == (reads, np.sum)


def test_other_bounds_are_ends_of_ranges_too():
    reads, preference = with_ranges(
        BOX, (Threshold("width", 2.0), Draw("width")), lambda v: np.where(v[:, 0] > 0, 0.0, v[:, 1]), 2
    )
    assert set(reads) == {Threshold("width", 2.0), Threshold("width", 5.0)}
    bounds = [2.0 if read == Threshold("width", 2.0) else 5.0 for read in reads]
    rows = np.array([[float(bound > x) for bound in bounds] for x in (1.5, 3.0, 7.0)])
    assert preference(rows) == pytest.approx([0.0, 3.5, 7.0], abs=0.05)


def test_ranges_end_where_draws_do():
    grammar = Grammar.parse("attr h = 20%: rand(0, 1) else: rand(2, 4)\nattr s = 50%: 1 else: 2\nLot --> A")
    assert range_ends(grammar, "h") == (0.0, 1.0, 2.0, 4.0)
    assert range_ends(grammar, "s") == range_ends(grammar, "nothing") == ()
    assert [cut.bound for cut in even_cuts(grammar, "h", 2)] == [1.0, 2.0]


def test_too_many_boxes_are_refused():
    with pytest.raises(InexactError, match="too many combinations"):
        with_ranges(BOX, (Draw("width"), Draw("height")), lambda v: v[:, 0], 300)


@pytest.mark.parametrize("base", ["grammar", "uniform"])
def test_a_sum_of_numbers_is_followed_in_ranges_with_the_reason(base):
    target = Target.of_score(BOX, score((100, "$width + $height < 10 and {A}"), (10, "{B}")), base)
    learned = compile_nearest(target, FOREST, lambda method: (f"Method {method}",))
    assert learned.method == "ranges"
    assert "changes with every value" in learned.findings[0]
    assert learned.text.startswith("// Method ranges\n")
    assert divergence(learned, target) < 0.02
    forest = learned.sample(400, 3)
    assert np.isfinite(learned.log_density(forest)).all()


def test_products_are_followed_in_ranges():
    target = Target.of_score(BOX, score((100, "$width * $height < 12")))
    learned = compile_nearest(target, FOREST)
    assert learned.method == "ranges"
    assert divergence(learned, target) < 0.02
    # Where only attributes differ between components, the rules are written once.
    assert learned.rules_after == learned.rules_before


def test_numbers_of_branches_are_followed_in_ranges():
    branches = " ".join(f"2.5%: {i}" for i in range(39)) + " else: 39"
    grammar = Grammar.parse(f"attr a = {branches}\nattr b = {branches}\nattr c = {branches}\nLot --> A")
    target = Target.of_score(grammar, score((100, "$a * $b * $c < 4000")))
    learned = compile_nearest(target, derive(grammar, 100, 0))
    assert learned.method == "ranges"
    forest = derive(grammar, 3_000, 8)
    assert jensen_shannon(target.of_models(forest), learned.ratio(forest)) < 0.05


def test_what_no_range_follows_is_learned_from_samples_with_the_reason():
    grammar = Grammar.parse("Lot --> s(rand(1, 2), 1, 1) Wall\nWall --> 50%: A else: B")
    target = Target.of_score(grammar, score((100, "$Lot < 1.5 and {A}"), (50, "{B}")))
    learned = compile_nearest(target, derive(grammar, 300, 0), num_samples=500)
    assert learned.method == "tied"
    assert "random expression inside rules" in learned.findings[0]


def test_what_is_exact_stays_exact():
    target = Target.of_score(BOX, score((100, "$width < 4 and {A}")))
    learned = compile_nearest(target, FOREST)
    assert (learned.method, learned.findings) == ("compile", ())
    assert divergence(learned, target) < 1e-12


def test_as_many_boxes_as_two_numbers_have_in_199_ranges_each_are_made():
    reads, preference = with_ranges(BOX, (Draw("width"), Draw("height")), lambda v: v[:, 0] + v[:, 1], 199)
    assert len(reads) == 2 * 198
    assert preference(np.zeros((1, len(reads)))) == pytest.approx(18.0, abs=0.1)


def test_130_ranges_that_depend_on_those_of_another_number_are_exact():
    """No two rows of the preference are proportional: the start rule needs a branch for each."""
    num = 130
    reads = tuple(Threshold(name, 1.0 + 8.0 * i / num) for name in ("width", "height") for i in range(1, num))
    table = 1.0 + np.random.default_rng(0).random((num, num))

    def preference(values):
        width, height = (num - 1 - part.sum(axis=1).astype(np.int64) for part in np.split(values, 2, axis=1))
        return table[width, height]

    target = Target(BOX, reads, preference)
    learned = target.compiled(FOREST)
    assert learned.ratio(FOREST) == pytest.approx(target.of_models(FOREST) / table.mean())
