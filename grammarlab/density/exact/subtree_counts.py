"""Components: the counts of a subtree that are needed to count patterns in the whole tree.

There are three kinds: the count of a pattern in the subtree (`Total`), the number of embeddings of a part of a pattern
at its root (`PatternMatch`), and that of a run of siblings anywhere inside it (`Deep`). For each symbol, only the
components that can be above zero and that an ancestor needs are kept; needs are open prefixes of patterns, passed down.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from grammarlab.density.grammar_skeleton import Alternative, TreeGrammar
from grammarlab.features.patterns.pattern import Below, Pattern
from grammarlab.language.numbering import SymbolKey

NO_CAP = 2**30
"""Cap of counts that are not capped; products of two such numbers fit into 64 bits."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A weighted sum of counts, capped where a preference no longer distinguishes its values."""

    terms: tuple[tuple[Pattern, int], ...]
    """Patterns with the weight of each occurrence, at least 1."""
    cap: int = NO_CAP
    """Cap: sums of this or more are treated as equal."""

    @classmethod
    def of(cls, pattern: Pattern) -> Reading:
        """Reading of the count of one pattern."""
        return cls(((pattern, 1),))

    def __str__(self) -> str:
        return " + ".join(str(pattern) if weight == 1 else f"{weight} * {pattern}" for pattern, weight in self.terms)


@dataclass(frozen=True, slots=True)
class Total:
    """Value of a reading in the subtree: embeddings whose top node lies in it."""

    reading: Reading


@dataclass(frozen=True, slots=True)
class PatternMatch:
    """Embeddings of a pattern whose top node is the root of the subtree."""

    pattern: Pattern


@dataclass(frozen=True, slots=True)
class Deep:
    """Runs directly below any node of the subtree."""

    below: Below


Component: TypeAlias = Total | PatternMatch | Deep


def fits(pattern: Pattern, key: SymbolKey, alternative: Alternative) -> bool:
    """Whether the label of a pattern's top node matches a node of this symbol and alternative."""
    symbol, parameters = key
    if pattern.symbol is not None and pattern.symbol != symbol:
        return False
    if alternative.branch is None:
        return pattern.parameters is None and pattern.branch is None
    if pattern.parameters is not None and pattern.parameters != parameters:
        return False
    return pattern.branch is None or alternative.branch[: len(pattern.branch)] == pattern.branch


