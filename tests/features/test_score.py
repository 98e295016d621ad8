"""Scores of models."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import UsageError
from grammarlab.features.expression import Expression
from grammarlab.features.model_score import MAX_CASES, Score, ScoreCase
from grammarlab.features.patterns.pattern import Pattern

COUNTS = st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=1, max_size=8)


def case(value, when):
    return ScoreCase(value, Expression.parse(when))


def test_the_first_case_that_holds_counts_and_none_is_zero():
    score = Score.of_cases([case(70, "{A} > 2"), case(20, "{A} > 1"), case(10, "{B}")])
    assert score.features == (Pattern("A"), Pattern("B"))
    assert score.evaluate(np.array([[3, 1], [2, 1], [1, 1], [1, 0]], dtype=float)).tolist() == [70, 20, 10, 0]
    assert score.levels == (0, 10, 20, 70)


@given(COUNTS, st.lists(st.tuples(st.integers(0, 100), st.integers(0, 5)), min_size=1, max_size=5))
def test_cases_are_read_from_the_top(counts, cases):
    score = Score.of_cases([case(value, f"{{A}} + {{B}} >= {least}") for value, least in cases])
    expected = [next((value for value, least in cases if a + b >= least), 0) for a, b in counts]
    assert score.evaluate(np.array(counts, dtype=float)).tolist() == expected


def test_a_text_is_cut_to_the_scale():
    score = Score.of_text("50 * {A} - 50")
    assert score.evaluate(np.array([[0.0], [1], [2], [3], [4]])).tolist() == [0, 0, 50, 100, 100]
    assert score.levels == ()


@given(COUNTS)
def test_a_product_of_factors_is_the_product_of_their_shares_of_100(counts):
    factors = [Score.of_text("30 * {A} - 20"), Score.of_cases([case(70, "{B} > 2"), case(30, "{A} and {B}")])]
    product = Score.product(factors)
    values = np.array(counts, dtype=float)
    shares = [factor.evaluate(values[:, ["AB".index(str(f)) for f in factor.features]]) / 100 for factor in factors]
    together = product.evaluate(values[:, ["AB".index(str(f)) for f in product.features]])
    np.testing.assert_allclose(together, 100 * shares[0] * shares[1], atol=1e-12)


def test_one_factor_is_itself():
    score = Score.of_text("{A}")
    assert Score.product([score]) is score


def test_nonsense_is_refused():
    with pytest.raises(UsageError, match="found 0"):
        Score.of_cases([])
    with pytest.raises(UsageError, match=f"1 to {MAX_CASES} cases"):
        Score.of_cases([case(1, "1")] * (MAX_CASES + 1))
    for value in (-1, 101, float("nan")):
        with pytest.raises(UsageError, match="from 0 to 100"):
            Score.of_cases([case(value, "1")])
    with pytest.raises(UsageError, match="at least one factor"):
        Score.product([])
