"""Units of draws: what annotations say of the shipped grammars follows from their operations, too."""

import itertools
from dataclasses import replace

import pytest

from grammarlab.language.dimensions import (
    UNKNOWN,
    _stated,
    _Units,
    unit_of_result,
    units_of_attributes,
    units_of_calls,
)
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import Attribute, Call, RuleFile, alternatives
from grammarlab.runs.sample.shipped import shipped_examples


def inferred(tree: RuleFile) -> dict[str, str]:
    """Units of the attributes that are drawn."""
    units = units_of_calls(tree)
    return {
        node.name: units[leaf.number]
        for node in tree.definitions
        if isinstance(node, Attribute)
        for leaf in alternatives(node.value)
        if isinstance(leaf, Call) and leaf.number in units
    }


def without_annotations(tree: RuleFile) -> RuleFile:
    return replace(
        tree,
        definitions=tuple(
            replace(node, annotations=()) if isinstance(node, Attribute) else node for node in tree.definitions
        ),
    )


def test_operations_say_what_authors_say():
    """The descriptions of the shipped grammars were written without this: no unit contradicts them, most are found."""
    agreed = total = 0
    for source in shipped_examples():
        tree = Grammar.parse(source.text()).tree
        stated = {
            node.name: unit
            for node in tree.definitions
            if isinstance(node, Attribute) and (unit := _stated(node.annotations))
        }
        units = inferred(without_annotations(tree))
        assert {name: units[name] for name in stated.keys() & units.keys()}.items() <= stated.items(), source.name
        agreed += len(stated.keys() & units.keys())
        total += len(stated)
    assert total > 30
    assert agreed >= 0.9 * total


@pytest.mark.parametrize(
    ("text", "units"),
    [
        ("Lot --> extrude(h) A", {"h": "m"}),
        ("Lot --> extrude('h) A", {"h": ""}),
        ("Lot --> extrude(h) split(y) { 'h : A }", {}),
        ("Lot --> extrude(world.up, h + 2) A", {"h": "m"}),
        ("Lot --> split(y) { ~h : A | 'v : B | { w : C }* }", {"h": "m", "v": "", "w": "m"}),
        ("Lot --> split(u, unitSpace, 0) { h : A | ~1 : B }", {}),
        ("Lot --> splitArea(x) { h : A }", {"h": "m²"}),
        ("Lot --> r(0, h, 0) t(v, 0, 0) A", {"h": "°", "v": "m"}),
        ("Lot --> roofHip(h, v) A", {"h": "°", "v": "m"}),
        ("Lot --> roofHip(byHeight, h) A", {"h": "m"}),
        ("Lot --> roofGable(byAngle, h, v, w) A", {"h": "°", "v": "m", "w": "m"}),
        ("Lot --> roofGable(20, 1, 1, true, h) A", {}),
        ("Lot --> roofShed(20, h) A", {}),
        ("Lot --> roofShed(byHeight, v, h) A", {"v": "m"}),
        ("Lot --> primitiveCylinder(h, v, w) A", {"v": "m", "w": "m"}),
        ("Lot --> setupUV(0, 1, 1) translateUV(0, h, h) A", {}),
        ("Lot --> Tower(h)\nTower(x) --> extrude(x) A", {"h": "m"}),
        ("Lot --> Tower(h)\nTower(x) --> case x > 3 : extrude(max(x, v)) A else : A", {"h": "m", "v": "m"}),
        ("f(x) = x + 1\nLot --> extrude(f(h)) A", {"h": "m"}),
        ("const k = case v > 1 : h else : 3\nLot --> extrude(k) A", {"h": "m"}),
        ("Lot --> extrude(h * v) split(y) { v : A }", {"h": "", "v": "m"}),
        ("Lot --> extrude(h * v * w) split(y) { v : A | 'w : A }", {"h": "", "v": "m", "w": ""}),
        ("Lot --> r(0, h * v, 0) extrude('v) A", {"h": "°", "v": ""}),
        ("Lot --> s(scope.sx - 2 * h, '1, scope.sz + v * 2 - w) A", {"h": "m", "v": "m", "w": "m"}),
        ("Lot --> extrude(w + 3 * h) A", {"w": "m"}),
        ("Lot --> t(0, h * rand(0, 1), 0) extrude(rand(3, 9)) A", {}),
        ("Lot with (k := h) --> extrude(k) A", {"h": "m"}),
        ("Lot with (h := v) --> r(0, h, 0) A", {"v": "°"}),
        ("Lot with (h := h) --> r(0, h, 0) A", {"h": "°"}),
        ("Lot with (k := v v := 3) --> extrude(k) A", {"v": "m"}),
        ("Lot(x) with (k := x) --> extrude(k) A\nStart --> Lot(w)", {"w": "m"}),
        ("const k with (v := h) = v\nLot --> extrude(k) A", {"h": "m"}),
        ("Lot --> extrude(h * 2) A", {}),
        ("Lot --> extrude(w / scope.sx) setbackToArea(w) { all : A }", {"w": "m²"}),
        ("Lot --> extrude(h) r(0, h, 0) A", {}),
        ("const k = h\nLot --> extrude(k) r(0, k, 0) A", {}),
        ("const k = h\nLot --> extrude(k) A(k)\nA(x) --> B(x)\nB(x) --> r(0, x, 0) C", {}),
        ("const k = h * v\nLot --> extrude(k) A(k)\nA(x) --> r(0, x, 0) t(v, 0, 0) C", {}),
        ('Lot --> set(h, 3) report("a", h) A(h)', {}),
    ],
)
def test_units_follow_from_the_places_of_values(text, units):
    attributes = "".join(f"attr {name} = rand(1, 9)\n" for name in "hvw")
    assert inferred(Grammar.parse(f"{attributes}{text}").tree) == units


