"""What a grammar leaves to chance, from its text and from samples."""

import pytest

from grammarlab.density.grammar_skeleton import Alternative, Cases, Chance, TreeGrammar, leaves
from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.shipped import shipped_examples

TEXT = """
attr p = 20
Lot --> 25% : extrude(2) [ A ] split(x) { 3 : B | { 2 : C }* | ~1 : NIL D } [ 50% : E else : NIL ] F NIL G
        else : case p > 3 : A
A --> p% : B else : C
"""


def skeleton(text=TEXT):
    return TreeGrammar.of(Grammar.parse(text))


def test_successors_are_numbered_as_the_engine_numbers_them():
    first, second, none = leaves(skeleton().body(("Lot", 0)))
    assert [(s.key[0], s.copies, s.certain) for s in first.successors] == [
        ("A", 1, True),
        ("B", 1, False),
        ("C", None, False),
        ("D", 1, False),
        ("E", None, False),
        ("F", 1, True),
        ("G", 1, True),
    ]
    assert (second.branch, none.branch, none.successors) == ((1, 0), None, ())


def test_successors_of_scattered_points_are_numbered_as_the_engine_numbers_them():
    text = "Lot --> A scatter(surface, 5, uniform) { B [ C ] } split(x) { ~1 : D }"
    body = skeleton(text).body(("Lot", 0))
    assert isinstance(body, Alternative)
    assert [(s.key[0], s.copies) for s in body.successors] == [("A", 1), ("B", None), ("C", None), ("D", 1)]
    nodes = derive(Grammar.parse(text), 1, 1).nodes
    assert nodes.child[1:].tolist() == [0] + [1] * 5 + [2] * 5 + [3]


def test_chances_have_probabilities_where_the_text_tells_them():
    body = skeleton().body(("Lot", 0))
    assert isinstance(body, Chance)
    assert body.probabilities == (0.25, 0.75)
    assert isinstance(body.branches[1], Cases)
    assert not body.branches[1].complete
    inner = skeleton().body(("A", 0))
    assert isinstance(inner, Chance)
    assert inner.probabilities is None


@pytest.mark.parametrize("source", shipped_examples(), ids=lambda source: source.name)
def test_forests_have_the_children_that_the_skeleton_says(source):
    grammar = Grammar.parse(source.text())
    tree = TreeGrammar.of(grammar)
    forest = derive(grammar, 3, 1, assets=source.assets)
    ends = {(*key, a.branch): a for key in tree.bodies for a in tree.alternatives(key)}
    nodes = forest.nodes
    for row in range(3, len(nodes)):  # roots come first
        rule = forest.rules[nodes.rule[nodes.parent[row]]]
        end = ends[rule.symbol, rule.parameters, rule.branch]
        assert end.successors[nodes.child[row]].key[0] == forest.symbols[nodes.symbol[row]]


def test_a_sample_tells_how_often_successors_occur():
    text = "Lot --> s(10, 10, 10) primitiveCube() comp(f) { top : A | side : B } split(x) { rand(-1, 1) : C | ~1 : D }"
    forest = derive(Grammar.parse(text), 60, 1)
    (end,) = leaves(skeleton(text).observed(forest).body(("Lot", 0)))
    assert isinstance(end, Alternative)
    assert [(s.key[0], s.copies) for s in end.successors] == [("A", 1), ("B", 4), ("C", None), ("D", 1)]


def test_few_derivations_only_contradict():
    text = "Lot --> primitiveCube() comp(f) { top : A } split(x) { 0 : B | ~1 : C }"
    forest = derive(Grammar.parse(text), 5, 1)
    (end,) = leaves(skeleton(text).observed(forest).body(("Lot", 0)))
    assert [s.copies for s in end.successors] == [None, 1, 1]


def test_a_grammar_without_a_beginning_is_refused():
    with pytest.raises(UsageError, match="unknown start rule"):
        skeleton("Lot(a) --> A")
