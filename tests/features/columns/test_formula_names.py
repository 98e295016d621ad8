"""Formulas in words."""

from __future__ import annotations

import itertools
import random
import re
from pathlib import Path

import numpy as np
import pytest

import grammarlab as gl
from grammarlab.arrays import Floats
from grammarlab.derivation.derive import derive
from grammarlab.features.columns.column_names import FeatureNames
from grammarlab.features.columns.formula_names import (
    COMBINATION,
    MAX_LENGTH,
    ONE_OF,
    RELATION,
    formula_words,
    unit_of,
)
from grammarlab.features.columns.vocabulary import Options, extract
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.node_labels import NodeLabels
from grammarlab.features.patterns.operations import evaluate
from grammarlab.features.patterns.pattern import Atom, Draw, Formula, Pattern, Threshold
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.dimensions import UNKNOWN
from grammarlab.language.grammar import Grammar
from grammarlab.learning.chosen_candidates import chosen_candidates
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.settings import FeatureOptions
from tests.cases import some, takes_turns

ALIKE, BOTH = "({*[A:0 + A:0]} + {*[A:1 + A:1]})", "{*[A:* + A:*]}"
RAW = re.compile(r"[@$*{}\[\]]|>|\w:[\d*]")
"""What only the text of a formula has."""
TOWERS = """
Lot --> 50% : Pair else : Tower
Pair --> Tower Tower
Tower --> 30% : Brick. else : Glass.
"""
FAR, THREE = "({*[A:0 + A:* + A:0]} + {*[A:1 + A:* + A:1]})", "{*[A:* + A:* + A:*]}"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{Floor} * $a + $b", "number of Floor · a + b"),
        ("({Floor} * $a + $b) / $c", "(number of Floor · a + b) over c"),
        ("$a - ($b - $c)", "a − (b − c)"),
        ("$a - ($b + $c)", "a − (b + c)"),
        ("$a - $b - $c", "a − b − c"),
        ("$a / ($b * $c)", "a over (b · c)"),
        ("$a * $b / $c", "a · b over c"),
        ("{Floor} % 2 == 1", "number of Floor modulo 2 equal to 1"),
        ("$a > $b", "a above b"),
        (
            "odd({A:0}, {A:1}, {A:2})",
            "number unlike the most among A → alternative 1, A → alternative 2 and A → alternative 3",
        ),
        ("equal({A}, {B}, {C}, {D}, {E})", "number of A to number of E (5) alike"),
        ("equal($wall, {A}, {B}, {C}, {D})", "wall to number of D (5) alike"),
        ("not ($a == $b)", "not a equal to b"),
        ("{A:0} + {B:0}", "A → alternative 1 + B → alternative 1"),
        ("{A:1} / {A:*}", "share of A → alternative 2"),
        ("({A:1} > 0) * $h + $w", "h where used + w"),
        ("({A:1} > 3) * $h", "(A → alternative 2 above 3) · h"),
        ("$a + (0 - 1) * $b", "a − 1 · b"),
        ("$a + (-1)", "a − 1"),
        ("$a - (-1)", "a + 1"),
        ("$a - (0 - 1) * $b", "a + 1 · b"),
        ("$a + (-1 - $b)", "a − 1 − b"),
        ("$a - (-1 - $b)", "a − (-1 − b)"),
        ("$a + ((0 - 1) * $b < 2)", "a + (-1 · b below 2)"),
        ("$a + (-1 % $b)", "a + -1 modulo b"),
        ("$a + (-1 % $b + $c)", "a + -1 modulo b + c"),
        ("$a + (-1 and $b)", "a + (-1 and b)"),
        ("not ({A:0} and {B})", "not (A → alternative 1 and number of B)"),
        ("count({A:0}, {A:1})", "number of kinds of A"),
        ("({A:0} + {B}) and ({C} + {D})", "(A = alternative 1 or B) and (C or D)"),
        ("{A:0} and ({C} + {D})", "A = alternative 1 and (C or D)"),
        ("({A} + {B}) and ({C} + {A})", "(number of A + number of B) and (number of C + number of A)"),
        ("($a + $b) and {C}", "(a + b) and number of C"),
        ("({A} + ($h < 2)) and {C}", "(number of A + (h below 2)) and number of C"),
        ("count({A:0}, {B}, not {C})", "number of these: A → alternative 1, B and not C"),
        ("followed(1, 2, $a, $b, $c)", "alternative 1 followed by 2 among a, b and c"),
        ("{A} - max({A:0}, {A:1})", "number of A unlike the most"),
        (
            "which({A > B@0:0}, {A > B@1:0})",
            "position of the first of A › B (successor 1) → alternative 1 and A › B (successor 2) → alternative 1",
        ),
        ("which(0, {A:1})", "A"),
        (f"{BOTH} - {ALIKE}", "exceptions to adjacent A with the same choice"),
        (f"{BOTH} > 0 and {ALIKE} == 0", "no adjacent A with the same choice"),
        (f"{BOTH} > 0 and {ALIKE} == 0 and {FAR} == {THREE}", "adjacent A with the same choice by turns"),
        ("{S[L@0:0, R@1:0]} + {S[L@0:1, R@1:1]}", "same choice at S › L (successor 1) and S › R (successor 2)"),
    ],
)
def test_words_bind_as_the_formula_does(text, words):
    assert formula_words(Expression.parse(text).formula, FeatureNames()) == words


