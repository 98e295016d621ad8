"""Labels of nodes of derivation trees, the same for all forests of a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import ROUNDING, Floats, Ints, connected, distinct, runs
from grammarlab.derivation.forest import Forest, RuleName


@dataclass(frozen=True)
class NodeLabels:
    """The label of a node is the rule that rewrote it, or its symbol if no rule did.

    Labels are numbered: rules first, then symbols, and last one number for unknown labels.
    """

    rules: tuple[RuleName, ...]
    """Rules that differ in more than their line."""
    symbols: tuple[str, ...]
    drawn: frozenset[str]
    """Symbols whose rule is drawn, at least in part."""
    successors: tuple[Mapping[int, str], ...]
    """Symbols that each rule has made, by ``child``, ascending."""
    chances: tuple[float, ...]
    """Probability of the draws of each rule, 1 without draws; NaN if it differs between nodes."""

    @classmethod
    def of(cls, forests: Sequence[Forest]) -> NodeLabels:
        """All labels of nodes of some forests."""
        rules: dict[tuple, RuleName] = {}
        for forest in forests:
            for rule in forest.rules:
                rules.setdefault(_key(rule), rule)
        symbols = tuple(dict.fromkeys(s for forest in forests for s in forest.symbols))
        drawn = frozenset(s.definition for forest in forests for s in forest.sites if s.kind == "choice")
        bare = cls(tuple(rules.values()), symbols, drawn, (), ())
        successors: list[dict[int, str]] = [{} for _ in rules]
        moments = np.zeros((3, len(rules) + 1))
        for forest in forests:
            for label, child, symbol in _successors_in(forest, bare):
                successors[label][child] = symbol
            starts, lengths = runs(forest.nodes.rule, forest.nodes.symbol)
            counts = np.bincount(bare.numbers(forest, starts), weights=lengths, minlength=bare.unknown + 1)
            moments[0] += counts[: len(rules) + 1]
            nodes, logarithms = _rule_draws(forest)
            number = bare.numbers(forest, nodes)
            for power in (1, 2):
                moments[power] += np.bincount(number, weights=logarithms**power, minlength=len(rules) + 1)
        _, mean, square = moments[:, :-1] / np.maximum(moments[0, :-1], 1.0)
        chances = np.where(square - mean**2 <= ROUNDING, np.exp(mean), np.nan)
        ordered = tuple(dict(sorted(children.items())) for children in successors)
        return cls(bare.rules, symbols, drawn, ordered, tuple(chances.tolist()))

    @property
    def unknown(self) -> int:
        """The last label, of nodes with unknown rule or symbol."""
        return len(self.rules) + len(self.symbols)

    def numbers(self, forest: Forest, rows: NDArray[np.integer] | None = None) -> Ints:
        """[N] the label of each node of a forest, or of those at some rows."""
        rules = [self._rule_numbers.get(_key(rule), self.unknown) for rule in forest.rules]
        first = len(self.rules)
        symbols = [first + self._symbol_numbers.get(s, self.unknown - first) for s in forest.symbols]
        symbol, rule = forest.nodes.symbol, forest.nodes.rule
        if rows is not None:
            symbol, rule = symbol.take(rows), rule.take(rows)
        index = symbol + np.int64(len(rules))
        np.copyto(index, rule, where=rule >= 0)
        return np.array([*rules, *symbols], dtype=np.int64)[index]

    def symbol_of(self, label: int) -> str:
        """The symbol of the nodes of a known label."""
        return self.rules[label].symbol if label < len(self.rules) else self.symbols[label - len(self.rules)]

    def alternatives(self, label: int) -> tuple[int, ...]:
        """Labels of all rules that rewrite the same symbol as this rule, itself included."""
        return self._alternatives[_key(self.rules[label])[:2]]

    def is_overloaded(self, symbol: str) -> bool:
        """Whether rules with different numbers of parameters rewrite a symbol."""
        return self._overloads[symbol] > 1

    @cached_property
    def chosen(self) -> NDArray[np.bool_]:
        """[unknown + 1] whether a label is a rule chosen at random."""
        flags = [r.symbol in self.drawn and len(self.alternatives(i)) > 1 for i, r in enumerate(self.rules)]
        return np.array(flags + [False] * (len(self.symbols) + 1))

    @cached_property
    def exchangeable(self) -> Mapping[str, str]:
        """Symbols that are alternatives of choices, each with a representative of its alternatives.

        A random rule that makes a single node is a choice of that node's symbol. Two such choices with a common symbol
        are treated as one: the roof of an office and the roof of a house.
        """
        choices: dict[tuple, set[str]] = {}
        for label in np.flatnonzero(self.chosen).tolist():
            if len(self.successors[label]) == 1:
                choices.setdefault(_key(self.rules[label])[:2], set()).update(self.successors[label].values())
        alternatives = [sorted(symbols) for symbols in choices.values() if len(symbols) > 1]
        if not alternatives:
            return {}
        symbols = sorted(set().union(*alternatives))
        number = {symbol: index for index, symbol in enumerate(symbols)}
        edges = np.array(
            [(number[joined[0]], number[symbol]) for joined in alternatives for symbol in joined], dtype=np.int64
        )
        group = connected(len(symbols), *edges.T)
        first = np.unique(group, return_index=True)[1]
        return {symbol: symbols[first[component]] for symbol, component in zip(symbols, group.tolist(), strict=True)}

    @cached_property
    def telling(self) -> NDArray[np.bool_]:
        """[unknown + 1] whether an edge below a label has more information than the edges around it."""
        forks = [len(children) > 1 for children in self.successors] + [False] * (len(self.symbols) + 1)
        return self.chosen | np.array(forks)

    @cached_property
    def symbol_numbers(self) -> Ints:
        """[unknown + 1] index into `symbols` for each label; -1 for the unknown one."""
        numbers = [self._symbol_numbers.get(self.symbol_of(label), -1) for label in range(self.unknown)]
        return np.array([*numbers, -1], dtype=np.int64)

    @cached_property
    def _rule_numbers(self) -> dict[tuple, int]:
        return {_key(rule): number for number, rule in enumerate(self.rules)}

    @cached_property
    def _symbol_numbers(self) -> dict[str, int]:
        return {symbol: number for number, symbol in enumerate(self.symbols)}

    @cached_property
    def _alternatives(self) -> dict[tuple, tuple[int, ...]]:
        groups: dict[tuple, list[int]] = {}
        for number, rule in enumerate(self.rules):
            groups.setdefault(_key(rule)[:2], []).append(number)
        return {key: tuple(numbers) for key, numbers in groups.items()}

    @cached_property
    def _overloads(self) -> Counter[str]:
        return Counter(symbol for symbol, _ in self._alternatives)


Key: TypeAlias = tuple[Any, ...]
"""Key of a column of a table; the modules that make columns describe their keys."""


class KeyIndex:
    """Columns of a table by key, in the order in which the keys were first found."""

    def __init__(self) -> None:
        self.keys: list[Key] = []
        self._columns: dict[Key, int] = {}

    def __len__(self) -> int:
        return len(self.keys)

    def columns(self, keys: Iterable[Key], grow: bool) -> Ints:
        """Column of each key; a new key is added with ``grow``, otherwise it is -1."""
        numbers = self._columns
        if not grow:
            return np.array([numbers.get(key, -1) for key in keys], dtype=np.int64)
        columns = np.array([numbers.setdefault(key, len(numbers)) for key in keys], dtype=np.int64)
        self.keys.extend(islice(numbers, len(self.keys), None))
        return columns


def _key(rule: RuleName) -> tuple[str, int, tuple[int, ...]]:
    return rule.symbol, rule.parameters, rule.branch


def _successors_in(forest: Forest, labels: NodeLabels) -> list[tuple[int, int, str]]:
    """Different (label of a node, ``child`` and symbol of one below it)."""
    nodes = forest.nodes
    # The parent -1 of a root takes the rule of the last node, so that roots are runs of their own.
    starts, _ = runs(nodes.parent < 0, nodes.rule.take(nodes.parent, mode="wrap"), nodes.child, nodes.symbol)
    starts = starts[nodes.parent[starts] >= 0]
    upper, child = labels.numbers(forest, nodes.parent[starts]), nodes.child[starts].astype(np.int64)
    width = int(child.max(initial=0)) + 1
    keys = (upper * width + child) * len(forest.symbols) + nodes.symbol[starts]
    edge, symbol = np.divmod(distinct(keys, (labels.unknown + 1) * width * len(forest.symbols)), len(forest.symbols))
    upper, child = np.divmod(edge, width)
    edges = zip(upper.tolist(), child.tolist(), symbol.tolist(), strict=True)
    return [(u, c, forest.symbols[s]) for u, c, s in edges]


def _rule_draws(forest: Forest) -> tuple[Ints, Floats]:
    """Nodes [K] whose rule was drawn, ascending, and the log-density of these draws; without certain ones."""
    definitions = {symbol: number for number, symbol in enumerate(forest.symbols)}
    owners = [definitions.get(site.definition, -1) if site.kind == "choice" else -1 for site in forest.sites]
    draws = forest.draws
    deciding = np.array([*owners, -1])[draws.site] == forest.nodes.symbol[draws.node]
    deciding &= forest.nodes.rule[draws.node] >= 0
    logarithms = np.bincount(draws.node[deciding], draws.log_density[deciding], len(forest.nodes))
    nodes = np.flatnonzero(logarithms != 0.0)  # nonzero of flags is twice as fast as of numbers
    return nodes, logarithms[nodes].astype(np.float64)
