"""The best tree of some labels, its leaves smooth functions where these explain scores better."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.preference.growth.person_search import search
from grammarlab.preference.growth.screening import gains
from grammarlab.preference.growth.tree_growth import Tree, undivided
from grammarlab.preference.judge.labelled_columns import MAX_LABELS, Explanation, Labels
from grammarlab.preference.judge.leaf_evidence import SmoothLeaf
from grammarlab.preference.person import NOISES, Person

_NUM_FINISHED = 3
"""Number of trees of different columns whose leaves may be smooth."""
_NUM_SMOOTH = 8
"""Number of columns of each leaf that are tried as smooth."""
_MIN_SMOOTH = 8
"""Smallest number of labels of a smooth leaf."""


class BestTree(NamedTuple):
    """The best tree and what it explains."""

    explanation: Explanation
    tree: Tree


class _SmoothColumn(NamedTuple):
    column: int
    price: float
    function: SmoothLeaf


def best_tree(labels: Labels, persons: Sequence[Person]) -> BestTree:
    """The best tree of some labels.

    Args:
        labels: the labels.
        persons: errors that the search starts with, those with more noise first.
    """
    found = search(labels.columns, labels.evidence, persons)
    different: dict[frozenset[int], Tree] = {}
    for tree in found.trees:
        different.setdefault(tree.columns, tree)
    # A smooth function of all labels needs no division.
    candidates = [*list(different.values())[:_NUM_FINISHED], undivided(labels.every, found.evidence)]
    # Trees share most of their leaves.
    cells = {cell.tobytes(): cell for tree in candidates for cell in tree.cells()}
    smooth = {key: _smooth(labels, cell) for key, cell in cells.items()}
    finished = [_with_smooth_leaves(labels, tree, found.evidence.person, smooth) for tree in candidates]
    return max(finished, key=lambda item: item.explanation.total)


def _with_smooth_leaves(
    labels: Labels, tree: Tree, person: Person, smooth: Mapping[bytes, Sequence[_SmoothColumn]]
) -> BestTree:
    """A tree whose leaves are smooth functions where these explain scores better, for the most likely noise."""
    leaves = [(cell, smooth[cell.tobytes()]) for cell in tree.cells()]
    evidence = labels.evidence.for_person(person)
    # The log-prior of the divisions.
    divided = tree.log_posterior - sum(evidence.of_labels(cell) for cell, _ in leaves)
    best = Explanation(tree.log_posterior - person.price, tree.columns, person)
    for noise in NOISES:
        other = person._replace(noise=noise)
        evidence, total, used = labels.evidence.for_person(other), divided - person.price, set[int](tree.columns)
        for cell, functions in leaves:
            plain = evidence.of_labels(cell)
            trials = [(each.function.log_evidence(noise) - each.price, each.column) for each in functions]
            highest, column = max(trials, default=(-np.inf, -1))
            total += max(plain, highest)
            used |= {column} if highest > plain else set()
        if total > best.total:
            best = Explanation(total, frozenset(used), other)
    return BestTree(best, tree)


def _smooth(labels: Labels, cell: Ints) -> list[_SmoothColumn]:
    """Columns of which a leaf may be a smooth function."""
    num, scores = len(cell), labels.scores[cell]
    if not _MIN_SMOOTH <= num <= MAX_LABELS or np.ptp(scores) == 0.0:
        return []
    worth = gains(labels.columns.coarse, cell, labels.scores) - labels.prices
    # A column of two values is no smooth one.
    worth[labels.columns.coarse.max(axis=1, initial=0) <= 1] = -np.inf
    functions = list[_SmoothColumn]()
    for column in np.argsort(-worth, kind="stable")[:_NUM_SMOOTH].tolist():
        values = labels.values[cell, column]
        if np.isfinite(worth[column]) and np.ptp(values) > 0.0:
            # The length and the size of the function are fitted: half of log n each, as for a weight.
            price = float(labels.prices[column] + 0.5 * np.log(num) + np.log(2.0))
            functions.append(_SmoothColumn(column, price, SmoothLeaf(values, scores)))
    return functions
