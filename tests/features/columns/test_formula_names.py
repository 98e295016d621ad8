"""Formulas in words."""

from __future__ import annotations

import pytest

from grammarlab.derivation.derive import derive
from grammarlab.features.columns.formula_names import formula_words
from grammarlab.features.columns.vocabulary import extract
from grammarlab.features.expression import Expression
from grammarlab.language.grammar import Grammar

ALIKE, BOTH = "({*[A:0 + A:0]} + {*[A:1 + A:1]})", "{*[A:* + A:*]}"
FAR, THREE = "({*[A:0 + A:* + A:0]} + {*[A:1 + A:* + A:1]})", "{*[A:* + A:* + A:*]}"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{Floor} * $a + $b", "Floor · a + b"),
        ("({Floor} * $a + $b) / $c", "(Floor · a + b) over c"),
        ("$a - ($b - $c)", "a − (b − c)"),
        ("$a - ($b + $c)", "a − (b + c)"),
        ("$a - $b - $c", "(a − b) − c"),
        ("$a / ($b * $c)", "a over (b · c)"),
        ("$a * $b / $c", "a · b over c"),
        ("{Floor} % 2 == 1", "Floor modulo 2 equal to 1"),
        ("$a > $b", "a above b"),
        ("odd({A:0}, {A:1}, {A:2})", "number unlike the most among A:0, A:1 and A:2"),
        ("equal({A}, {B}, {C}, {D}, {E})", "A to E (5) alike"),
        ("not ($a == $b)", "not a equal to b"),
        ("{A:0} + {B:0}", "A:0 + B:0"),
        ("{A:1} / {A:*}", "share of A:1"),
        ("({A:1} > 0) * $h + $w", "h where used + w"),
        ("count({A:0}, {A:1})", "number of kinds of A"),
        ("count({A:0}, {B}, not {C})", "number of these: A:0, B and not C"),
        ("followed(1, 2, $a, $b, $c)", "alternative 1 followed by 2 among a, b and c"),
        ("{A} - max({A:0}, {A:1})", "number of A unlike the most"),
        ("which({A > B@0:0}, {A > B@1:0})", "position of the first of A > B@0:0 and A > B@1:0"),
        ("which(0, {A:1})", "A"),
        (f"{BOTH} - {ALIKE}", "exceptions to adjacent A with the same choice"),
        (f"{BOTH} > 0 and {ALIKE} == 0", "no adjacent A with the same choice"),
        (f"{BOTH} > 0 and {ALIKE} == 0 and {FAR} == {THREE}", "adjacent A with the same choice by turns"),
        ("{S[L@0:0, R@1:0]} + {S[L@0:1, R@1:1]}", "same choice at S › L and S › R@1"),
    ],
)
def test_words_bind_as_the_formula_does(text, words):
    assert formula_words(Expression.parse(text).formula, {}) == words


def test_a_choice_at_a_place_is_named_as_the_table_names_the_place():
    grammar = Grammar.parse(
        """
        Lot --> 50% : Pair Tower else : Tower
        Pair --> Tower Tower
        Tower --> 30% : Brick else : Glass
        """
    )
    table = extract([derive(grammar, 200, seed=1)])
    names = dict(zip(table.features, table.names, strict=True))
    places = [f"which({{Pair:* > Tower@{i}:0}}, {{Pair:* > Tower@{i}:1}})" for i in (0, 1)]
    formula = Expression.parse(f"equal({places[0]}, {places[1]})").formula
    assert formula_words(formula, names) == "Pair › Tower 1 and Pair › Tower 2 alike"
    role = Expression.parse("which({A:0} + {B:0}, {A:1} + {B:1})").formula
    assert formula_words(role, {}) == "A or B"
