"""Checks for rules that are never applied and rules that never end."""

from __future__ import annotations

from collections.abc import Iterator

from grammarlab.language.checking.symbols import Remarks
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
    walk,
)

Key = tuple[str, int]
"""Name of a rule and number of its parameters."""


def check_reachable(tree: RuleFile, roots: tuple[Rule, ...], remarks: Remarks) -> None:
    """Warn of unreachable rules.

    Args:
        tree: the rule file.
        roots: the start rules of derivations.
        remarks: collects the findings.
    """
    successors: dict[Key, set[Key]] = {}
    for rule in _rules(tree):
        called = {(item.name, len(item.arguments)) for item in walk(rule) if isinstance(item, Invoke)}
        successors.setdefault(_key(rule), set()).update(called)
    reached: set[Key] = set()
    waiting = [_key(rule) for rule in roots]
    while waiting:
        key = waiting.pop()
        if key not in reached:
            reached.add(key)
            waiting += successors.get(key, set()) & successors.keys()
    for rule in _rules(tree):
        redefines_import = "." in rule.name.rstrip(".")
        if _key(rule) not in reached and not redefines_import and rule.keyword != "extension":
            message = f"nothing leads from a start rule to the rule {rule.name}"
            remarks.warning("unreachable-rule", rule.location, message, "mark a rule to begin with by @StartRule")


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
        bodies.setdefault(_key(rule), []).append(rule.body)
    ending: set[Key] = set()
    _grow(ending, {key: [_rule_needs(body) for body in choices] for key, choices in bodies.items()})
    for rule in rules:
        if _key(rule) not in ending and rule.name not in builtins.operations():
            message = f"the rule {rule.name} never ends: all its branches call it, or another such rule"
            hint = "add a case or a random branch that ends, or a symbol without a rule"
            remarks.error("endless-rule", rule.location, message, hint)
    _check_endless_values(tree, remarks)


Needs = list[frozenset[Key]]
"""Paths through a definition; each is the set of definitions that must end for it to end."""
MAX_WAYS = 64
"""Largest number of distinguished paths through a definition; one with more paths is assumed to end."""


def _grow(ending: set[Key], needs: dict[Key, list[Needs]]) -> None:
    """Add definitions that can end to `ending`, until none is left."""
    owners: list[Key] = []
    missing: list[int] = []
    users: dict[Key, list[int]] = {}
    ready: list[Key] = []
    for key, way in ((key, way) for key, choices in needs.items() for ways in choices for way in ways):
        unsettled = [needed for needed in way if needed in needs and needed not in ending]
        if not unsettled:
            ready.append(key)
        for needed in unsettled:
            users.setdefault(needed, []).append(len(owners))
        owners.append(key)
        missing.append(len(unsettled))
    while ready:
        key = ready.pop()
        if key in ending:
            continue
        ending.add(key)
        for way_number in users.get(key, ()):
            missing[way_number] -= 1
            if missing[way_number] == 0:
                ready.append(owners[way_number])


def _rule_needs(choice: Choice) -> Needs:
    if isinstance(choice, Case | Stochastic):
        return [way for branch in choice.branches for way in _rule_needs(branch)][:MAX_WAYS]
    if not isinstance(choice, Sequence):
        return [frozenset()]
    ways: Needs = [frozenset()]
    always: set[Key] = set()
    for item in choice.items:
        if isinstance(item, Invoke):
            if item.name == "NIL":
                break
            if item.name not in builtins.operations():
                always.add((item.name, len(item.arguments)))
        elif isinstance(item, Scoped):
            inner = _rule_needs(item.body)
            if len(inner) * len(ways) > MAX_WAYS:
                return [frozenset()]
            if len(inner) == 1:
                always |= inner[0]
            else:
                ways = [way | more for way in ways for more in inner]
    return [way | always for way in ways]


def _check_endless_values(tree: RuleFile, remarks: Remarks) -> None:
    definitions = [node for node in tree.definitions if isinstance(node, Attribute | Function)]
    attributes = {node.name for node in definitions if isinstance(node, Attribute)}
    needs: dict[Key, list[Needs]] = {}
    for node in definitions:
        needs.setdefault(_value_key(node), []).append(_value_needs(node.value, _locals(node), attributes))
    ending: set[Key] = set()
    _grow(ending, needs)
    for node in definitions:
        if _value_key(node) not in ending:
            message = f"{node.name} is defined by itself, so it never has a value"
            remarks.error("endless-value", node.location, message, "add a case that does not use it")


def _locals(node: Attribute | Function) -> frozenset[str]:
    parameters = node.parameters if isinstance(node, Function) else ()
    return frozenset((*parameters, *(variable.name for variable in node.variables)))


def _value_needs(choice: Choice, hidden: frozenset[str], attributes: set[str]) -> Needs:
    if isinstance(choice, Case | Stochastic):
        heads = choice.conditions if isinstance(choice, Case) else choice.percentages
        first = _used(heads[0], hidden, attributes) if heads[0] is not None else frozenset[Key]()
        ways = [way for branch in choice.branches for way in _value_needs(branch, hidden, attributes)]
        return [first | way for way in ways][:MAX_WAYS]
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
    waiting: list[Node] = [node]
    while waiting:
        current = waiting.pop()
        if isinstance(current, Case | Stochastic):
            continue
        yield current
        if isinstance(current, Binary) and current.operator in ("&&", "||"):
            waiting.append(current.left)
        else:
            waiting += children(current)


def _rules(tree: RuleFile) -> Iterator[Rule]:
    return (node for node in tree.definitions if isinstance(node, Rule))


def _key(rule: Rule) -> Key:
    return rule.name, len(rule.parameters)


def _value_key(node: Attribute | Function) -> Key:
    return node.name, -1 if isinstance(node, Attribute) else len(node.parameters)
