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

MOST = 4
"""Largest number of equalities."""
_MOST_CHOICES = 60
"""Largest number of choices that are compared with each other."""
_MOST_ALTERNATIVES = 11
"""Largest number of alternatives of a choice."""
_MOST_ANCESTORS = 3
"""Largest number of ancestors that tell where a choice is made."""
_MOST_TIMES = 64
"""Largest average number of times that a model makes the choice of a symbol; if there are more, none is compared."""

_Branch: TypeAlias = tuple[int, ...]


class _Made(NamedTuple):
    """M choices made in n models, with the same alternatives."""

    model: Ints
    """[M]"""
    taken: Ints
    """[M] number of the branch."""
    nodes: Ints
    """[1 + A, M] the node, numbered across forests, and its ancestors from the parent up; -1 above roots."""
    following: Ints
    """[1 + A, M] the next sibling of each of these; -1 for the last one."""
    children: Ints
    """[1 + A, M] which successor each of these is."""
    symbols: Ints
    """[1 + A, M] symbols of these."""

    def take(self, rows: Ints | NDArray[np.bool_]) -> _Made:
        """Some of the choices."""
        return _Made(*(column[..., rows] for column in self))

    def lines(self, length: int) -> Iterator[_Made]:
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
    """Which successor each node below the first one is."""

    def pattern(self, branch: _Branch) -> Pattern:
        """The line with an alternative of the choice."""
        found = Pattern(self.symbols[-1], branch=branch)
        for symbol, child in zip(self.symbols[-2::-1], self.children[::-1], strict=True):
            found = Pattern(symbol, below=(Below((found,), child),))
        return found

    def below(self, top: str, branch: _Branch) -> Below:
        """The line as a condition on a node with this symbol, which is its first one or far above it."""
        pattern = self.pattern(branch)
        return pattern.below[0] if len(self.symbols) > 1 and self.symbols[0] == top else Below((pattern,), deep=True)


class _Choice(NamedTuple):
    """A choice that each of n models makes at most once."""

    line: _Line
    taken: Ints
    """[n] number of the branch; -1 if a model does not make the choice."""
    top: Ints
    """[n] the first node of the line; -1 if a model does not make the choice."""


class _Equality(NamedTuple):
    """Choices that may be made alike."""

    total: Callable[[], Total]
    """Makes the feature: of thousands, a few are needed."""
    values: Ints
    """[n] how many are."""
    alone: float
    """What the choices tell about scores without their equality, nats."""


def find_equalities(forests: Sequence[Forest], scores: Floats) -> tuple[list[Total], float]:
    """Equalities that explain more of the scores than either choice that they compare, best first.

    Some do so by chance: whether scores need one is for others to judge.

    Args:
        forests: the scored models.
        scores: [n] their scores, in their order.

    Returns:
        The equalities, and the log of the number of all: what the choice of one costs, in nats.
    """
    if len(scores) < 2 or not np.ptp(scores) > 0.0:
        return [], 0.0
    scaled = (scores - scores.min()) / np.ptp(scores)
    labels, root = NodeLabels.of(forests), _root(forests)
    found: dict[bytes, _Equality] = {}
    for branches, made in _made(forests, labels):
        for equality in (
            *_adjacent(made, branches, labels, len(scores)),
            *_pairs(made, branches, labels, root, scaled),
        ):
            if np.ptp(equality.values) > 0:
                found.setdefault(equality.values.tobytes(), equality)
    if not found:
        return [], 0.0
    equalities = list(found.values())
    gained = gains_of(np.array([each.values for each in equalities]), scaled)
    order = [
        equalities[place] for place in np.argsort(-gained, kind="stable") if gained[place] > equalities[place].alone
    ]
    return [each.total() for each in order[:MOST]], float(np.log(len(equalities)))


def _made(forests: Sequence[Forest], labels: NodeLabels) -> Iterator[tuple[dict[int, _Branch], _Made]]:
    """All choices with the same alternatives, and the branch of each number."""
    numbers = {branch: number for number, branch in enumerate(dict.fromkeys(rule.branch for rule in labels.rules))}
    kinds: dict[tuple[_Branch, ...], list[int]] = {}
    for label in np.flatnonzero(labels.chosen).tolist():
        branches = tuple(sorted(labels.rules[each].branch for each in labels.alternatives(label)))
        if len(branches) <= _MOST_ALTERNATIVES and not labels.is_overloaded(labels.symbol_of(label)):
            kinds.setdefault(branches, []).append(label)
    all_trees = [Trees(forest) for forest in forests]
    for branches, members in kinds.items():
        parts, models, nodes = list[_Made](), 0, 0
        for trees in all_trees:
            parts.append(_made_in(trees, labels, members, numbers, models, nodes))
            models, nodes = models + trees.num_models, nodes + len(trees.forest.nodes)
        made = _Made(*(np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)))
        made = made.take(np.bincount(made.symbols[0])[made.symbols[0]] <= _MOST_TIMES * models)
        if len(made.model):
            yield {numbers[branch]: branch for branch in branches}, made


