"""Branches of rules that read an attribute: a model that takes none of them does not depend on its value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grammarlab.features.patterns.pattern import Pattern
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import Branch, function_name
from grammarlab.language.syntax.syntax_tree import Case, Choice, Node, Rule, Stochastic, walk


def readers_of(grammar: Grammar) -> dict[str, tuple[Pattern, ...]]:
    """Branches that read each attribute, directly or through functions and other attributes.

    Args:
        grammar: grammar with the rules of its default style.

    >>> grammar = Grammar.parse('''
    ... attr width = rand(1, 2)
    ... half = width / 2
    ... Lot --> 50% : s(1, half, 1) Box else: NIL
    ... ''')
    >>> [str(pattern) for pattern in readers_of(grammar)["width"]]
    ['Lot:0']
    """
    reached = _reached(grammar)
    several = [name for name, _ in grammar.rules]
    readers: dict[str, dict[Pattern, None]] = {name: {} for name in grammar.attributes}
    for (symbol, parameters), rule in grammar.rules.items():
        local_names = {*rule.parameters, *(variable.name for variable in rule.variables)}
        for branch, name in _names(rule):
            pattern = Pattern(symbol, parameters if several.count(symbol) > 1 else None, branch)
            for attribute in reached.get(name, ()) if name not in local_names else ():
                readers[attribute][pattern] = None
    return {name: _widest(tuple(patterns)) for name, patterns in readers.items()}


def _reached(grammar: Grammar) -> Mapping[str, frozenset[str]]:
    """Attributes that the value of each attribute and function depends on, itself included."""
    named: dict[str, set[str]] = {name: {name} for name in grammar.attributes}
    for definition in (*grammar.attributes.values(), *grammar.functions.values()):
        named.setdefault(definition.name, set()).update(function_name(node) for node in walk(definition))
    reached = {name: frozenset(names) & named.keys() for name, names in named.items()}
    while True:
        wider = {name: names.union(*(reached[other] for other in names)) for name, names in reached.items()}
        if wider == reached:
            return {name: names & grammar.attributes.keys() for name, names in reached.items()}
        reached = wider


def _names(rule: Rule) -> Iterator[tuple[Branch, str]]:
    """Names that a rule reads, each with the common beginnings of the branches that read it."""
    for variable in rule.variables:
        yield from _inside((), variable.value)
    yield from _of_choice((), rule.body)


def _of_choice(path: Branch, choice: Choice) -> Iterator[tuple[Branch, str]]:
    if not isinstance(choice, Case | Stochastic):
        yield from _inside(path, choice)
        return
    for condition in choice.conditions if isinstance(choice, Case) else choice.percentages:
        if condition is not None:
            yield from _inside(path, condition)
    for number, branch in enumerate(choice.branches):
        yield from _of_choice((*path, number), branch)


def _inside(path: Branch, node: Node) -> Iterator[tuple[Branch, str]]:
    return ((path, name) for below in walk(node) if (name := function_name(below)))


def _widest(patterns: tuple[Pattern, ...]) -> tuple[Pattern, ...]:
    """Patterns that no other pattern of the same symbol includes."""

    def includes(wide: Pattern, narrow: Pattern) -> bool:
        start, branch = wide.branch or (), narrow.branch or ()
        same = (wide.symbol, wide.parameters) == (narrow.symbol, narrow.parameters)
        return same and len(start) < len(branch) and branch[: len(start)] == start

    return tuple(pattern for pattern in patterns if not any(includes(other, pattern) for other in patterns))
