"""Choices of a grammar whose probabilities are learned, and counts of their branches.

A *choice* is one list of ``N%`` branches of a rule, once for each context of its symbol, or the parts of a drawn
attribute. Its branches are *cells*; a derivation is described by its count of each cell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy import sparse

from grammarlab.arrays import Floats, Ints, take_rows
from grammarlab.density.exact.attributes import AttributeParts, parts_taken
from grammarlab.density.exact.contexts import Contexts, OpenPatterns
from grammarlab.density.grammar_skeleton import Alternative, Body, Cases, Chance
from grammarlab.derivation.forest import Forest
from grammarlab.features.patterns.pattern import Below, Pattern
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import Branch, SymbolKey

RuleChoice: TypeAlias = tuple[int, Branch]
"""A choice in a rule: a symbol of `Contexts`, and the branches that lead to the choice."""


@dataclass(frozen=True)
class Choices:
    """Choices with A cells in total."""

    contexts: Contexts
    attributes: tuple[AttributeParts, ...]
    """Drawn attributes; their parts are the last cells."""
    original: Floats
    """[A] probability of each cell in the original grammar."""
    choice: Ints
    """[A] choice of each cell, ascending from 0."""
    first: Mapping[RuleChoice, int]
    """The first cell of each choice in a rule."""
    first_of_attribute: tuple[int, ...]
    """The first cell of each attribute."""

    @classmethod
    def of(
        cls,
        contexts: Contexts,
        attributes: Sequence[AttributeParts] = (),
        learned: Callable[[int, Chance], bool] = lambda symbol, chance: True,
    ) -> Choices:
        """The choices of a grammar whose probabilities are constants.

        Args:
            contexts: the symbols.
            attributes: the attributes to learn.
            learned: function of a symbol of `contexts` and a choice of its rule: whether to learn it.
        """
        first: dict[RuleChoice, int] = {}
        lists: list[Sequence[float]] = []
        size = 0
        for symbol, (key, _) in enumerate(contexts.symbols):
            for chance in chances(contexts.tree.body(key)):
                if chance.probabilities is not None and learned(symbol, chance):
                    first[symbol, chance.path] = size
                    lists.append(chance.probabilities)
                    size += len(chance.probabilities)
        starts = np.cumsum([size, *(len(parts.parts) for parts in attributes)])[:-1]
        lists += [parts.probabilities.tolist() for parts in attributes]
        return cls(
            contexts,
            tuple(attributes),
            np.array([p for values in lists for p in values], dtype=np.float64),
            np.repeat(np.arange(len(lists)), [len(values) for values in lists]),
            first,
            tuple(starts.tolist()),
        )

    def cells(self, symbol: int, branch: Branch) -> tuple[int, ...]:
        """The cells of a production of a symbol of `contexts`."""
        choices = [
            (self.first[symbol, branch[:i]], index)
            for i, index in enumerate(branch)
            if (symbol, branch[:i]) in self.first
        ]
        return tuple(first + index for first, index in choices)

    def count(self, grammar: Grammar, forest: Forest) -> sparse.csr_array:
        """[models, A] count of each cell in each model of a forest of the grammar."""
        node, symbol = self._symbols(forest)
        pair, number = np.unique(
            symbol * len(forest.rules) + forest.nodes.rule[node].astype(np.int64), return_inverse=True
        )
        owners = [self.cells(int(p // len(forest.rules)), forest.rules[p % len(forest.rules)].branch) for p in pair]
        spread = sparse.csr_array(
            (
                np.ones(sum(map(len, owners))),
                np.array([cell for cells in owners for cell in cells], dtype=np.int64),
                np.cumsum([0, *map(len, owners)]),
            ),
            shape=(len(pair), len(self.original)),
        )
        coordinates = forest.nodes.model[node].astype(np.int64), number.reshape(-1)
        production_counts = sparse.coo_array(
            (np.ones(len(node)), coordinates), shape=(forest.num_models, len(pair))
        ).tocsr()
        counts = production_counts @ spread
        for parts, first in zip(self.attributes, self.first_of_attribute, strict=True):
            cell = first + parts_taken(parts, grammar, forest)
            ones = np.ones(forest.num_models), (np.arange(forest.num_models), cell)
            counts = counts + sparse.csr_array(ones, shape=counts.shape)
        return sparse.csr_array(counts)

    def extents(self, forest: Forest, weights: Floats) -> Floats:
        """[choices] mean share of a model's nodes at or below the symbol of each choice; 0 for attributes.

        Args:
            forest: models of the grammar.
            weights: [models] weight of each model, >= 0 and not all 0.
        """
        parent, model = forest.nodes.parent.astype(np.int64), forest.nodes.model
        size = np.ones(len(parent))
        for level in reversed(list(levels(parent))):
            np.add.at(size, parent[level], size[level])
        root = parent < 0
        share = size / np.bincount(model[root], size[root], forest.num_models)[model]
        node, symbol = self._symbols(forest)
        extent = np.bincount(symbol, (weights[model] * share)[node], len(self.contexts.symbols)) / weights.sum()
        result = np.zeros(int(self.choice.max(initial=-1)) + 1)
        for (number, _), first in self.first.items():
            result[self.choice[first]] = extent[number]
        return result

    def _symbols(self, forest: Forest) -> tuple[Ints, Ints]:
        """The nodes with a rule, and the index of each one's symbol in `contexts`."""
        nodes, contexts = forest.nodes, self.contexts
        rules = [((rule.symbol, rule.parameters), rule.branch) for rule in forest.rules]
        table: dict[tuple[int, int], tuple[int, ...]] = {}
        by_key: dict[SymbolKey, list[int]] = {}
        for symbol, (key, _) in enumerate(contexts.symbols):
            by_key.setdefault(key, []).append(symbol)
        offset = np.zeros((len(contexts.symbols), max(1, len(rules))), dtype=np.int64)
        flat: list[int] = []
        for rule, (key, branch) in enumerate(rules):
            for symbol in by_key.get(key, ()):
                offset[symbol, rule] = len(flat)
                table[symbol, rule] = contexts.children[symbol, branch]
                flat += table[symbol, rule]
        children = np.array(flat, dtype=np.int64)
        rows = np.flatnonzero(nodes.rule >= 0)
        row_of = np.full(len(nodes) + 1, -1, dtype=np.int64)
        row_of[rows] = np.arange(len(rows))
        parent = row_of[nodes.parent[rows]]
        rule, child = nodes.rule[rows].astype(np.int64), nodes.child[rows].astype(np.int64)
        number = np.zeros(len(rows), dtype=np.int64)
        for level in levels(parent):
            above = parent[level]
            number[level] = children[offset[number[above], rule[above]] + child[level]]
        return rows, number


