"""Rules that derivations come to, and the one that a file is likely to begin with."""

import pytest

from grammarlab.language.grammar import Grammar
from grammarlab.language.reachability import likely_start, marks_start, reached_rules


@pytest.mark.parametrize(
    ("text", "start"),
    [
        ("A --> NIL  B --> C  C --> X", "B"),
        ("A --> B  B --> A", "A"),
        ("A(x) --> B  B --> NIL", "B"),
        ("A(x) --> X", ""),
        ("A --> X  style other  B --> C  C --> A", "A"),
    ],
)
def test_the_likely_start_leads_to_most_rules_and_of_equal_ones_is_the_first(text, start):
    assert likely_start(Grammar.parse(text).tree) == start


def test_a_mark_of_another_style_is_none_of_the_file():
    assert not marks_start(Grammar.parse("A --> X  style other  @StartRule B --> X").tree)
    assert marks_start(Grammar.parse("A --> X  @StartRule B --> X").tree)


def test_rules_with_other_numbers_of_parameters_are_others():
    grammar = Grammar.parse("A --> B(1)  B --> C  B(x) --> D  C --> X  D --> X")
    assert reached_rules(grammar.tree, grammar.start_rules) >= {("A", 0), ("B", 1), ("D", 0)}
    assert not {("B", 0), ("C", 0)} & reached_rules(grammar.tree, grammar.start_rules)
