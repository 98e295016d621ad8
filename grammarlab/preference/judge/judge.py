"""What explains scores: columns that are there, or columns composed of these, each at its price.

An explanation is a tree or a line, with the errors of the person. Its total is the evidence of the scores minus the
description length of the explanation, in nats. The composed columns of the best explanation are accepted if its total
exceeds that of the best explanation of known columns, and that of one distribution of values, whatever the columns say
(`grammarlab.preference.unexplained`); nothing else decides. Without this rival a division of 24 noisy scores into good
and bad ones would be proven by saying what scores there are: a tree of one leaf has to learn that first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import MANY_COLUMNS, Floats, Ints
from grammarlab.preference.base import MIN_PART
from grammarlab.preference.growth.person_search import search
from grammarlab.preference.growth.screening import coarse_bins, gains
from grammarlab.preference.growth.tree_growth import Tree, log_leaf
from grammarlab.preference.judge.labelled_columns import Explanation, Labels
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.judge.votes import Vote, votes
from grammarlab.preference.judge.weighted_sums import Measures, WeightedSum, weighted_sums
from grammarlab.preference.lines.line_preference import best_line
from grammarlab.preference.person import START_PERSONS, Person
from grammarlab.preference.unexplained import log_evidence_of_values


@dataclass(frozen=True)
class Verdict:
    """The best explanation."""

    accepted: tuple[int, ...]
    """Composed columns that it uses, ascending; () if known columns explain scores as well."""
    votes: tuple[Vote, ...]
    """Columns joined from flags that it uses."""
    sums: tuple[WeightedSum, ...]
    """Weighted sums that it uses."""
    prices: tuple[float, ...]
    """Price of each of these columns, the accepted ones first, then votes, then sums, in nats."""
    total: float
    """Its total in nats."""
    known: float
    """Total of the best explanation of known columns."""
    person: Person
    """The errors of the person."""


def judged(
    known: Floats, composed: Floats, prices: Floats, flags: Floats, measures: Measures, scores: Floats
) -> Verdict:
    """The best explanation of scores.

    Args:
        known: [n, F] columns that are used in any case.
        composed: [n, C] further columns.
        prices: [C] description length of each of them, in nats.
        flags: [n, K] 0 or 1, no two equal or opposite: columns that may be joined.
        measures: n rows of numbers that may be added.
        scores: [n] 0-100.

    >>> randomness = np.random.default_rng(0)
    >>> known, composed = randomness.random((64, 4)), randomness.random((64, 50))
    >>> none, prices, scores = known[:, :0], np.full(50, np.log(50)), 80.0 * (composed[:, 7] > 0.5)
    >>> verdict = judged(known, composed, prices, none, Measures(none, np.zeros(0)), scores)
    >>> verdict.accepted
    (7,)
    """
    width = known.shape[1]
    # Log 2 says whether a column is a known one.
    labels = Labels.of(known, np.full(width, np.log(2.0) + np.log(max(width, 1))), scores)
    base = best_tree(labels, START_PERSONS)
    best_known = _better(base.explanation, _best_line(labels))
    # As in `unexplained_scores`, scores of an undivided tree have any distribution, or values have one, with even odds.
    nothing = log_evidence_of_values(scores) - float(np.log(2.0)) + log_leaf(0)
    to_beat = max(best_known.total, nothing)
    person = base.explanation.person
    evidence = labels.evidence.for_person(person)
    shortlist = _shortlist(composed, prices, base.tree, evidence)
    joined = votes(flags, scores)
    sums = weighted_sums(measures, evidence, to_beat + person.price)
    columns = [vote.values(flags) for vote in joined] + [some.values(measures.values) for some in sums]
    further = np.concatenate([composed[:, shortlist], *(column[:, None] for column in columns)], axis=1)
    # Half of the prior is that of the language. Scores choose three kinds, formulas, votes and weighted sums, and
    # each costs as if it had the other half alone: all shares may add up to nearly 2 instead of 1. With a third of
    # that half for each, a vote that 64 scores support is not worth its price in one of 36 files.
    further_prices = np.append(prices[shortlist], [np.log(2.0) + each.price for each in (*joined, *sums)])
    wider = labels.joined(further, np.log(2.0) + further_prices)
    best = _better(best_known, best_tree(wider, START_PERSONS).explanation)
    best = _better(best, _best_line(wider))
    best = best if best.total > to_beat else best_known
    used = sorted(column - width for column in best.columns if column >= width)
    first = len(shortlist), len(shortlist) + len(joined)
    return Verdict(
        accepted=tuple(int(shortlist[column]) for column in used if column < first[0]),
        votes=tuple(joined[column - first[0]] for column in used if first[0] <= column < first[1]),
        sums=tuple(sums[column - first[1]] for column in used if column >= first[1]),
        prices=tuple(wider.prices[[width + column for column in used]].tolist()),
        total=best.total,
        known=best_known.total,
        person=best.person,
    )


class BestTree(NamedTuple):
    """The best tree and what it explains."""

    explanation: Explanation
    tree: Tree


def best_tree(labels: Labels, persons: Sequence[Person]) -> BestTree:
    """The best tree of some labels.

    Args:
        labels: the labels.
        persons: errors that the search starts with, those with more noise first.
    """
    found = search(labels.columns, labels.evidence, persons)
    tree, person = found.trees[0], found.evidence.person
    return BestTree(Explanation(tree.log_posterior - person.price, tree.columns, person), tree)


def _better(first: Explanation, second: Explanation) -> Explanation:
    """The better of two explanations, the first one if they are as good."""
    return second if second.total > first.total else first


def _best_line(labels: Labels) -> Explanation:
    """The best line."""
    line = best_line(labels.values, labels.prices, labels.scores)
    return Explanation(line.total, frozenset(line.columns), line.person)


def _shortlist(composed: Floats, prices: Floats, tree: Tree, evidence: LeafEvidence) -> Ints:
    """The composed columns that may explain most: of all scores, or of a leaf of known columns."""
    coarse = coarse_bins(composed)
    worth = np.zeros(composed.shape[1])
    for part in (tree.labels, *(cell for cell in tree.cells() if len(cell) >= MIN_PART)):
        possible = evidence.best_possible(part) - evidence.of_labels(part)
        worth = np.maximum(worth, np.minimum(gains(coarse, part, evidence.scores), possible))
    return np.sort(np.argsort(prices - worth, kind="stable")[:MANY_COLUMNS])
