"""Tree patterns that explain scores, such as a black cylinder above a green box, which no path can express.

Patterns are grown condition by condition. Only patterns that explain the scores better than the best of the same number
of random columns are kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.derivation.forest import Forest
from grammarlab.features.columns.column_keys import Meaning
from grammarlab.features.columns.paths import choices_below, count_adjacent_pairs
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.node_labels import KeyIndex, NodeLabels
from grammarlab.features.patterns.pattern import Below, Feature, Pattern
from grammarlab.features.patterns.tree_index import Trees

_BEAM_WIDTH = 24
"""Number of patterns that are grown further."""


def search_patterns(
    forests: Sequence[Forest], residuals: Floats, most: int = 8, conditions: int = 2
) -> tuple[Pattern, ...]:
    """Patterns that explain the residuals of a preference, best first.

    The search begins with single choices and pairs of adjacent siblings, and adds choices below their nodes, one by
    one, to those that explain most. It uses only patterns that occur in the given models.

    Args:
        forests: the scored models.
        residuals: [n] scores minus predictions (or minus their mean), in the order of the models.
        most: largest number of patterns.
        conditions: largest number of choices added to a pattern.
    """
    search = _PatternSearch(forests, residuals)
    beam = search.try_all(search.seeds)
    for _ in range(conditions):
        beam = search.try_all([longer for pattern in beam for longer in search.extensions(pattern)])
    return search.best(most)


class _PatternSearch:
    def __init__(self, forests: Sequence[Forest], residuals: Floats) -> None:
        self._trees = [Trees(forest) for forest in forests]
        self._residuals = residuals - (residuals.mean() if len(residuals) else 0.0)
        labels = NodeLabels.of(forests)
        index = KeyIndex()
        for trees in self._trees:
            count_adjacent_pairs(trees, labels, index, grow=True)
        meaning = Meaning(labels, index.keys, ())
        choices = np.flatnonzero(labels.chosen).tolist()
        nodes = {label: meaning.node(label) for label in choices}
        self.seeds = [*nodes.values(), *(meaning.feature(key) for key in index.keys)]
        below: dict[str, list[int]] = {}
        for trees in self._trees:
            for upper, label in choices_below(trees, labels):
                below.setdefault(labels.symbol_of(upper), []).append(label)
        self._below = {symbol: [nodes[label] for label in sorted(set(children))] for symbol, children in below.items()}
        self._by_values: dict[bytes, tuple[Pattern, Floats]] = {}
        self._num_patterns = 0

    def try_all(self, patterns: Sequence[Feature]) -> list[Pattern]:
        """The patterns that explain most, one of each set with equal counts in all models."""
        candidates = [pattern for pattern in dict.fromkeys(patterns) if isinstance(pattern, Pattern)]
        if not candidates:
            return []
        values = np.concatenate([count(trees, candidates) for trees in self._trees])
        self._num_patterns += len(candidates)
        fresh: dict[bytes, tuple[Pattern, Floats]] = {}
        for pattern, column in zip(candidates, values.T, strict=True):
            key = column.tobytes()
            if np.ptp(column) > 0.0 and key not in self._by_values:
                fresh.setdefault(key, (pattern, column))
        self._by_values |= fresh
        ranked = sorted(fresh.values(), key=lambda item: -_explained(item[1], self._residuals))
        return [pattern for pattern, _ in ranked[:_BEAM_WIDTH]]

    def extensions(self, pattern: Pattern) -> list[Pattern]:
        """The pattern with one more choice below one of its nodes."""
        if pattern.symbol is not None:
            return self._with_condition(pattern)
        (below,) = pattern.below
        longer: list[Pattern] = []
        for index, node in enumerate(below.run):
            runs = [(*below.run[:index], grown, *below.run[index + 1 :]) for grown in self._with_condition(node)]
            longer += [replace(pattern, below=(replace(below, run=run),)) for run in runs]
        return longer

    def best(self, most: int) -> tuple[Pattern, ...]:
        """The patterns that explain most in addition to the previous ones, as long as they explain more than chance."""
        residuals, chosen = self._residuals, list[Pattern]()
        # The largest squared correlation of m columns of noise with n numbers is about 2 log(m) / n.
        least = 2.0 * np.log(max(2, self._num_patterns)) / max(1, len(residuals))
        while len(chosen) < most and residuals @ residuals > 1e-9 * (self._residuals @ self._residuals):
            pattern, column = max(
                self._by_values.values(), key=lambda item: _explained(item[1], residuals), default=(None, residuals)
            )
            if pattern is None or _explained(column, residuals) < least:
                break
            chosen.append(pattern)
            centred = column - column.mean()
            residuals = residuals - centred * (centred @ residuals) / (centred @ centred)
        return tuple(chosen)

    def _with_condition(self, node: Pattern) -> list[Pattern]:
        choices = self._below.get(node.symbol or "", [])
        return [replace(node, below=(*node.below, Below((choice,), deep=True))) for choice in choices]


def _explained(column: Floats, residuals: Floats) -> float:
    """The share of the variance of the residuals that a linear function of a column explains."""
    centred = column - column.mean()
    total = (centred @ centred) * (residuals @ residuals)
    return float((centred @ residuals) ** 2 / total) if total > 0.0 else 0.0
