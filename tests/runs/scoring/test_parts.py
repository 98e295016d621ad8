"""Parts of models and the rules that made them."""

import numpy as np
import pytest

from grammarlab.derivation import compile_grammar, derive
from grammarlab.derivation.vocabulary import number_grammar
from grammarlab.errors import UsageError
from grammarlab.language.grammar import Grammar
from grammarlab.runs.scoring.parts import PartFinder
from grammarlab.scene import realize, triangles

TEXT = """\
Lot --> [ extrude(4) color(1, 0, 0) Box ] color(0, 1, 0) split(x) { 5 : Plate | ~1 : [ t(0, 9, 0) Plate ] NIL } Empty
Box --> comp(f) { side : 50% : Wall. else : Pane | top : color(0, 0, 1) Roof }
Pane --> extrude(0.1)
Empty --> NIL
"""


def finder(text=TEXT):
    grammar = Grammar.parse(text, "lot.cga")
    forest = derive(compile_grammar(grammar), 1, 5, first_model=3)
    return PartFinder.of("5:3", forest, number_grammar(grammar))


def test_every_triangle_belongs_to_one_part_and_parts_come_in_the_order_of_the_derivation():
    parts = finder()
    found = [parts.find(number, False) for number in range(len(parts.parts))]
    assert [part.number for part in found] == list(range(found[0].count))
    owners = np.concatenate([np.arange(*part.triangles) for part in found])
    assert sorted(owners.tolist()) == list(range(len(triangles(realize(parts.forest)).triangles)))
    for part in found:
        for triangle in range(*part.triangles):
            assert parts.find(triangle, True) == part
    assert parts.find(-1, False) == found[-1]
    assert parts.find(len(found), False) == found[0]


def test_the_path_names_symbols_with_the_places_of_their_branches():
    lines = TEXT.splitlines()
    parts = finder()
    for number in range(len(parts.parts)):
        path = parts.find(number, False).path
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