@dataclass(frozen=True)
class PatternComponents:
    """Components of a list of readings, and those that matter at each symbol."""

    tree: TreeGrammar
    readings: tuple[Reading, ...]

    @cached_property
    def all(self) -> tuple[Component, ...]:
        """Every component, without repetition."""
        components: dict[Component, None] = {Total(reading): None for reading in self.readings}
        for pattern in (pattern for reading in self.readings for pattern, _ in reading.terms):
            for below in _belows(pattern):
                components |= {PatternMatch(inner): None for inner in below.run}
                if below.deep:
                    components[Deep(below)] = None
        return tuple(components)

    @cached_property
    def inner_cap(self) -> int:
        """Cap of all components except totals: at least the cap of every total that depends on them."""
        return max((reading.cap for reading in self.readings), default=NO_CAP)

    def cap(self, component: Component) -> int:
        """Cap of a component: values of this or more are treated as equal."""
        return component.reading.cap if isinstance(component, Total) else self.inner_cap

    @cached_property
    def number(self) -> Mapping[Component, int]:
        """Index of each component in `all`."""
        return {component: i for i, component in enumerate(self.all)}

    @cached_property
    def active(self) -> Mapping[SymbolKey, tuple[int, ...]]:
        """For each reachable symbol, the needed components that can be above zero."""
        masks = dict.fromkeys(self.tree.reachable, 0)
        masks[self.tree.start] = sum(1 << self.number[Total(reading)] for reading in set(self.readings))
        queue = [self.tree.start]
        while queue:
            key = queue.pop()
            mask = masks[key] & self._possible[key]
            for alternative in self.tree.alternatives(key):
                conditions = self.conditions(key, alternative, _bits(mask))
                for position, successor in enumerate(alternative.successors):
                    required = self._required(conditions, position, mask) & self._possible[successor.key]
                    if required & ~masks[successor.key]:
                        masks[successor.key] |= required
                        queue.append(successor.key)
        return {key: _bits(mask & self._possible[key]) if mask else () for key, mask in masks.items()}

    @cached_property
    def calls(self) -> Mapping[SymbolKey, tuple[SymbolKey, ...]]:
        """For each relevant symbol, its relevant successors."""
        matters = {key for key, active in self.active.items() if active}
        return {
            key: tuple({s.key: None for a in self.tree.alternatives(key) for s in a.successors if s.key in matters})
            for key in self.active
            if key in matters
        }

    def conditions(self, key: SymbolKey, alternative: Alternative, active: Sequence[int]) -> tuple[Below, ...]:
        """The runs that must be counted among the children of a node with this alternative."""
        runs: dict[Below, None] = {}
        for i in active:
            component = self.all[i]
            if isinstance(component, Deep):
                runs[component.below] = None
            else:
                for pattern in tops(component):
                    if fits(pattern, key, alternative):
                        runs |= dict.fromkeys(pattern.below)
        return tuple(runs)

    @cached_property
    def _inherited(self) -> int:
        """Components that are sums over the subtree."""
        return sum(1 << i for i, component in enumerate(self.all) if not isinstance(component, PatternMatch))

    @cached_property
    def _possible(self) -> dict[SymbolKey, int]:
        """For each symbol, a superset of the components that can be above zero, as bits."""
        possible = dict.fromkeys(self.tree.reachable, 0)
        named = {pattern.symbol for c in self.all if not isinstance(c, Deep) for pattern in tops(c)}
        # Symbols are visited again when components are found below them.
        queue = [key for key in possible if None in named or key[0] in named]
        waiting = set(queue)
        while queue:
            key = queue.pop()
            waiting.discard(key)
            mask = self._possible_at(key, possible)
            if mask != possible[key]:
                possible[key] = mask
                again = [parent for parent in self.tree.callers[key] if parent not in waiting]
                queue += again
                waiting.update(again)
        return possible

    def _labelled(self, key: SymbolKey) -> tuple[int, ...]:
        """Components that begin at a node of this symbol under some alternative."""
        return tuple(sorted({*self._by_top.get(None, ()), *self._by_top.get(key[0], ())}))

    @cached_property
    def _by_top(self) -> dict[str | None, list[int]]:
        """Components by the symbols of their top nodes; under None those with any top node."""
        by_symbol: dict[str | None, list[int]] = {}
        for i, component in enumerate(self.all):
            names = {None} if isinstance(component, Deep) else {pattern.symbol for pattern in tops(component)}
            for name in names:
                by_symbol.setdefault(name, []).append(i)
        return by_symbol

    def _possible_at(self, key: SymbolKey, possible: Mapping[SymbolKey, int]) -> int:
        mask, labelled = possible[key], self._labelled(key)
        for alternative in self.tree.alternatives(key):
            below = [possible[successor.key] for successor in alternative.successors]
            inherited = 0
            for child in below:
                inherited |= child & self._inherited
            mask |= inherited
            for i in labelled:
                if not mask >> i & 1 and self._begins(self.all[i], key, alternative, below, inherited):
                    mask |= 1 << i
        return mask

    def _begins(
        self, component: Component, key: SymbolKey, alternative: Alternative, below: Sequence[int], inherited: int
    ) -> bool:
        if isinstance(component, Deep):
            return self._run_possible(component.below, below)
        return any(
            fits(pattern, key, alternative)
            and all(
                self._run_possible(condition, below)
                or (condition.deep and bool(inherited >> self.number[Deep(condition)] & 1))
                for condition in pattern.below
            )
            for pattern in tops(component)
        )

    def _run_possible(self, condition: Below, below: Sequence[int]) -> bool:
        bits = [self.number[PatternMatch(inner)] for inner in condition.run]
        positions = range(len(below)) if condition.child is None else range(condition.child, condition.child + 1)
        return any(i < len(below) and below[i] >> bits[0] & 1 for i in positions) and all(
            any(mask >> bit & 1 for mask in below) for bit in bits[1:]
        )

    def _required(self, conditions: Sequence[Below], position: int, mask: int) -> int:
        """Components of the child at a place that the components `mask` of a node need, as bits."""
        required = mask & self._inherited
        for condition in conditions:
            if condition.deep:
                required |= 1 << self.number[Deep(condition)]
            for step, inner in enumerate(condition.run):
                if step or condition.child in (None, position):
                    required |= 1 << self.number[PatternMatch(inner)]
        return required


def top_terms(component: Total | PatternMatch) -> tuple[tuple[Pattern, int], ...]:
    """Patterns embedded at the node, with the weight of each embedding."""
    return ((component.pattern, 1),) if isinstance(component, PatternMatch) else component.reading.terms


def tops(component: Total | PatternMatch) -> tuple[Pattern, ...]:
    """Patterns embedded at the node."""
    return tuple(pattern for pattern, _ in top_terms(component))


def _belows(pattern: Pattern) -> Iterator[Below]:
    for below in pattern.below:
        yield below
        for inner in below.run:
            yield from _belows(inner)


def _bits(mask: int) -> tuple[int, ...]:
    return tuple(i for i in range(mask.bit_length()) if mask >> i & 1)
