"""Values of features in the models of a forest, all models at once.

A pattern is evaluated bottom-up: the nodes that match a part of it, and their numbers of embeddings, are two short
columns, and a condition below a node is a sum over children or descendants. Parts that several patterns share are
evaluated once.

>>> from grammarlab.derivation import derive
>>> from grammarlab.features.patterns.pattern_text import parse
>>> from grammarlab.language.grammar import Grammar
>>> grammar = Grammar.parse("Lot --> A A A  A --> 50%: Red else: B  B --> Red Blue")
>>> forest = derive(grammar, 4, seed=1)
>>> count(forest, [parse("A"), parse("A:0"), parse("Lot > A@2:1"), parse("A >> Red"), parse("Lot[A:0 + A:1]")])
array([[3., 1., 0., 3., 0.],
       [3., 1., 1., 3., 1.],
       [3., 1., 1., 3., 1.],
       [3., 2., 0., 3., 1.]])
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.forest import Forest, RuleName
from grammarlab.features.patterns.operations import evaluate
from grammarlab.features.patterns.pattern import Below, Draw, Feature, Formula, Pattern, Present, Threshold
from grammarlab.features.patterns.tree_index import Trees

MAX_EMBEDDINGS = float(2**31)
"""Largest number of embeddings at one node; larger counts are clipped, so that sums stay exact and finite."""


def count(forest: Forest | Trees, features: Sequence[Feature]) -> Floats:
    """The values [models, F] of features.

    Args:
        forest: the models; `Trees` caches intermediate results for further calls.
        features: the features. Names that the forest does not have are counted 0 times.

    Raises:
        UsageError: If the columns of the forest are not trees.

    >>> import grammarlab as gl
    >>> forest = gl.derive(gl.Grammar.parse("Lot --> 50% : A else : B B"), 3, seed=1)
    >>> gl.count(forest, [gl.pattern("A"), gl.pattern("B")]).tolist()
    [[1.0, 0.0], [0.0, 2.0], [0.0, 2.0]]
    """
    counter = _Counter(forest if isinstance(forest, Trees) else Trees(forest))
    values = np.zeros((counter.trees.num_models, len(features)))
    for column, feature in enumerate(features):
        values[:, column] = counter.per_model(feature)
    return values


class _Counter:
    def __init__(self, trees: Trees) -> None:
        self.trees = trees
        self._cache: dict[Pattern, tuple[Ints, Floats]] = {}

    def per_model(self, feature: Feature) -> Floats:
        """[models] values of one feature."""
        match feature:
            case Pattern():
                rows, ways = self._matches(feature)
                return self._total(self.trees.model[rows], ways)
            case Threshold(site=site, bound=bound):
                rows = self.trees.draw_rows(site)
                below = self.trees.forest.draws.value[rows] < bound
                return self._total(self.trees.draw_model[rows[below]])
            case Draw(site=site, branch=int(branch)):
                rows = self.trees.draw_rows(site)
                is_branch = self.trees.forest.draws.value[rows] == branch
                return self._total(self.trees.draw_model[rows[is_branch]])
            case Draw(site=site):
                total, number = self._draws(site)
                return total / np.maximum(number, 1.0)
            case Formula():
                columns = {read: self.per_model(read) for read in feature.features}
                return evaluate(feature.steps, columns, self.trees.num_models)
            case Present(feature=Draw(site=site, branch=None)):
                return np.minimum(self._draws(site)[1], 1.0)
            case Present(feature=inner):
                return np.minimum(self.per_model(inner), 1.0)

    def _draws(self, site: str) -> tuple[Floats, Floats]:
        """[models] sum and number of the draws of a name."""
        rows = self.trees.draw_rows(site)
        models = self.trees.draw_model[rows]
        return self._total(models, self.trees.forest.draws.value[rows]), self._total(models)

    def _total(self, models: NDArray[np.integer], weights: Floats | None = None) -> Floats:
        return np.bincount(models, weights=weights, minlength=self.trees.num_models).astype(np.float64)

    def _matches(self, pattern: Pattern) -> tuple[Ints, Floats]:
        """The nodes that a pattern can be laid on, ascending, and in how many ways each, >= 1."""
        if pattern not in self._cache:
            rows = self._fitting(pattern)
            ways = np.ones(len(rows))
            for below in pattern.below:
                starts, values = self._runs(below)
                collect = self.trees.sum_below if below.deep else self.trees.sum_by_parent
                embeddings = collect(starts, values, rows)
                is_match = embeddings > 0.0
                rows, ways = (
                    rows[is_match],
                    np.minimum(ways[is_match] * np.minimum(embeddings[is_match], MAX_EMBEDDINGS), MAX_EMBEDDINGS),
                )
            self._cache[pattern] = rows, ways
        return self._cache[pattern]

    def _fitting(self, pattern: Pattern) -> Ints:
        """The nodes whose label fits that of a pattern, ascending."""
        forest = self.trees.forest
        groups = [
            self.trees.rows_of_rule(number)
            for number in self.trees.rules_of(pattern.symbol)
            if _fits(forest.rules[number], pattern)
        ]
        if pattern.branch is None and pattern.parameters is None:
            groups += [
                self.trees.leaf_rows_of_symbol(number)
                for number, symbol in enumerate(forest.symbols)
                if pattern.symbol is None or symbol == pattern.symbol
            ]
        return self.trees.merged([rows for rows in groups if len(rows)])

    def _runs(self, below: Below) -> tuple[Ints, Floats]:
        """The nodes that a run of siblings can start at, and in how many ways each."""
        rows, ways = self._matches(below.run[0])
        if below.child is not None:
            placed = self.trees.forest.nodes.child[rows] == below.child
            rows, ways = rows[placed], ways[placed]
        here = rows
        for sibling in below.run[1:]:
            here = self.trees.next_sibling[here]
            matching, values = self._matches(sibling)
            index = np.searchsorted(matching, here)
            is_match = (index < len(matching)) & (here >= 0)
            is_match[is_match] = matching[index[is_match]] == here[is_match]
            rows, here = rows[is_match], here[is_match]
            ways = np.minimum(ways[is_match] * values[index[is_match]], MAX_EMBEDDINGS)
        return rows, ways


def _fits(rule: RuleName, pattern: Pattern) -> bool:
    """Whether a rule of the symbol of a pattern has its number of parameters and its branch."""
    return (pattern.parameters is None or rule.parameters == pattern.parameters) and (
        pattern.branch is None or rule.branch[: len(pattern.branch)] == pattern.branch
    )
