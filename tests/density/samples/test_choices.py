"""Contexts, choices and how often their branches were taken, against walking the trees."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given
from hypothesis import strategies as st

from grammarlab.density.exact.attributes import attribute_parts
from grammarlab.density.exact.contexts import Contexts, NoContext, OpenPatterns, ParentEdges
from grammarlab.density.grammar_skeleton import TreeGrammar
from grammarlab.density.samples.choices import Choices, chances, relevant_choices
from grammarlab.derivation.derive import derive
from grammarlab.features.patterns import pattern_text
from grammarlab.features.patterns.pattern import Threshold
from grammarlab.language.grammar import Grammar
from tests.cases import bulk
from tests.density.exact.test_compile import Preference
from tests.density.trees import all_trees, count, grammars, patterns, text_of

few = bulk(30, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
TOWERS = Grammar.parse(
    """
Lot --> 30% : Tower else : Tower Tower
Tower --> 50% : Block else : Block Block
Block --> 40% : Box else : 50% : Glass(1) Roof else : Round
Glass(n) --> 20% : Black else : Blue
Roof --> Glass(2)
"""
)


def contexts_of(tree, features, kind):
    if kind == "none":
        return Contexts.of(tree, NoContext())
    if kind == "edges":
        return Contexts.of(tree, ParentEdges(tree, features))
    return Contexts.of(tree, OpenPatterns(tree, features))


def cells_taken(choices, tree):
    """How often a tree takes each cell, node by node."""
    counts = np.zeros(len(choices.original))

    def walk(node, symbol):
        key = (node.symbol, 0)
        assert choices.contexts.symbols[symbol][0] == key
        if node.branch is None:
            return
        for cell in choices.cells(symbol, node.branch):
            counts[cell] += 1
        for place, child in node.children:
            walk(child, choices.contexts.children[symbol, node.branch][place])

    walk(tree, 0)
    return counts


@few
@given(grammars(), st.lists(patterns(), max_size=3), st.sampled_from(["none", "edges", "open"]), st.integers(0, 99))
def test_densities_are_products_over_cells(rules, features, kind, seed):
    grammar = Grammar.parse(text_of(rules))
    choices = Choices.of(contexts_of(TreeGrammar.of(grammar), features, kind))
    forest = derive(grammar, 30, seed)
    counts = choices.count(grammar, forest)
    np.testing.assert_allclose(counts @ np.log(choices.original), forest.log_probability(), atol=1e-10)
    sums = np.bincount(choices.choice, weights=choices.original)
    np.testing.assert_allclose(sums, 1.0)


@few
@given(grammars(), st.lists(patterns(), min_size=1, max_size=2), st.integers(0, 1000))
def test_choices_that_are_left_out_are_independent_of_every_preference(rules, features, seed):
    trees = all_trees(rules, "S")
    assume(len(trees) <= 400)
    tree = TreeGrammar.of(Grammar.parse(text_of(rules)))
    contexts = Contexts.of(tree, opened := OpenPatterns(tree, features))
    relevant = relevant_choices(contexts, opened)
    left_out = Choices.of(contexts, (), lambda symbol, chance: not relevant(symbol, chance))
    values = Preference(seed)(np.array([[count(pattern, one) for pattern in features] for _, one in trees]))
    mass = np.array([p for p, _ in trees]) * values
    taken = mass @ np.array([cells_taken(left_out, one) for _, one in trees])
    made = np.bincount(left_out.choice, weights=taken)[left_out.choice] if len(taken) else taken
    np.testing.assert_allclose(taken, made * left_out.original, atol=1e-12)


def test_a_choice_on_which_nothing_depends_is_left_out():
    tree = TreeGrammar.of(TOWERS)
    features = [pattern_text.parse("Lot > Tower@0 > Block@0:0")]
    contexts = Contexts.of(tree, opened := OpenPatterns(tree, features))
    relevant = relevant_choices(contexts, opened)
    learned = {
        (contexts.symbols[i][0][0], chance.path)
        for i, (key, _) in enumerate(contexts.symbols)
        for chance in chances(tree.body(key))
        if relevant(i, chance)
    }
    # Neither how many towers or blocks there are matters, nor what stands in blocks that are no boxes.
    assert learned == {("Block", ())}
    assert contexts.num_contexts["Block", 0] == 2
    assert contexts.num_contexts["Glass", 1] == 1


def test_numbers_of_copies_that_nobody_knows_matter():
    grammar = Grammar.parse(
        "Lot --> 50% : split(x) { ~1 : A }* else : split(x) { ~2 : A }*\nA --> 50% : Box else : Round"
    )
    tree = TreeGrammar.of(grammar)
    contexts = Contexts.of(tree, opened := OpenPatterns(tree, [pattern_text.parse("A:0")]))
    body = next(chances(tree.body(("Lot", 0))))
    assert relevant_choices(contexts, opened)(0, body)


def test_symbols_are_split_by_the_edges_that_patterns_name():
    tree = TreeGrammar.of(TOWERS)
    contexts = Contexts.of(tree, ParentEdges(tree, [pattern_text.parse("Tower > Block:0")]))
    assert contexts.num_contexts["Block", 0] == 3
    assert contexts.num_contexts["Tower", 0] == 1
    longer = Contexts.of(tree, ParentEdges(tree, [pattern_text.parse("Lot > Tower > Block:0")]))
    # A block must know the edges above its tower too, and so the tower knows them.
    assert longer.num_contexts["Tower", 0] == 3
    assert longer.num_contexts["Block", 0] == 9


def test_recursive_grammars_have_finitely_many_contexts():
    grammar = Grammar.parse("Lot --> Branch\nBranch --> 60% : Leaf else : Branch Branch")
    tree = TreeGrammar.of(grammar)
    features = [pattern_text.parse("Branch > Branch > Branch:0"), pattern_text.parse("Branch:1 >> Branch:0")]
    for kind in ("edges", "open"):
        choices = Choices.of(contexts_of(tree, features, kind))
        forest = derive(grammar, 50, 1)
        found = choices.count(grammar, forest) @ np.log(choices.original)
        np.testing.assert_allclose(found, forest.log_probability())


def test_parts_of_attributes_are_cells():
    grammar = Grammar.parse("attr h = rand(0, 10)\nLot --> 50% : extrude(h) A else : B")
    parts = attribute_parts(grammar, "h", [Threshold("h", 2.0), Threshold("h", 5.0)])
    choices = Choices.of(Contexts.of(TreeGrammar.of(grammar), NoContext()), [parts])
    forest = derive(grammar, 200, 3)
    counts = choices.count(grammar, forest).toarray()
    assert (counts.sum(axis=1) == 2).all()
    np.testing.assert_allclose(choices.original, [0.5, 0.5, 0.2, 0.3, 0.5])
    heights = forest.draws.value[[site.name == "h" for site in np.array(forest.sites, dtype=object)[forest.draws.site]]]
    for number, (low, high) in enumerate(pairwise([0, 2, 5, 10])):
        assert counts[:, 2 + number].sum() == pytest.approx(((heights >= low) & (heights < high)).sum())


def test_the_extent_of_a_choice_is_the_share_of_the_nodes_that_it_decides():
    choices, forest = Choices.of(Contexts.of(TreeGrammar.of(TOWERS), NoContext())), derive(TOWERS, 6, 3)
    nodes, weights = forest.nodes, np.array([1.0, 0.0, 2.0, 1.0, 1.0, 3.0])
    sizes = np.ones(len(nodes))
    for node in reversed(range(len(nodes))):
        if nodes.parent[node] >= 0:
            sizes[nodes.parent[node]] += sizes[node]
    whole = np.bincount(nodes.model)
    expected = np.zeros(int(choices.choice.max()) + 1)
    for (symbol, _), first in choices.first.items():
        name = choices.contexts.symbols[symbol][0][0]
        made = np.flatnonzero((np.array(forest.symbols)[nodes.symbol] == name) & (nodes.rule >= 0))
        share = weights[nodes.model[made]] * sizes[made] / whole[nodes.model[made]]
        expected[choices.choice[first]] = share.sum() / weights.sum()
    np.testing.assert_allclose(choices.extents(forest, weights), expected)
    assert expected[0] == 1.0 > expected.min() > 0.0
