"""Names of split symbols: they say what distinguishes them, and are valid and unique for any symbols."""

from __future__ import annotations

import re

import numpy as np
import pytest

from grammarlab.density.exact.compile import compile_density
from grammarlab.density.exact.readings import read
from grammarlab.derivation.derive import derive
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.checking.check import check_text
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import SUPPORTED

STREET = """@StartRule
Street --> [ House ] [ t(9, 0, 0) House ]
House --> 30% : Storey Roof 30% : Storey Storey Roof 20% : Storey Storey Storey Roof else : Shed
Storey --> 50% : extrude(3) StoreyBrick else : extrude(3) Plaster.
Roof --> 40% : RoofFlat 40% : RoofHip else : RoofGable
RoofFlat --> Tar.
RoofHip --> Tiles.
RoofGable --> Tiles.
Shed --> Wood.
StoreyBrick --> 80% : Red. else : Yellow.
"""


def learned(reads, preference, text=STREET):
    grammar = Grammar.parse(text)
    return compile_density(grammar, [parse(read) for read in reads], preference, forest=derive(grammar, 300, 1))


def new_names(text, before=STREET):
    return set(Grammar.parse(text).rules) - set(Grammar.parse(before).rules)


def names_of(reads, preference):
    return {name for name, _ in new_names(learned(reads, preference).text)}


def test_counts_of_parts_name_a_symbol():
    left, right = "Street[House@0 > Storey]", "Street[House@1 > Storey]"
    assert names_of([left, right], lambda v: (v[:, 0] == 3) & (v[:, 1] < 3)) >= {"House_three_storeys"}
    assert "House_shed" in names_of([left, right], lambda v: (v[:, 0] == 0) & (v[:, 1] > 0))


def test_branches_name_a_symbol():
    first, second = "Street[House@0 >> RoofFlat]", "Street[House@0 >> RoofHip]"
    names = names_of([first, second], lambda v: 1.0 * (v[:, 0] > 0))
    assert "Roof_flat" in names
    assert "Roof_not_hip" in names_of([first, second], lambda v: 1.0 * (v[:, 1] == 0))


@pytest.mark.parametrize(
    ("operations", "names"),
    [
        (("t(1, 0, 0)", "t(2, 0, 0)", "t(3, 0, 0)"), {"House_first", "House_not_second"}),
        (("color(1, 0, 0)", "color(1, 1, 0)", "color(0, 1, 0)"), {"House_red", "House_not_yellow"}),
    ],
)
def test_the_colour_or_else_the_place_of_a_branch_names_a_symbol(operations, names):
    first, second, third = operations
    text = f"""@StartRule
    Street --> House [ t(9, 0, 0) House ]
    House --> 50% : {first} Walls 30% : {second} Walls else : {third} Walls
    Walls --> extrude(3)
    """
    found = learned(["Street[House@0:0]", "Street[House@1:1]"], lambda v: 1.0 * (v[:, 0] > 0) * (v[:, 1] == 0), text)
    assert {name for name, _ in new_names(found.text, text)} == names


def test_preferences_of_what_is_all_possible_name_a_symbol():
    names = names_of(["Street[House@0 >> RoofHip]", "Street[House@1 >> RoofHip]"], lambda v: 1.0 + 3.0 * v[:, 0])
    assert names == {"House_mostly_roofHip", "Roof_mostly_hip"}


def test_what_a_branch_says_names_a_symbol():
    text = """@StartRule
    Street --> House [ t(9, 0, 0) House ]
    House --> 50% : Walls("plain trim") 30% : Walls("plain") else : Walls("#FFFFFF")
    Walls(kind) --> extrude(3)
    """
    found = learned(["Street[House@0:0]", "Street[House@1:2]"], lambda v: 1.0 * (v[:, 0] > 0) * (v[:, 1] == 0), text)
    assert {name for name, _ in new_names(found.text, text)} == {"House_plainTrim", "House_not_white"}
    assert "// House in Street: with House plain trim\n" in found.text


