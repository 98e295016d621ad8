"""Rules that a derivation can come to, and the rule that a file without a mark is likely to begin with."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from grammarlab.language.grammar import default_style, is_start_rule
from grammarlab.language.syntax.syntax_tree import Import, Invoke, Rule, RuleFile, walk

Key: TypeAlias = "tuple[str, int]"
"""Name of a rule and number of its parameters."""


def key_of(rule: Rule) -> Key:
    """The key of a rule."""
    return rule.name, len(rule.parameters)


def reached_rules(tree: RuleFile, roots: Iterable[Rule]) -> set[Key]:
    """Rules of a file that a derivation from these roots can come to, the roots included.

    What redefines a rule of an imported file counts as reached.
    """
    return _reached(_successors(tree), [*(key_of(rule) for rule in roots), *_redefined(tree)])


def likely_start(tree: RuleFile) -> str:
    """The rule without parameters that leads to most rules, of equal ones the first; empty without such a rule.

    >>> from grammarlab.language.grammar import Grammar
    >>> likely_start(Grammar.parse("Helper --> NIL  Plot --> extrude(3) Mass  Mass --> comp(f) { all : Wall }").tree)
    'Plot'
    """
    successors = _successors(tree)
    rules = [rule for rule in default_style(tree) if isinstance(rule, Rule) and not rule.parameters]
    best = max(rules, key=lambda rule: len(_reached(successors, [key_of(rule)])), default=None)
    return "" if best is None else best.name


def marks_start(tree: RuleFile) -> bool:
    """Whether a rule of the default style is marked as a start rule."""
    return any(isinstance(node, Rule) and is_start_rule(node) for node in default_style(tree))


def _successors(tree: RuleFile) -> dict[Key, set[Key]]:
    successors: dict[Key, set[Key]] = {}
    for rule in tree.definitions:
        if isinstance(rule, Rule):
            callees = {(item.name, len(item.arguments)) for item in walk(rule) if isinstance(item, Invoke)}
            successors.setdefault(key_of(rule), set()).update(callees)
    return successors


def _redefined(tree: RuleFile) -> list[Key]:
    imports = [definition for definition in tree.definitions if isinstance(definition, Import)]
    nodes = [node for definition in imports for rule in definition.rules for node in walk(rule)]
    return [(node.name, len(node.arguments)) for node in nodes if isinstance(node, Invoke)]


def _reached(successors: dict[Key, set[Key]], stack: list[Key]) -> set[Key]:
    reached: set[Key] = set()
    while stack:
        key = stack.pop()
        if key not in reached:
            reached.add(key)
            stack += successors.get(key, set()) & successors.keys()
    return reached
