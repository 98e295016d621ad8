"""Trees of splits, grown at random in proportion to their posterior and then pruned.

A node divides its labels with prior probability .9 / sqrt(1 + depth). Its split is drawn by the evidence of the
parts, each taken as one cell; sometimes by a guide with more noise, which prefers parts that differ in their mean.
The guide finds splits that gain only together with a second split, since trees are pruned bottom-up: a branch is kept
if it has more evidence than its labels as one cell.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.cells.cells import ScoreCells
from grammarlab.preference.cells.splits import Above, Split
from grammarlab.preference.judge.score_tree import MAX_DEPTH

GUIDE_PROBABILITY = 0.5
"""Probability of a draw by the guide."""
_AHEAD_DEPTH = 1
"""Depth above which nodes look one step ahead."""
_MIN_POSSIBLE_GAIN = 6.0
"""Gain in nats below which no division is possible: less than the price of a split."""


@dataclass(frozen=True, slots=True)
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

    def bounds(self) -> set[Above]:
        """Its splits at bounds."""
        return {node.split for node in self.nodes() if isinstance(node.split, Above)}

    def cell_of(self, rows: Floats) -> tuple[Ints, tuple[Ints, ...]]:
        """Number [m] of the cell of each row [m, F], and the cells; rows of new parts belong to the whole node."""
        number, cells = np.zeros(len(rows), dtype=np.int64), list[Ints]()
        self._assign(rows, np.arange(len(rows)), number, cells)
        return number, tuple(cells)

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


@dataclass(frozen=True, slots=True)
class Growth:
    """Options of growing trees."""

    temperature: float = 1.0
    """Temperature of the draws of splits: 1 for their posterior, near 0 for the best one."""
    doubt: float = 0.0
    """Temperature of pruning in nats: a branch with about this gain or loss is kept at random; 0 keeps the better."""
    guides: Sequence[ScoreCells] = ()
    """Labels and error models with more noise, which guide the draws of splits."""


def replanted(cells: ScoreCells, tree: Tree, rows: Floats, labels: Ints, depth: int = 0) -> Tree:
    """The splits of a tree with other labels, pruned by their evidence.

    Args:
        cells: the labels and the error model.
        tree: a tree of any labels.
        rows: [n, F] rows of all labels.
        labels: [c] indices, ascending.
        depth: depth of the node.
    """
    leaf, dividing = _leaf(cells, labels, depth)
    if tree.split is None or len(labels) < 2:
        return leaf
    part_of = tree.split.parts(rows[labels])
    mass = cells.splits.mass_of(part_of, labels)
    if mass <= 0.0:
        return leaf
    branches = dict(tree.parts)
    parts = tuple(
        (part, replanted(cells, branches.get(part, leaf), rows, labels[part_of == part], depth + 1))
        for part in np.unique(part_of).tolist()
    )
    evidence = float(np.log(dividing * mass)) + sum(part.log_posterior for _, part in parts)
    return Tree(labels, evidence, tree.split, parts) if evidence > leaf.log_posterior else leaf


def _leaf(cells: ScoreCells, labels: Ints, depth: int) -> tuple[Tree, float]:
    """A node of labels as one cell, and the prior probability that it is divided."""
    dividing = float(0.9 / np.sqrt(1.0 + depth))
    return Tree(labels, cells.of_cell(labels) + float(np.log1p(-dividing))), dividing


def grow(cells: ScoreCells, labels: Ints, growth: Growth, randomness: np.random.Generator, depth: int = 0) -> Tree:
    """A tree of some labels.

    Args:
        cells: the labels and the error model.
        labels: [c] indices, ascending.
        growth: options of growing.
        randomness: draws splits.
        depth: depth of the node.
    """
    leaf, dividing = _leaf(cells, labels, depth)
    undivided = leaf.log_posterior - float(np.log1p(-dividing))
    if len(labels) < 2 or depth >= MAX_DEPTH or undivided > cells.best_possible(labels) - _MIN_POSSIBLE_GAIN:
        return leaf
    guided = bool(growth.guides) and randomness.random() < GUIDE_PROBABILITY
    guide = growth.guides[int(randomness.integers(len(growth.guides)))] if guided else cells
    ranked = guide.ranked(labels, depth < _AHEAD_DEPTH)
    if ranked is None:
        return leaf
    drawn = int(np.argmax(ranked.log_posterior / growth.temperature + randomness.gumbel(size=len(ranked.log_mass))))
    split = cells.splits.drawn(ranked.member[ranked.group == drawn], randomness)
    part_of = cells.splits.parts[split, labels]
    parts = tuple(
        (part, grow(cells, labels[part_of == part], growth, randomness, depth + 1))
        for part in np.unique(part_of).tolist()
    )
    prior = float(np.log(dividing) + ranked.log_mass[drawn])
    tree = Tree(labels, prior + sum(part.log_posterior for _, part in parts), cells.splits.splits[split], parts)
    return tree if _stays(tree.log_posterior - leaf.log_posterior, growth.doubt, randomness) else leaf


def regrown(
    cells: ScoreCells,
    tree: Tree,
    growth: Growth,
    randomness: np.random.Generator,
    temperature: float = 0.0,
    depth: int = 0,
) -> Tree:
    """A tree after regrowing each node in turn, from the top, and replacing it if the new branch is more likely.

    Args:
        cells: the labels and the error model.
        tree: the initial tree.
        growth: options of growing.
        randomness: draws them.
        temperature: approximate loss of a branch in nats that is accepted; 0 for none.
        depth: depth of the first node.
    """
    if len(tree.labels) < 2:
        return tree
    candidate = grow(cells, tree.labels, growth, randomness, depth)
    if candidate.log_posterior - tree.log_posterior > -temperature * randomness.exponential():
        tree = candidate
    parts = tuple(
        (part, regrown(cells, branch, growth, randomness, temperature, depth + 1)) for part, branch in tree.parts
    )
    gained = sum(new.log_posterior - old.log_posterior for (_, new), (_, old) in zip(parts, tree.parts, strict=True))
    return replace(tree, log_posterior=tree.log_posterior + gained, parts=parts)


def loosened(tree: Tree, rows: Floats, randomness: np.random.Generator) -> Tree:
    """A tree with each bound somewhere between the nearest labels on both sides, where no label says more.

    Args:
        tree: the tree.
        rows: [n, F] rows of all labels.
        randomness: draws the bounds.
    """
    split = tree.split
    if isinstance(split, Above):
        values = rows[tree.labels, split.column]
        above = values > split.bound
        low, high, share = values[~above].max(), values[above].min(), randomness.random()
        # Of neighbouring floats, and of floats whose difference is infinite, too.
        split = Above(split.column, float(min((1.0 - share) * low + share * high, np.nextafter(high, low))))
    parts = tuple((part, loosened(branch, rows, randomness)) for part, branch in tree.parts)
    return replace(tree, split=split, parts=parts)


def _stays(gain: float, doubt: float, randomness: np.random.Generator) -> bool:
    if not doubt:
        return gain > 0.0
    return bool(randomness.random() < 1.0 / (1.0 + np.exp(np.clip(-gain / doubt, -50.0, 50.0))))
