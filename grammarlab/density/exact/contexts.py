"""Symbols split by context: the same grammar with more symbols, so that more can be learned about it.

The paper's splitting operation indexes a symbol by the edge that leads to it: the rule of its parent and its place
below (section 4.6, after Klein and Manning's parent annotation). `ParentEdges` does that for the symbols that relevant
features name below their top. `OpenPatterns` distinguishes fewer symbols: a symbol is split by the features
matched from the root down to it, so that it supports conditions on descendants.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from grammarlab.density.exact.splitting import MAX_WAYS
from grammarlab.density.exact.subtree_counts import fits
from grammarlab.density.grammar_skeleton import Alternative, TreeGrammar
from grammarlab.errors import GrammarlabError
from grammarlab.features.patterns.pattern import Below, Pattern
from grammarlab.language.call_order import groups
from grammarlab.language.numbering import Branch, SymbolKey


class AbstractContext(ABC):
    """Context of symbols: a value that is passed down the tree."""

    start: Hashable
    """Context of the start symbol."""

    @abstractmethod
    def below(self, context: Hashable, key: SymbolKey, alternative: Alternative, child: int) -> Hashable:
        """The context of a successor, from that of its parent.

        Args:
            context: context of the parent.
            key: symbol of the parent.
            alternative: alternative of the parent.
            child: index of the successor.
        """


class NoContext(AbstractContext):
    """No context: symbols are not split."""

    start = ()

    def below(self, context: Hashable, key: SymbolKey, alternative: Alternative, child: int) -> Hashable:
        return ()


class ParentEdges(AbstractContext):
    """Context of the edges above a symbol: as many as the longest pattern that names it there.

    Conditions on descendants at any depth do not split symbols, since no edge leads to them.

    Args:
        tree: the grammar.
        patterns: the relevant patterns.
    """

    start = ()

    def __init__(self, tree: TreeGrammar, patterns: Sequence[Pattern]) -> None:
        self._length = _edges_needed(tree, patterns)

    def below(self, context: Hashable, key: SymbolKey, alternative: Alternative, child: int) -> Hashable:
        above = context if isinstance(context, tuple) else ()
        edges = (*above, (key, alternative.branch, child))
        length = self._length.get(alternative.successors[child].key, 0)
        return edges[len(edges) - length :] if length else ()


class OpenPatterns(AbstractContext):
    """Context of the parts of patterns that may match at a symbol or below it, given its ancestors.

    Args:
        tree: the grammar.
        patterns: the relevant patterns.
    """

    start = frozenset()

    def __init__(self, tree: TreeGrammar, patterns: Sequence[Pattern]) -> None:
        self.tops = tuple(dict.fromkeys(patterns))
        self._inside = _symbols_inside(tree)

    def below(self, context: Hashable, key: SymbolKey, alternative: Alternative, child: int) -> Hashable:
        conditions = {condition for condition in _opened(context) if condition.deep}
        for pattern in self.matched(context, key, alternative):
            conditions |= {condition for condition in pattern.below if _may_match(condition, child)}
        return frozenset(c for c in conditions if self._may_lie(c, alternative.successors[child].key))

    def matched(self, context: Hashable, key: SymbolKey, alternative: Alternative) -> tuple[Pattern, ...]:
        """Parts of patterns whose top node may match a node, for any descendants."""
        inner = [pattern for condition in _opened(context) for pattern in condition.run]
        return tuple(pattern for pattern in dict.fromkeys([*self.tops, *inner]) if fits(pattern, key, alternative))

    def _may_lie(self, condition: Below, key: SymbolKey) -> bool:
        names = self._inside[key] if condition.deep else {key[0]}
        return any(pattern.symbol is None or pattern.symbol in names for pattern in condition.run)


@dataclass(frozen=True)
class Contexts:
    """A grammar's symbols, once per context."""

    tree: TreeGrammar
    symbols: tuple[tuple[SymbolKey, Hashable], ...]
    """Each symbol with its context; the first one is the start."""
    children: Mapping[tuple[int, Branch | None], tuple[int, ...]]
    """Indices of the successors, for each index of `symbols` and each alternative."""

    @classmethod
    def of(cls, tree: TreeGrammar, context: AbstractContext) -> Contexts:
        """All symbols in contexts that can be reached.

        Raises:
            GrammarlabError: If there are more than `MAX_WAYS`.
        """
        numbers: dict[tuple[SymbolKey, Hashable], int] = {(tree.start, context.start): 0}
        symbols = [(tree.start, context.start)]
        children: dict[tuple[int, Branch | None], tuple[int, ...]] = {}
        number = 0
        while number < len(symbols):
            key, above = symbols[number]
            for alternative in tree.alternatives(key):
                below: list[int] = []
                for child, successor in enumerate(alternative.successors):
                    symbol = successor.key, context.below(above, key, alternative, child)
                    if symbol not in numbers:
                        numbers[symbol] = len(symbols)
                        symbols.append(symbol)
                    below.append(numbers[symbol])
                children[number, alternative.branch] = tuple(below)
            number += 1
            if len(symbols) > MAX_WAYS:
                raise GrammarlabError(
                    f"the relevant features split the grammar into more than {MAX_WAYS:,} symbols: use fewer "
                    "features, or shorter paths"
                )
        return cls(tree, tuple(symbols), children)

    @cached_property
    def num_contexts(self) -> Mapping[SymbolKey, int]:
        """Number of contexts of each symbol."""
        counts: dict[SymbolKey, int] = {}
        for key, _ in self.symbols:
            counts[key] = counts.get(key, 0) + 1
        return counts


def _opened(context: Hashable) -> frozenset[Below]:
    return context if isinstance(context, frozenset) else frozenset()


def _may_match(condition: Below, child: int) -> bool:
    return condition.deep or condition.child in (None, child) or len(condition.run) > 1


def _edges_needed(tree: TreeGrammar, patterns: Sequence[Pattern]) -> dict[SymbolKey, int]:
    """Number of edges above each symbol in its context."""
    nested: list[tuple[Pattern, int]] = []
    waiting = [(pattern, 0) for pattern in patterns]
    while waiting:
        pattern, depth = waiting.pop()
        nested.append((pattern, depth))
        waiting += [(inner, depth + 1) for below in pattern.below if not below.deep for inner in below.run]
    keys = tree.reachable
    length = {
        key: max((depth for pattern, depth in nested if pattern.symbol in (None, key[0])), default=0) for key in keys
    }
    changed = True
    while changed:
        changed = False
        for key in keys:
            below = {s.key for alternative in tree.alternatives(key) for s in alternative.successors}
            longest = max((length[child] - 1 for child in below), default=0)
            if longest > length[key]:
                length[key] = longest
                changed = True
    return length


def _symbols_inside(tree: TreeGrammar) -> dict[SymbolKey, set[str]]:
    """Names of each symbol and of all symbols in its trees."""
    keys = tree.reachable
    calls = {key: {s.key for alternative in tree.alternatives(key) for s in alternative.successors} for key in keys}
    inside: dict[SymbolKey, set[str]] = {}
    for group in groups(calls):
        names = {key[0] for key in group}.union(*(inside[c] for key in group for c in calls[key] if c in inside))
        inside |= dict.fromkeys(group, names)
    return inside
