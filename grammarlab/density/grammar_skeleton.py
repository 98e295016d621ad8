"""Skeleton of a grammar: symbols, alternatives with probabilities, and successors, without geometry.

Choices that depend on geometry are unknown: the branch of a ``case``, and the number of shapes of a
successor inside a block. A sample of derivations can determine the second, for that sample.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.derivation.expressions import VOCABULARY
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.language.checking.percentages import probabilities
from grammarlab.language.display_names import words_of_branches
from grammarlab.language.grammar import Grammar
from grammarlab.language.numbering import Branch, Successor, SymbolKey, number_branches
from grammarlab.language.syntax.syntax_tree import Case, Choice, Stochastic

MIN_DERIVATIONS = 30
"""Smallest number of derivations from which a constant count is assumed constant."""
MAX_EXAMINED_MODELS = 300
"""Largest number of models of a sample that are examined."""
_BLOCK_NODES = 1 << 16
"""Number of nodes examined together, so that they stay in the cache."""


@dataclass(frozen=True, slots=True)
class Alternative:
    """An alternative: a leaf of a rule's choices."""

    branch: Branch | None
    """Path of branches to the alternative; None if nothing rewrites the symbol: it has no rule, or no case holds."""
    successors: tuple[Successor, ...]
    """Successors in the order of the text; the index of each is its ``child`` in a forest."""


@dataclass(frozen=True, slots=True)
class Chance:
    """Choice between ``N%`` branches."""

    path: Branch
    """Position of the choice: the branches that lead to it."""
    probabilities: tuple[float, ...] | None
    """Probability of each branch, summing to 1; None if a percentage is not constant."""
    branches: tuple[Body, ...]


@dataclass(frozen=True, slots=True)
class Cases:
    """``case`` branches, which are not random."""

    path: Branch
    branches: tuple[Body, ...]
    complete: bool
    """Whether there is an ``else``; without one, the last branch here is for shapes for which no case holds."""


Body: TypeAlias = Alternative | Chance | Cases
LEAF = Alternative(None, ())
"""The alternative of a symbol without a rule."""


@dataclass(frozen=True)
class TreeGrammar:
    """The stochastic skeleton of a grammar."""

    start: SymbolKey
    bodies: Mapping[SymbolKey, Body]
    """Choices of each rule."""
    sample_counts: Mapping[tuple[SymbolKey, Branch], int] = field(default_factory=dict)
    """Counts of each alternative in the sample that determined the copies; empty without a sample."""
    grammar: Grammar | None = field(default=None, compare=False, repr=False)
    """The grammar of the text; None for a skeleton without one."""

    @classmethod
    def of(cls, grammar: Grammar, start_rule: str | None = None) -> TreeGrammar:
        """Skeleton of a grammar from its text.

        Args:
            grammar: the grammar.
            start_rule: symbol to start with, instead of the one that the grammar marks.

        Raises:
            UsageError: If there is no start rule.
        """
        marked = [rule.name for rule in (*grammar.start_rules, *grammar.rules.values()) if not rule.parameters]
        start = start_rule if start_rule is not None else next(iter(marked), "")
        if (start, 0) not in grammar.rules:
            raise UsageError(f"unknown start rule {start or '(none)'}: expected a rule without parameters")
        branches = number_branches(grammar, VOCABULARY)
        successors = {(branch.key, branch.branch): branch.successors for branch in branches}
        bodies = {key: _body(key, rule.body, (), successors) for key, rule in grammar.rules.items()}
        return cls((start, 0), bodies, grammar=grammar)

    def body(self, key: SymbolKey) -> Body:
        """Choices of a symbol."""
        return self.bodies.get(key, LEAF)

    def alternatives(self, key: SymbolKey) -> Iterator[Alternative]:
        """All alternatives of a symbol."""
        yield from leaves(self.body(key))

    @cached_property
    def words(self) -> Mapping[tuple[SymbolKey, Branch], str]:
        """What an alternative alone says, such as a colour or a text between quotes, for those that say something."""
        words: dict[tuple[SymbolKey, Branch], str] = {}
        if self.grammar is None:
            return words
        read = frozenset((*self.grammar.attributes, *(name for name, _ in self.grammar.functions)))
        for key, rule in self.grammar.rules.items():
            names = words_of_branches(rule.body, read)
            branches = [alternative.branch for alternative in self.alternatives(key) if alternative.branch is not None]
            words |= {(key, branch): word for branch, word in zip(branches, names, strict=True) if word}
        return words

    @cached_property
    def reachable(self) -> tuple[SymbolKey, ...]:
        """Reachable symbols, each after one that has it as a successor."""
        symbols = dict.fromkeys([self.start])
        queue = [self.start]
        while queue:
            for alternative in self.alternatives(queue.pop()):
                for successor in alternative.successors:
                    if successor.key not in symbols:
                        symbols[successor.key] = None
                        queue.append(successor.key)
        return tuple(symbols)

    @cached_property
    def callers(self) -> Mapping[SymbolKey, tuple[SymbolKey, ...]]:
        """For each reachable symbol, those that have it as a successor."""
        parents: dict[SymbolKey, list[SymbolKey]] = {key: [] for key in self.reachable}
        for key in self.reachable:
            for child in {s.key for alternative in self.alternatives(key) for s in alternative.successors}:
                parents[child].append(key)
        return {key: tuple(callers) for key, callers in parents.items()}

    def observed(self, forest: Forest) -> TreeGrammar:
        """Skeleton with the numbers of copies from a sample of derivations.

        A successor with unknown copies gets the number that it always had in at least `MIN_DERIVATIONS`
        derivations of its branch; a single part of a split has one copy unless the sample contradicts.
        """
        counts = _Copies(forest)
        bodies = {key: _settled(body, key, counts) for key, body in self.bodies.items()}
        sample_counts = {
            (key, alternative.branch): counts.derivations(key, alternative.branch)
            for key, body in bodies.items()
            for alternative in leaves(body)
            if alternative.branch is not None
        }
        return replace(self, bodies=bodies, sample_counts=sample_counts)