def levels(parent: Ints) -> Iterator[Ints]:
    """Rows below the roots by depth, from the top, given the row of each one's parent, -1 for a root."""
    order = np.argsort(parent, kind="stable")
    starts = np.searchsorted(parent[order], np.arange(len(parent) + 1))
    rows = np.flatnonzero(parent < 0)
    while len(rows):
        where, _ = take_rows(starts, rows)
        rows = order[where]
        if len(rows):
            yield rows


def chances(body: Body) -> Iterator[Chance]:
    """The choices of a rule, from the top."""
    if isinstance(body, Chance):
        yield body
    if isinstance(body, Chance | Cases):
        for branch in body.branches:
            yield from chances(branch)


def relevant_choices(contexts: Contexts, patterns: OpenPatterns) -> Callable[[int, Chance], bool]:
    """The choices that affect the counts of patterns.

    A choice is left out only if all its branches lead to trees that no pattern distinguishes: then the branch is
    independent of all counts, and its probability is the original one under any preference that only reads counts. Two
    symbols are equivalent if, recursively, their productions have the same probabilities, match the same parts of
    patterns, and have equivalent successors.

    Args:
        contexts: the grammar, split by ``patterns``.
        patterns: the patterns that the preference reads.
    """
    signature = _Signatures(contexts, patterns)
    kind = [0] * len(contexts.symbols)
    size = 0
    while True:
        classes: dict[object, int] = {signature.nothing: 0}
        kind = [classes.setdefault(signature.symbol(i, kind), len(classes)) for i in range(len(kind))]
        if len(classes) == size:
            break
        size = len(classes)

    def matters(symbol: int, chance: Chance) -> bool:
        return len({signature.body(symbol, branch, kind) for branch in chance.branches}) > 1

    return matters


class _Signatures:
    """Signatures of symbols and their choices for given classes of equivalent symbols."""

    nothing = ("leaf", (), ())

    def __init__(self, contexts: Contexts, patterns: OpenPatterns) -> None:
        self.contexts = contexts
        self.patterns = patterns
        self.fitting: dict[tuple[int, Branch | None], tuple[Pattern, ...]] = {}
        self.ordered = any(len(below.run) > 1 for below in _conditions(patterns))

    def symbol(self, number: int, kind: Sequence[int]) -> object:
        return self.body(number, self.contexts.tree.body(self.contexts.symbols[number][0]), kind)

    def body(self, number: int, body: Body, kind: Sequence[int]) -> object:
        if isinstance(body, Alternative):
            return self._alternative(number, body, kind)
        inner = [self.body(number, branch, kind) for branch in body.branches]
        if len(set(inner)) == 1:
            return inner[0]
        if isinstance(body, Cases) or body.probabilities is None:
            return "cases", number, tuple(inner)
        total: dict[object, float] = {}
        for probability, signature in zip(body.probabilities, inner, strict=True):
            total[signature] = total.get(signature, 0.0) + probability
        return "chance", frozenset((signature, round(p, 12)) for signature, p in total.items() if p > 0.0)

    def _alternative(self, number: int, alternative: Alternative, kind: Sequence[int]) -> object:
        production = number, alternative.branch
        if production not in self.fitting:
            key, context = self.contexts.symbols[number]
            self.fitting[production] = self.patterns.matched(context, key, alternative)
        inside: list[tuple[object, ...]] = []
        for child, successor in zip(self.contexts.children[production], alternative.successors, strict=True):
            if self.ordered or kind[child]:
                # A random number of copies is not equivalent to any other.
                copies = successor.copies if successor.copies is not None else successor.location
                inside.append((kind[child], copies))
        return "leaf", self.fitting[production], tuple(inside if self.ordered else sorted(inside, key=repr))


def _conditions(patterns: OpenPatterns) -> Iterator[Below]:
    waiting = list(patterns.tops)
    while waiting:
        for below in waiting.pop().below:
            yield below
            waiting += below.run
