"""What learned grammars read like."""

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.density.exact.compile import compile_density
from grammarlab.derivation.derive import derive
from grammarlab.errors import GrammarlabError
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.checking.check import check_text
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import SUPPORTED

HOUSE = """// Houses
version "2023.0"

// How wide a window is.
attr width = 2

@StartRule
House -->
    50% : Facade(3) Roof   // the usual kind
    else : Facade(5) Facade(3)

// A wall with something in it.
Facade(n) -->
    case n > 4 : Wide(n)
    else : Wide(n)

Wide(n) -->
    30% : extrude(n) Window
    50% : extrude(n) Door
    else : Wall.

// Not touched by anything.
Roof --> color("#111111") Tiles.
Window --> s(width, 1, 1) Glass.
Door --> Wood.
"""


def learn(text, pattern, preference, **options):
    return compile_density(Grammar.parse(text), [parse(p) for p in pattern], preference, **options)


def test_a_split_symbol_is_a_renamed_rule_with_its_condition_above_it():
    learned = learn(HOUSE, ["House:1 > Facade@1 >> Window"], lambda v: v[:, 0])
    assert "Facade(5) Facade_window(3)" in learned.text
    assert (
        "// Facade in House: with Facade >> Window\nFacade_window(n) -->\n    case n > 4 : Wide_window(n)"
        in learned.text
    )
    assert "// Wide in Facade_window: with Window\nWide_window(n) --> extrude(n) Window\n" in learned.text
    assert "the usual kind" not in learned.text


def test_a_learned_grammar_still_looks_at_the_street():
    text = """
    attr streetWidth = [0]
    Lot --> 50% : House else : extrude(2) Shed.
    House --> 30% : setback(streetWidth[0] / 4) { street.front : Garden. | remainder : Mass } else : Mass
    Mass --> extrude(3) comp(f) { street.front : Front. | streetSide || street.side : Wall. }
    """
    learned = learn(text, ["Lot > House"], lambda v: v[:, 0])
    assert all(word in learned.text for word in ("attr streetWidth = [0]", "street.front : Garden.", "streetSide ||"))
    forest = derive(Grammar.parse(learned.text), 20, 3, footprint=(9.0, 7.0), street_width=[8.0, 0.0, 0.0, 6.0])
    leaves = [forest.symbols[symbol] for symbol in forest.nodes.symbol]
    assert leaves.count("Front.") == 40  # two of each corner house
    assert 0 < leaves.count("Garden.") < 20


def test_what_does_not_change_keeps_text_comments_and_order():
    learned = learn(HOUSE, ["House:1 > Facade@1 >> Window"], lambda v: v[:, 0])
    lines = learned.text.splitlines()
    assert all(line in lines for line in HOUSE.split("@StartRule", maxsplit=1)[0].splitlines())
    for kept in ("// Not touched by anything.", "Wide(n) -->\n    30% : extrude(n) Window\n    50% : extrude(n) Door"):
        assert (kept in learned.text) == (kept != "// Not touched by anything.")  # Roof no longer occurs
    places = [learned.text.index(f"\n{name}") for name in ("House", "Facade(n)", "Wide(n)", "Window", "Door")]
    assert places == sorted(places)


def test_one_variant_keeps_its_name():
    learned = learn(HOUSE, ["House:0"], lambda v: 1.0 + 3.0 * v[:, 0])
    assert learned.text == HOUSE.replace("50% : Facade", "80% : Facade")
    only = learn(HOUSE, ["House:0"], lambda v: v[:, 0])
    assert "House --> Facade(3) Roof   // the usual kind" in only.text
    assert only.grammar.rules.keys() == Grammar.parse(HOUSE).rules.keys()


def test_names_are_not_taken_twice():
    text = HOUSE + "\nFacade_window --> NIL\nWide_window(n) --> NIL\n"
    learned = learn(text, ["House:1 > Facade@1 >> Window"], lambda v: v[:, 0])
    assert "Facade_window_2(n) -->" in learned.text
    assert {finding.code for finding in check_text(learned.text, "learned.cga", SUPPORTED)} == {"unreachable-rule"}


