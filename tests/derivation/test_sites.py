"""Names of random expressions."""

from collections import Counter
from pathlib import Path

import pytest

from grammarlab.derivation import compile_grammar, derive
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load

GRAMMARS = sorted((Path(__file__).parents[2] / "grammars").glob("*.cga"))


def names(text):
    return [(site.name, site.kind) for site in compile_grammar(Grammar.parse(text)).sites]


def test_an_attribute_gives_its_name_to_the_draw_that_is_its_value():
    assert names("attr h = rand(1, 5)\nattr tall = p(0.3)\nLot --> extrude(h) A") == [
        ("h", "uniform"),
        ("tall", "bernoulli"),
    ]


def test_a_draw_that_is_only_part_of_the_value_does_not_get_the_name():
    assert names("attr h = 2 * rand(1, 5)\nLot --> extrude(h) A") == [("h#1", "uniform")]
    assert names("attr h = rand(1, rand(2))\nLot --> extrude(h) A") == [("h", "uniform"), ("h#1", "uniform")]


def test_ranges_of_one_attribute_share_its_name():
    assert names("attr h = 25% : rand(1, 2) else : rand(2, 5)\nLot --> extrude(h) A") == [
        ("h#1", "choice"),
        ("h", "uniform"),
        ("h", "uniform"),
    ]
    assert names('attr style = 25% : "old" else : "new"\nLot --> A') == [("style", "choice")]
    assert names("attr h = 25% : 1 else : rand(2, 5)\nLot --> A") == [("h#1", "choice"), ("h#2", "uniform")]


def test_draws_of_a_rule_are_named_after_it_and_numbered_where_there_are_several():
    text = "Lot --> 50% : split(y) { rand(1, 2) : A | ~1 : A } else : C\nA --> 10% : B else : C\nB(n) --> A"
    assert names(text) == [("Lot#1", "choice"), ("Lot#2", "uniform"), ("A", "choice")]


def test_a_function_of_the_grammar_called_rand_is_no_random_expression():
    assert names("rand(a) = a\nLot --> extrude(rand(3)) A") == []


def test_a_rule_called_like_an_attribute_leaves_the_name_to_it():
    assert names("attr A = rand(3)\nLot --> A\nA --> 30% : B else : C") == [("A", "uniform"), ("A#1", "choice")]


@pytest.mark.parametrize("path", GRAMMARS, ids=lambda path: path.stem)
def test_names_in_the_shipped_grammars_are_unique_and_their_lines_right(path):
    sites = compile_grammar(load(path)).sites
    assert max(Counter(site.name for site in sites).values()) == 1
    lines = path.read_text(encoding="utf-8").splitlines()
    words = {"choice": "%", "uniform": "rand", "bernoulli": "p(", "file": "fileRandom"}
    for site in sites:
        assert words[site.kind] in lines[site.line - 1], site


def test_values_of_a_named_draw_are_values_of_the_attribute():
    text = "attr h = 25% : rand(1, 2) else : rand(2, 5)\nLot --> extrude(h) A"
    forest = derive(Grammar.parse(text), 50, 1)
    named = [site.name == "h" for site in forest.sites]
    drawn = {
        int(forest.nodes.model[n]): v
        for n, s, v in zip(forest.draws.node, forest.draws.site, forest.draws.value, strict=True)
        if named[s]
    }
    assert [drawn[m] for m in range(50)] == forest.leaves.size[forest.leaves.node.argsort(), 1].tolist()
