"""The numbering of a grammar, against the engine and the text."""

import numpy as np
import pytest

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import compile_grammar, derive
from grammarlab.derivation.expressions import number_grammar
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.language.syntax.syntax_tree import Numbered, walk
from tests.whole_grammars import WHOLE

GRAMMARS = WHOLE
TEXT = """\
attr h = 30% : rand(1, 2) else : 4
Lot --> 25% : extrude(h) [ A ] split(x) { 3 : B | { 2 : C(p(0.5)) }* } scatter(surface, 2, uniform) { D }
        else : case h > 3 : NIL A
"""


def words_at(text, locations):
    lines = text.splitlines()
    return [lines[place.line - 1][place.column - 1 :] for place in locations]


def test_successors_blocks_and_random_places_have_numbers_and_stand_where_the_text_has_them():
    numbering = number_grammar(Grammar.parse(TEXT))
    first, second = numbering.branches
    assert [successor.key for successor in first.successors] == [("A", 0), ("B", 0), ("C", 1), ("D", 0)]
    assert all(
        found.startswith(successor.key[0])
        for successor, found in zip(
            first.successors, words_at(TEXT, [s.location for s in first.successors]), strict=True
        )
    )
    assert [found.split("(")[0] for found in words_at(TEXT, first.blocks)] == ["split", "scatter", "scatter"]
    assert (second.branch, [successor.key for successor in second.successors]) == ((1, 0), [("A", 0)])
    assert [place.owner for place in numbering.random_places] == ["h", "h", "Lot", "Lot"]
    found = words_at(TEXT, [place.node.location for place in numbering.random_places])
    assert [word[:4] for word in found] == ["30% ", "rand", "25% ", "p(0."]


@pytest.mark.parametrize("path", GRAMMARS, ids=lambda path: path.stem)
def test_forests_are_numbered_so(path):
    grammar = load(path)
    numbering, program = number_grammar(grammar), compile_grammar(grammar)
    assert numbering.symbols == program.symbols
    assert [(*b.key, b.branch, b.location.line) for b in numbering.branches] == [
        (r.symbol, r.parameters, r.branch, r.line) for r in program.rule_names
    ]
    assert [p.node.location.line for p in numbering.random_places] == [site.line for site in program.sites]
    nodes = derive(program, 20, 3, assets=AssetFolder(path.parent / "assets")).nodes
    below = np.flatnonzero(nodes.parent >= 0)
    for symbol, parent_rule, child in {
        *zip(
            nodes.symbol[below].tolist(),
            nodes.rule[nodes.parent[below]].tolist(),
            nodes.child[below].tolist(),
            strict=True,
        )
    }:
        successor = numbering.branches[parent_rule].successors[child]
        assert successor.key[0] == numbering.symbols[symbol]


def test_numbers_count_the_places_of_chance_and_calls_through_the_tree():
    tree = Grammar.parse(TEXT).tree
    numbers = [node.number for node in walk(tree) if isinstance(node, Numbered)]
    assert numbers == list(range(len(numbers)))
    assert Grammar.parse("// a comment\n" + TEXT).tree == tree
