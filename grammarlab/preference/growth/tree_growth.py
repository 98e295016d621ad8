"""Trees of splits: each node is divided by the best cut of one column, and pruned if its parts explain no more.

A node divides its labels with prior probability .9 / sqrt(1 + depth). A screening
(`grammarlab.preference.growth.screening`) chooses the columns whose best cuts are found exactly
(`grammarlab.preference.growth.cuts`), in a few bins of the labels of the node
(`grammarlab.preference.growth.node_bins`); then each bound moves to the best place near by. Some divisions gain only
together with a second one: trees also grow from given first divisions, whatever these gain alone, and are pruned
bottom-up.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import expit

from grammarlab.arrays import FEW, MANY, NUM_LEVELS, ROUNDING, SEVERAL, Floats, Ints
from grammarlab.preference.base import HOPELESS
from grammarlab.preference.growth.cuts import Cuts, all_cuts, best_cuts, price_of_bounds
from grammarlab.preference.growth.node_bins import node_bins
from grammarlab.preference.growth.part_evidence import Evidence
from grammarlab.preference.growth.screening import gains
from grammarlab.preference.growth.split_columns import SplitColumns
from grammarlab.preference.growth.splits import Split, Value

_DIVIDED = 0.9
"""Prior probability that all labels are divided; it falls with the depth of a node."""
_IMPROVED_DEPTH = 2
"""Number of levels of nodes that are grown again."""
_EQUAL = 1e-4
"""Difference in nats below which places of a bound are equally good; then the middle one is taken."""


@dataclass(frozen=True)
class Tree:
    """A node of a tree with its labels."""

    labels: Ints
    """[c] indices of the labels of the node, ascending."""
    log_posterior: float
    """Log of the evidence of all cells and of the prior of all splits."""
    split: Split | None = None
    """Split of the labels; None for a cell."""
    parts: tuple[tuple[int, Tree], ...] = ()
    """The parts with labels, by number."""

    def cells(self) -> Iterator[Ints]:
        """The labels of each cell."""
        if self.split is None:
            yield self.labels
        for _, part in self.parts:
            yield from part.cells()

    def nodes(self) -> Iterator[Tree]:
        """This node and all below it."""
        yield self
        for _, part in self.parts:
            yield from part.nodes()

    def cell_of(self, rows: Floats) -> tuple[Ints, tuple[Ints, ...]]:
        """Number [m] of the cell of each row [m, F], and the cells; rows of new parts belong to the whole node."""
        number, cells = np.zeros(len(rows), dtype=np.int64), list[Ints]()
        self._assign(rows, np.arange(len(rows)), number, cells)
        return number, tuple(cells)

    @cached_property
    def columns(self) -> frozenset[int]:
        """Columns of rows that the tree divides by."""
        return frozenset(column for node in self.nodes() if node.split for column in node.split.columns)

    def _assign(self, rows: Floats, indices: Ints, number: Ints, cells: list[Ints]) -> None:
        part_of = np.full(len(indices), -1) if self.split is None else self.split.parts(rows[indices])
        unassigned = np.ones(len(indices), dtype=bool)
        for part, tree in self.parts:
            inside = part_of == part
            unassigned &= ~inside
            if inside.any():
                tree._assign(rows, indices[inside], number, cells)
        if unassigned.any():
            number[indices[unassigned]] = len(cells)
            cells.append(self.labels)


class Others(NamedTuple):
    """Trees that were found otherwise."""

    trees: Sequence[Tree]
    rows: Floats
    """[n, F] rows of the labels that their splits are tried for."""


class _Ranked(NamedTuple):
    """The best cuts of K columns of a node."""

    log_posterior: Floats
    """[K] log of the evidence of the parts and of the prior of the cut."""
    columns: Ints
    """[K]"""
    codes: Ints
    """[K, c] bins of the labels of the node."""
    cuts: Cuts


@dataclass(frozen=True, eq=False)
class TreeGrowth:
    """Labels, what they may be split by, and the trees that grow from both."""

    columns: SplitColumns
    evidence: Evidence

    @cached_property
    def every(self) -> Ints:
        """[n] indices of all labels."""
        return np.arange(len(self.evidence.scores))

    @cached_property
    def _ranked_cache(self) -> dict[bytes, _Ranked]:
        """Cache of ranked cuts: trees share most of their nodes."""
        return {}

    @cached_property
    def _grown_cache(self) -> dict[tuple[bytes, int, int], Tree]:
        """Cache of branches by labels, depth and patience."""
        return {}

    def trees(self, others: Others | None = None) -> list[Tree]:
        """Different trees of all labels, the most likely one first: the best one, and those of other first divisions.

        Args:
            others: trees of any labels, whose splits are tried as well.
        """
        trees = self._beginnings(SEVERAL, others)
        return _different([*trees, self._improved(max(trees, key=lambda tree: tree.log_posterior), 0)])

    def sketches(self, others: Others | None = None) -> list[Tree]:
        """A few of these trees, found quickly."""
        return _different(self._beginnings(FEW, others))

    def replanted(self, others: Others) -> list[Tree]:
        """The splits of trees of any labels with these labels, pruned by their evidence; the most likely tree first."""
        return _different([self._replanted(tree, others.rows, self.every, 0) for tree in others.trees])

    def _beginnings(self, num_roots: int, others: Others | None) -> list[Tree]:
        """The best tree, those of other first divisions, and others with these labels."""
        roots = self._screened(self.every)[:num_roots].tolist()
        trees = [self.grown(self.every, root) for root in (None, *roots)]
        return trees if others is None else trees + self.replanted(others)

    def grown(self, labels: Ints, root: int | None = None) -> Tree:
        """The tree of some labels, with a given column of the first division or, if it is None, the best one."""
        return self._grown(labels, 0, HOPELESS) if root is None else self._rooted(labels, root)

    def drawn(self, doubt: float, randomness: np.random.Generator) -> Tree:
        """A tree of all labels that explains these about as well as the best one.

        Args:
            doubt: > 0, temperature of draws of splits and of pruning in nats: a branch with about this gain or loss is
                kept at random.
            randomness: draws splits.
        """
        return self._drawn(self.every, 0, doubt, randomness)

    def with_others(self, tree: Tree, depth: int = 0) -> float:
        """Log of the evidence of a branch together with its node as a cell, and all other divisions of its nodes.

        Many divisions explain scores about as well as the best one, so the best one alone understates what is
        explained. Other divisions are single cuts into cells; further trees, which can only add to these, are left out.
        """
        return float(np.logaddexp(self._leaf(tree.labels, depth).log_posterior, self.divided(tree, depth)))

    def divided(self, tree: Tree, depth: int = 0) -> float:
        """The same without the node as a cell; minus infinity if there is no division."""
        columns = self._compared(tree.labels)
        beside = self._single_cuts(tree.labels, depth, columns)
        if tree.split is None:
            return beside
        parts = [part for _, part in tree.parts]
        prior = tree.log_posterior - sum(part.log_posterior for part in parts)
        more = prior + sum(self.with_others(part, depth + 1) for part in parts)
        if self.columns.place(tree.split.reading) in columns:
            # The cut itself is one of those beside.
            cut = prior + sum(self._leaf(part.labels, depth + 1).log_posterior for part in parts)
            more = more + np.log1p(-np.exp(cut - more)) if cut < more else -np.inf
        return float(np.logaddexp(beside, more))

    def _compared(self, labels: Ints) -> Ints:
        """[K] columns whose cuts of a node are compared; none if no cut is worth its price."""
        ranked = self._worth_dividing(labels)
        return np.zeros(0, dtype=np.int64) if ranked is None else ranked.columns

    def _single_cuts(self, labels: Ints, depth: int, columns: Ints) -> float:
        """Log of the evidence of all divisions of a node by one cut of one of some columns [K] into cells."""
        if not len(columns):
            return -np.inf
        codes = self._codes(columns, labels)
        totals = all_cuts(codes, self.evidence.terms[labels], self.evidence.of_sums, log_leaf(depth + 1))
        return _log_dividing(depth) + float(np.logaddexp.reduce(totals - self.columns.prices[columns]))

    def _grown(self, labels: Ints, depth: int, patience: float) -> Tree:
        key = labels.tobytes(), depth, int(patience)
        if key not in self._grown_cache:
            self._grown_cache[key] = self._divided(labels, depth, patience)
        return self._grown_cache[key]

    def _divided(self, labels: Ints, depth: int, patience: float) -> Tree:
        leaf, ranked = self._leaf(labels, depth), self._worth_dividing(labels)
        if ranked is None:
            return leaf
        best = int(np.argmax(ranked.log_posterior))
        left = patience - self._loss(depth, ranked, best, leaf)
        return leaf if left < 0.0 else self._branch(labels, depth, ranked, best, leaf, min(left, patience))

    def _loss(self, depth: int, ranked: _Ranked, index: int, leaf: Tree) -> float:
        """What a node loses by a cut whose parts are not divided, in nats."""
        parts = (len(ranked.cuts.first(index)) + 1) * log_leaf(depth + 1)
        return float(leaf.log_posterior - ranked.log_posterior[index] - _log_dividing(depth) - parts)

    def _rooted(self, labels: Ints, column: int) -> Tree:
        """The tree of some labels with a given column of the first division."""
        leaf = self._leaf(labels, 0)
        ranked = self._cut(np.array([column]), labels)
        if not np.isfinite(ranked.log_posterior[0]):
            return leaf
        left = HOPELESS - max(self._loss(0, ranked, 0, leaf), 0.0)
        return self._branch(labels, 0, ranked, 0, leaf, max(left, 0.0))

    def _branch(self, labels: Ints, depth: int, ranked: _Ranked, index: int, leaf: Tree, patience: float) -> Tree:
        """The node divided by one of the ranked cuts, its parts grown; the leaf if it is more likely."""
        branch = self._cut_by(labels, depth, ranked, index, lambda part: self._grown(part, depth + 1, patience))
        return branch if branch.log_posterior > leaf.log_posterior else leaf

    def _cut_by(self, labels: Ints, depth: int, ranked: _Ranked, index: int, grown: Callable[[Ints], Tree]) -> Tree:
        """The node divided by one of the ranked cuts, with a tree of the labels of each part."""
        split, prior = self._split(labels, ranked, index)
        part_of = np.searchsorted(np.array(split.bounds), self.columns.values[labels, ranked.columns[index]])
        parts = tuple((part, grown(labels[part_of == part])) for part in range(len(split.bounds) + 1))
        return _node(labels, depth, split, prior, parts)

    def _improved(self, tree: Tree, depth: int) -> Tree:
        """A tree after its first nodes, from the top, were grown again from their best cuts if these are better."""
        ranked = self._worth_dividing(tree.labels) if depth < _IMPROVED_DEPTH else None
        if ranked is None:
            return tree
        leaf, order = self._leaf(tree.labels, depth), np.argsort(-ranked.log_posterior, kind="stable")
        cuts = [index for index in order[:SEVERAL].tolist() if np.isfinite(ranked.log_posterior[index])]
        others = (self._branch(tree.labels, depth, ranked, index, leaf, HOPELESS) for index in cuts)
        best = max((tree, *others), key=lambda tree: tree.log_posterior)
        parts = tuple((part, self._improved(branch, depth + 1)) for part, branch in best.parts)
        gained = sum(
            new.log_posterior - old.log_posterior for (_, new), (_, old) in zip(parts, best.parts, strict=True)
        )
        return replace(best, log_posterior=best.log_posterior + gained, parts=parts)

    def _drawn(self, labels: Ints, depth: int, doubt: float, randomness: np.random.Generator) -> Tree:
        leaf, ranked = self._leaf(labels, depth), self._worth_dividing(labels)
        if ranked is None:
            return leaf
        index = int(np.argmax(ranked.log_posterior / doubt + randomness.gumbel(size=len(ranked.columns))))
        branch = self._cut_by(
            labels, depth, ranked, index, lambda part: self._drawn(part, depth + 1, doubt, randomness)
        )
        share = expit((branch.log_posterior - leaf.log_posterior) / doubt)
        return branch if randomness.random() < share else leaf

    def _replanted(self, tree: Tree, rows: Floats, labels: Ints, depth: int) -> Tree:
        leaf = self._leaf(labels, depth)
        column = None if tree.split is None else self.columns.place(tree.split.reading)
        if tree.split is None or column is None or len(labels) < 2:
            return leaf
        part_of = tree.split.parts(rows[labels])
        different = np.unique(part_of).tolist()
        if len(different) < 2:
            return leaf
        branches = dict(tree.parts)
        parts = tuple(
            (part, self._replanted(branches.get(part, leaf), rows, labels[part_of == part], depth + 1))
            for part in different
        )
        num_values = len(np.unique(self.columns.values[labels, column]))
        prior = -float(self.columns.prices[column] + price_of_bounds(len(parts) - 1, num_values - 1))
        branch = _node(labels, depth, tree.split, prior, parts)
        return branch if branch.log_posterior > leaf.log_posterior else leaf

    def _leaf(self, labels: Ints, depth: int) -> Tree:
        """A node of labels as one cell."""
        return Tree(labels, self.evidence.of_labels(labels) + log_leaf(depth))

    def _worth_dividing(self, labels: Ints) -> _Ranked | None:
        """The best cuts of a node; None if none can explain its scores better than one cell."""
        if len(labels) < 2 or not self.columns.values.shape[1]:
            return None
        if self.evidence.of_labels(labels) > self.evidence.best_possible(labels) - self.columns.prices.min():
            return None
        key = labels.tobytes()
        if key not in self._ranked_cache:
            self._ranked_cache[key] = self._cut(self._screened(labels)[:MANY], labels)
        ranked = self._ranked_cache[key]
        return ranked if np.isfinite(ranked.log_posterior).any() else None

    def _screened(self, labels: Ints) -> Ints:
        """[C] columns, those that may explain most of the scores of some labels first.

        By turns those that explain most beyond their price, and most for each nat of it: two cheap columns together may
        explain what a dear one does.
        """
        possible = self.evidence.best_possible(labels) - self.evidence.of_labels(labels)
        worth = np.minimum(gains(self.columns.coarse, labels, self.evidence.scores), possible)
        prices = np.maximum(self.columns.prices, ROUNDING)
        orders = [np.argsort(-rank, kind="stable") for rank in (worth - prices, worth / prices)]
        by_turns = np.stack(orders, axis=1).reshape(-1)
        return by_turns[np.sort(np.unique(by_turns, return_index=True)[1])]

    def _cut(self, columns: Ints, labels: Ints) -> _Ranked:
        """The best cut of a node by each of some columns [K]."""
        codes = self._codes(columns, labels)
        cuts = best_cuts(codes, self.evidence.terms[labels], self.evidence.of_sums)
        return _Ranked(cuts.log_evidence - self.columns.prices[columns], columns, codes, cuts)

    def _codes(self, columns: Ints, labels: Ints) -> Ints:
        """[K, c] bins of the labels of a node by columns [K]."""
        return node_bins(self.columns.values[np.ix_(labels, columns)], self.evidence.scores[labels], NUM_LEVELS)

    def _split(self, labels: Ints, ranked: _Ranked, index: int) -> tuple[Split, float]:
        """A split by one of the ranked cuts, its bounds moved to the best places near by, and its log-prior."""
        column, codes, first = int(ranked.columns[index]), ranked.codes[index], ranked.cuts.first(index)
        different, place, where = np.unique(self.columns.values[labels, column], return_index=True, return_inverse=True)
        code_of, number = codes[place], where.reshape(-1)
        bounds = np.searchsorted(code_of, np.array(first))
        if len(different) > codes.max() + 1:
            sums = np.zeros((len(different) + 1, self.evidence.terms.shape[1]))
            np.add.at(sums, number + 1, self.evidence.terms[labels])
            bounds = _moved(bounds, code_of, np.cumsum(sums, axis=0), self.evidence)
        middles = (different[bounds - 1] + different[bounds]) / 2.0
        # Between neighbouring floats, and floats whose sum is infinite, too.
        middles = np.where(
            (middles >= different[bounds - 1]) & (middles < different[bounds]), middles, different[bounds - 1]
        )
        prior = -float(self.columns.prices[column] + price_of_bounds(len(first), len(different) - 1))
        return Split(self.columns.readings[column], tuple(middles.tolist())), prior


def _different(trees: Sequence[Tree]) -> list[Tree]:
    """Trees of all labels without those that divide these as a better one does, the most likely one first."""
    different: dict[frozenset[bytes], Tree] = {}
    for tree in sorted(trees, key=lambda tree: -tree.log_posterior):
        different.setdefault(frozenset(cell.tobytes() for cell in tree.cells()), tree)
    return list(different.values())


def posterior_shares(trees: Sequence[Tree]) -> Floats:
    """[trees] the weight of each of different trees, its posterior among them; all sum to 1."""
    posterior = np.array([tree.log_posterior for tree in trees])
    shares = np.exp(posterior - posterior.max())
    return shares / shares.sum()


def loosened(tree: Tree, rows: Floats, randomness: np.random.Generator) -> Tree:
    """A tree with each bound on values somewhere between the nearest labels on both sides, where no label says more.

    Args:
        tree: the tree.
        rows: [n, F] rows of all labels.
        randomness: draws the bounds.
    """
    split = tree.split
    if split is not None and isinstance(split.reading, Value):
        values, bounds = split.reading.read(rows[tree.labels]), list[float]()
        for bound in split.bounds:
            low, high, share = values[values <= bound].max(), values[values > bound].min(), randomness.random()
            # Of neighbouring floats, and of floats whose difference is infinite, too.
            bounds.append(float(min((1.0 - share) * low + share * high, np.nextafter(high, low))))
        split = split._replace(bounds=tuple(bounds))
    parts = tuple((part, loosened(branch, rows, randomness)) for part, branch in tree.parts)
    return replace(tree, split=split, parts=parts)


def _moved(bounds: Ints, code_of: Ints, below: Floats, evidence: Evidence) -> Ints:
    """Bounds [b], each at the place with the most evidence among those of its bin and the bin below, in turn.

    Args:
        bounds: [b] index of the first value of each interval but the lowest, ascending.
        code_of: [V] bin of each value, ascending.
        below: [V + 1, W] sums of the terms of the labels with smaller values.
        evidence: evidence of parts.
    """
    moved = [0, *bounds.tolist(), len(code_of)]
    for index in range(1, len(moved) - 1):
        code = code_of[moved[index]]
        low = max(int(np.searchsorted(code_of, code - 1)), moved[index - 1] + 1)
        high = min(int(np.searchsorted(code_of, code, side="right")), moved[index + 1] - 1)
        places = np.arange(low, high + 1)
        lower, upper = below[places] - below[moved[index - 1]], below[moved[index + 1]] - below[places]
        total = evidence.of_sums(lower) + evidence.of_sums(upper)
        best = places[total > total.max() - _EQUAL]
        moved[index] = int(best[len(best) // 2])
    return np.array(moved[1:-1])


def _node(labels: Ints, depth: int, split: Split, prior: float, parts: tuple[tuple[int, Tree], ...]) -> Tree:
    """A divided node; the prior is the log of that of its split, given that there is one."""
    total = _log_dividing(depth) + prior + sum(part.log_posterior for _, part in parts)
    return Tree(labels, total, split, parts)


def _log_dividing(depth: int) -> float:
    """Log of the prior probability that a node is divided."""
    return float(np.log(_DIVIDED / np.sqrt(1.0 + depth)))


def log_leaf(depth: int) -> float:
    """Log of the prior probability that a node is a cell."""
    return float(np.log1p(-_DIVIDED / np.sqrt(1.0 + depth)))
