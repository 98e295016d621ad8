"""What an expression reads, in as few states as it tells apart."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.density.exact.readings import read
from grammarlab.density.exact.subtree_counts import NO_CAP, Reading
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.pattern import Pattern, Threshold
from grammarlab.features.patterns.pattern_text import parse

NUMBERS = st.integers(-2, 5).map(str)
COUNTS = st.sampled_from(["{A}", "{B}", "{C}"])
SUMS = st.recursive(
    st.one_of(NUMBERS, COUNTS),
    lambda s: st.tuples(s, st.sampled_from("+-*"), s).map(lambda t: f"({' '.join(t)})"),
    max_leaves=5,
)
CONDITIONS = st.recursive(
    st.one_of(SUMS, st.tuples(SUMS, st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), SUMS).map(" ".join)),
    lambda s: st.one_of(
        st.tuples(s, st.sampled_from(["and", "or"]), s).map(lambda t: f"({' '.join(t)})"), s.map(lambda t: f"not ({t})")
    ),
    max_leaves=4,
)
TEXTS = st.one_of(
    SUMS, CONDITIONS, st.tuples(CONDITIONS, SUMS, CONDITIONS, NUMBERS, SUMS).map(lambda t: f"choose({', '.join(t)})")
)


@given(TEXTS, st.integers(0, 1000))
def test_reading_less_changes_no_value(text, seed):
    expression = Expression.parse(text)
    counts = np.random.default_rng(seed).integers(0, 12, (40, 3)).astype(float)
    column = dict(zip("ABC", counts.T, strict=True))

    def value(item):
        assert isinstance(item, Reading)
        total = sum(weight * column[pattern.symbol or ""] for pattern, weight in item.terms)
        return np.minimum(total, item.cap)

    reads, rest = read(expression)
    names = [feature.symbol for feature in expression.features if isinstance(feature, Pattern)]
    wanted = expression.evaluate(
        np.stack([column[name or ""] for name in names], axis=1) if names else np.zeros((40, 0))
    )
    found = rest(np.stack([value(item) for item in reads], axis=1) if reads else np.zeros((40, 0)))
    assert found == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("{A} + {B} == 0", {("A + B", 1)}),
        ("{A} + 2 * {B} + 1 >= 5 or {A} > 2", {("A + 2 * B", 5), ("A", 3)}),
        ("not {A} and {B}", {("A", 1), ("B", 1)}),
        ("{A} == {B}", {("A", NO_CAP), ("B", NO_CAP)}),
        ("{A} * {B}", {("A", NO_CAP), ("B", NO_CAP)}),
        ("choose({A}, {B}, 0)", {("A", 1), ("B", NO_CAP)}),
    ],
)
def test_sums_are_read_as_far_as_they_matter(text, wanted):
    reads, _ = read(Expression.parse(text))
    assert {(str(item), item.cap) for item in reads if isinstance(item, Reading)} == wanted


def test_thresholds_are_read_as_they_are():
    reads, rest = read(Expression.parse("choose($h < 3, {A} + 1, 0)"))
    assert set(reads) == {Threshold("h", 3.0), Reading.of(parse("A"))}
    values = {Threshold("h", 3.0): 1.0, Reading.of(parse("A")): 4.0}
    assert rest(np.array([[values[item] for item in reads]])).tolist() == [5.0]  # ty: ignore[invalid-argument-type]
