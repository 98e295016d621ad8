"""Trees that explain scores: grown greedily, each division the best one by evidence and price.

The total of a tree in nats is the evidence of its leaves minus its description length: log 2 for each node, the price
of each column, and the bounds of each division (`grammarlab.preference.judge.cuts`). A column that is in the tree
already is named among these. Totals of all trees are comparable, whatever columns they use.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.judge.cuts import BinnedColumns, Cut, best_cuts, price_of_bounds
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.judge.screening import gains

NODE_PRICE = float(np.log(2.0))
"""Price of a node, divided or not."""
_NUM_EXACT = 48
"""Number of columns of a node whose divisions are compared exactly, those that a screening ranks first. More are only
slower."""
MAX_DEPTH = 12
"""Largest depth of a tree."""
_PATIENCE = 12.0
"""Largest loss in nats of a division that is tried although its parts, as leaves, explain less than the node: a few
liked designs are apart only after several divisions."""
_PATIENT_DEPTH = 2
"""Depth from which on each division has to gain."""


@dataclass(frozen=True, eq=False)
class ScoreTree:
    """A tree of some labels."""

    labels: Ints
    total: float
    """Evidence minus description length, in nats."""
    cut: Cut | None = None
    """Its division; None for a leaf."""
    parts: tuple[ScoreTree, ...] = ()

    def leaves(self) -> Iterator[ScoreTree]:
        """All leaves."""
        if self.cut is None:
            yield self
        for part in self.parts:
            yield from part.leaves()

    @cached_property
    def columns(self) -> frozenset[int]:
        """Columns that the tree divides by."""
        own = frozenset[int]() if self.cut is None else frozenset([self.cut.column])
        return own.union(*(part.columns for part in self.parts))


def leaf_of(labels: Ints, evidence: LeafEvidence) -> ScoreTree:
    """A tree that does not divide some labels."""
    return ScoreTree(labels, evidence.of_labels(labels) - NODE_PRICE)


@dataclass(frozen=True, eq=False)
class TreeGrowth:
    """Labels and columns that trees grow from."""

    columns: BinnedColumns
    prices: Floats
    """[C] description length of each column, in nats."""
    scores: Floats
    """[n] 0-100."""
    evidence: LeafEvidence

    def grown(self, labels: Ints, root: int | None = None) -> ScoreTree:
        """A tree of some labels.

        Args:
            labels: [m] indices.
            root: the column of the first division; None for the best one.
        """
        return self._grown(labels, frozenset(), 0, root)

    def roots(self, labels: Ints, num: int) -> list[int]:
        """The columns with the best first divisions, best first."""
        candidates = self._candidates(labels, frozenset())
        values = self._values(candidates, labels, frozenset())[0]
        order = np.argsort(-values, kind="stable")[:num]
        return [int(candidates[index]) for index in order.tolist() if np.isfinite(values[index])]

    def _grown(self, labels: Ints, used: frozenset[int], depth: int, root: int | None = None) -> ScoreTree:
        leaf = leaf_of(labels, self.evidence)
        if len(labels) < 2 or depth >= MAX_DEPTH or np.ptp(self.scores[labels]) == 0.0:
            return leaf
        candidates = self._candidates(labels, used) if root is None else np.array([root])
        values, cuts = self._values(candidates, labels, used)
        best = int(np.argmax(values)) if len(values) else -1
        patience = _PATIENCE if depth < _PATIENT_DEPTH else 0.0
        if best < 0 or values[best] < leaf.total - patience:
            return leaf
        cut, seen, parts = cuts[best], used | {cuts[best].column}, list[ScoreTree]()
        for part in cut.parts(self.columns, labels):
            parts.append(self._grown(part, seen, depth + 1))
            seen |= parts[-1].columns
        total = -NODE_PRICE - self._price(used)[cut.column] + sum(part.total for part in parts)
        total -= self._bounds_price(cut, labels)
        return ScoreTree(labels, total, cut, tuple(parts)) if total > leaf.total else leaf

    def _values(self, candidates: Ints, labels: Ints, used: frozenset[int]) -> tuple[Floats, list[Cut]]:
        """[K] total of a node divided by each column, its parts leaves, and the divisions."""
        divided = best_cuts(self.columns, candidates, labels, self.evidence.terms, self.evidence)
        num_parts = np.array([len(cut.first) + 1 for cut in divided.cuts], dtype=np.float64)
        return divided.log_evidence - NODE_PRICE * (1.0 + num_parts) - self._price(used)[candidates], divided.cuts

    def _candidates(self, labels: Ints, used: frozenset[int]) -> Ints:
        """Columns whose divisions are compared exactly."""
        worth = gains(self.columns, labels, self.scores) - self._price(used)
        return np.argsort(-worth, kind="stable")[:_NUM_EXACT]

    def _price(self, used: frozenset[int]) -> Floats:
        """[C] price of each column, given those that are in the tree: with even odds it is one of them."""
        if not used:
            return self.prices
        again = np.array(sorted(used))
        prices = self.prices + np.log(2.0)
        prices[again] = np.minimum(prices[again], np.log(2.0) + np.log(len(again)))
        return prices

    def _bounds_price(self, cut: Cut, labels: Ints) -> float:
        """Price of the bounds of a division, as `best_cuts` has it."""
        num_places = len(np.unique(self.columns.codes[cut.column, labels])) - 1
        return price_of_bounds(len(cut.first), num_places)
