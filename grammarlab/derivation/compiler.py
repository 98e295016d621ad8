"""From a grammar to a `Program`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields

from grammarlab.derivation.addresses import number_sites
from grammarlab.derivation.array_expressions import makes_arrays
from grammarlab.derivation.expressions import CompiledFunction, ExpressionCompiler, Names
from grammarlab.derivation.forest import RuleName
from grammarlab.derivation.functions import BUILTINS
from grammarlab.derivation.functions.attributes import ASK_FOR_PIVOT, STATE_DEFAULTS
from grammarlab.derivation.operations import BLOCKS, OPERATIONS
from grammarlab.derivation.pivots import PIVOT_POSITION
from grammarlab.derivation.program import CompiledRule, Program
from grammarlab.derivation.sequences import Operations, SequenceCompiler, Successors
from grammarlab.derivation.sites import describe_sites, function_name
from grammarlab.derivation.uv_sets import mentioned_uv_sets
from grammarlab.derivation.workspace import CompiledAttribute
from grammarlab.errors import DerivationError
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax import (
    Call,
    Choice,
    Invoke,
    Name,
    Node,
    Rule,
    RuleFile,
    Scatter,
    Stochastic,
)
from grammarlab.language.syntax import Sequence as SyntaxSequence


def compile_grammar(grammar: Grammar) -> Program:
    """Everything about a grammar that does not depend on models and seeds.

    Raises:
        DerivationError: when the grammar has no rule to start with.
    """
    return _Compilation(grammar).program()


class _Compilation:
    def __init__(self, grammar: Grammar) -> None:
        self._grammar = grammar
        tree = grammar.tree
        self._rules = list(grammar.rules.values())
        self._functions = list(grammar.functions.values())
        self._attributes = list(grammar.attributes.values())
        self._symbols = _number_symbols(tree)
        self._numbers = {(rule.name, len(rule.parameters)): i for i, rule in enumerate(self._rules)}
        addresses = number_sites(tree)
        own = {a.name for a in self._attributes} | {f.name for f in self._functions}
        self._site_nodes = [n for n in _walk(tree) if _is_random(n) and function_name(n) not in own]
        drawing = self._drawing_functions()
        compiled = {
            (f.name, len(f.parameters)): CompiledFunction(
                f.name, len(f.parameters), (f.name, len(f.parameters)) in drawing, f.location
            )
            for f in self._functions
        }
        self._names = Names(
            frozenset(a.name for a in self._attributes),
            compiled,
            addresses,
            {id(node): site for site, node in enumerate(self._site_nodes)},
            any(makes_arrays(node) for node in _walk(tree)),
        )
        self._drawing_functions_set = drawing
        self._drawing_rules = self._rules_that_draw()
        self._rule_names: list[RuleName] = []

    def program(self) -> Program:
        for function in self._functions:
            code = ExpressionCompiler(self._names, function.parameters).choice(function.value)
            self._names.functions[function.name, len(function.parameters)].code = code
        attributes = {
            a.name: CompiledAttribute(
                a.name, ExpressionCompiler(self._names).choice(a.value), self._draws_itself(a.value), a.location
            )
            for a in self._attributes
        }
        rules = tuple(self._rule(rule) for rule in self._rules)
        start_rules = {rule.name: i for i, rule in enumerate(self._rules) if not rule.parameters}
        return Program(
            tuple(self._symbols),
            tuple(self._rule_names),
            describe_sites(self._grammar, self._site_nodes),
            attributes,
            rules,
            _call_order([self._callees(rule) for rule in self._rules]),
            start_rules,
            self._default_start(start_rules),
            self._state_names(),
            mentioned_uv_sets(self._grammar.tree),
        )

    def _rule(self, rule: Rule) -> CompiledRule:
        expressions = ExpressionCompiler(self._names, rule.parameters)
        successors = Successors(self._symbols, self._numbers, self._draws)

        def leaf(choice: Choice, path: tuple[int, ...]) -> Operations:
            if not isinstance(choice, SyntaxSequence):
                raise DerivationError("expected operations, found an expression", choice.location)
            self._rule_names.append(RuleName(rule.name, len(rule.parameters), path, choice.location.line))
            return SequenceCompiler(expressions, successors).sequence(choice, rule=len(self._rule_names) - 1)

        body = expressions.branching(rule.body, leaf)
        needs_key = (rule.name, len(rule.parameters)) in self._drawing_rules
        return CompiledRule(self._symbols[rule.name], body, needs_key)

    def _default_start(self, start_rules: Mapping[str, int]) -> str:
        marked = [rule.name for rule in (*self._grammar.start_rules, *self._rules) if rule.name in start_rules]
        if not marked:
            raise DerivationError(
                "the grammar has no rule to start with", None, "mark a rule without parameters with @StartRule"
            )
        return marked[0]

    def _draws(self, node: object) -> bool:
        """Whether anything random may happen in a piece of the tree or in what is derived from it."""
        return self._draws_itself(node) or any(callee in self._drawing_rules for callee in _invoked(node))

    def _draws_itself(self, node: object) -> bool:
        return any(
            _is_random(n) or isinstance(n, Scatter) or _called(n) in self._drawing_functions_set for n in _walk(node)
        )

    def _drawing_functions(self) -> frozenset[tuple[str, int]]:
        calls = {(f.name, len(f.parameters)): {_called(n) for n in _walk(f.value)} - {None} for f in self._functions}
        drawing = {(f.name, len(f.parameters)) for f in self._functions if any(_is_random(n) for n in _walk(f.value))}
        return _spread(drawing, calls)

    def _rules_that_draw(self) -> frozenset[tuple[str, int]]:
        calls = {(r.name, len(r.parameters)): set(_invoked(r.body)) for r in self._rules}
        drawing = {(r.name, len(r.parameters)) for r in self._rules if self._draws_itself(r.body)}
        return _spread(drawing, calls)

    def _callees(self, rule: Rule) -> list[int]:
        return sorted({self._numbers[callee] for callee in _invoked(rule.body) if callee in self._numbers})

    def _state_names(self) -> frozenset[str]:
        tree = self._grammar.tree
        read = {node.identifier for node in _walk(tree) if isinstance(node, Name)} & STATE_DEFAULTS.keys()
        invoked = [node for node in _walk(tree) if isinstance(node, Invoke)]
        changed = {
            node.arguments[0].identifier
            for node in invoked
            if node.name == "set" and node.arguments and isinstance(node.arguments[0], Name)
        }
        asks = any(
            (isinstance(node, Name) and node.identifier in ASK_FOR_PIVOT)
            or (isinstance(node, Call) and node.function == "convert")
            for node in _walk(tree)
        )
        pivot = PIVOT_POSITION if asks or any(node.name == "translate" for node in invoked) else ()
        return frozenset(read | (changed & {a.name for a in self._attributes}) | set(pivot))


def _walk(root: object) -> Iterator[Node]:
    """All nodes of a piece of the tree, in the order of the text."""
    stack = [root]
    while stack:
        item = stack.pop()
        if isinstance(item, tuple):
            stack.extend(reversed(item))
        elif isinstance(item, Node):
            yield item
            stack.extend(getattr(item, field.name) for field in reversed(fields(item)))


def _is_random(node: Node) -> bool:
    if isinstance(node, Stochastic):
        return True
    builtin = BUILTINS.get(function_name(node))
    return builtin is not None and builtin.random


def _called(node: Node) -> tuple[str, int] | None:
    """The function of the grammar that a node would call, if there is one of that name."""
    if isinstance(node, Call):
        return node.function, len(node.arguments)
    return (node.identifier, 0) if isinstance(node, Name) else None


def _invoked(node: object) -> Iterator[tuple[str, int]]:
    for item in _walk(node):
        if isinstance(item, Invoke) and item.name not in OPERATIONS:
            yield item.name, len(item.arguments)


def _spread(drawing: set, calls: Mapping) -> frozenset:
    """Everything that leads to one of ``drawing`` by its calls."""
    callers: dict = {}
    for caller, callees in calls.items():
        for callee in callees:
            callers.setdefault(callee, set()).add(caller)
    reached, open_ends = set(drawing), list(drawing)
    while open_ends:
        new = callers.get(open_ends.pop(), set()) - reached
        reached |= new
        open_ends += new
    return frozenset(reached)


def _number_symbols(tree: RuleFile) -> dict[str, int]:
    """Numbers of all symbols: those with rules first, then the others, each in the order of the text."""
    ruled = [d.name for d in tree.definitions if isinstance(d, Rule)]
    invoked = [
        node.name
        for node in _walk(tree)
        if isinstance(node, Invoke) and node.name not in OPERATIONS and node.name not in BLOCKS and node.name != "NIL"
    ]
    return {name: number for number, name in enumerate(dict.fromkeys([*ruled, *invoked]))}


def _call_order(callees: Sequence[Sequence[int]]) -> tuple[tuple[int, ...], ...]:
    """The strongly connected groups of a call graph, callers before callees (Tarjan 1972, without recursion)."""
    count = len(callees)
    index, low = [-1] * count, [0] * count
    on_stack = [False] * count
    stack: list[int] = []
    groups: list[tuple[int, ...]] = []
    clock = 0
    for root in range(count):
        if index[root] >= 0:
            continue
        work = [(root, iter(callees[root]))]
        index[root] = low[root] = clock
        clock += 1
        stack.append(root)
        on_stack[root] = True
        while work:
            vertex, rest = work[-1]
            for callee in rest:
                if index[callee] < 0:
                    index[callee] = low[callee] = clock
                    clock += 1
                    stack.append(callee)
                    on_stack[callee] = True
                    work.append((callee, iter(callees[callee])))
                    break
                if on_stack[callee]:
                    low[vertex] = min(low[vertex], index[callee])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[vertex])
                if low[vertex] == index[vertex]:
                    cut = stack.index(vertex)
                    group, stack[cut:] = stack[cut:], []
                    for member in group:
                        on_stack[member] = False
                    groups.append(tuple(sorted(group)))
    return tuple(reversed(groups))