@pytest.mark.parametrize(
    ("ratio", "words"), [(0.5, {"more", "fewer"}), (0.1, {"mostly", "rarely"}), (0.01, {"nearlyOnly", "hardlyAny"})]
)
def test_the_degree_of_a_preference_is_in_the_name(ratio, words):
    for is_liked in (True, False):
        names = names_of(
            ["Street[House@0 >> RoofHip]", "Street[House@1 >> RoofHip]"],
            lambda v, is_liked=is_liked: np.where((v[:, 0] > 0) == is_liked, 1.0, ratio),
        )
        (name,) = (name for name in names if name.startswith("House_"))
        assert name.split("_")[1] in words
        assert (name.split("_")[1] in {"more", "mostly", "nearlyOnly"}) == is_liked


ODD = ("日本Wall", "Ünder_Öl", "_", "__", "case_", "A" * 200, "A" * 199 + "B", "İx", "attr1", "House_no_x", "NILs")
NAMES = ("House", "Storey", "Roof", "RoofFlat", "RoofHip", "RoofGable", "Shed", "StoreyBrick")
READS = ("Street[House@0 > Storey]", "Street[House@1 > Shed]", "Street[House@0 >> RoofHip]")


def test_comments_above_symbols_name_the_parts_that_these_have():
    text = """@StartRule
    Lot --> Base Roof
    Base --> 50% : Shop. 30% : Home. else : Barn.
    Roof --> 50% : Flat. 30% : Hip. else : Gable.
    """
    reads, score = read(Expression.parse("{Base:0} + {Roof:0} == 1"))
    new = compile_density(Grammar.parse(text), reads, score).text
    assert set(re.findall(r"// (Base|Roof) in Lot: with(?:out)? (.*)", new)) == {("Base", "Shop."), ("Roof", "Flat.")}


def test_comments_above_symbols_do_not_deny_themselves():
    text = """@StartRule
    Lot --> House [ t(9, 0, 0) House ]
    House --> 50% : color(1, 0, 0) Walls. 30% : color(1, 1, 0) Walls. else : color(0, 1, 0) Walls.
    """
    new = learned(["Lot[House@0:0]", "Lot[House@1:1]"], lambda v: 1.0 * (v[:, 0] > 0) * (v[:, 1] == 0), text).text
    assert re.findall(r"// House in Lot: (.*)", new) == ["with House red", "never with House yellow"]


def test_new_names_are_not_those_of_imported_rules():
    text = """@StartRule
    Street --> p.Wall [ t(9, 0, 0) p.Wall ]
    p.Wall --> 50% : Brick. else : p.Wall_green
    p.Wall_green --> 50% : Ivy. else : Moss.
    """
    found = learned(["Street[p.Wall@0 > p.Wall_green]"], lambda v: 1.0 * (v[:, 0] > 0), text)
    assert {name for name, _ in new_names(found.text, text)} == {"p.Wall_green_2"}
    assert found.text.count("p.Wall_green -->") == 1


@pytest.mark.parametrize("seed", range(4))
def test_odd_names_stay_valid_and_unique(seed):
    random = np.random.default_rng(seed)
    odd: dict[str, str] = dict(zip(NAMES, random.permutation(ODD).tolist(), strict=False))
    text, *reads = (re.sub(r"\w+", lambda match: odd.get(match[0], match[0]), each) for each in (STREET, *READS))
    values = random.random(5)
    found = learned(reads, lambda v: values[(v @ [1, 2, 3] % 5).astype(int)] * (v[:, 0] != 1), text)
    assert check_text(found.text, "learned.cga", SUPPORTED) == ()
    # Each definition is a rule of its own: none has the name of another one.
    heads = re.findall(r"^(\w+) -->", found.text, re.MULTILINE)
    assert len(NAMES) <= len(heads) == len(set(heads)) == len(found.grammar.rules)
    assert max(map(len, heads)) <= max(map(len, odd.values())) + 45
    assert (count(found.sample(50, 1), [parse(reads[0])]) != 1).all()
