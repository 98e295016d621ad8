"""Boxes: conjunctions of bounds on many columns, all of whose bounds are looked for together.

A person who calls a design good if nothing is wrong with it has a conjunction of many conditions. Each condition alone
explains little, so that trees, which grow split by split, begin with splits that explain the scores by chance. Here
boxes are drawn by Markov chains in proportion to

    product over faces of (odds of a face x density of its bound) x product over labels inside of p(y | v1) / p(y | v0),

v1 and v0 the values of designs inside and outside. A box has slots for faces. A step empties one and draws its face, or
none, in proportion to this: column, side and bound together. Chains begin with liked labels that weigh as much as all
disliked ones, since a box that leaves a liked design outside seldom gets it back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.growth.splits import Split, Value
from grammarlab.preference.growth.tree_growth import Tree
from grammarlab.preference.person import MODEL_NOISE, NOISES, START_BLUNDERS, Intervals, Singles, log_likelihood

MIN_COLUMNS = 8
"""Smallest number of continuous columns; trees find conjunctions of fewer."""
NUM_CHAINS = 6
"""Number of chains, and of boxes from each of them."""
_NUM_HEATED, _NUM_BETWEEN = 360, 16
"""Numbers of steps of a chain before its first box and between boxes."""
_HEATED_SHARE = 0.7
"""Share of the first steps in which a chain cools down."""
_TEMPERATURE = 3.0
"""Temperature of its first step."""
_NUM_SLOTS, _NUM_FACES = 24, 8.0
"""Largest number of faces, and number of faces that are expected beforehand."""


@dataclass(frozen=True, slots=True)
class Box:
    """Designs between bounds."""

    low: Floats
    """[F] lower bound of each column; minus infinity for none."""
    high: Floats
    """[F] upper bound of each column; infinity for none."""

    def tree(self, rows: Floats) -> Tree:
        """The box as a tree of labels [n, F], the bounds that exclude most labels first.

        Bounds that exclude no label are left out.
        """
        return self._nodes(rows, np.arange(len(rows)))

    def _nodes(self, rows: Floats, labels: Ints) -> Tree:
        outside = np.stack([rows[labels] <= self.low, rows[labels] > self.high])
        number = outside.sum(axis=1)
        if not number.any():
            return Tree(labels, 0.0)
        side, column = divmod(int(number.argmax()), rows.shape[1])
        is_outside = outside[side, :, column]
        leaf, rest = Tree(labels[is_outside], 0.0), self._nodes(rows, labels[~is_outside])
        split = Split(Value(column), (float(self.high[column] if side else self.low[column]),))
        return Tree(labels, 0.0, split, ((0, rest), (1, leaf)) if side else ((0, leaf), (1, rest)))


def find_boxes(
    rows: Floats,
    scores: Floats,
    continuous: Flags,
    randomness: np.random.Generator,
    intervals: Intervals | None = None,
    num_chains: int = NUM_CHAINS,
    priors: Floats | None = None,
) -> list[Box]:
    """Boxes that explain scores; none for few continuous columns, or without scores of two kinds.

    Args:
        rows: [n, F] rows of labels.
        scores: [n] 0-100.
        continuous: [F] whether columns are continuous, see `are_many`.
        randomness: draws boxes.
        intervals: [n] intervals of the labels, if they are not scores.
        num_chains: number of chains.
        priors: [F] how likely faces of columns are, relative to each other; None if all are equally likely. Columns
            beyond F count 1.
    """
    if not are_many(int(np.count_nonzero(continuous)), len(continuous)) or len(np.unique(scores)) < 2:
        return []
    gains = _gains(scores, intervals)
    if not (gains > 0.0).any() or not (gains < 0.0).any():
        return []
    columns = np.flatnonzero(np.ptp(rows, axis=0) > 0.0)
    if not len(columns):
        return []
    likely = np.ones(rows.shape[1])
    likely[: len(continuous)] = 1.0 if priors is None else priors
    places = _Places.of(rows[:, columns], likely[columns])
    boxes: list[Box] = []
    for _ in range(num_chains):
        for faces in _drawn(places, gains, randomness):
            low, high = np.full(rows.shape[1], -np.inf), np.full(rows.shape[1], np.inf)
            for (column, is_upper), bound in faces.items():
                (high if is_upper else low)[columns[column]] = bound
            boxes.append(Box(low, high))
    return boxes


def are_many(num_continuous: int, num_columns: int) -> bool:
    """Whether a space with so many continuous columns is searched for boxes: they are the rule, not the exception.

    >>> are_many(90, 110), are_many(60, 250), are_many(3, 3)
    (True, False, False)
    """
    return num_continuous >= MIN_COLUMNS and 2 * num_continuous > num_columns


def _gains(scores: Floats, intervals: Intervals | None) -> Singles:
    """[n] log-likelihood that each label gains inside of a box."""
    ascending = np.sort(scores)
    num = np.arange(1, len(scores))
    below, above = np.cumsum(ascending)[:-1], np.cumsum(ascending[::-1])[::-1][1:]
    between = below**2 / num + above**2 / (len(scores) - num)
    cut = int(np.argmax(np.where(np.diff(ascending) > 0.0, between, -1.0))) + 1
    low, high = float(ascending[:cut].mean()), float(ascending[cut:].mean())
    errors = scores - np.where(scores >= ascending[cut], high, low)
    noise = float(np.clip(errors.std(), MODEL_NOISE, NOISES[-1]))
    values = np.clip([low, high], 0.0, MAX_SCORE)
    outside, inside = log_likelihood(scores if intervals is None else intervals, values, noise, START_BLUNDERS).T
    return inside - outside


@dataclass(frozen=True)
class _Places:
    """Labels in the order of each of C columns, and the places for bounds between them."""

    values: Floats
    """[C, n] columns of the labels."""
    order: Ints
    """[C, n] ascending order."""
    low: Floats
    """[C, n - 1] smaller value at each place."""
    high: Floats
    """[C, n - 1] larger value."""
    log_prior: Singles
    """[C, n - 1] log-probability of a bound, equal parts of it by its range and by the number of labels."""

    @classmethod
    def of(cls, columns: Floats, priors: Floats) -> _Places:
        """The places of labels [n, C] in columns with priors [C]."""
        values = np.ascontiguousarray(columns.T)
        order = np.argsort(values, axis=1, kind="stable")
        ascending = np.take_along_axis(values, order, axis=1)
        gaps = np.diff(ascending, axis=1)
        shares = (gaps / np.ptp(values, axis=1, keepdims=True) + (gaps > 0.0) / gaps.shape[1]) / 2.0
        with np.errstate(divide="ignore"):
            log_prior = np.log(shares) + np.log(_NUM_FACES / (2.0 * _NUM_SLOTS) * priors / priors.sum())[:, None]
        return cls(values, order, ascending[:, :-1], ascending[:, 1:], log_prior.astype(np.float32))


_Faces = dict[tuple[int, bool], float]
"""Bounds by column and whether they are upper ones."""


def _drawn(places: _Places, gains: Singles, randomness: np.random.Generator) -> list[_Faces]:
    """Boxes of one chain."""
    chain, is_liked = _Chain(places, randomness), gains > 0.0
    balance = max(1.0, float(-gains[~is_liked].sum() / gains[is_liked].sum()))
    for step in range(_NUM_HEATED):
        heat = max(0.0, 1.0 - step / (_HEATED_SHARE * _NUM_HEATED))
        weighted = np.where(is_liked, gains * balance**heat, gains) / _TEMPERATURE**heat
        chain.step(weighted.astype(np.float32))
    boxes = list[_Faces]()
    for _ in range(NUM_CHAINS):
        for _ in range(_NUM_BETWEEN):
            chain.step(gains)
        boxes.append(dict(chain.faces))
    return boxes


class _Chain:
    def __init__(self, places: _Places, randomness: np.random.Generator) -> None:
        self.places, self.randomness = places, randomness
        self.slots: list[tuple[int, bool] | None] = [None] * _NUM_SLOTS
        """Column of each face and whether it is an upper bound."""
        self.faces: _Faces = {}
        self.outside: dict[tuple[int, bool], Flags] = {}
        """[n] labels outside of each face."""
        self.num_outside = np.zeros(places.values.shape[1], dtype=np.int64)
        """[n] number of faces that a label is outside of."""

    def step(self, gains: Singles) -> None:
        """Draw the face of a slot, or none, given the other faces."""
        slot = int(self.randomness.integers(_NUM_SLOTS))
        name = self.slots[slot]
        if name is not None:
            self.slots[slot] = None
            del self.faces[name]
            self.num_outside -= self.outside.pop(name)
        inside = np.where(self.num_outside == 0, gains, np.float32(0.0))
        below = np.cumsum(inside[self.places.order], axis=1, dtype=np.float32)
        total = below[:, -1:]
        log_odds = np.stack([total - below[:, :-1], below[:, :-1]]) + self.places.log_prior
        for column, is_upper in self.faces:
            log_odds[int(is_upper), column] = -np.inf
        highest = max(float(log_odds.max()), float(total[0, 0]))
        odds = np.exp(log_odds - np.float32(highest)).reshape(-1, log_odds.shape[2])
        by_face = np.cumsum(odds.sum(axis=1, dtype=np.float64))
        none = np.exp(float(total[0, 0]) - highest)
        drawn = self.randomness.random() * (by_face[-1] + none)
        if drawn < by_face[-1]:
            self.slots[slot] = self._added(int(np.searchsorted(by_face, drawn, side="right")), odds)

    def _added(self, row: int, odds: Singles) -> tuple[int, bool]:
        """Add a face at a place drawn by the odds [2 C, places] of its row."""
        within = np.cumsum(odds[row], dtype=np.float64)
        place = int(np.searchsorted(within, self.randomness.random() * within[-1], side="right"))
        is_upper, column = divmod(row, len(self.places.values))
        low, high = float(self.places.low[column, place]), float(self.places.high[column, place])
        # Labels equal to a bound are below it.
        bound = min(low + self.randomness.random() * (high - low), float(np.nextafter(high, low)))
        above = self.places.values[column] > bound
        name = column, bool(is_upper)
        self.faces[name], self.outside[name] = bound, above if is_upper else ~above
        self.num_outside += self.outside[name]
        return name
