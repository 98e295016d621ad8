"""What explains scores: columns that are there, or columns composed of these, each at its price.

An explanation is a tree or a line with the errors of the person. Its total is the evidence of the scores minus the
description length of the explanation. The composed columns of the best explanation are accepted if its total exceeds
that of the best explanation of known columns; nothing else decides.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.cells.person_error import BLUNDERS, NOISES, PRICE_OF_BLUNDERS
from grammarlab.preference.judge.cuts import BinnedColumns
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.judge.score_line import best_line
from grammarlab.preference.judge.score_tree import NODE_PRICE, ScoreTree, TreeGrowth
from grammarlab.preference.judge.screening import gains
from grammarlab.preference.judge.smooth_leaf import MAX_LABELS, SmoothLeaf
from grammarlab.preference.judge.unexplained_scores import UnexplainedScores
from grammarlab.preference.judge.votes import Vote, votes

_START_NOISES = (20.0, 8.0, 0.5)
"""Standard deviations of the errors that searches start with, in points."""
_START_BLUNDERS = 0.03
"""Probability of blunders that searches start with."""
_NUM_ROOTS = 3
"""Number of first divisions that trees grow from."""
_NUM_COMPOSED = 120
"""Number of composed columns that are compared exactly."""
_NUM_SMOOTH = 8
"""Number of columns of each leaf that are tried as smooth."""
_MIN_SMOOTH = 8
"""Smallest number of labels of a smooth leaf."""


class Person(NamedTuple):
    """Errors of a person."""

    noise: float
    blunders: float

    @property
    def price(self) -> float:
        """Minus the log of the prior, up to a constant."""
        return PRICE_OF_BLUNDERS * self.blunders


@dataclass(frozen=True)
class Verdict:
    """The best explanation."""

    accepted: tuple[int, ...]
    """Composed columns that it uses; () if known columns explain scores as well."""
    votes: tuple[Vote, ...]
    """Columns joined from flags that it uses."""
    total: float
    """Its total in nats."""
    known: float
    """Total of the best explanation of known columns."""
    unexplained: float
    """Total of no explanation."""
    person: Person


class _Explanation(NamedTuple):
    total: float
    columns: frozenset[int]
    person: Person


@dataclass(frozen=True, eq=False)
class _Labels:
    """Scores and all columns: known ones first."""

    values: Floats
    """[n, F] columns."""
    binned: BinnedColumns
    prices: Floats
    """[F] in nats."""
    scores: Floats
    unexplained: UnexplainedScores

    @cached_property
    def every(self) -> Ints:
        return np.arange(len(self.scores))

    def with_columns(self, values: Floats, prices: Floats) -> _Labels:
        """The same labels with more columns."""
        return replace(
            self,
            values=np.concatenate([self.values, values], axis=1),
            binned=self.binned + BinnedColumns.of(values),
            prices=np.append(self.prices, prices),
        )

    def growth(self, person: Person) -> TreeGrowth:
        evidence = LeafEvidence.of(self.scores, self.unexplained, person.noise, person.blunders)
        return TreeGrowth(self.binned, self.prices, self.scores, evidence)


def judged(known: Floats, composed: Floats, prices: Floats, flags: Floats, scores: Floats) -> Verdict:
    """The best explanation of scores.

    Args:
        known: [n, F] columns that are used in any case.
        composed: [n, C] further columns.
        prices: [C] description length of each of them, in nats.
        flags: [n, K] 0 or 1, columns that may be joined.
        scores: [n] 0-100.
    """
    price = float(np.log(2.0) + np.log(max(known.shape[1], 1)))
    first = _Labels(
        known,
        BinnedColumns.of(known),
        np.full(known.shape[1], price),
        scores,
        UnexplainedScores.of(scores),
    )
    nothing = float(first.unexplained.log_evidence(first.unexplained.members.sum(axis=0)[None])[0])
    base, tree = _best_tree(first, [Person(noise, _START_BLUNDERS) for noise in _START_NOISES])
    line = _line(first, base.person)
    best_known = max(base, line, key=lambda explanation: explanation.total)
    shortlist = _shortlist(composed, prices, tree, scores)
    joined = votes(flags, scores)
    columns = [composed[:, shortlist], *(vote.values(flags)[:, None] for vote in joined)]
    more = first.with_columns(
        np.concatenate(columns, axis=1), np.append(prices[shortlist], [vote.price for vote in joined]) + np.log(2.0)
    )
    candidates = [best_known, _best_tree(more, [best_known.person])[0], _line(more, best_known.person)]
    best = max(candidates, key=lambda explanation: explanation.total)
    width = known.shape[1]
    used = sorted(column - width for column in best.columns if column >= width)
    return Verdict(
        tuple(int(shortlist[column]) for column in used if column < len(shortlist)),
        tuple(joined[column - len(shortlist)] for column in used if column >= len(shortlist)),
        best.total,
        best_known.total,
        nothing,
        best.person,
    )


def _best_tree(labels: _Labels, persons: list[Person]) -> tuple[_Explanation, ScoreTree]:
    """The best tree of a few roots and persons, with its most likely person."""
    found: list[tuple[float, ScoreTree, Person]] = []

    def grow(person: Person) -> None:
        growth = labels.growth(person)
        roots = [None, *growth.roots(labels.every, _NUM_ROOTS)]
        for tree in (growth.grown(labels.every, root) for root in roots):
            found.append((tree.total - person.price, tree, person))

    for person in persons:
        grow(person)
    _, tree, person = max(found, key=lambda item: item[0])
    for _ in range(2):
        likely = _most_likely(labels, tree, person)
        if likely in persons:
            break
        persons = [*persons, likely]
        grow(likely)
        _, tree, person = max(found, key=lambda item: item[0])
    explanations = [_with_smooth_leaves(labels, tree, person, total) for total, tree, person in _different(found)]
    best = max(explanations, key=lambda item: item[0].total)
    return best


def _different(found: list[tuple[float, ScoreTree, Person]]) -> list[tuple[float, ScoreTree, Person]]:
    """The best few, one of each set of columns."""
    best: dict[frozenset[int], tuple[float, ScoreTree, Person]] = {}
    for item in sorted(found, key=lambda item: -item[0]):
        best.setdefault(item[1].columns, item)
    return list(best.values())[:3]


def _most_likely(labels: _Labels, tree: ScoreTree, at: Person) -> Person:
    """The errors with which a tree has the highest total."""
    leaves = [leaf.labels for leaf in tree.leaves()]

    def total(person: Person) -> float:
        evidence = LeafEvidence.of(labels.scores, labels.unexplained, person.noise, person.blunders)
        return float(evidence(np.array([evidence.terms[leaf].sum(axis=0) for leaf in leaves])).sum()) - person.price

    return max([at, *(Person(noise, blunders) for noise in NOISES for blunders in BLUNDERS)], key=total)


def _with_smooth_leaves(
    labels: _Labels, tree: ScoreTree, person: Person, total: float
) -> tuple[_Explanation, ScoreTree]:
    """A tree whose leaves are smooth functions where these explain scores better, for the most likely noise."""
    leaves = [(leaf, _smooth(labels, leaf)) for leaf in tree.leaves()]
    best = _Explanation(total, tree.columns, person)
    for noise in NOISES:
        erring = Person(noise, person.blunders)
        evidence = LeafEvidence.of(labels.scores, labels.unexplained, noise, person.blunders)
        gained, used = 0.0, set[int](tree.columns)
        for leaf, functions in leaves:
            # `leaf.total` is for the person that the tree was grown for.
            plain = evidence.of_labels(leaf.labels) - NODE_PRICE
            trials = [(function.log_evidence(noise) - price - NODE_PRICE, column) for column, price, function in functions]
            highest, column = max(trials, default=(-np.inf, -1))
            gained += max(plain, highest) - leaf.total
            used |= {column} if highest > plain else set()
        if total + gained > best.total:
            best = _Explanation(total + gained, frozenset(used), erring)
    return best, tree


def _smooth(labels: _Labels, leaf: ScoreTree) -> list[tuple[int, float, SmoothLeaf]]:
    """Columns of which a leaf may be a smooth function, and their prices."""
    m = len(leaf.labels)
    if not _MIN_SMOOTH <= m <= MAX_LABELS or np.ptp(labels.scores[leaf.labels]) == 0.0:
        return []
    worth = gains(labels.binned, leaf.labels, labels.scores) - labels.prices
    worth[labels.binned.sizes <= 2] = -np.inf
    functions: list[tuple[int, float, SmoothLeaf]] = []
    for column in np.argsort(-worth, kind="stable")[:_NUM_SMOOTH].tolist():
        values = labels.values[leaf.labels, column]
        if np.isfinite(worth[column]) and values.std() > 0.0:
            price = float(labels.prices[column]) + 0.5 * float(np.log(m)) + float(np.log(2.0))
            functions.append((column, price, SmoothLeaf(values, labels.scores[leaf.labels])))
    return functions


def _line(labels: _Labels, person: Person) -> _Explanation:
    """The best line, for the errors of a tree and for little noise."""
    lines = []
    for noise in dict.fromkeys((person.noise, *_START_NOISES)):
        erring = Person(noise, person.blunders)
        line = best_line(labels.values, labels.prices, labels.scores, noise, person.blunders)
        lines.append(_Explanation(line.total - erring.price, frozenset(line.columns), erring))
    return max(lines, key=lambda explanation: explanation.total)


def _shortlist(composed: Floats, prices: Floats, tree: ScoreTree, scores: Floats) -> Ints:
    """The composed columns that may explain most, of all scores and in each leaf of the known columns."""
    binned = BinnedColumns.of(composed)
    worth = gains(binned, np.arange(len(scores)), scores)
    for leaf in tree.leaves():
        if len(leaf.labels) >= _MIN_SMOOTH:
            worth = np.maximum(worth, gains(binned, leaf.labels, scores))
    return np.sort(np.argsort(-(worth - prices), kind="stable")[:_NUM_COMPOSED])