def test_learned_grammars_have_nothing_to_complain_about():
    for pattern in ("Window", "Door", "House:1", "Facade >> Window", "House[Facade >> Door]"):
        learned = learn(HOUSE, [pattern], lambda v: (v[:, 0] == 1) * 1.0, header=["From a test"])
        assert [finding.message for finding in check_text(learned.text, "learned.cga", SUPPORTED)] == []
        assert learned.text.startswith("// From a test\n\n// Houses\n")


def test_trees_can_be_seen_as_trees_of_the_original():
    learned = learn(HOUSE, ["House:1 > Facade@1 >> Window"], lambda v: v[:, 0])
    forest = learned.sample(200, 5)
    original = derive(Grammar.parse(HOUSE), 1, 0)
    assert (forest.symbols, forest.rules, forest.sites) == (original.symbols, original.rules, original.sites)
    assert (count(forest, [parse("House:1 > Facade@1 >> Window")]) == 1).all()
    assert set(count(forest, [parse("Window")]).ravel()) == {1.0, 2.0}


def test_small_probabilities_keep_their_digits():
    text = "Lot --> 50% : A else : B\nA --> 99.9999999% : x else : y\nB --> 60% : x else : z"
    learned = learn(text, ["A:0", "A:1"], lambda v: np.select([v[:, 0] > 0, v[:, 1] > 0], [1e-6, 1.0], 1e-12))
    grammar = Grammar.parse(text)
    forest = derive(grammar, 400, 1)
    values = count(forest, [parse("A:0"), parse("A:1")])
    wanted = np.select([values[:, 0] > 0, values[:, 1] > 0], [1e-6, 1.0], 1e-12)
    assert learned.ratio(forest) == pytest.approx(wanted / learned.mean_preference, rel=1e-12)


def test_a_recursive_start_symbol_keeps_both_of_its_meanings():
    text = "@StartRule\nLot --> 40% : House Lot else : House\nHouse --> 50% : Low. else : High."
    learned = learn(text, ["Lot > House@0:0"], lambda v: (v[:, 0] >= 2) * 1.0, cap=4)
    forest = learned.sample(300, 1)
    assert (count(forest, [parse("House:0")]) >= 2).all()
    assert learned.grammar.start_rule is not None
    assert learned.grammar.start_rule.name == learned.start[0]


def test_cases_inside_one_that_no_model_reaches_stay_as_they_are():
    text = """attr h = rand(3, 9)
Lot --> extrude(h) House
House -->
    case scope.sy > 99 :
        case scope.sx > 50 : Wide
        else : 50% : Tall else : Slim
    else : 50% : Low else : Flat
"""
    grammar = Grammar.parse(text)
    found = compile_density(
        grammar, [parse("Low")], lambda v: np.where(v[:, 0] > 0, 1.0, 0.0), forest=derive(grammar, 300, 1)
    )
    inner = "case scope.sx > 50 : Wide"
    assert inner in found.text
    assert (count(derive(found.grammar, 50, seed=2), [parse("Low")]) == 1).all()


def test_a_comment_above_a_rule_is_apart_from_the_rule_before_it():
    text = "Lot --> [ House ] House\nHouse --> Wall\nWall --> 50% : Brick else : Glass"
    grammar = Grammar.parse(text)
    reads = [parse("Lot[House@0 >> Brick]"), parse("Lot[House@1 >> Brick]")]
    found = compile_density(
        grammar, reads, lambda v: np.where(v[:, 0] > v[:, 1], 1.0, 0.0), forest=derive(grammar, 50, 1)
    )
    lines = found.text.splitlines()
    comments = [number for number, line in enumerate(lines) if line.startswith("//") and number]
    assert len(comments) >= 4
    assert not any(lines[number - 1].strip() for number in comments)


def test_a_text_with_other_rules_than_those_meant_is_refused():
    """A defect in the writing of rules is reported where the text is read again, and never ends in a file."""
    learned = learn(HOUSE, ["House:1 > Facade@1 >> Window"], lambda v: v[:, 0])
    facade = "Facade_window(n) -->"
    fewer = learned.text.replace(
        f"{facade}\n    case n > 4 : Wide_window(n)\n    else : Wide_window(n)", f"{facade} NIL"
    )
    for text in (f"{learned.text}\n{facade} NIL", fewer, f"{learned.text}\nOther --> NIL"):
        assert text != learned.text
        with pytest.raises(GrammarlabError, match="does not have the rules that are meant"):
            replace(learned, text=text).grammar  # noqa: B018
