"""Density of derivation trees under a grammar of split symbols, summed over the hidden variants.

A tree of the original grammar does not contain the variants of its nodes. The probability of a tree is the
sum over all assignments of variants; it is computed bottom-up, for all trees of a forest at once, as a ratio to the
probability under the original grammar, so that only nodes where the two grammars differ are visited.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints, take_rows
from grammarlab.density.exact.grammar_text import Origin
from grammarlab.density.grammar_skeleton import Alternative, Body, Chance, TreeGrammar
from grammarlab.derivation.forest import Forest
from grammarlab.language.numbering import Branch, SymbolKey


class StartRule(NamedTuple):
    """The learned start rule of a tree, with its branches: all, or those of one component."""

    key: SymbolKey
    component: int | None


@dataclass(frozen=True, slots=True)
class _Production:
    """One learned alternative."""

    variant: int
    origin: Branch | None
    ratio: float
    """Probability of the alternative divided by that of its original."""
    children: tuple[int, ...]
    """The variant of each successor, -1 if nothing below it differs."""


class TreeRatio:
    """Density ratio of trees under a learned grammar and the original grammar.

    Args:
        original: the original grammar.
        learned: the grammar whose rules were made from it.
        origins: origins of changed rules; all others are the original's.
        starts: possible starts of a tree.
    """

    def __init__(
        self,
        original: TreeGrammar,
        learned: TreeGrammar,
        origins: Mapping[SymbolKey, Origin],
        starts: Sequence[StartRule],
    ) -> None:
        self._original = original
        self._learned = learned
        self._origins = origins
        differing = self._differing(starts)
        self._numbers = {start: i for i, start in enumerate(dict.fromkeys([*differing, *starts]))}
        self._starts = [self._numbers[start] for start in starts]
        self._slots: dict[tuple[SymbolKey, Branch | None], list[_Production]] = {}
        for start, number in self._numbers.items():
            for origin, ratio, alternative in self._alternatives(start):
                children = tuple(self._numbers.get(StartRule(s.key, None), -1) for s in alternative.successors)
                key = self._origin(start.key).key
                self._slots.setdefault((key, origin), []).append(_Production(number, origin, ratio, children))

    def __call__(self, forest: Forest) -> Floats:
        """[starts, models] density under the learned grammar, from each start, divided by that under the original."""
        columns = _Columns(forest, self._original, {key for key, _ in self._slots})
        result = np.zeros((len(self._numbers), len(columns.nodes)))
        slots = [self._slots.get(way, []) for way in columns.ways]
        width = max((len(productions) for productions in slots), default=0)
        ratio = np.array([[p.ratio for p in productions] + [0.0] * (width - len(productions)) for productions in slots])
        product = ratio[columns.way]
        for level in columns.levels():
            for way, rows in _by_group(columns.way[level], level):
                for slot, production in enumerate(slots[way]):
                    result[production.variant, rows] += product[rows, slot]
            parents = columns.parent[level]
            below = level[parents >= 0]
            slot_of = columns.way[columns.parent[below]] * columns.max_children + columns.child[below]
            for group, rows in _by_group(slot_of, below):
                way, child = divmod(group, columns.max_children)
                for slot, production in enumerate(slots[way]):
                    if production.children[child] >= 0:
                        np.multiply.at(product[:, slot], columns.parent[rows], result[production.children[child], rows])
        ratios = np.zeros((len(self._starts), forest.num_models))
        roots = forest.nodes.parent[columns.nodes] < 0
        ratios[:, forest.nodes.model[columns.nodes[roots]]] = result[self._starts][:, roots]
        return ratios

    def _origin(self, key: SymbolKey) -> Origin:
        origin = self._origins.get(key)
        branches = [alternative.branch for alternative in self._learned.alternatives(key)]
        return origin or Origin(key, {branch: branch for branch in branches if branch is not None})

    def _alternatives(self, start: StartRule) -> Iterator[tuple[Branch | None, float, Alternative]]:
        """The learned alternatives of a rule, with their originals and ratios."""
        origin = self._origin(start.key)
        before = _path_probabilities(self._original.body(origin.key))
        after = _path_probabilities(self._learned.body(start.key))
        for alternative in self._learned.alternatives(start.key):
            branch = alternative.branch
            if branch is not None and start.component not in (None, *branch[:1]):
                continue
            source = origin.branches[branch] if branch is not None else None
            old = before.get(source, 0.0) if source is not None else 1.0
            new = after[branch] if branch is not None else 1.0
            if old > 0.0:
                yield source, new / old, alternative

    def _differing(self, starts: Sequence[StartRule]) -> list[StartRule]:
        """The learned rules below the starts with any difference from the original."""
        keys = {start.key: None for start in starts}
        queue = list(keys)
        below: dict[SymbolKey, set[SymbolKey]] = {}
        while queue:
            key = queue.pop()
            below[key] = {s.key for alternative in self._learned.alternatives(key) for s in alternative.successors}
            queue += [child for child in below[key] if child not in keys]
            keys |= dict.fromkeys(below[key])
        differing = {key for key in keys if key in self._origins}
        grows = True
        while grows:
            more = {key for key in keys if key not in differing and below[key] & differing}
            differing |= more
            grows = bool(more)
        return [StartRule(key, None) for key in keys if key in differing]


class _Columns:
    """Nodes of a forest with split symbols, and their tree structure."""

    def __init__(self, forest: Forest, original: TreeGrammar, keys: set[SymbolKey]) -> None:
        nodes = forest.nodes
        rules = [((rule.symbol, rule.parameters), rule.branch) for rule in forest.rules]
        self.ways: list[tuple[SymbolKey, Branch | None]] = [*rules]
        """Symbol and alternative of a node."""
        of_rule = np.array([key in keys for key, _ in rules], dtype=bool)
        unruled = {key[0]: key for key in keys}
        of_symbol = np.full(len(forest.symbols), -1, dtype=np.int64)
        for i, symbol in enumerate(forest.symbols):
            if symbol in unruled:
                of_symbol[i] = len(self.ways)
                self.ways.append((unruled[symbol], None))
        way = np.where(nodes.rule >= 0, nodes.rule, of_symbol[nodes.symbol])
        relevant = np.where(nodes.rule >= 0, of_rule[nodes.rule], of_symbol[nodes.symbol] >= 0)
        self.nodes: Ints = np.flatnonzero(relevant)
        """[R] rows of the nodes in the forest."""
        self.way = way[self.nodes]
        """[R] index into `ways`."""
        row_of = np.full(len(nodes) + 1, -1, dtype=np.int64)
        row_of[self.nodes] = np.arange(len(self.nodes))
        self.parent: Ints = row_of[nodes.parent[self.nodes]]
        """[R] index of the parent in `nodes`, -1 for a root and below other nodes."""
        self.child = nodes.child[self.nodes].astype(np.int64)
        self.max_children = int(self.child.max(initial=0)) + 1

    def levels(self) -> Iterator[Ints]:
        """The rows by depth, the deepest first."""
        order = np.argsort(self.parent, kind="stable")
        children = np.searchsorted(self.parent[order], np.arange(len(self.nodes) + 1))
        layers = [np.flatnonzero(self.parent < 0)]
        while len(layers[-1]):
            where, _ = take_rows(children, layers[-1])
            layers.append(order[where])
        yield from reversed(layers[:-1])


def _by_group(group: Ints, rows: Ints) -> Iterator[tuple[int, Ints]]:
    """The rows of each group."""
    order = np.argsort(group, kind="stable")
    values, starts = np.unique(group[order], return_index=True)
    parts = np.split(rows[order], starts[1:]) if len(rows) else []
    yield from zip(values.tolist(), parts, strict=True)


def _path_probabilities(body: Body) -> dict[Branch, float]:
    """Probability of each alternative of a rule, from its stochastic choices."""
    probabilities: dict[Branch, float] = {}

    def visit(body: Body, probability: float) -> None:
        if isinstance(body, Alternative):
            if body.branch is not None:
                probabilities[body.branch] = probability
            return
        chances = body.probabilities if isinstance(body, Chance) else None
        for i, branch in enumerate(body.branches):
            visit(branch, probability * (chances[i] if chances is not None else 1.0))

    visit(body, 1.0)
    return probabilities