def leaves(body: Body) -> Iterator[Alternative]:
    """The alternatives of a rule's choices, left to right."""
    if isinstance(body, Alternative):
        yield body
    else:
        for branch in body.branches:
            yield from leaves(branch)


def _body(
    key: SymbolKey, choice: Choice, path: Branch, successors: Mapping[tuple[SymbolKey, Branch], tuple[Successor, ...]]
) -> Body:
    if not isinstance(choice, Case | Stochastic):
        return Alternative(path, successors[key, path])
    branches = tuple(_body(key, branch, (*path, i), successors) for i, branch in enumerate(choice.branches))
    if isinstance(choice, Stochastic):
        return Chance(path, probabilities(choice), branches)
    complete = choice.conditions[-1] is None
    return Cases(path, branches if complete else (*branches, LEAF), complete)


class _Copies:
    """Number of children of each place, for the nodes of a forest."""

    def __init__(self, forest: Forest) -> None:
        nodes = forest.nodes
        self._rules = {(name.symbol, name.parameters, name.branch): i for i, name in enumerate(forest.rules)}
        self._max_children = int(nodes.child.max(initial=0)) + 1
        size = len(forest.rules) * self._max_children
        derivations, total, repeats = (np.zeros(n + 1, dtype=np.int64) for n in (len(forest.rules), size, size))
        for start in range(0, len(nodes), _BLOCK_NODES):
            rows: slice | Ints = slice(start, start + _BLOCK_NODES)
            if forest.num_models > MAX_EXAMINED_MODELS:
                rows = start + np.flatnonzero(nodes.model[rows] < MAX_EXAMINED_MODELS)
            parent, repeat = nodes.parent[rows], nodes.repeat[rows]
            derivations += np.bincount(nodes.rule[rows] + 1, minlength=len(derivations))
            slot = nodes.rule[parent] * np.int32(self._max_children) + nodes.child[rows]
            slot[parent < 0] = size
            total += np.bincount(slot, minlength=len(total))
            later = np.flatnonzero(repeat)
            repeats += np.bincount(slot[later], repeat[later], minlength=len(repeats)).astype(np.int64)
        self._derivations, self._total, self._repeats = derivations[1:], total, repeats

    def derivations(self, key: SymbolKey, branch: Branch) -> int:
        """Number of times that a branch was taken."""
        rule = self._rules.get((*key, branch))
        return 0 if rule is None else int(self._derivations[rule])

    def constant(self, key: SymbolKey, branch: Branch, child: int) -> int | None:
        """Constant number of children at each place; None if it varies."""
        rule = self._rules[*key, branch]
        if child >= self._max_children:
            return 0
        slot = rule * self._max_children + child
        count = int(self._derivations[rule])
        copies, remainder = divmod(int(self._total[slot]), count)
        # The children of one parent are numbered from 0, so the sum of these numbers is least where all have as many.
        return copies if not remainder and self._repeats[slot] == count * (copies * (copies - 1) // 2) else None


def _settled(body: Body, key: SymbolKey, counts: _Copies) -> Body:
    """The choices with the counted numbers of copies; the same object if they are equal."""
    if not isinstance(body, Alternative):
        branches = tuple(_settled(branch, key, counts) for branch in body.branches)
        same = all(new is old for new, old in zip(branches, body.branches, strict=True))
        return body if same else replace(body, branches=branches)
    branch = body.branch
    number = 0 if branch is None else counts.derivations(key, branch)
    if branch is None or number == 0:
        return body
    successors = list(body.successors)
    for child, successor in enumerate(body.successors):
        if not successor.certain:
            copies = counts.constant(key, branch, child)
            # Few derivations can show that a number differs, not that it never does.
            if copies != successor.copies and (copies is None or number >= MIN_DERIVATIONS):
                successors[child] = replace(successor, copies=copies)
    return replace(body, successors=tuple(successors)) if successors != list(body.successors) else body
