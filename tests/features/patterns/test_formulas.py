"""Formulas: their texts, their values, and relations of sequences against plain Python."""

from __future__ import annotations

from collections import Counter
from itertools import groupby, pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.features import named_features
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.operations import SEQUENCE_RELATIONS, apply
from grammarlab.features.patterns.pattern import Draw, Formula, Pattern
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar

GRAMMAR = Grammar.parse(
    """
    attr h = rand(1, 5)
    attr w = rand(1, 5)
    Lot --> A A B
    A --> 50% : Red else : B
    B --> 30% : Blue 30% : Blue Blue else : NIL
    """
)
ATOMS = st.one_of(
    st.sampled_from(["A", "A:0", "B:1", "Lot > A@1:1", "A >> Blue"]).map(parse), st.sampled_from([Draw("h"), Draw("w")])
)


def formulas(operands):
    binary = st.tuples(st.sampled_from(["+", "-", "*", "/", "%", "==", "!=", "and", "or"]), operands, operands)
    listed = st.tuples(
        st.sampled_from(["min", "max", "which", "count", "least", *SEQUENCE_RELATIONS]),
        st.lists(operands, min_size=2, max_size=4),
    )
    return st.one_of(
        binary.map(lambda t: Formula.of(*t)),
        listed.map(lambda t: Formula.of(t[0], *t[1])),
        operands.map(lambda t: Formula.of("not", t)),
        st.tuples(operands, st.sampled_from([-3.0, -0.5, 2.0, 1e20])).map(lambda t: Formula.of("+", *t)),
    )


@given(st.recursive(ATOMS, formulas, max_leaves=12).filter(lambda formula: isinstance(formula, Formula)))
def test_the_text_of_a_formula_is_parsed_as_an_equal_formula(formula):
    again = Expression.parse(str(formula)).formula
    assert again == formula
    assert hash(again) == hash(formula)
    assert str(again) == str(formula)


@given(st.recursive(ATOMS, formulas, max_leaves=12).filter(lambda formula: isinstance(formula, Formula)))
def test_the_value_of_a_formula_is_its_expression_on_the_counts_of_its_features(formula):
    forest = derive(GRAMMAR, 20, seed=1)
    expected = Expression.parse(str(formula)).evaluate(count(forest, formula.features))
    np.testing.assert_array_equal(count(forest, [formula])[:, 0], expected)


def test_a_comparison_of_a_draw_is_read_and_written_as_a_threshold():
    formula = Expression.parse("$h < 3 and {A:0} > 1").formula
    assert [str(feature) for feature in formula.features] == ["h < 3", "A:0"]
    assert Expression.parse(str(formula)).formula == formula


def test_steps_in_another_order_are_the_same_formula():
    first = Expression.parse("a * (-3) + b * 3", {"a": Expression.parse("{A}"), "b": Expression.parse("{B}")})
    parts = Formula.of("*", Pattern("A"), -3.0), Formula.of("*", Pattern("B"), 3.0)
    assert first.formula == Formula.of("+", *parts)


def test_names_that_the_grammar_lacks_are_found_inside_formulas():
    forest = derive(GRAMMAR, 2, seed=1)
    with pytest.raises(UsageError, match=r"no symbol 'C'.*\n.*no random expression 'hh'; did you mean 'h'"):
        named_features.count(forest, [Formula.of("+", Pattern("C"), Draw("hh"))])


# Relations of sequences ----------------------------------------------------------------------------------------------


def _relation(name, elements):
    present = [element for element in elements if element]
    pairs = list(pairwise(present))
    match name:
        case "distinct":
            return len(set(present))
        case "changes":
            return sum(a != b for a, b in pairs)
        case "longest_run":
            return max((len(list(run)) for _, run in groupby(present)), default=0)
        case "like_first":
            return elements[0] and elements[1:].count(elements[0])
        case "balance":
            half = len(present) // 2
            return sum(present[:half]) - sum(present[len(present) - half :])
        case "odd":
            return len(present) - max(Counter(present).values(), default=0)
    holds = {
        "equal": len(set(present)) == 1,
        "unequal_neighbours": all(a != b for a, b in pairs),
        "alternating": len(present) >= 3 and present[0] != present[1] and present[2:] == present[:-2],
        "mirrored": present == present[::-1],
        "ascending": present == sorted(present),
        "same_ends": present[:1] == present[-1:],
    }[name]
    return int(len(present) >= 2 and holds)


@pytest.mark.parametrize("name", SEQUENCE_RELATIONS)
@given(rows=st.integers(2, 7).flatmap(lambda k: st.lists(st.tuples(*[st.integers(0, 3)] * k), min_size=1, max_size=30)))
def test_relations_of_sequences_leave_out_missing_elements(name, rows):
    columns = [np.array(column, dtype=np.float64) for column in zip(*rows, strict=True)]
    assert apply(name, columns).tolist() == [_relation(name, row) for row in rows]


@given(st.lists(st.tuples(*[st.integers(0, 2)] * 5), min_size=1, max_size=30))
def test_an_element_is_followed_by_another_one_at_once_or_later(rows):
    columns = [np.array(column, dtype=np.float64) for column in zip(*rows, strict=True)]
    expected = [any(b == row[1] and row[0] in row[2:i] for i, b in enumerate(row) if i > 2) for row in rows]
    assert apply("followed", columns).tolist() == expected


@given(st.lists(st.tuples(*[st.integers(-1, 2)] * 3), min_size=1, max_size=30))
def test_the_least_of_some_numbers_leaves_out_those_that_are_zero(rows):
    columns = [np.array(column, dtype=np.float64) for column in zip(*rows, strict=True)]
    assert apply("least", columns).tolist() == [min(filter(None, row), default=0) for row in rows]


@given(st.lists(st.tuples(*[st.integers(-1, 2)] * 4), min_size=1, max_size=30))
def test_which_is_the_number_of_the_first_that_is_not_zero(rows):
    columns = [np.array(column, dtype=np.float64) for column in zip(*rows, strict=True)]
    expected = [next((number for number, value in enumerate(row, 1) if value), 0) for row in rows]
    assert apply("which", columns).tolist() == expected
