"""The deterministic bottom-up automaton that counts patterns in the trees of a grammar.

The state of a node is its components (`grammarlab.density.exact.subtree_counts`), each capped.
The children of a node are read one after the other; a `Scan` has the state of the children read so far.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.density.exact.subtree_counts import Deep, PatternComponents, PatternMatch, Total, fits, top_terms
from grammarlab.density.grammar_skeleton import Alternative
from grammarlab.errors import InexactError
from grammarlab.features.patterns.pattern import Below, Pattern
from grammarlab.language.call_order import groups
from grammarlab.language.numbering import Branch, Successor, SymbolKey


@dataclass(frozen=True, slots=True)
class ScanStep:
    """Reading one child."""

    child: int
    key: SymbolKey
    next: Ints
    """[P, S] the scan state after scan state p and a child in state s."""


@dataclass(frozen=True, slots=True)
class Scan:
    """Reading the relevant children of one alternative, from the single scan state 0."""

    steps: tuple[ScanStep, ...]
    final: Ints
    """[P] the state of the node for each final scan state."""


@dataclass(frozen=True)
class Automaton:
    """Reachable states of every symbol and scans of every alternative."""

    components: PatternComponents
    states: Mapping[SymbolKey, Ints]
    """[S, C] the states of each reachable symbol; columns as in `PatternComponents.active`. No rows if no
    derivation of the symbol ends."""
    scans: Mapping[tuple[SymbolKey, Branch | None], Scan]
    """Scans of alternatives all of whose successors have states."""

    @property
    def totals(self) -> Ints:
        """[S, R] each reading of a whole tree, for each state of the start symbol."""
        components, start = self.components, self.components.tree.start
        states = self.states[start]
        column_of = {i: column for column, i in enumerate(components.active[start])}
        columns = [column_of.get(components.number[Total(reading)]) for reading in components.readings]
        totals = np.zeros((len(states), len(columns)), dtype=np.int64)
        for number, column in enumerate(columns):
            if column is not None:
                totals[:, number] = states[:, column]
        return totals


def count_automaton(components: PatternComponents, max_states: int = 20_000) -> Automaton:
    """The automaton that counts patterns in the trees of a grammar.

    Args:
        components: what to count; all readings have caps if a relevant symbol is recursive.
        max_states: largest number of states of a symbol; a step of a scan may have 50 times as many pairs of states.

    Raises:
        InexactError: If the number of occurrences of a relevant symbol is unknown, or there are too many
            states.
    """
    build = _AutomatonBuild(components, max_states)
    for group in groups(components.calls):
        build.settle(group)
    return Automaton(components, build.states, build.scans)


class _AutomatonBuild:
    def __init__(self, components: PatternComponents, max_states: int) -> None:
        self.components = components
        self.max_states = max_states
        plain = [key for key, active in components.active.items() if not active]
        self.states: dict[SymbolKey, Ints] = dict.fromkeys(plain, np.zeros((1, 0), dtype=np.int64))
        self.scans: dict[tuple[SymbolKey, Branch | None], Scan] = {}

    def settle(self, group: Sequence[SymbolKey]) -> None:
        """Find the states of symbols that may call each other; the states of other called symbols are known."""
        active = self.components.active
        for key in group:
            self.states[key] = np.zeros((0, len(active[key])), dtype=np.int64)
        recursive = len(group) > 1 or group[0] in self.components.calls[group[0]]
        growing = True
        while growing:
            sizes = [len(self.states[key]) for key in group]
            for key in group:
                self._symbol(key)
            growing = recursive and sizes != [len(self.states[key]) for key in group]

    def _alternatives(self, key: SymbolKey) -> Iterator[Alternative]:
        return self.components.tree.alternatives(key)

    def _symbol(self, key: SymbolKey) -> None:
        productions: list[tuple[Alternative, tuple[ScanStep, ...], Ints]] = []
        for alternative in self._alternatives(key):
            if all(len(self.states[successor.key]) for successor in alternative.successors):
                productions.append((alternative, *_Reading(self, key, alternative).run()))
        width = len(self.components.active[key])
        rows = np.concatenate([np.zeros((0, width), dtype=np.int64), *(ends for _, _, ends in productions)])
        self.states[key], numbers = distinct_rows(rows)
        if len(self.states[key]) > self.max_states:
            raise _too_many(key, len(self.states[key]))
        start = 0
        for alternative, steps, ends in productions:
            self.scans[key, alternative.branch] = Scan(steps, numbers[start : start + len(ends)])
            start += len(ends)


class _Reading:
    """One alternative: the columns of a scan, and its steps."""

    def __init__(self, build: _AutomatonBuild, key: SymbolKey, alternative: Alternative) -> None:
        self.build, self.key, self.alternative = build, key, alternative
        components = build.components
        self.active = components.active[key]
        self.conditions = components.conditions(key, alternative, self.active)
        self.inherited = [i for i in self.active if not isinstance(components.all[i], PatternMatch)]
        for condition in self.conditions:
            number = components.number.get(Deep(condition))
            if number is not None and number not in self.inherited:
                self.inherited.append(number)
        self.run_columns = {condition: len(self.inherited) + i for i, condition in enumerate(self.conditions)}
        """Column of the runs seen so far."""
        self.open: dict[Below, int] = {}
        """First column of the unfinished runs: one column for each number of matched siblings."""
        width = len(self.inherited) + len(self.conditions)
        for condition in self.conditions:
            if len(condition.run) > 1:
                self.open[condition] = width
                width += len(condition.run) - 1
        self.width = width
        inherited = [components.cap(components.all[i]) for i in self.inherited]
        self.caps = np.array(inherited + [components.inner_cap] * (width - len(inherited)), dtype=np.int64)
        """[W] cap of each column."""

    def run(self) -> tuple[tuple[ScanStep, ...], Ints]:
        """The steps, and the state [P, C] of the node for each scan state at the end."""
        rows = np.zeros((1, self.width), dtype=np.int64)
        steps: list[ScanStep] = []
        for child, successor in self._order():
            if len(rows) * len(self.build.states[successor.key]) > 50 * self.build.max_states:
                raise _too_many(self.key, len(rows) * len(self.build.states[successor.key]))
            reached = self._read(rows, child, successor.key)
            if successor.copies != 1:
                if (reached != rows[:, None, :]).any():
                    raise self._uncertain(successor)
                continue
            pairs = reached.shape[:2]
            rows, numbers = distinct_rows(reached.reshape(pairs[0] * pairs[1], self.width))
            steps.append(ScanStep(child, successor.key, numbers.reshape(pairs)))
        return tuple(steps), self._states(rows)

    def _order(self) -> list[tuple[int, Successor]]:
        """The relevant children; the one with most states last, if their order does not matter."""
        children = list(enumerate(self.alternative.successors))
        if self.open:
            return children
        active, states = self.build.components.active, self.build.states
        children = [(child, successor) for child, successor in children if active[successor.key]]
        return sorted(children, key=lambda pair: len(states[pair[1].key]))

    def _read(self, rows: Ints, child: int, key: SymbolKey) -> Ints:
        """[P, S, W] the scan after each of the rows [P, W] and each state of the child."""
        states = self.build.states[key]
        column_of = {i: column for column, i in enumerate(self.build.components.active[key])}
        number = self.build.components.number

        def column(i: int) -> Ints:
            return states[:, column_of[i]] if i in column_of else np.zeros(len(states), dtype=np.int64)

        result = np.repeat(rows[:, None, :], len(states), axis=1)
        passed_on = [slot for slot, i in enumerate(self.inherited) if i in column_of]
        result[:, :, passed_on] += states[:, [column_of[self.inherited[slot]] for slot in passed_on]]
        for condition, slot in self.run_columns.items():
            matches = [column(number[PatternMatch(pattern)]) for pattern in condition.run]
            if condition.child not in (None, child):
                matches[0] = np.zeros_like(matches[0])
            if condition not in self.open:
                result[:, :, slot] += matches[0]
                continue
            first, last = self.open[condition], len(condition.run) - 1
            begun = rows[:, None, first : first + last]
            result[:, :, slot] += begun[:, :, last - 1] * matches[last]
            result[:, :, first] = matches[0]
            for length in range(1, last):
                result[:, :, first + length] = begun[:, :, length - 1] * matches[length]
        return np.minimum(result, self.caps)

    def _states(self, rows: Ints) -> Ints:
        """The state [P, C] of the node after all children."""
        components = self.build.components
        inherited = {i: slot for slot, i in enumerate(self.inherited)}
        states = np.zeros((len(rows), len(self.active)), dtype=np.int64)
        passed_on = [column for column, i in enumerate(self.active) if i in inherited]
        states[:, passed_on] = rows[:, [inherited[self.active[column]] for column in passed_on]]
        for column, i in enumerate(self.active):
            component = components.all[i]
            if isinstance(component, Deep):
                states[:, column] += rows[:, self.run_columns[component.below]]
            else:
                for pattern, weight in top_terms(component):
                    if fits(pattern, self.key, self.alternative):
                        states[:, column] += weight * self._matches(pattern, rows)
        return np.minimum(states, [components.cap(components.all[i]) for i in self.active])

    def _matches(self, pattern: Pattern, rows: Ints) -> Ints:
        """[P] embeddings of a pattern whose top node matches this node."""
        cap = self.build.components.inner_cap
        value = np.ones(len(rows), dtype=np.int64)
        for condition in pattern.below:
            runs = rows[:, self.run_columns[condition]]
            if condition.deep:
                runs = runs + rows[:, self.inherited.index(self.build.components.number[Deep(condition)])]
            value = np.minimum(value * np.minimum(runs, cap), cap)
        return value

    def _uncertain(self, successor: Successor) -> InexactError:
        name, line = successor.key[0], successor.location.line
        return InexactError(
            f"how often {self.key[0]} has {name} (line {line}) depends on sizes or conditions, and the preference "
            f"counts what lies in or beside it: an exact grammar must know that number"
        )


def distinct_rows(rows: Ints) -> tuple[Ints, Ints]:
    """The different rows [K, W] of a table [N, W] of integers >= 0, and the index [N] of each row among them."""
    if len(rows) <= 1 or not rows.shape[1]:
        return rows[:1], np.zeros(len(rows), dtype=np.int64)
    radix = rows.max(axis=0) + 1
    if float(np.prod(radix.astype(np.float64))) < 2.0**62:
        weights = np.concatenate([np.cumprod(radix[:0:-1])[::-1], [1]])
        _, first, numbers = np.unique(rows @ weights, return_index=True, return_inverse=True)
        return rows[first], numbers
    distinct, numbers = np.unique(rows, axis=0, return_inverse=True)
    return distinct, numbers.reshape(-1)


def _too_many(key: SymbolKey, number: int) -> InexactError:
    return InexactError(
        f"the preference distinguishes {number:,} kinds of {key[0]}: too many for an exact grammar. "
        "Leave out features that matter little"
    )
