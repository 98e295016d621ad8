"""The best tree: from a few first divisions, with the errors of the person that make it most likely."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.preference.judge.judged_labels import MAX_LABELS
from grammarlab.preference.judge.labelled_columns import Explanation, Labels
from grammarlab.preference.judge.score_tree import NODE_PRICE, ScoreTree, TreeGrowth, leaf_of
from grammarlab.preference.judge.screening import gains
from grammarlab.preference.judge.smooth_leaf import SmoothLeaf
from grammarlab.preference.person import NOISES, PERSONS, Person

_NUM_ROOTS = 3
"""Number of first divisions that trees grow from, beside the best one. More are only slower."""
_NUM_PERSONS = 2
"""Largest number of times that errors are improved and trees grown again."""
_NUM_FINISHED = 3
"""Number of trees of different columns whose leaves may be smooth."""
_NUM_SMOOTH = 8
"""Number of columns of each leaf that are tried as smooth."""
_MIN_SMOOTH = 8
"""Smallest number of labels of a smooth leaf."""


class Grown(NamedTuple):
    """A tree with the errors that it was grown for."""

    tree: ScoreTree
    person: Person

    @property
    def total(self) -> float:
        """Evidence minus description length, the person's included."""
        return self.tree.total - self.person.price


class BestTree(NamedTuple):
    """The best tree and what it explains."""

    explanation: Explanation
    tree: ScoreTree


class _SmoothColumn(NamedTuple):
    column: int
    price: float
    function: SmoothLeaf


def best_tree(labels: Labels, persons: Sequence[Person]) -> BestTree:
    """The best tree of some labels, its leaves smooth functions where these explain scores better.

    Args:
        labels: the labels.
        persons: errors that searches start with.
    """
    grown = search(labels, persons)
    different: dict[frozenset[int], Grown] = {}
    for item in grown:
        different.setdefault(item.tree.columns, item)
    # A smooth function of all labels needs no division.
    person = grown[0].person
    candidates = [
        *list(different.values())[:_NUM_FINISHED],
        Grown(leaf_of(labels.every, labels.evidence(person)), person),
    ]
    finished = [_with_smooth_leaves(labels, item) for item in candidates]
    return max(finished, key=lambda item: item.explanation.total)


def search(labels: Labels, persons: Sequence[Person]) -> list[Grown]:
    """Trees of some labels, the best one first.

    Args:
        labels: the labels.
        persons: errors that searches start with.
    """
    grown = [item for person in persons for item in _grown(labels, person)]
    tried, best = set(persons), max(grown, key=lambda item: item.total)
    for _ in range(_NUM_PERSONS):
        likely = most_likely(labels, [leaf.labels for leaf in best.tree.leaves()], best.person)
        if likely in tried:
            break
        tried.add(likely)
        grown += _grown(labels, likely)
        best = max(grown, key=lambda item: item.total)
    return sorted(grown, key=lambda item: -item.total)


def _grown(labels: Labels, person: Person) -> list[Grown]:
    growth = TreeGrowth(labels.binned, labels.prices, labels.scores, labels.evidence(person))
    roots = growth.roots(labels.every, _NUM_ROOTS)
    return [Grown(growth.grown(labels.every, root), person) for root in (None, *roots)]


def most_likely(labels: Labels, leaves: Sequence[Ints], person: Person) -> Person:
    """The errors with which leaves have the highest total, among them those of a person."""

    def total(person: Person) -> float:
        evidence = labels.evidence(person)
        return sum(evidence.of_labels(leaf) for leaf in leaves) - person.price

    return max([person, *PERSONS], key=total)


def _with_smooth_leaves(labels: Labels, grown: Grown) -> BestTree:
    """A tree whose leaves are smooth functions where these explain scores better, for the most likely noise."""
    tree, blunders = grown.tree, grown.person.blunders
    leaves = [(leaf, _smooth(labels, leaf)) for leaf in tree.leaves()]
    best = Explanation(grown.total, tree.columns, grown.person)
    # The price of divisions: leaves are evaluated again.
    divided = grown.total - sum(leaf.total for leaf, _ in leaves)
    for noise in NOISES:
        person = Person(noise, blunders)
        evidence, total, used = labels.evidence(person), divided, set[int](tree.columns)
        for leaf, functions in leaves:
            plain = evidence.of_labels(leaf.labels)
            trials = [(smooth.function.log_evidence(noise) - smooth.price, smooth.column) for smooth in functions]
            highest, column = max(trials, default=(-np.inf, -1))
            total += max(plain, highest) - NODE_PRICE
            used |= {column} if highest > plain else set()
        if total > best.total:
            best = Explanation(total, frozenset(used), person)
    return BestTree(best, tree)


def _smooth(labels: Labels, leaf: ScoreTree) -> list[_SmoothColumn]:
    """Columns of which a leaf may be a smooth function."""
    num, scores = len(leaf.labels), labels.scores[leaf.labels]
    if not _MIN_SMOOTH <= num <= MAX_LABELS or np.ptp(scores) == 0.0:
        return []
    worth = gains(labels.binned, leaf.labels, labels.scores) - labels.prices
    worth[labels.binned.sizes <= 2] = -np.inf
    functions = list[_SmoothColumn]()
    for column in np.argsort(-worth, kind="stable")[:_NUM_SMOOTH].tolist():
        values = labels.values[leaf.labels, column]
        if np.isfinite(worth[column]) and np.ptp(values) > 0.0:
            # The length and the size of the function are fitted: half of log n each, as for a weight.
            price = float(labels.prices[column] + 0.5 * np.log(num) + np.log(2.0))
            functions.append(_SmoothColumn(column, price, SmoothLeaf(values, scores)))
    return functions