def test_a_choice_at_a_place_is_named_as_the_table_names_the_place():
    grammar = Grammar.parse(
        """
        Lot --> 50% : Pair Tower else : Tower
        Pair --> Tower Tower
        Tower --> 30% : Brick else : Glass
        """
    )
    table = extract([derive(grammar, 200, seed=1)])
    names = FeatureNames(dict(zip(table.features, table.names, strict=True)), table.labels)
    places = [f"which({{Pair:* > Tower@{i}:0}}, {{Pair:* > Tower@{i}:1}})" for i in (0, 1)]
    formula = Expression.parse(f"equal({places[0]}, {places[1]})").formula
    assert formula_words(formula, names) == "Pair › Tower 1 and Pair › Tower 2 alike"
    role = Expression.parse("which({A:0} + {B:0}, {A:1} + {B:1})").formula
    assert formula_words(role, FeatureNames()) == "A or B"


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
    words = formula_words(formula, FeatureNames({**atoms}))
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
        ("({C} > 2 and {B:0}) and {A:0}", "(number of C above 2) and B → y and A → x"),
        ("($a < 2 and {B:0}) and {A:0}", "(a below 2) and B → y and A → x"),
    ):
        assert formula_words(Expression.parse(text).formula, FeatureNames({**names})) == words


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Pair:* > Tower@1:0", "Pair › Tower 2 → Brick"),
        ("Pair > Tower@0:1", "Pair › Tower 1 → Glass"),
        ("Lot:1 > Tower@0:0", "Lot (Tower) › Tower → Brick"),
        ("Lot > *@0 > Tower@1:0", "Lot › Tower 2 → Brick"),
        ("Lot:0 > *@0 > Tower@1:0", "Lot (Pair) › Pair › Tower 2 → Brick"),
        ("Lot:0 >> Tower:1", "Lot (Pair) ⋯ Tower → Glass"),
        ("*[Tower:0 + Tower:1]", "Tower = Brick beside Tower = Glass"),
        ("Pair[Tower@0:0, Tower@1:1]", "Pair › Tower 1 = Brick with Pair › Tower 2 = Glass"),
        ("Tower", "number of Tower"),
        ("Tower:*", "number of Tower"),
        ("*:0", "parts → Pair / Brick"),
        ("Nowhere:1.0 > Else@3", "Nowhere (alternative 2.1) › Else (successor 4)"),
        ("Brick.", "number of Brick"),
    ],
)
def test_features_that_are_no_columns_are_named_as_columns_are(text, words):
    forest = derive(Grammar.parse(TOWERS), 200, seed=1)
    assert FeatureNames({}, NodeLabels.of([forest]))[parse(text)] == words


@pytest.mark.parametrize(
    ("text", "words", "place"),
    [
        ("A:0", "A → alternative 1", "A"),
        ("A[*@0:0]", "A › successor 1 → alternative 1", "A › successor 1"),
        ("A > *:0", "A › any → alternative 1", "A › any"),
        ("A >> *:0", "A ⋯ any → alternative 1", "A › any"),
        ("A > *@0 > *:0", "A › any → alternative 1", "A › any"),
        ("A:0 > *@1:0", "A (alternative 1) › successor 2 → alternative 1", "A › successor 2"),
        ("* > *:0", "parts → alternative 1", "parts"),
        ("* > *@1:0", "successor 2 → alternative 1", "successor 2"),
    ],
)
def test_a_choice_of_any_symbol_is_not_named_as_the_node_above_it(text, words, place):
    pattern, names = parse(text), FeatureNames()
    assert (names[pattern], names.place(pattern)) == (words, place)


