"""Graph of the rules and symbols of a grammar, with a layout on a page."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from grammarlab.language.call_order import groups
from grammarlab.language.syntax.tree import Invoke, Rule, Stochastic
from grammarlab.language.syntax.walking import walk

_SWEEPS = 8
"""Passes of the crossing reduction; more passes change little on graphs of a few hundred symbols."""


@dataclass(frozen=True, slots=True)
class PlacedSymbol:
    """A symbol with its place."""

    symbol: str
    kind: str
    """``start``, ``rule``, ``stochastic`` (a rule with a stochastic choice) or ``terminal``."""
    column: int
    """From 0 at the start rule."""
    row: float
    """From 0 at the top, in rows of boxes."""


@dataclass(frozen=True, slots=True)
class RuleGraph:
    """Symbols of a grammar, with edges from rules to the symbols they make."""

    kind: Mapping[str, str]
    """For each symbol, as in `PlacedSymbol`."""
    edges: Collection[tuple[str, str]]
    """A rule and a symbol that it makes; each pair once."""

    def neighbours(self, forward: bool = True) -> dict[str, list[str]]:
        """Successors of each symbol, or its predecessors if backward."""
        found: dict[str, list[str]] = {symbol: [] for symbol in self.kind}
        for edge in self.edges:
            start, end = edge if forward else reversed(edge)
            found[start].append(end)
        return found


def rule_graph(rules: Iterable[Rule], start: str, operations: frozenset[str]) -> RuleGraph:
    """Graph of the symbols, with an edge from each rule to each symbol it makes.

    Args:
        rules: all rules; overloads count as one symbol.
        start: the start rule.
        operations: names that are operations, not symbols.
    """
    kind: dict[str, str] = {}
    made: dict[str, dict[str, None]] = {}
    for rule in rules:
        inside = list(walk(rule.body))
        stochastic = kind.get(rule.name) == "stochastic" or any(isinstance(node, Stochastic) for node in inside)
        kind[rule.name] = "start" if rule.name == start else "stochastic" if stochastic else "rule"
        for node in inside:
            if isinstance(node, Invoke) and node.name not in operations:
                kind.setdefault(node.name, "terminal")
                made.setdefault(rule.name, {})[node.name] = None
    return RuleGraph(kind, [(symbol, child) for symbol in kind for child in made.get(symbol, ())])


def place(graph: RuleGraph) -> list[PlacedSymbol]:
    """Columns by the longest path from the start, rows with few crossing edges (Sugiyama, Tagawa and Toda, 1981)."""
    column = _columns(graph)
    rows: dict[str, float] = {}
    layers: list[list[str]] = [[] for _ in range(max(column.values(), default=-1) + 1)]
    for symbol in graph.kind:
        layers[column[symbol]].append(symbol)
    for layer in layers:
        rows.update({symbol: index for index, symbol in enumerate(layer)})
    for sweep in range(_SWEEPS):
        forward = sweep % 2 == 0
        neighbours = graph.neighbours(not forward)
        for layer in layers if forward else reversed(layers):
            layer.sort(key=lambda symbol: _mean([rows[other] for other in neighbours[symbol]], rows[symbol]))
            rows.update({symbol: index for index, symbol in enumerate(layer)})
    tallest = max(map(len, layers), default=0)
    return [
        PlacedSymbol(symbol, graph.kind[symbol], index, row + (tallest - len(layer)) / 2)
        for index, layer in enumerate(layers)
        for row, symbol in enumerate(layer)
    ]


def _columns(graph: RuleGraph) -> dict[str, int]:
    """Length of the longest path to each symbol; the symbols of one recursion share a column."""
    before = graph.neighbours(forward=False)
    column: dict[str, int] = {}
    for group in groups(before):
        above = [column[symbol] for member in group for symbol in before[member] if symbol not in group]
        column.update(dict.fromkeys(group, max(above, default=-1) + 1))
    return column


def _mean(values: list[float], otherwise: float) -> float:
    return sum(values) / len(values) if values else otherwise
