"""Comparisons say which designs lie in a half-space, in the form that people write."""

import re

import numpy as np
import pytest

from grammarlab.features.columns.column_names import comparison, spread_of
from grammarlab.features.patterns.pattern import Draw, HalfSpace, Threshold


@pytest.mark.parametrize(
    ("space", "inside", "outside"),
    [
        (HalfSpace(("a", "b"), (1.0, -1.0), 0.0), "a < b", "a at least b"),
        (HalfSpace(("a", "b"), (-1.0, 1.0), -0.0013), "a > b", "a at most b"),
        (HalfSpace(("a", "b"), (-1.0, -1.0), -12.3014), "a + b > 12.3", "a + b at most 12.3"),
        (HalfSpace(("a", "b"), (-1.0, 1.0), -3.002), "a > b + 3", "a at most b + 3"),
        (HalfSpace(("a", "b"), (1.0, -1.0), -3.002), "a < b - 3", "a at least b - 3"),
        (HalfSpace(("a", "b"), (1.0, 1.0), 0.0013), "a + b < 0", "a + b at least 0"),
        (HalfSpace(("a", "b"), (1.0, 1.0), 2.4849, logarithmic=True), "a * b < 12", "a * b at least 12"),
        (HalfSpace(("a", "b"), (-1.0, 1.0), -0.6935, logarithmic=True), "a > 2 * b", "a at most 2 * b"),
        (HalfSpace(("a", "b"), (-1.0, 0.5), 0.0001, logarithmic=True), "a > b^0.5", "a at most b^0.5"),
    ],
)
def test_half_spaces_read_like_comparisons(space, inside, outside):
    assert (comparison(space, 20.0), comparison(space, 20.0, holds=False)) == (inside, outside)


@pytest.mark.parametrize("logarithmic", [False, True])
def test_comparisons_hold_for_the_designs_of_the_half_space_only(logarithmic):
    randomness = np.random.default_rng(0)
    draws = dict(zip("abc", np.exp(randomness.normal(size=(3, 200))), strict=True))
    for _ in range(100):
        weights = randomness.permutation([1.0, -1.0, 0.5, -0.25])[:3]
        bound = float(np.log(2.0) if logarithmic else randomness.integers(-8, 9) / 4.0)
        space = HalfSpace(("a", "b", "c"), tuple(weights.tolist()), bound, logarithmic)
        columns = np.array(list(draws.values()))
        inside = weights @ (np.log(columns) if logarithmic else columns) < bound
        assert (_evaluated(comparison(space), draws) == inside).all()
        assert (_evaluated(comparison(space, holds=False), draws) == ~inside).all()


def _evaluated(text, draws):
    """A comparison as an expression of Python."""
    for word, sign in (("at least", ">="), ("at most", "<="), ("^", "**")):
        text = text.replace(word, sign)
    return eval(re.sub(r"(\d) ([a-c])", r"\1 * \2", text), {}, draws)  # noqa: S307 - made right here


def test_the_range_of_a_sum_is_that_of_its_draws():
    values = np.array([[0.0, 1.0, 7.0], [10.0, 5.0, 7.0], [4.0, 0.0, 7.0]])
    features = (Draw("a"), Draw("b"), Threshold("a", 3.0))
    assert spread_of(HalfSpace(("a", "b"), (1.0, -2.0), 3.0), features, values) == 20.0
    assert spread_of(HalfSpace(("a", "unknown"), (1.0, 1.0), 3.0), features, values) == 10.0
    # Only positive draws have a logarithm.
    assert spread_of(HalfSpace(("b",), (1.0,), 3.0, logarithmic=True), features, values) == np.log(5.0)
