"""Derivation trees of a forest, indexed for counting, and forests without the data that no feature needs.

Each index is made when it is first needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import BATCH, MAX_STEPS, Floats, Ints, offsets_from_counts
from grammarlab.derivation.forest import Forest, Leaves, NodeIds, Reports
from grammarlab.derivation.materials import Materials
from grammarlab.errors import UsageError
from grammarlab.features.patterns.node_labels import NodeLabels

_MAX_CHILDREN = 1 << 23
"""Upper bound on the number of successors of one rule branch, above that of the largest rule file."""


class Trees:
    """Look-ups over the N nodes of a forest."""

    def __init__(self, forest: Forest) -> None:
        """Index a forest.

        Raises:
            UsageError: If its columns are not trees, as in a damaged file.
        """
        _check(forest)
        self.forest = forest
        self.model = forest.nodes.model
        self.parent = forest.nodes.parent.astype(np.int64)  # NumPy's index type, four times as fast
        self.num_models = forest.num_models
        self._labelled: tuple[NodeLabels, Ints] | None = None

    def labels(self, labels: NodeLabels) -> Ints:
        """[N] the label of each node; computed once for the same labels."""
        if self._labelled is None or self._labelled[0] is not labels:
            self._labelled = labels, labels.numbers(self.forest)
        return self._labelled[1]

    def rows_of_rule(self, rule: int) -> Ints:
        """The nodes that a rule rewrote, ascending."""
        order, offsets = self._by_rule
        return order[offsets[rule + 1] : offsets[rule + 2]]

    def leaf_rows_of_symbol(self, symbol: int) -> Ints:
        """The nodes of a symbol that no rule rewrote, ascending."""
        order, offsets = self._leaves_by_symbol
        return order[offsets[symbol] : offsets[symbol + 1]]

    def rules_of(self, symbol: str | None) -> Sequence[int]:
        """Numbers of the rules of a symbol, of all for None, ascending."""
        return range(len(self.forest.rules)) if symbol is None else self._rules_by_symbol.get(symbol, ())

    def merged(self, groups: Sequence[Ints]) -> Ints:
        """The nodes of groups without common nodes, each of them ascending, in ascending order."""
        if len(groups) == 1:
            return groups[0]
        # Marks cost less than sorting: a look at every node is quick.
        is_member = np.zeros(len(self.model), dtype=bool)
        for rows in groups:
            is_member[rows] = True
        return np.flatnonzero(is_member)

    def draw_rows(self, site: str) -> Ints:
        """Rows of the draws of random expressions with a name."""
        order, offsets = self._draws_by_site
        named = [i for i, expression in enumerate(self.forest.sites) if expression.name == site]
        return np.concatenate([np.zeros(0, np.int64), *(order[offsets[i] : offsets[i + 1]] for i in named)])

    @cached_property
    def roots(self) -> Ints:
        """The nodes without a parent, ascending."""
        return np.flatnonzero(self.parent < 0)

    @cached_property
    def _scratch(self) -> Floats:
        """[N] zeros between two sums."""
        return np.zeros(len(self.model))

    @cached_property
    def draw_model(self) -> NDArray[np.int32]:
        """[D] the model of each draw."""
        return self.model[self.forest.draws.node]

    @cached_property
    def next_sibling(self) -> Ints:
        """[N] the next sibling, by ``child`` and then ``repeat``; -1 for the last one and for roots."""
        nodes = self.forest.nodes
        order = np.lexsort((nodes.repeat, nodes.child, nodes.parent))
        following = np.full(len(nodes), -1, dtype=np.int64)
        first, second = order[:-1], order[1:]
        siblings = (nodes.parent[first] == nodes.parent[second]) & (nodes.parent[first] >= 0)
        following[first[siblings]] = second[siblings]
        return following

    @cached_property
    def repeated(self) -> NDArray[np.bool_]:
        """[N] whether a node or an ancestor is one of several shapes of a single successor, and not the first."""
        flags = np.append(self.forest.nodes.repeat > 0, False)  # the last row is the parent of the roots
        if flags.any():
            for start, end in pairwise(self._waves):
                flags[start:end] |= flags[self.parent[start:end]]
        return flags[:-1]

    def sum_by_parent(self, rows: Ints, values: Floats, nodes: Ints) -> Floats:
        """[len(nodes)] sum of the values of the children of each node."""
        parents = self.parent[rows]
        inner = parents >= 0
        parents, values = parents[inner], values[inner]
        np.add.at(self._scratch, parents, values)
        sums = self._scratch[nodes]
        self._scratch[parents] = 0.0
        return sums

    def sum_below(self, rows: Ints, values: Floats, nodes: Ints) -> Floats:
        """[len(nodes)] sum of the values of all nodes below each node."""
        totals = np.zeros(len(self.model))
        # Deeper trees are summed as a whole, in linear time.
        for _ in range(MAX_STEPS):
            above = self.parent[rows]
            inner = above >= 0
            rows, values = above[inner].astype(np.int64), values[inner]
            if not len(rows):
                return totals[nodes]
            np.add.at(totals, rows, values)
        # The remaining values have reached these rows and must still be passed to their ancestors.
        rest = np.zeros(len(self.model))
        np.add.at(rest, rows, values)
        totals -= rest
        for start, end in pairwise(self._waves[::-1]):
            above = self.parent[end:start]
            inner = above >= 0
            np.add.at(rest, above[inner], rest[end:start][inner])
        return (totals + rest)[nodes]

    @cached_property
    def _waves(self) -> list[int]:
        """Cuts of the rows, from 0 to N, such that no row has its parent in its own piece."""
        cuts, longest = [0], BATCH
        while cuts[-1] < len(self.parent):
            start = cuts[-1]
            inside = self.parent[start : start + longest] >= start
            length = int(inside.argmax()) or len(inside)
            cuts.append(start + length)
            longest = max(2 * length, BATCH)
        return cuts

    @cached_property
    def _by_rule(self) -> tuple[Ints, Ints]:
        return _grouped(self.forest.nodes.rule + np.int16(1), len(self.forest.rules) + 1)

    @cached_property
    def _rules_by_symbol(self) -> dict[str, list[int]]:
        numbers: dict[str, list[int]] = {}
        for number, rule in enumerate(self.forest.rules):
            numbers.setdefault(rule.symbol, []).append(number)
        return numbers

    @cached_property
    def _leaves_by_symbol(self) -> tuple[Ints, Ints]:
        leaves = self.rows_of_rule(-1)
        order, offsets = _grouped(self.forest.nodes.symbol[leaves], len(self.forest.symbols))
        return leaves[order], offsets

    @cached_property
    def _draws_by_site(self) -> tuple[Ints, Ints]:
        return _grouped(self.forest.draws.site, len(self.forest.sites))


def without_geometry(forest: Forest) -> Forest:
    """Only the trees and draws of a forest: leaves, meshes and reported values take most of its memory."""
    reports = forest.reports
    return replace(
        forest,
        leaves=Leaves(**{column.name: _emptied(getattr(forest.leaves, column.name)) for column in fields(Leaves)}),
        reports=Reports(_emptied(reports.node), _emptied(reports.key), _emptied(reports.value), ()),
        frames=_emptied(forest.frames),
        meshes=forest.meshes.take(np.zeros(0, np.int64)),
        materials=Materials(_emptied(forest.materials.channels), ()),
        texture_maps=_emptied(forest.texture_maps),
    )


def _check(forest: Forest) -> None:
    nodes, draws = forest.nodes, forest.draws
    size = len(nodes)
    good = (
        _within(nodes.model, forest.num_models)
        and _within(nodes.symbol, len(forest.symbols))
        and int(nodes.rule.min(initial=-1)) >= -1
        and int(nodes.rule.max(initial=-1)) < len(forest.rules)
        and _within(nodes.child, _MAX_CHILDREN)
        and bool((nodes.parent < np.arange(size, dtype=nodes.parent.dtype)).all())
        and int(nodes.parent.min(initial=-1)) >= -1
        and _within(draws.node, size)
        and _within(draws.site, len(forest.sites))
    )
    if not good:
        raise UsageError("these derivations are damaged: their columns are not trees. Sample them again.")


def _within(column: NDArray[np.integer], high: int) -> bool:
    """Whether 0 <= value < high for all."""
    # Read as unsigned integers, negative ones are the largest.
    return int(column.view(column.dtype.str.replace("i", "u")).max(initial=0)) < high or not len(column)


def _grouped(keys: NodeIds, limit: int) -> tuple[Ints, Ints]:
    """Rows ordered by key, ascending within a key, and the offset of each key."""
    return np.argsort(keys, kind="stable"), offsets_from_counts(np.bincount(keys, minlength=limit))


def _emptied(column: NDArray) -> NDArray:
    """No rows of a column; a copy, since a view would keep the rows."""
    return column[:0].copy()
