"""A preference as a function of few columns, from which a grammar can be compiled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from grammarlab.preference.base import Floats, Ints
from grammarlab.preference.simple.regression_tree import Split, leaves_of


class _Fork(NamedTuple):
    """A split: a column, a bound, and the subtrees below and above it."""

    column: int
    bound: float
    below: float | _Fork
    above: float | _Fork


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
        """The function as an expression (`grammarlab.features.rules.expression`).

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
