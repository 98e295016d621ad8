"""Formulas in words."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest

from grammarlab.arrays import Floats
from grammarlab.derivation.derive import derive
from grammarlab.features.columns.formula_names import ONE_OF, formula_words, unit_of
from grammarlab.features.columns.vocabulary import extract
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.operations import evaluate
from grammarlab.features.patterns.pattern import Atom, Draw, Pattern
from grammarlab.language.dimensions import UNKNOWN
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
        ("$a - $b - $c", "a − b − c"),
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


def is_said(words: str, made: dict[str, str]) -> bool:
    """Whether a sentence about pairs of choices is true of what was made of each choice."""

    def holds(text: str) -> bool:
        place, sign, values = text.split(" ", 2)
        return (made[place] in values.split(" / ")) == (sign == "=")

    rows = words.removeprefix(ONE_OF).split(", or ")
    assert words.startswith(ONE_OF) == (len(rows) > 1)
    return any(all(map(holds, row.split(" with "))) for row in rows)


@pytest.mark.parametrize("seed", range(20))
def test_tables_of_pairs_say_which_alternatives_go_together(seed):
    """Random tables of two choices of three alternatives each, which may also be missing, in all 16 cases."""
    randomness = random.Random(seed)

    def some(symbol: str) -> str:
        total = " + ".join(f"{{{symbol}:{i}}}" for i in sorted(randomness.sample(range(3), randomness.randint(1, 2))))
        return f"not ({total})" if randomness.random() < 0.3 else f"({total})"

    text = " or ".join(f"{some('A')} and {some('B')}" for _ in range(randomness.randint(1, 3)))
    formula = Expression.parse(text).formula
    atoms = {Pattern(symbol, branch=(i,)): f"{symbol} → {symbol}{i}" for symbol in "AB" for i in range(3)}
    words = formula_words(formula, {**atoms})
    cases = list(itertools.product(["A0", "A1", "A2", ""], ["B0", "B1", "B2", ""]))
    columns: dict[Atom, Floats] = {}
    columns |= {
        atom: np.array([float(name[-2:] in case) for case in cases])
        for atom, name in atoms.items()
        if str(atom) in text
    }
    truth = evaluate(formula.steps, columns, len(cases)) != 0.0
    assert [is_said(words, dict(zip("AB", case, strict=True))) for case in cases] == truth.tolist(), words


def test_what_is_no_pair_of_choices_is_no_table():
    names = {Pattern("A", branch=(0,)): "A → x", Pattern("B", branch=(0,)): "B → y", Pattern("C"): "number of C"}
    for text, words in (
        ("{A:0} and {C}", "A → x and number of C"),
        ("{A:0} or {B:0}", "A → x or B → y"),
        ("{A:0} and {B:0} and {A:0} + 1", "A = x with B = y and (A → x + 1)"),
        ("({C} > 0 and $k:1) and {A:0}", "k = 1 with A = x"),
    ):
        assert formula_words(Expression.parse(text).formula, {**names, Draw("k", 1): "k = 1"}) == words


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("$h", "m"),
        ("$h + $w", "m"),
        ("$h * $w + 3", "m²"),
        ("{Floor} * $h + $w", "m"),
        ("{Floor} + $h", ""),
        ("$h * $w / $w", "m"),
        ("$h / $w", ""),
        ("min($h, 2 * $w)", "m"),
        ("$h > $w", ""),
        ("$pitch - $h", ""),
        ("($pitch + 10) / 2", "°"),
        ("sqrt($h * $w)", ""),
        ("$h * $w * $h * $w", ""),
        ("{Floor}", ""),
        ("$h * $share", "m"),
        ("$h * $any", ""),
        ("$any", ""),
        ("$h / $any * $any", ""),
        ("sqrt($h * $w) * $h", ""),
    ],
)
def test_units_of_formulas_are_those_of_what_they_read(text, unit):
    units = {"h": "m", "w": "m", "pitch": "°", "share": ""}
    assert unit_of(Expression.parse(text).formula, lambda name: units.get(name, UNKNOWN)) == unit