def test_names_that_are_built_from_steps_are_those_of_columns():
    """Paths of a table whose nodes have branches are named alike, whether the table gives the name or not."""
    forest = derive(Grammar.parse(TOWERS), 200, seed=1)
    table = extract([forest], Options(length=3, far_pairs=True))
    built = FeatureNames({}, table.labels)
    assert [built[feature] for feature in table.features] == list(table.names)


@takes_turns
@pytest.mark.parametrize(
    "path", sorted((Path(__file__).parents[3] / "grammars").glob("*.cga")), ids=lambda path: path.stem
)
def test_no_formula_about_a_shipped_grammar_shows_its_syntax(path):
    """300 random candidates and all that random scores suggest, in the words of a grammar and of people."""
    space = GrammarSpace(gl.load(path.stem), gl.load(path.stem).assets)
    forests = list(space.sample(True, 40, 1))
    table = space.tabulated(forests, FeatureOptions())[1]
    names = FeatureNames(dict(zip(table.features, table.names, strict=True)), table.labels)
    made, randomness = space.candidates(forests), np.random.default_rng(0)
    features = [made.makers[index]() for index in randomness.permutation(len(made.makers))[:300]]
    features += [one.formula() for one in chosen_candidates(made.elements, randomness.uniform(0.0, 100.0, 40))]
    for feature in features:
        words = formula_words(feature, names) if isinstance(feature, Formula) else names[feature]
        for text in (words, space.display_names.text(words)):
            assert not RAW.search(text), (text, str(feature))
        assert len(words) <= MAX_LENGTH, (words, str(feature))


def test_words_for_what_is_too_long_name_all_that_it_reads():
    """Conditions are left out only if they say where a draw is used."""
    long = "Name" * 35
    pairs = " or ".join(f"({{Roof:0}} > 2 and {{Base:{number}}})" for number in range(12))
    for text, words in (
        (pairs, "a relation of Roof and Base"),
        (f"({{{long}}} > 0) * 2", f"a combination of {long}"),
        (
            " + ".join(f"({{Roof:0}} > 0) * $h{number} * $k" for number in range(12)),
            "a combination of h0, k, h1 and 10 others",
        ),
    ):
        assert formula_words(Expression.parse(text).formula, FeatureNames()) == words


@pytest.mark.parametrize(
    ("sign", "said"), [("<", "below"), ("<=", "at most"), (">", "above"), (">=", "at least"), ("==", "equal to")]
)
@pytest.mark.parametrize("bound", ["0", "2.5", "-1", "1000", "0.1"])
def test_a_draw_is_compared_with_the_number_of_the_text(sign, said, bound):
    for text, words in (
        (f"$a {sign} {bound}", f"a {said} {bound}"),
        (f"$a {sign} {bound} and {{B:1}}", f"(a {said} {bound}) and B → alternative 2"),
        (f"choose($a {sign} {bound}, 2, 3)", f"choice by a {said} {bound}, 2 and 3"),
    ):
        assert formula_words(Expression.parse(text).formula, FeatureNames()) == words


def test_names_that_are_too_long_are_cut():
    long = "X" * 200
    for text, start, end in (
        (f"{{{long}}} > 3", "a relation of XX", "X…"),
        (f"{{{long}}} * $h + $k", "a combination of XX", "X… and 2 others"),
    ):
        words = formula_words(Expression.parse(text).formula, FeatureNames())
        assert (len(words), words[: len(start)], words[-len(end) :]) == (MAX_LENGTH, start, end)


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


