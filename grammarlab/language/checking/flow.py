"""Checks for rules that are never applied and rules that never end."""

from __future__ import annotations

from collections.abc import Iterator

from grammarlab.language.checking.symbols import Remarks
from grammarlab.language.reachability import Key, key_of, likely_start, marks_start, reached_rules
from grammarlab.language.syntax import builtins
from grammarlab.language.syntax.syntax_tree import (
    Attribute,
    Binary,
    Call,
    Case,
    Choice,
    Function,
    Invoke,
    Name,
    Node,
    Rule,
    RuleFile,
    Scoped,
    Sequence,
    Stochastic,
    children,
)


def check_reachable(tree: RuleFile, roots: tuple[Rule, ...], remarks: Remarks) -> None:
    """Warn of unreachable rules, at the first of them.

    Args:
        tree: the rule file.
        roots: the start rules of derivations.
        remarks: collects the findings.
    """
    reached = reached_rules(tree, roots)
    likely = "" if marks_start(tree) else likely_start(tree)
    example = f", such as {likely}" if likely and (likely, 0) not in reached else ""
    unreachable = [
        rule
        for rule in _rules(tree)
        if key_of(rule) not in reached and "." not in rule.name.rstrip(".") and rule.keyword != "extension"
    ]
    if unreachable:  # many, in a file of several start rules
        first, others = unreachable[0], len(unreachable) - 1
        more = f", nor to {others:,} {'other' if others == 1 else 'others'}" if others else ""
        message = f"nothing leads from a start rule to the rule {first.name}{more}"
        hint = f"mark a rule to begin with by @StartRule{example}"
        remarks.warning("unreachable-rule", first.location, message, hint)


def check_shadowed(tree: RuleFile, remarks: Remarks) -> None:
    """Warn of rules that are never applied because CGA has an operation of their name."""
    for rule in _rules(tree):
        if rule.name in builtins.operations():
            message = f"the rule {rule.name} is never applied: {rule.name} is an operation"
            remarks.warning("shadowed-rule", rule.location, message, "give the rule another name")


def check_endless(tree: RuleFile, remarks: Remarks) -> None:
    """Report rules that always call themselves, and values that are defined by themselves.

    Calls inside blocks do not count: a part of a split may have size 0, a component may be missing.
    """
    rules = list(_rules(tree))
    bodies: dict[Key, list[Choice]] = {}
    for rule in rules:
        bodies.setdefault(key_of(rule), []).append(rule.body)
    ending: set[Key] = set()
    _grow(ending, {key: [_rule_requirements(body) for body in choices] for key, choices in bodies.items()})
    for rule in rules:
        if key_of(rule) not in ending and rule.name not in builtins.operations():
            message = f"the rule {rule.name} never ends: all its branches call it, or another such rule"
            hint = "add a case or a random branch that ends, or a symbol without a rule"
            remarks.error("endless-rule", rule.location, message, hint)
    _check_endless_values(tree, remarks)


Requirements = list[frozenset[Key]]
"""Paths through a definition; each is the set of definitions that must end for it to end."""
MAX_PATHS = 64
"""Largest number of distinguished paths through a definition; one with more paths is assumed to end."""


def _grow(ending: set[Key], requirements: dict[Key, list[Requirements]]) -> None:
    """Add definitions that can end to `ending`, until none is left."""
    owners: list[Key] = []
    missing: list[int] = []
    users: dict[Key, list[int]] = {}
    ready: list[Key] = []
    for key, path in ((key, path) for key, choices in requirements.items() for paths in choices for path in paths):
        unsettled = [requirement for requirement in path if requirement in requirements and requirement not in ending]
        if not unsettled:
            ready.append(key)
        for requirement in unsettled:
            users.setdefault(requirement, []).append(len(owners))
        owners.append(key)
        missing.append(len(unsettled))
    while ready:
        key = ready.pop()
        if key in ending:
            continue
        ending.add(key)
        for path_index in users.get(key, ()):
            missing[path_index] -= 1
            if missing[path_index] == 0:
                ready.append(owners[path_index])


def _rule_requirements(choice: Choice) -> Requirements:
    if isinstance(choice, Case | Stochastic):
        return [path for branch in choice.branches for path in _rule_requirements(branch)][:MAX_PATHS]
    if not isinstance(choice, Sequence):
        return [frozenset()]
    paths: Requirements = [frozenset()]
    always: set[Key] = set()
    for item in choice.items:
        if isinstance(item, Invoke):
            if item.name not in builtins.operations():
                always.add((item.name, len(item.arguments)))
        elif isinstance(item, Scoped):
            inner = _rule_requirements(item.body)
            if len(inner) * len(paths) > MAX_PATHS:
                return [frozenset()]
            if len(inner) == 1:
                always |= inner[0]
            else:
                paths = [path | inner_path for path in paths for inner_path in inner]
    return [path | always for path in paths]


def _check_endless_values(tree: RuleFile, remarks: Remarks) -> None:
    definitions = [node for node in tree.definitions if isinstance(node, Attribute | Function)]
    attributes = {node.name for node in definitions if isinstance(node, Attribute)}
    requirements: dict[Key, list[Requirements]] = {}
    for node in definitions:
        requirements.setdefault(_value_key(node), []).append(_value_requirements(node.value, _locals(node), attributes))
    ending: set[Key] = set()
    _grow(ending, requirements)
    for node in definitions:
        if _value_key(node) not in ending:
            message = f"{node.name} is defined by itself, so it never has a value"
            remarks.error("endless-value", node.location, message, "add a case that does not use it")


def _locals(node: Attribute | Function) -> frozenset[str]:
    parameters = node.parameters if isinstance(node, Function) else ()
    return frozenset((*parameters, *(variable.name for variable in node.variables)))


def _value_requirements(choice: Choice, hidden: frozenset[str], attributes: set[str]) -> Requirements:
    if isinstance(choice, Case | Stochastic):
        heads = choice.conditions if isinstance(choice, Case) else choice.percentages
        first = _used(heads[0], hidden, attributes) if heads[0] is not None else frozenset[Key]()
        paths = [path for branch in choice.branches for path in _value_requirements(branch, hidden, attributes)]
        return [first | path for path in paths][:MAX_PATHS]
    return [_used(choice, hidden, attributes)]


def _used(node: Node, hidden: frozenset[str], attributes: set[str]) -> frozenset[Key]:
    """Definitions that must have a value for an expression to have one."""
    used: set[Key] = set()
    for inner in _unconditional(node):
        if isinstance(inner, Name) and inner.identifier not in hidden:
            used.add((inner.identifier, -1 if inner.identifier in attributes else 0))
        elif isinstance(inner, Call):
            used.add((inner.function, len(inner.arguments)))
    return frozenset(used)


def _unconditional(node: Node) -> Iterator[Node]:
    """The parts of an expression that are always evaluated: no branches of choices, nothing that && and || may skip."""
    stack: list[Node] = [node]
    while stack:
        current = stack.pop()
        if isinstance(current, Case | Stochastic):
            continue
        yield current
        if isinstance(current, Binary) and current.operator in ("&&", "||"):
            stack.append(current.left)
        else:
            stack += children(current)


def _rules(tree: RuleFile) -> Iterator[Rule]:
    return (node for node in tree.definitions if isinstance(node, Rule))


def _value_key(node: Attribute | Function) -> Key:
    return node.name, -1 if isinstance(node, Attribute) else len(node.parameters)
