"""Choices that are made alike: the same alternative at two places, or of adjacent parts.

That two blocks have the same shape says nothing about either block alone, and takes one condition for each shape.
Choices of different symbols are comparable if they have the same alternatives: the frame of a box and of a cylinder.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import combinations, islice
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.forest import Forest
from grammarlab.features.patterns.node_labels import NodeLabels
from grammarlab.features.patterns.pattern import Below, Pattern, Total
from grammarlab.features.patterns.tree_index import Trees
from grammarlab.features.search.totals import gains_of

MAX_EQUALITIES = 4
"""Largest number of equalities."""
_MAX_CHOICES = 60
"""Largest number of choices that are compared with each other."""
_MAX_ALTERNATIVES = 11
"""Largest number of alternatives of a choice."""
_MAX_ANCESTORS = 3
"""Largest number of ancestors that distinguish places of a choice."""
_MAX_TIMES = 64
"""Largest average number of times that a model makes the choice of a symbol; if there are more, none is compared."""

_Branch: TypeAlias = tuple[int, ...]


class _ChoiceTable(NamedTuple):
    """M choices made in n models, with the same alternatives."""

    model: Ints
    """[M] model that makes each choice."""
    branch: Ints
    """[M] number of the branch."""
    nodes: Ints
    """[1 + A, M] the node, numbered across forests, and its ancestors from the parent up; -1 above roots."""
    following: Ints
    """[1 + A, M] next sibling of each node; -1 for the last one."""
    children: Ints
    """[1 + A, M] index of each node among the successors of its parent."""
    symbols: Ints
    """[1 + A, M] symbols of the nodes."""

    def take(self, rows: Ints | NDArray[np.bool_]) -> _ChoiceTable:
        """Some of the choices."""
        return _ChoiceTable(*(column[..., rows] for column in self))

    def lines(self, length: int) -> Iterator[_ChoiceTable]:
        """The choices at each path of so many successors below a symbol."""
        keys = np.concatenate([self.symbols[length : length + 1], self.children[:length]])
        line_of = np.unique(keys, axis=1, return_inverse=True)[1].reshape(-1)
        order = np.argsort(line_of, kind="stable")
        for rows in np.split(order, np.flatnonzero(np.diff(line_of[order])) + 1):
            if (self.nodes[length, rows] >= 0).all():
                yield self.take(rows)


class _Line(NamedTuple):
    """A choice and the nodes above it, from the top down."""

    symbols: tuple[str | None, ...]
    """Symbols of the nodes, the last one of the choice; None for any."""
    children: tuple[int, ...]
    """Index of each node below the first one among the successors of its parent."""

    def pattern(self, branch: _Branch) -> Pattern:
        """The line with an alternative of the choice."""
        node = Pattern(self.symbols[-1], branch=branch)
        for symbol, child in zip(self.symbols[-2::-1], self.children[::-1], strict=True):
            node = Pattern(symbol, below=(Below((node,), child),))
        return node

    def below(self, top: str, branch: _Branch) -> Below:
        """The line as a condition on a node with this symbol, which is its first one or far above it."""
        pattern = self.pattern(branch)
        return pattern.below[0] if len(self.symbols) > 1 and self.symbols[0] == top else Below((pattern,), deep=True)


class _Choice(NamedTuple):
    """A choice that each of n models makes at most once."""

    line: _Line
    branch: Ints
    """[n] number of the branch; -1 if a model does not make the choice."""
    top: Ints
    """[n] the first node of the line; -1 if a model does not make the choice."""


class _Equality(NamedTuple):
    """Choices that may be made alike."""

    total: Callable[[], Total]
    """Makes the feature: of thousands, a few are needed."""
    values: Ints
    """[n] number of choices that are made alike."""
    alone: float
    """Gain of the log-likelihood of scores by the choices without their equality, in nats."""


def find_equalities(forests: Sequence[Forest], scores: Floats) -> tuple[list[Total], float]:
    """Equalities that explain more of the scores than either choice that they compare, best first.

    Some do so by chance: whether scores need one is for others to judge.

    Args:
        forests: the scored models.
        scores: [n] scores of the models, in their order.

    Returns:
        The equalities, and the log of the number of all: what the choice of one costs, in nats.
    """
    if len(scores) < 2 or not np.ptp(scores) > 0.0:
        return [], 0.0
    scaled = (scores - scores.min()) / np.ptp(scores)
    labels, root = NodeLabels.of(forests), _root(forests)
    by_values: dict[bytes, _Equality] = {}
    for branches, table in _choice_tables(forests, labels):
        for equality in (
            *_adjacent(table, branches, labels, len(scores)),
            *_pairs(table, branches, labels, root, scaled),
        ):
            if np.ptp(equality.values) > 0:
                by_values.setdefault(equality.values.tobytes(), equality)
    if not by_values:
        return [], 0.0
    equalities = list(by_values.values())
    gained = gains_of(np.array([candidate.values for candidate in equalities]), scaled)
    order = [
        equalities[index] for index in np.argsort(-gained, kind="stable") if gained[index] > equalities[index].alone
    ]
    return [candidate.total() for candidate in order[:MAX_EQUALITIES]], float(np.log(len(equalities)))


def _choice_tables(forests: Sequence[Forest], labels: NodeLabels) -> Iterator[tuple[dict[int, _Branch], _ChoiceTable]]:
    """All choices with the same alternatives, and the branch of each number."""
    numbers = {branch: number for number, branch in enumerate(dict.fromkeys(rule.branch for rule in labels.rules))}
    kinds: dict[tuple[_Branch, ...], list[int]] = {}
    for label in np.flatnonzero(labels.chosen).tolist():
        branches = tuple(sorted(labels.rules[other].branch for other in labels.alternatives(label)))
        if len(branches) <= _MAX_ALTERNATIVES and not labels.is_overloaded(labels.symbol_of(label)):
            kinds.setdefault(branches, []).append(label)
    all_trees = [Trees(forest) for forest in forests]
    for branches, members in kinds.items():
        parts, models, nodes = list[_ChoiceTable](), 0, 0
        for trees in all_trees:
            parts.append(_choices_in(trees, labels, members, numbers, models, nodes))
            models, nodes = models + trees.num_models, nodes + len(trees.forest.nodes)
        table = _ChoiceTable(*(np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)))
        table = table.take(np.bincount(table.symbols[0])[table.symbols[0]] <= _MAX_TIMES * models)
        if len(table.model):
            yield {numbers[branch]: branch for branch in branches}, table


def _choices_in(
    trees: Trees, labels: NodeLabels, members: Sequence[int], numbers: dict[_Branch, int], models: int, nodes: int
) -> _ChoiceTable:
    """The choices of some labels in one forest, after others with so many models and nodes."""
    label = np.append(trees.labels(labels), labels.unknown)
    lines = [np.flatnonzero(np.isin(label[:-1], members))]
    for _ in range(_MAX_ANCESTORS):
        lines.append(np.where(lines[-1] >= 0, trees.parent[lines[-1]], -1))
    line, branch = np.stack(lines), np.array([numbers[rule.branch] for rule in labels.rules])
    following = np.where(line >= 0, trees.next_sibling[line], -1)
    return _ChoiceTable(
        trees.model[lines[0]].astype(np.int64) + models,
        branch[label[lines[0]]],
        np.where(line >= 0, line + nodes, -1),
        np.where(following >= 0, following + nodes, -1),
        np.where(line >= 0, trees.forest.nodes.child[line], -1).astype(np.int64),
        labels.symbol_numbers[label[line]],
    )


def _adjacent(
    table: _ChoiceTable, branches: dict[int, _Branch], labels: NodeLabels, num_models: int
) -> Iterator[_Equality]:
    """Numbers of adjacent parts that are alike in a choice below them, or in their own."""
    for length in range(_MAX_ANCESTORS):
        for line in table.lines(length):
            ordered = line.take(np.argsort(line.nodes[length], kind="stable"))
            part, following = ordered.nodes[length], ordered.following[length]
            if (np.diff(part) == 0).any():
                continue
            index = np.minimum(np.searchsorted(part, following), len(part) - 1)
            pairs = part[index] == following
            equal = pairs & (ordered.branch[index] == ordered.branch)
            if equal.any():
                shared = _line(ordered.take(pairs | np.isin(part, following)), length, labels)
                values = np.bincount(ordered.model[equal], minlength=num_models)
                yield _Equality(partial(_all_adjacent, shared, list(branches.values())), values, 0.0)


def _all_adjacent(line: _Line, branches: Sequence[_Branch]) -> Total:
    """The number of adjacent parts that have taken the same alternative."""
    runs = [Below((line.pattern(branch),) * 2) for branch in branches]
    return Total(tuple((Pattern(below=(run,)), 1) for run in runs))


def _pairs(
    table: _ChoiceTable, branches: dict[int, _Branch], labels: NodeLabels, root: str, scores: Floats
) -> Iterator[_Equality]:
    """Equalities of two choices that models make at most once."""
    choices = list(islice(_choices(table, labels, len(scores)), _MAX_CHOICES))
    alone = [float(gains_of((choice.branch + 1)[None], scores)[0]) for choice in choices]
    for (first, first_gain), (second, second_gain) in combinations(zip(choices, alone, strict=True), 2):
        top = _top(first, second, root)
        if top:
            same = (first.branch == second.branch) & (first.branch >= 0)
            total = partial(_equal, first.line, second.line, list(branches.values()), top)
            yield _Equality(total, same.astype(np.int64), max(first_gain, second_gain, 0.0))


def _choices(table: _ChoiceTable, labels: NodeLabels, num_models: int) -> Iterator[_Choice]:
    """Choices of symbols that models have once, and choices at places below other nodes that models have once."""
    visited: set[bytes] = set()
    for length in range(_MAX_ANCESTORS + 1):
        for line in table.lines(length):
            if (line.nodes[1] < 0).any() or np.bincount(line.model).max() > 1:  # a root is no part of anything
                continue
            branch, top = np.full((2, num_models), -1)
            branch[line.model], top[line.model] = line.branch, line.nodes[length]
            if len(np.unique(line.branch)) > 1 and branch.tobytes() not in visited:
                visited.add(branch.tobytes())
                yield _Choice(_line(line, length, labels), branch, top)


def _line(table: _ChoiceTable, length: int, labels: NodeLabels) -> _Line:
    """What choices at one path have in common."""
    symbols = [np.unique(row).tolist() for row in table.symbols[length::-1]]
    names = tuple(labels.symbols[numbers[0]] if len(numbers) == 1 else None for numbers in symbols)
    return _Line(names, tuple(table.children[:length, 0][::-1].tolist()))


def _top(first: _Choice, second: _Choice, root: str) -> str:
    """Symbol of a node above both choices; empty if there is none that a pattern can name."""
    (first_symbol, *inner), (second_symbol, *others) = first.line.symbols, second.line.symbols
    if len(inner) != len(others):
        return ""
    both = (first.branch >= 0) & (second.branch >= 0)
    shared = inner and first_symbol == second_symbol and (first.top == second.top)[both].all()
    return (first_symbol if shared else root) or ""


def _equal(first: _Line, second: _Line, branches: Sequence[_Branch], top: str) -> Total:
    """The number of alternatives that both choices have taken, which is 1 or 0."""
    pairs = [Pattern(top, below=(first.below(top, branch), second.below(top, branch))) for branch in branches]
    return Total(tuple((pair, 1) for pair in pairs))


def _root(forests: Sequence[Forest]) -> str:
    """The symbol of all roots, if no other node has it; else an empty text."""
    roots, inner = set[str](), set[str]()
    for forest in forests:
        above = forest.nodes.parent < 0
        roots |= {forest.symbols[symbol] for symbol in np.unique(forest.nodes.symbol[above]).tolist()}
        inner |= {forest.symbols[symbol] for symbol in np.unique(forest.nodes.symbol[~above]).tolist()}
    return "" if len(roots) != 1 or roots & inner else roots.pop()