class Reader:
    """Reads words as a person does: products before sums, these before comparisons, ``not``, ``and`` and ``or``.

    What begins with ``not``, ``smallest of`` or ``abs of`` goes on as far as it can, up to a parenthesis.
    """

    LEVELS = (
        ((" or ", "or"),),
        ((" and ", "and"),),
        (
            *((" at most ", "<="), (" at least ", ">="), (" below ", "<"), (" above ", ">")),
            *((" equal to ", "=="), (" not equal to ", "!=")),
        ),
        ((" + ", "+"), (" − ", "-")),
        ((" · ", "*"), (" over ", "/"), (" modulo ", "%")),
    )

    def __init__(self, text: str, in_list: bool = False) -> None:
        self.text, self.in_list = text, in_list

    def level(self, number: int = 0) -> str:
        if number == len(self.LEVELS):
            return self.atom()
        value = self.level(number + 1)
        while sign := next(((word, sign) for word, sign in self.LEVELS[number] if self.text.startswith(word)), None):
            if self.in_list and sign[1] in ("and", "or"):
                break
            self.text = self.text.removeprefix(sign[0])
            value = f"({value} {sign[1]} {self.level(number + 1)})"
        return value

    def atom(self) -> str:
        for word, operation in (("smallest of ", "min"), ("largest of ", "max"), ("abs of ", "abs"), ("not ", "not")):
            if self.text.startswith(word):
                self.text = self.text.removeprefix(word)
                if operation == "abs":
                    inner = Reader(self.text, in_list=True)
                    value, self.text = inner.level(), inner.text
                    return f"abs({value})"
                return f"(not {self.level(2)})" if operation == "not" else f"{operation}({self.elements()})"
        if self.text.startswith("("):
            inner = Reader(self.text[1:])
            value = inner.level()
            assert inner.text.startswith(")"), inner.text
            self.text = inner.text[1:]
            return f"({value})"
        found = re.match(r"-?[\d.,]*\d|[a-e]", self.text)
        assert found, self.text
        self.text = self.text[found.end() :]
        return found[0] if found[0] not in "abcde" else f"${found[0]}"

    def elements(self) -> str:
        inner = Reader(self.text, in_list=True)
        values = [inner.level()]
        while separator := next((each for each in (", ", " and ") if inner.text.startswith(each)), ""):
            inner.text = inner.text.removeprefix(separator)
            values.append(inner.level())
        self.text = inner.text
        return ", ".join(values)


def some_formula(randomness: random.Random, depth: int) -> str:
    if depth == 0:
        return randomness.choice(["$a", "$b", "$c", "$d", "$e", "2", "3"])
    inner = [some_formula(randomness, randomness.randrange(depth)) for _ in range(3)]
    if randomness.random() < 0.3:
        return randomness.choice(["min({0}, {1})", "max({0}, {1}, {2})", "abs({0})", "not ({0})"]).format(*inner)
    sign = randomness.choice(["+", "-", "*", "/", "%", "<", ">=", "==", "and", "or"])
    return f"(({inner[0]}) {sign} ({inner[1]}))"


@pytest.mark.parametrize("seed", some(range(300)))
def test_words_of_a_formula_are_read_as_the_formula(seed):
    """Random formulas in words, read by what a person knows of signs, have the values of the formulas."""
    randomness = random.Random(seed)
    formula = Expression.parse(some_formula(randomness, 4)).formula
    words = formula_words(formula, FeatureNames())
    if words.startswith((RELATION, COMBINATION)):
        return  # too long: only what it is about
    reader = Reader(words)
    read = Expression.parse(reader.level()).formula
    assert not reader.text
    values = {name: np.array([randomness.choice([-2.0, 0.0, 1.0, 2.5]) for _ in range(40)]) for name in "abcde"}
    with np.errstate(all="ignore"):
        expected, found = (values_of(each, values) for each in (formula, read))
    np.testing.assert_allclose(found, expected, rtol=1e-9, equal_nan=True)


def values_of(formula: Formula, values: dict[str, Floats]) -> Floats:
    columns: dict[Atom, Floats] = {Draw(name): column for name, column in values.items()}
    below: dict[Atom, Floats] = {
        atom: (values[atom.site] < atom.bound).astype(np.float64)
        for atom in formula.features
        if isinstance(atom, Threshold)
    }
    return evaluate(formula.steps, columns | below, 40)


def test_many_things_are_told_by_the_words_that_neighbours_begin_with():
    names = {"A": "Walls", "B": "Roof on brick", "C": "Roof on tile", "D": "Roof on tile, high", "E": "Base"}
    names |= {"F": "UpperFloorsOnBrick", "G": "UpperFloorsOnTile"}
    own = FeatureNames({Pattern(symbol): name for symbol, name in names.items()})

    def words(symbols):
        return formula_words(Expression.parse(f"equal({', '.join(f'{{{each}}}' for each in symbols)})").formula, own)

    assert words("ABCDE") == "Walls, Roof (3) and Base alike"
    assert words("AFGEB") == "Walls, Upper floors (2), Base and Roof on brick alike"
    assert words("AEBCD") == "Walls, Base and Roof (3) alike"
    assert words("ABCD") == "Walls, Roof on brick, Roof on tile and Roof on tile, high alike"
    assert words("BCBDC") == "Roof on brick to Roof on tile (5) alike"
    assert words("BAEBXY") == "Roof on brick to number of Y (6) alike"