@pytest.mark.parametrize(
    ("annotation", "unit"),
    [
        ("@Distance", "m"),
        ("@Angle", "°"),
        ('@Description("Height of a floor, metres")', "m"),
        ('@Description("Width in meters.")', "m"),
        ('@Description("Eaves (m)")', "m"),
        ('@Description("Area of the plot, m²")', "m²"),
        ('@Description("Turn [degrees]")', "°"),
        ('@Description("HEIGHT, METRES")', "m"),
        ('@Description("Shirt sizes: S, M")', ""),
        ('@Description("Academic title, Deg")', ""),
        ('@Description("Room")', ""),
        ('@Description("Number of stem")', ""),
    ],
)
def test_annotations_have_the_last_word(annotation, unit):
    """An attribute that both a length and an angle are made of has no unit unless its author says which."""
    text = f"{annotation}\nattr h = rand(1, 9)\nLot --> extrude(h) r(0, h, 0) A"
    assert inferred(Grammar.parse(text).tree).get("h", "") == unit


def test_products_and_quotients_of_units_are_inverse():
    for first, second in itertools.product(["", "m", "m²", "m³"], repeat=2):
        product = unit_of_result("*", (first, second))
        assert product == unit_of_result("*", (second, first))
        if product != UNKNOWN:
            assert unit_of_result("/", (product, second)) == first
    assert unit_of_result("*", ("°", "")) == unit_of_result("*", ("", "°")) == unit_of_result("*", (None, "°")) == "°"
    assert unit_of_result("*", ("°", "m")) == unit_of_result("/", ("m", "°")) == UNKNOWN
    assert unit_of_result("choose", ("", "m", "", "m", "m")) == "m"
    assert unit_of_result("choose", ("", "m", "", "m", "°")) == UNKNOWN
    assert unit_of_result("and", ("m", "m")) == unit_of_result("sqrt", ("",)) == ""
    assert unit_of_result("sqrt", ("m²",)) == UNKNOWN


@pytest.mark.parametrize("operation", ["+", "*", "/", "min"])
@pytest.mark.parametrize("other", ["", "m", "m²", "°", UNKNOWN, None])
def test_what_is_made_of_an_unknown_unit_is_unknown(operation, other):
    results = {unit_of_result(operation, units) for units in ((UNKNOWN, other), (other, UNKNOWN))}
    assert results == {UNKNOWN}


def test_only_what_a_grammar_defines_has_a_unit():
    text = "attr h = 3\nattr share = 0.5\nk = 2\nLot --> t(0, share * scope.sy, 0) extrude(h + rand(k, 2)) A"
    assert units_of_attributes(Grammar.parse(text).tree) == {"h": "m", "k": "m"}


def test_units_do_not_depend_on_the_order_of_definitions():
    """They are the least that agrees with all places, however that is found."""
    for source in shipped_examples():
        tree = Grammar.parse(source.text()).tree
        turned = replace(tree, definitions=tree.definitions[::-1])
        assert units_of_attributes(turned) == units_of_attributes(tree)
        assert units_of_calls(turned) == units_of_calls(tree)


@pytest.mark.parametrize("turn", [1, -1])
def test_a_long_chain_of_rules_is_followed_once(monkeypatch: pytest.MonkeyPatch, turn: int):
    rules = [f"R{number}(x) --> R{number + 1}(x)" for number in range(200)]
    text = "\n".join(["attr h = 3", "R --> R0(h)", *rules, "R200(x) --> extrude(x) A"])
    tree = Grammar.parse(text).tree
    followed: list[object] = []
    follow = _Units.follow
    monkeypatch.setattr(_Units, "follow", lambda units, flow: (followed.append(flow), follow(units, flow))[1])
    assert units_of_attributes(replace(tree, definitions=tree.definitions[::turn])) == {"h": "m"}
    assert len(followed) <= 2 * len(tree.definitions)
