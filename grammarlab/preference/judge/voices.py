"""Whether scores are those of one person: a taste may have changed, or two people may have scored by turns.

The order of scores is data. Two hypotheses divide them between two voices, each with a taste of its own: the later
scores have another one than the earlier ones, or turns of a few scores have one and the other in turn. They are judged
like any explanation (`grammarlab.preference.judge.judge`): the total of two trees, one for each voice, less the price
of the division, against the total of the best tree of all scores. The price is log 2 for the kind of division, log n
for the place of a change or the log of the number of lengths of turns, and the log of prior odds: most persons agree
with themselves.

A file may be sorted by score or by a column of designs, which is no disagreement. So scores of a sorted file are those
of one voice. What the order says about how high scores are, the gain of undivided trees, counts half: questions about
rare likes give high scores later than low ones.

A quick measure of what the best column of each voice explains chooses the divisions that are compared exactly. A change
is then moved to where scores are predicted best by the other scores of their voice.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from grammarlab.arrays import MANY, Flags, Floats, Ints
from grammarlab.preference.base import MIN_PART, ODDS_OF_SIMPLER
from grammarlab.preference.growth.person_search import most_likely, search
from grammarlab.preference.growth.screening import coarse_bins, gains_of_parts
from grammarlab.preference.growth.tree_growth import Tree, TreeGrowth
from grammarlab.preference.judge.labelled_columns import Labels
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.person import START_PERSONS, Person

Kind = Literal["change", "turns"]

_MAX_TURN = 64
"""Largest number of scores of a turn: every length is compared, and longer turns are few."""
_LEVEL_SHARE = 0.5
"""Share of the gain by levels of scores that does not count."""


@dataclass(frozen=True, eq=False)
class Division:
    """Scores divided between two voices."""

    kind: Kind
    number: int
    """Number of scores before a change, or of a turn."""
    is_second: Flags
    """[n] whether each score is of the second voice."""

    @classmethod
    def at(cls, number: int, num: int) -> Division:
        """A change after a number of n scores."""
        return cls("change", number, np.arange(num) >= number)

    @classmethod
    def by_turns(cls, number: int, num: int) -> Division:
        """Turns of a number of n scores."""
        return cls("turns", number, np.arange(num) // number % 2 == 1)

    @property
    def price(self) -> float:
        """Description length, with the prior odds, in nats."""
        num = len(self.is_second)
        places = num if self.kind == "change" else len(_lengths(num))
        return float(np.log(2.0) + np.log(places) + np.log(ODDS_OF_SIMPLER))

    @property
    def voices(self) -> tuple[Ints, Ints]:
        """Indices of the scores of each voice."""
        return np.flatnonzero(~self.is_second), np.flatnonzero(self.is_second)


@dataclass(frozen=True, eq=False)
class TwoVoices:
    """Scores that two tastes explain."""

    division: Division
    trees: tuple[Tree, Tree]
    """What explains each voice."""
    person: Person
    """The errors of both."""
    total: float
    """Evidence minus description length, in nats."""
    agreed: Floats
    """[n] means of each score and the mean score that the other voice gives to such a design."""


def two_voices(columns: Floats, prices: Floats, scores: Floats) -> TwoVoices | None:
    """The two voices of scores; None if one explains them as well.

    Args:
        columns: [n, F] columns of the scored designs.
        prices: [F] description length of each column, in nats.
        scores: [n] 0-100, in the order in which they were given.
    """
    divisions = list(_divisions(len(scores)))
    if not divisions or not columns.shape[1] or _are_sorted(columns, scores):
        return None
    worth = _worth(columns, prices, scores, divisions)
    likely = _most_likely_divisions(worth, divisions)
    if not likely:
        return None
    labels = _labels(columns, prices, scores, worth, likely)
    best = max((_moved(labels, _explained(labels, divisions[i])) for i in likely), key=lambda two: two.total)
    least = best.total - _LEVEL_SHARE * max(_level_gain(labels, best), 0.0)
    return best if least > _total_of_one(labels, best, least) else None


def _are_sorted(columns: Floats, scores: Floats) -> bool:
    """Whether scores, or a column of several values, only rise or only fall."""
    steps = np.diff(np.column_stack([scores, columns]), axis=0)
    is_sorted = ~np.any(steps < 0.0, axis=0) | ~np.any(steps > 0.0, axis=0)
    has_several = np.count_nonzero(steps, axis=0) >= MIN_PART
    return bool(is_sorted[0] or np.any(is_sorted & has_several))


def _divisions(num: int) -> Iterator[Division]:
    """Divisions of n scores that are compared quickly."""
    if num >= 2 * MIN_PART:
        places = np.unique(np.linspace(MIN_PART, num - MIN_PART, MANY).round().astype(np.int64))
        yield from (Division.at(place, num) for place in places.tolist())
        yield from (Division.by_turns(length, num) for length in _lengths(num))


def _lengths(num: int) -> range:
    """Possible lengths of turns of n scores: after one turn of each voice, enough scores remain."""
    return range(1, min((num - MIN_PART) // 2, _MAX_TURN) + 1)


def _worth(columns: Floats, prices: Floats, scores: Floats, divisions: Sequence[Division]) -> Floats:
    """[3, D, F] what each column explains of all scores and of those of each voice, less its price, in nats."""
    seconds = np.array([division.is_second for division in divisions])
    parts = np.concatenate([np.ones((1, len(scores)), dtype=bool), ~seconds, seconds])
    every, *voices = np.split(gains_of_parts(coarse_bins(columns), parts, scores) - prices, [1, 1 + len(divisions)])
    return np.stack([np.broadcast_to(every, voices[0].shape), *voices])


def _most_likely_divisions(worth: Floats, divisions: Sequence[Division]) -> list[int]:
    """Index of the division of each kind whose voices have the best columns; of none that explains too little."""
    every, *voices = np.maximum(worth.max(axis=2), 0.0)
    gains = sum(voices) - every - [division.price for division in divisions]
    best: dict[Kind, int] = {}
    for index, division in enumerate(divisions):
        if gains[index] > max(gains[best[division.kind]] if division.kind in best else 0.0, 0.0):
            best[division.kind] = index
    return list(best.values())


def _labels(columns: Floats, prices: Floats, scores: Floats, worth: Floats, likely: Sequence[int]) -> Labels:
    """The scores with the columns that explain most of them or of a voice."""
    rankings = [worth[0, 0], *(worth[voice, index] for voice in (1, 2) for index in likely)]
    chosen = np.unique([np.argsort(-ranking, kind="stable")[:MANY] for ranking in rankings])
    return Labels.of(columns[:, chosen], prices[chosen], scores)


def _explained(labels: Labels, division: Division) -> TwoVoices:
    """The best explanation of two voices, a tree for each, with the same errors."""
    best = max((_grown(labels, division, person) for person in START_PERSONS), key=lambda two: two.total)
    likely = most_likely(labels.evidence, [[cell for tree in best.trees for cell in tree.cells()]], [0.0])
    return best if likely in START_PERSONS else max(best, _grown(labels, division, likely), key=lambda two: two.total)


def _grown(labels: Labels, division: Division, person: Person) -> TwoVoices:
    growth = TreeGrowth(labels.columns, labels.evidence.for_person(person))
    first, second = (growth.grown(voice) for voice in division.voices)
    total = first.log_posterior + second.log_posterior - person.price - division.price
    return TwoVoices(division, (first, second), person, total, _agreed(labels, division, (first, second)))


def _agreed(labels: Labels, division: Division, trees: tuple[Tree, Tree]) -> Floats:
    agreed = labels.scores.copy()
    for tree, others in zip(trees, division.voices[::-1], strict=True):
        for leaf, members in _in_leaves(labels, tree, others):
            agreed[members] = (labels.scores[members] + labels.scores[leaf.labels].mean()) / 2.0
    return agreed


def _moved(labels: Labels, two: TwoVoices) -> TwoVoices:
    """A change at the place where other scores of a voice predict each score best."""
    if two.division.kind != "change":
        return two
    num, evidence = len(labels.scores), labels.evidence.for_person(two.person)
    first, second = (_predicted(labels, tree, evidence) for tree in two.trees)
    before = np.concatenate([[0.0], np.cumsum(first - second)])
    place = MIN_PART + int(np.argmax(before[MIN_PART : num - MIN_PART + 1]))
    moved = two if place == two.division.number else _explained(labels, Division.at(place, num))
    return max(two, moved, key=lambda item: item.total)


def _predicted(labels: Labels, tree: Tree, evidence: LeafEvidence) -> Floats:
    """[n] log-probability of each score, given the other scores of a tree."""
    found = np.zeros(len(labels.scores))
    for leaf, members in _in_leaves(labels, tree, labels.every):
        own = np.isin(members, leaf.labels)
        terms, total = evidence.terms[members], evidence.terms[leaf.labels].sum(axis=0)
        with_it, without = total + terms * ~own[:, None], total - terms * own[:, None]
        found[members] = evidence.of_sums(with_it) - evidence.of_sums(without)
    return found


def _in_leaves(labels: Labels, tree: Tree, members: Ints) -> Iterator[tuple[Tree, Ints]]:
    """The leaves of a tree, each with those of some scores that are in it."""
    if tree.split is None:
        yield tree, members
    else:
        part_of = tree.split.parts(labels.values[members])
        for part, branch in tree.parts:
            yield from _in_leaves(labels, branch, members[part_of == part])


def _level_gain(labels: Labels, two: TwoVoices) -> float:
    """What an undivided tree for each voice explains beyond one for all."""
    evidence = labels.evidence.for_person(two.person)
    return sum(evidence.of_labels(voice) for voice in two.division.voices) - evidence.of_labels(labels.every)


def _total_of_one(labels: Labels, two: TwoVoices, enough: float) -> float:
    """Total of the best tree of all scores; if it is enough, of any tree with that total.

    Trees that begin like those of a voice, or with what distinguishes the designs of the voices, are among them.
    """
    flag, price = _apart(labels, two.division)
    wider = labels.joined(flag[:, None], np.array([price]))
    growth = TreeGrowth(wider.columns, wider.evidence.for_person(two.person))
    roots = {len(labels.prices)}.union(*(tree.split.columns for tree in two.trees if tree.split is not None))
    alike = max(growth.grown(labels.every, root).log_posterior for root in [None, *sorted(roots)]) - two.person.price
    if alike >= enough:
        return alike
    # The longer search is for scores that seem to have two voices.
    found = search(labels.columns, labels.evidence, START_PERSONS)
    return max(alike, found.trees[0].log_posterior - found.evidence.person.price)


def _apart(labels: Labels, division: Division) -> tuple[Floats, float]:
    """[n] whether a column is above the bound that tells the designs of the voices apart best; its price."""
    order = np.argsort(labels.values, axis=0, kind="stable")
    ascending = np.take_along_axis(labels.values, order, axis=0)
    share = division.is_second.mean()
    excess = np.abs(np.cumsum(division.is_second[order] - share, axis=0)[:-1])
    excess[np.diff(ascending, axis=0) <= 0.0] = 0.0
    place, column = np.unravel_index(int(excess.argmax()), excess.shape)
    places = max(len(np.unique(ascending[:, column])) - 1, 1)
    flag = (labels.values[:, column] > ascending[place, column]).astype(np.float64)
    return flag, float(labels.prices[column] + np.log(places))
