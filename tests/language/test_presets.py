"""Presets of rule files: the models of the same choices made when deriving, from an ordinary text."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.errors import UsageError
from grammarlab.language.grammar import Grammar
from grammarlab.language.presets import RuleChoices, preset, preset_differences
from grammarlab.language.syntax.syntax_tree import Number
from grammarlab.runs.sample.sources import load

TEXT = """// A house.
@Group("size") @Range(min=1, max=9)
attr height = 3 // metres
attr tone = "red"
attr shops = false
attr floors =
    20% : 1
    else : rand(2, 5)

@Hidden @StartRule
Lot --> extrude(height) A
@startrule( )
start Other --> 50% : A else : B
House --> case shops : extrude(height) color(tone) A else : s(rand(1, 2), 0, 0) B
Part(n) --> A
extension Tower --> 30% : extrude(floors) A else : House
"""


def leaves(grammar, **options):
    forest = derive(grammar, 12, 5, **options)
    names = [forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]]
    return names, forest.leaves.size.tolist(), forest.nodes.model[forest.leaves.node].tolist()


@pytest.mark.parametrize("start", ["", "Lot", "Other", "House", "Tower"])
@pytest.mark.parametrize(
    "values", [{}, {"height": 7.25, "shops": True}, {"height": 2, "tone": 'a "b" \\ blue', "shops": True}]
)
def test_models_of_a_preset_are_those_of_the_same_choices_in_a_derivation(start, values):
    grammar = Grammar.parse(TEXT)
    chosen = preset(grammar, start, values)
    assert leaves(chosen) == leaves(grammar, start_rule=start or None, attributes=values)
    assert preset(chosen, start, values).text == chosen.text
    if start:
        assert [rule.name for rule in chosen.start_rules] == [start]


def test_a_preset_of_nothing_is_the_grammar_and_all_other_text_is_kept():
    grammar = Grammar.parse(TEXT)
    assert preset(grammar) is grammar
    unmarked = Grammar.parse("Lot --> A  House --> B")
    assert preset(unmarked, "Lot") is unmarked
    chosen = preset(grammar, "House", {"height": 4, "floors": 3})
    changed = TEXT.replace("height = 3 //", "height = 4 //").replace("\n    20% : 1\n    else : rand(2, 5)", " 3")
    changed = changed.replace("@Hidden @StartRule\nLot", "@Hidden Lot").replace("@startrule( )\nstart Other", "Other")
    assert chosen.text == changed.replace("House -->", "@StartRule\nHouse -->", 1)
    assert chosen.attributes["height"].annotations == grammar.attributes["height"].annotations


def test_a_constant_instead_of_a_random_value_keeps_the_density_of_the_rest():
    grammar = Grammar.parse("attr h = rand(3)  Lot --> 25% : extrude(h) A else : extrude(h) B")
    constant = derive(preset(grammar, attributes={"h": 2}), 4000, 1)
    assert np.all(constant.leaves.size[:, 1] == 2.0)
    share = np.mean([constant.symbols[symbol] == "A" for symbol in constant.nodes.symbol[constant.leaves.node]])
    assert share == pytest.approx(0.25, abs=4 * np.sqrt(0.25 * 0.75 / 4000))


@pytest.mark.parametrize(
    ("start", "values", "message"),
    [
        ("Hous", {}, "start rule 'Hous' is not a rule of the file; did you mean 'House'"),
        ("Zzz", {}, "expected one of Lot, Other, House, Tower"),
        ("Part", {}, "'Part' has parameters; expected a rule without"),
        ("", {"heigth": 3}, "unknown attribute 'heigth'; did you mean 'height'"),
        ("", {"height": "tall"}, "attribute 'height': expected a finite number, found 'tall'"),
        ("", {"height": True}, "expected a finite number, found True"),
        ("", {"height": float("nan")}, "expected a finite number, found nan"),
        ("", {"height": 12}, "attribute 'height': expected 1 to 9, found 12"),
        ("", {"shops": 1}, "attribute 'shops': expected true or false, found 1"),
        ("", {"tone": 1}, "attribute 'tone': expected a text, found 1"),
        ("", {"tone": "a\rb"}, "expected a text of one line"),
        ("", {"tone": [1]}, "expected a text, found"),
    ],
)
def test_choices_that_do_not_fit_are_refused(start, values, message):
    with pytest.raises(UsageError, match=message):
        preset(Grammar.parse(TEXT), start, values)


def test_choices_in_a_style_are_those_of_the_style():
    grammar = Grammar.parse(TEXT + "style Tall  attr height = 8  Attic --> B")
    chosen = RuleChoices(style="Tall", start_rule="Attic", attributes={"floors": 2.0}).apply(grammar)
    assert [rule.name for rule in chosen.start_rules] == ["Attic"]
    assert chosen.attributes["height"].value == Number(8.0)
    with pytest.raises(UsageError, match="'Attic' is not a rule"):
        RuleChoices(start_rule="Attic").apply(grammar)


def test_differences_are_those_of_the_choices():
    grammar = Grammar.parse(TEXT)
    assert preset_differences(grammar, grammar) == ()
    chosen = preset(grammar, "House", {"height": 4})
    assert preset_differences(grammar, chosen) == ("start rule Lot, Other, now House", "attribute height = 3, now 4")
    long_values = [Grammar.parse(f'attr tone = "{letter * 9000}" Lot --> A') for letter in "ab"]
    assert max(map(len, preset_differences(*long_values))) < 200


def test_equal_choices_have_equal_hashes_and_plain_values():
    values: dict[str, Any] = {"floors": np.int64(2), "tone": "red", "height": np.float32(2.5), "shops": True}
    choices = RuleChoices(library="lib", attributes=values)
    again = RuleChoices(library=Path("lib"), attributes=dict(reversed(values.items())))
    assert (hash(choices), repr(choices)) == (hash(again), repr(again))
    assert choices == again
    assert [type(value) for value in choices.attributes.values()] == [float, float, bool, str]
    assert choices.apply(Grammar.parse(TEXT)).attributes["height"].value == Number(2.5)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"start_rule": 3}, "start_rule: expected str"),
        ({"style": None}, "style: expected str"),
        ({"library": 3}, "library: expected Path or str"),
        ({"attributes": [("height", 2)]}, "attributes: expected Mapping"),
        ({"attributes": {1: 2}}, "name of an attribute: expected str"),
        ({"attributes": {"height": 10**5000}}, "attribute 'height': expected a finite number, found an integer"),
    ],
)
def test_choices_of_other_types_are_refused(options, message):
    with pytest.raises(UsageError, match=message):
        RuleChoices(**options)
    with pytest.raises(UsageError, match="choices: expected RuleChoices"):
        load("toy", options)
