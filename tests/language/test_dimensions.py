"""Units of draws: what annotations say of the shipped grammars follows from their operations, too."""

import itertools
from dataclasses import replace

import pytest

from grammarlab.language.dimensions import _stated, unit_of_result, units_of_calls
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
        ("Lot --> extrude('h) A", {}),
        ("Lot --> extrude(world.up, h + 2) A", {"h": "m"}),
        ("Lot --> split(y) { ~h : A | 'v : B | { w : C }* }", {"h": "m", "w": "m"}),
        ("Lot --> split(u, unitSpace, 0) { h : A | ~1 : B }", {}),
        ("Lot --> splitArea(x) { h : A }", {"h": "m²"}),
        ("Lot --> r(0, h, 0) t(v, 0, 0) A", {"h": "°", "v": "m"}),
        ("Lot --> roofHip(h, v) A", {"h": "°", "v": "m"}),
        ("Lot --> roofHip(byHeight, h) A", {"h": "m"}),
        ("Lot --> roofGable(byAngle, h, v, v) A", {"h": "°", "v": "m"}),
        ("Lot --> primitiveCylinder(h, v, w) A", {"v": "m", "w": "m"}),
        ("Lot --> setupUV(0, 1, 1) translateUV(0, h, h) A", {}),
        ("Lot --> Tower(h)\nTower(x) --> extrude(x) A", {"h": "m"}),
        ("Lot --> Tower(h)\nTower(x) --> case x > 3 : extrude(max(x, v)) A else : A", {"h": "m", "v": "m"}),
        ("f(x) = x + 1\nLot --> extrude(f(h)) A", {"h": "m"}),
        ("const k = case v > 1 : h else : 3\nLot --> extrude(k) A", {"h": "m"}),
        ("Lot --> extrude(h * v) split(y) { v : A }", {"v": "m"}),
        ("Lot --> extrude(h * 2) A", {}),
        ("Lot --> extrude(w / scope.sx) setbackToArea(w) { all : A }", {"w": "m²"}),
        ("Lot --> extrude(h) r(0, h, 0) A", {}),
        ("const k = h\nLot --> extrude(k) r(0, k, 0) A", {}),
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
        if product or not (first or second):
            assert unit_of_result("/", (product, second)) == first
    assert unit_of_result("*", ("°", "")) == "°"
    assert unit_of_result("*", ("°", "m")) == unit_of_result("/", ("m", "°")) == ""
    assert unit_of_result("choose", ("", "m", "", "m", "m")) == "m"
    assert unit_of_result("choose", ("", "m", "", "m", "°")) == ""
    assert unit_of_result("and", ("m", "m")) == ""