def _made_in(
    trees: Trees, labels: NodeLabels, members: Sequence[int], numbers: dict[_Branch, int], models: int, nodes: int
) -> _Made:
    """The choices of some labels in one forest, after others with so many models and nodes."""
    label = np.append(trees.labels(labels), labels.unknown)
    lines = [np.flatnonzero(np.isin(label[:-1], members))]
    for _ in range(_MOST_ANCESTORS):
        lines.append(np.where(lines[-1] >= 0, trees.parent[lines[-1]], -1))
    line, branch = np.stack(lines), np.array([numbers[rule.branch] for rule in labels.rules])
    following = np.where(line >= 0, trees.next_sibling[line], -1)
    return _Made(
        trees.model[lines[0]].astype(np.int64) + models,
        branch[label[lines[0]]],
        np.where(line >= 0, line + nodes, -1),
        np.where(following >= 0, following + nodes, -1),
        np.where(line >= 0, trees.forest.nodes.child[line], -1).astype(np.int64),
        labels.symbol_numbers[label[line]],
    )


def _adjacent(made: _Made, branches: dict[int, _Branch], labels: NodeLabels, num_models: int) -> Iterator[_Equality]:
    """Numbers of adjacent parts that are alike in a choice below them, or in their own."""
    for length in range(_MOST_ANCESTORS):
        for line in made.lines(length):
            own = line.take(np.argsort(line.nodes[length], kind="stable"))
            part, following = own.nodes[length], own.following[length]
            if (np.diff(part) == 0).any():
                continue
            place = np.minimum(np.searchsorted(part, following), len(part) - 1)
            pairs = part[place] == following
            equal = pairs & (own.taken[place] == own.taken)
            if equal.any():
                shared = _line(own.take(pairs | np.isin(part, following)), length, labels)
                values = np.bincount(own.model[equal], minlength=num_models)
                yield _Equality(partial(_all_adjacent, shared, list(branches.values())), values, 0.0)


def _all_adjacent(line: _Line, branches: Sequence[_Branch]) -> Total:
    """The number of adjacent parts that have taken the same alternative."""
    runs = [Below((line.pattern(branch),) * 2) for branch in branches]
    return Total(tuple((Pattern(below=(run,)), 1) for run in runs))


def _pairs(
    made: _Made, branches: dict[int, _Branch], labels: NodeLabels, root: str, scores: Floats
) -> Iterator[_Equality]:
    """Equalities of two choices that models make at most once."""
    choices = list(islice(_choices(made, labels, len(scores)), _MOST_CHOICES))
    alone = [float(gains_of((each.taken + 1)[None], scores)[0]) for each in choices]
    for (one, first), (other, second) in combinations(zip(choices, alone, strict=True), 2):
        top = _top(one, other, root)
        if top:
            same = (one.taken == other.taken) & (one.taken >= 0)
            total = partial(_equal, one.line, other.line, list(branches.values()), top)
            yield _Equality(total, same.astype(np.int64), max(first, second, 0.0))


def _choices(made: _Made, labels: NodeLabels, num_models: int) -> Iterator[_Choice]:
    """Choices of symbols that models have once, and choices at places below other nodes that models have once."""
    seen: set[bytes] = set()
    for length in range(_MOST_ANCESTORS + 1):
        for own in made.lines(length):
            if (own.nodes[1] < 0).any() or np.bincount(own.model).max() > 1:  # a root is no part of anything
                continue
            taken, top = np.full((2, num_models), -1)
            taken[own.model], top[own.model] = own.taken, own.nodes[length]
            if len(np.unique(own.taken)) > 1 and taken.tobytes() not in seen:
                seen.add(taken.tobytes())
                yield _Choice(_line(own, length, labels), taken, top)


def _line(made: _Made, length: int, labels: NodeLabels) -> _Line:
    """What choices at one path have in common."""
    symbols = [np.unique(row).tolist() for row in made.symbols[length::-1]]
    names = tuple(labels.symbols[each[0]] if len(each) == 1 else None for each in symbols)
    return _Line(names, tuple(made.children[:length, 0][::-1].tolist()))


def _top(one: _Choice, other: _Choice, root: str) -> str:
    """Symbol of a node above both choices; empty if there is none that a pattern can name."""
    (first, *inner), (second, *others) = one.line.symbols, other.line.symbols
    if len(inner) != len(others):
        return ""
    both = (one.taken >= 0) & (other.taken >= 0)
    shared = inner and first == second and (one.top == other.top)[both].all()
    return (first if shared else root) or ""


def _equal(one: _Line, other: _Line, branches: Sequence[_Branch], top: str) -> Total:
    """The number of alternatives that both choices have taken, which is 1 or 0."""
    pairs = [Pattern(top, below=(one.below(top, each), other.below(top, each))) for each in branches]
    return Total(tuple((pair, 1) for pair in pairs))


def _root(forests: Sequence[Forest]) -> str:
    """The symbol of all roots, if no other node has it; else an empty text."""
    roots, inner = set[str](), set[str]()
    for forest in forests:
        above = forest.nodes.parent < 0
        roots |= {forest.symbols[symbol] for symbol in np.unique(forest.nodes.symbol[above]).tolist()}
        inner |= {forest.symbols[symbol] for symbol in np.unique(forest.nodes.symbol[~above]).tolist()}
    return "" if len(roots) != 1 or roots & inner else roots.pop()
