"""Which rule leads to which symbol, and where to put them on a page."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import networkx as nx

from grammarlab.language.syntax import Invoke, Rule, Stochastic
from grammarlab.language.walking import walk

_SWEEPS = 8
"""Passes of the crossing reduction; more changes little on graphs of some hundred symbols."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A symbol with its place."""

    symbol: str
    kind: str
    """``start``, ``rule``, ``stochastic`` (a rule with chance in it) or ``terminal``."""
    column: int
    """From 0 at the start rule."""
    row: float
    """From 0 at the top, in rows of boxes."""


def rule_graph(rules: Iterable[Rule], start: str, operations: frozenset[str]) -> nx.DiGraph[str]:
    """The symbols, with an edge from each rule to what it makes; an attribute ``kind`` as in `Placed`.

    Args:
        rules: all rules; overloads count as one symbol.
        start: the start rule.
        operations: names that are operations, not symbols.
    """
    graph: nx.DiGraph[str] = nx.DiGraph()
    for rule in rules:
        stochastic = any(isinstance(node, Stochastic) for node in walk(rule.body))
        if rule.name == start:
            kind = "start"
        elif stochastic or graph.nodes.get(rule.name, {}).get("kind") == "stochastic":
            kind = "stochastic"
        else:
            kind = "rule"
        graph.add_node(rule.name, kind=kind)
        for node in walk(rule.body):
            if isinstance(node, Invoke) and node.name not in operations:
                graph.add_edge(rule.name, node.name)
    for symbol, data in graph.nodes.items():
        data.setdefault("kind", "terminal")
        graph.nodes[symbol].update(data)
    return graph


def place(graph: nx.DiGraph[str]) -> list[Placed]:
    """Columns by the longest way from the start, rows so that few edges cross (Sugiyama, Tagawa and Toda, 1981)."""
    column = _columns(graph)
    rows: dict[str, float] = {}
    layers: list[list[str]] = [[] for _ in range(max(column.values(), default=-1) + 1)]
    for symbol in graph:
        layers[column[symbol]].append(symbol)
    for layer in layers:
        rows.update({symbol: index for index, symbol in enumerate(layer)})
    for sweep in range(_SWEEPS):
        forward = sweep % 2 == 0
        for layer in layers if forward else reversed(layers):
            neighbours = graph.predecessors if forward else graph.successors
            layer.sort(key=lambda symbol: _mean([rows[other] for other in neighbours(symbol)], rows[symbol]))
            rows.update({symbol: index for index, symbol in enumerate(layer)})
    tallest = max(map(len, layers), default=0)
    return [
        Placed(symbol, graph.nodes[symbol]["kind"], index, row + (tallest - len(layer)) / 2)
        for index, layer in enumerate(layers)
        for row, symbol in enumerate(layer)
    ]


def _columns(graph: nx.DiGraph[str]) -> dict[str, int]:
    """The longest way to each symbol; the symbols of one recursion share a column."""
    condensed = nx.condensation(graph)
    column: dict[str, int] = {}
    for component in nx.topological_sort(condensed):
        members = condensed.nodes[component]["members"]
        before = [column[p] for member in members for p in graph.predecessors(member) if p not in members]
        column.update(dict.fromkeys(members, max(before, default=-1) + 1))
    return column


def _mean(values: list[float], otherwise: float) -> float:
    return sum(values) / len(values) if values else otherwise
