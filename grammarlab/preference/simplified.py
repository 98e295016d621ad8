"""A preference as a regression tree of few levels, from which a grammar can be compiled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.regression_tree import MAX_CODES, Split, leaves_of


@dataclass(frozen=True)
class SimplifiedPreference:
    """A regression tree: a score for each leaf."""

    tree: tuple[Split, ...]
    scores: Floats
    """[L] scores of the leaves, >= 0."""

    def __call__(self, rows: Floats) -> Floats:
        """The score [n] of rows [n, F]."""
        return self.scores[leaves_of(self.tree, rows)]

    @property
    def columns(self) -> Ints:
        """[K] the columns of its splits, ascending."""
        return np.unique(np.array([split.column for split in self.tree], dtype=np.int64))

    @property
    def levels(self) -> tuple[float, ...]:
        """The different scores, ascending."""
        return tuple(np.unique(self.scores).tolist())

    def scaled(self, factor: float) -> SimplifiedPreference:
        """The function multiplied by a factor."""
        return replace(self, scores=self.scores * factor)

    def times(self, other: SimplifiedPreference) -> SimplifiedPreference:
        """The product with another function of the same columns."""
        tree, scores = list(self.tree), self.scores.tolist()
        for leaf, score in enumerate(self.scores.tolist()):
            numbers = [leaf]
            for split in other.tree:
                tree.append(split._replace(leaf=numbers[split.leaf]))
                numbers.append(len(tree))
            scores += [score * value for value in other.scores[1:].tolist()]
            scores[leaf] = score * float(other.scores[0])
        return SimplifiedPreference(tuple(tree), np.array(scores)).pruned()

    def pruned(self) -> SimplifiedPreference:
        """The same function without redundant splits."""
        splits: list[Split] = []
        scores: list[float] = [0.0]

        def lay(node: float | _Fork, leaf: int) -> None:
            if not isinstance(node, _Fork):
                scores[leaf] = node
                return
            scores.append(0.0)
            splits.append(Split(leaf, node.column, node.bound))
            new = len(splits)
            lay(node.below, leaf)
            lay(node.above, new)

        lay(self._nodes(), 0)
        return SimplifiedPreference(tuple(splits), np.array(scores))

    def text(self, condition: Callable[[int, float], str]) -> str:
        """The function as an expression (`grammarlab.features.expression`).

        Args:
            condition: from a column and a bound to the text of the condition value >= bound.
        """

        def lay(node: float | _Fork) -> str:
            if not isinstance(node, _Fork):
                return f"{node:.5g}"
            return f"choose({condition(node.column, node.bound)}, {lay(node.above)}, {lay(node.below)})"

        return lay(self._nodes())

    def _nodes(self) -> float | _Fork:
        """The tree as nested nodes; nodes with two equal sides are merged."""
        nodes: list[float | _Fork] = self.scores.tolist()
        for number, split in reversed(list(enumerate(self.tree, 1))):
            below, above = nodes[split.leaf], nodes[number]
            nodes[split.leaf] = below if below == above else _Fork(split.column, split.bound, below, above)
        return nodes[0]


def drawn_to_levels(values: Floats, masses: Floats, num_levels: int) -> Floats:
    """Values [n] quantised to at most a number of levels, each the mean of consecutive values.

    Of all partitions, the one with the least squared change of the square roots is used (Fisher 1958, by dynamic
    programming): values near 0 are merged with other small values first, and 0 itself changes last.

    Args:
        values: [n] >= 0.
        masses: [n] >= 0, weight of each value.
        num_levels: >= 1.

    >>> drawn_to_levels(np.array([60.0, 20.0, 22.0, 0.0]), np.ones(4), 3).round(6).tolist()
    [60.0, 21.0, 21.0, 0.0]
    """
    different, inverse = np.unique(values, return_inverse=True)
    if len(different) <= num_levels:
        return values
    if len(different) > MAX_CODES:
        steps = np.floor(np.sqrt(different / different[-1]) * (MAX_CODES - 1)).astype(np.int64)
        inverse = np.unique(steps, return_inverse=True)[1][inverse]
    # If all masses are 0, all values have equal weight.
    masses = masses + 1e-12 * max(float(masses.sum()), 1e-300)
    mass = np.bincount(inverse, masses).astype(np.float64)
    means = np.bincount(inverse, masses * values) / mass
    ends = _cuts(np.sqrt(means), mass, min(num_levels, len(means)))
    level = np.repeat(np.arange(len(ends) - 1), np.diff(ends))
    return (np.bincount(level, mass * means) / np.bincount(level, mass))[level[inverse]]


class _Fork(NamedTuple):
    """A split: a column, a bound, and the subtrees below and above it."""

    column: int
    bound: float
    below: float | _Fork
    above: float | _Fork


def _cuts(roots: Floats, mass: Floats, num_levels: int) -> list[int]:
    """Offsets of the levels of ascending values."""
    size = len(roots)
    sums = [np.concatenate([[0.0], np.cumsum(column)]) for column in (mass, mass * roots, mass * roots**2)]
    first, last = np.arange(size + 1)[:, None], np.arange(size + 1)[None, :]
    m, r, s = (column[last] - column[first] for column in sums)
    with np.errstate(divide="ignore", invalid="ignore"):
        cost = np.where(first < last, np.maximum(np.nan_to_num(s - r**2 / m), 0.0), np.inf)
    best = cost[0]
    choices = []
    for _ in range(num_levels - 1):
        total = best[:, None] + cost
        choices.append(total.argmin(axis=0))
        best = total.min(axis=0)
    ends = [size]
    for choice in reversed(choices):
        ends.append(int(choice[ends[-1]]))
    return [0, *reversed(ends)]
