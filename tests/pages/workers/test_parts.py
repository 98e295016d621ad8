"""Parts of models and the rules that made them."""

import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.pages.workers.artist import PartFinder
from grammarlab.scene import triangles

TEXT = """\
Lot --> [ extrude(4) color(1, 0, 0) Box ] color(0, 1, 0) split(x) { 5 : Plate | ~1 : [ t(0, 9, 0) Plate ] NIL } Empty
Box --> comp(f) { side : 50% : Wall. else : Pane | top : color(0, 0, 1) Roof }
Pane --> extrude(0.1)
Empty --> NIL
"""


ADDRESS = Address(False, 5, 3)


def finder(text=TEXT):
    return PartFinder(str(ADDRESS), GrammarSpace(Grammar.parse(text, "lot.cga")).parts(ADDRESS))


def all_parts(parts):
    return [parts.find(number, False) for number in range(parts.find(0, False).count)]


def test_every_triangle_belongs_to_one_part_and_parts_come_in_the_order_of_the_derivation():
    parts = finder()
    found = all_parts(parts)
    assert [part.number for part in found] == list(range(found[0].count))
    owners = np.concatenate([np.arange(*part.triangles) for part in found])
    assert sorted(owners.tolist()) == list(
        range(len(triangles(GrammarSpace(Grammar.parse(TEXT)).realize([ADDRESS]).scene).triangles))
    )
    for part in found:
        for triangle in range(*part.triangles):
            assert parts.find(triangle, True) == part
    assert parts.find(-1, False) == found[-1]
    assert parts.find(len(found), False) == found[0]


def test_the_path_names_symbols_with_the_places_of_their_branches():
    lines = TEXT.splitlines()
    parts = finder()
    for part in all_parts(parts):
        path = part.path
        assert path[0] == ("Lot", "lot.cga:1:11")
        for symbol, place in path[1:]:
            file, line, column = place.split(":")
            assert file == "lot.cga"
            word = lines[int(line) - 1][int(column) - 1 :]
            starts = {"Box": "comp", "Pane": "extrude"}.get(symbol, symbol)
            assert word.startswith(starts)


def test_what_is_not_there_is_refused():
    with pytest.raises(UsageError, match="expected 0 to"):
        finder().find(10**9, True)
    with pytest.raises(UsageError, match="no visible part"):
        finder("Lot --> NIL").find(0, False)
