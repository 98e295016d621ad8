"""A learned preference as a function of few features: what a grammar can be made of.

Predictions of the pool become regression trees, from the simplest one whose density is as near to the predicted one as
`TOLERANCE` says to one that follows it closely. Leaves with nearly the same score are drawn to few levels, and small
scores to 0, as far as the tolerance lets them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.learning.designs.design_space import Designs
from grammarlab.learning.designs.tables import DesignTable
from grammarlab.learning.round import State, Study
from grammarlab.learning.targets.agreement import agreement
from grammarlab.learning.targets.words import Words, words_of
from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Relevance
from grammarlab.preference.simple.levels import drawn_to_levels
from grammarlab.preference.simple.pruning import needed_columns
from grammarlab.preference.simple.regression_tree import Split, grow, leaves_of, means_of, round_between
from grammarlab.preference.simple.simplified import SimplifiedPreference

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TOLERANCE = 0.005
"""Nats of divergence from the predictions, on the pool, that fewer rules and rounder numbers may cost."""
_OF_THE_TREE = 0.004
"""What of it the tree may use; the rest is for rounding."""
_CLOSE = 1e-6
"""Nats: a tree that comes nearer need not grow."""
_SIZES = (1.0, 1.25, 1.6, 2.0, 3.0)
"""How many times as many leaves as the smallest tree that is near enough are tried as well."""
_HARDLY = 1e-5
"""Nats that nobody notices: values that differ by nothing but rounding are the same."""
_AS_NEAR = 1.05
"""Times the least divergence: larger trees that are as near to other designs are nearer to those that they grew on."""
_MOVED = 2e-4
"""Nats that rounder bounds may cost."""
_PARTS = (0.02, 0.005, 0.001)
"""Of the range of a quantity: how far a bound may move to be rounder, the farthest first."""
_HELD_OUT = 3
"""One design in 3 tells how near a tree is that grew on the others."""
_LEVELS = 12
"""Of scores, to see which columns tell them apart."""
_LEFT = 5e-4
"""Columns are left out as long as they move no more than this part of what is liked."""
_MOST_VALUES = 128
"""A column with more different values tells all designs of a pool apart, and so nothing about levels."""


@dataclass(frozen=True)
class SimplifiedFactor:
    """One liked factor of a preference."""

    name: str
    num_labels: int
    relevances: tuple[Relevance, ...]
    """Of the groups of columns, in the order of their numbers."""
    predicted: Floats
    """[m] score of each design of the pool, 0 to 100."""


@dataclass(frozen=True)
class Predicted:
    """What is expected of the designs of a pool."""

    factors: tuple[SimplifiedFactor, ...]
    scores: Floats
    """[m] all factors together, 0 to 100, one at least above 0."""
    shares: Floats
    """[F] how much the preference looks at each column of the table."""
    words: Words
    """What they say."""
    findings: tuple[str, ...] = ()
    """What a person should know about them."""


@dataclass(frozen=True)
class Simplified:
    """A simple function of the columns, and how far it is from what was predicted."""

    preference: SimplifiedPreference
    js: float
    """Nats, on the pool."""


def predict(study: Study[Designs], state: State) -> Predicted:
    """The predictions of a state for the pool.

    Args:
        study: the pool and its tables.
        state: what was learned; something is liked.
    """
    table, made = study.table(state), study.tables(state.wide).made
    pool, possible = table.rows[: len(made.pool)], made.weights > 0.0
    factors = tuple(
        _factor(state.answers[name].factor, len(state.answers[name].scores), state.preferences[name], table, pool)
        for name in state.liked
    )
    shares = np.max([[entry.share for entry in factor.relevances] for factor in factors], axis=0)[table.groups]
    scores = product([factor.predicted for factor in factors])
    if scores[possible].any():
        return Predicted(factors, scores, shares, words_of(table, scores, made.weights))
    ranks = np.prod([_above_the_lowest(state.preferences[name], pool) for name in state.liked], axis=0)
    finding = (
        "none of the models looked at is predicted to be liked, so the order of the predictions counts alone: score "
        "more models like those that you like"
    )
    scores = ranks if ranks[possible].any() else np.ones(len(pool))
    return Predicted(factors, scores, shares, Words((), ()), (finding,))


def product(scores: Sequence[Floats]) -> Floats:
    """[n] of factors one score, 0 to 100."""
    return MAX_SCORE * np.prod(np.minimum(np.array(scores), MAX_SCORE) / MAX_SCORE, axis=0)


def simpler(rows: Floats, scores: Floats, weights: Floats, columns: Ints, max_leaves: int) -> Iterator[Simplified]:
    """Simple functions that come near some scores: the smallest first that is as near as the tolerance asks.

    Where none is, the nearest alone. Trees grow on two thirds of the designs, and the others tell how near they are: a
    tree of many questions may know designs by heart.

    Args:
        rows: [n, F] of the designs of a pool, in the units of the features.
        scores: [n] >= 0, one at least positive together with its weight.
        weights: [n] >= 0, what each design stands for.
        columns: [C] that may be asked about, the most wanted first.
        max_leaves: of a tree.
    """
    paths = [
        _Path.grown(rows, scores, weights, some, max_leaves) for some in _column_sets(rows, scores, weights, columns)
    ]
    near = [path for path in paths if path.smallest]
    if not near:
        nearest = min(paths, key=lambda path: min(path.js))
        size = int(np.flatnonzero(np.array(nearest.js) <= _AS_NEAR * min(nearest.js))[-1]) + 1
        yield nearest.simplified(nearest.preference(size))
        return
    for path in near:
        last = 0
        for size in dict.fromkeys(min(int(path.smallest * factor), len(path.js)) for factor in _SIZES):
            if last and path.js[last - 1] < _CLOSE:
                break
            yield from path.drawn(size)
            last = size


def _column_sets(rows: Floats, scores: Floats, weights: Floats, columns: Ints) -> list[Ints]:
    """Columns to grow trees on: the few that tell levels of the scores apart, if only together, and all."""
    levels = drawn_to_levels(scores, weights, _LEVELS)
    counts = columns[[len(np.unique(rows[:, column])) <= _MOST_VALUES for column in columns.tolist()]]
    needed = needed_columns(rows, levels, weights, counts, _LEFT)
    return [needed, columns] if 0 < len(needed) < len(columns) else [columns]


@dataclass(frozen=True)
class _Path:
    """A tree and what its beginnings are like."""

    rows: Floats
    scores: Floats
    weights: Floats
    tree: tuple[Split, ...]
    js: tuple[float, ...]
    """Divergence of the trees of 1, 2, … leaves on designs that they did not grow on."""

    @classmethod
    def grown(cls, rows: Floats, scores: Floats, weights: Floats, columns: Ints, max_leaves: int) -> _Path:
        held_out = np.arange(len(rows)) % _HELD_OUT == 0
        if not (weights * scores)[held_out].any() or not (weights * scores)[~held_out].any():
            held_out[:] = True
        own = ~held_out if not held_out.all() else held_out
        tree = grow(rows[own], scores[own], weights[own], columns, max_leaves)
        js: list[float] = []
        for size in range(1, len(tree) + 2):
            leaf = leaves_of(tree[: size - 1], rows)
            means = means_of(leaf[own], size, scores[own], weights[own])[leaf]
            js.append(agreement(scores[held_out], means[held_out], weights[held_out]).js)
            if js[-1] < _CLOSE:
                break
        return cls(rows, scores, weights, tree, tuple(js))

    @property
    def smallest(self) -> int:
        """Leaves of the smallest tree that is near enough; 0 where none is."""
        return next((size for size, js in enumerate(self.js, 1) if js <= _OF_THE_TREE), 0)

    def preference(self, size: int) -> SimplifiedPreference:
        """The tree of so many leaves."""
        tree = self.tree[: size - 1]
        leaf = leaves_of(tree, self.rows)
        return SimplifiedPreference(tree, means_of(leaf, size, self.scores, self.weights))

    def simplified(self, preference: SimplifiedPreference) -> Simplified:
        return Simplified(preference.pruned(), self.distance(preference))

    def distance(self, preference: SimplifiedPreference) -> float:
        return agreement(self.scores, preference(self.rows), self.weights).js

    def drawn(self, size: int) -> Iterator[Simplified]:
        """The tree of so many leaves: with as few levels as may be, and nearly as it is."""
        exact = self.preference(size)
        own = self.distance(exact)
        for bound in (_OF_THE_TREE, own + _HARDLY):
            yield self.simplified(self._round(self._drawn(exact, max(bound, own)), max(_OF_THE_TREE, own)))

    def _round(self, preference: SimplifiedPreference, bound: float) -> SimplifiedPreference:
        """The same with rounder bounds, as far as they hardly move the density."""
        most = min(bound, self.distance(preference) + _MOVED)
        for number, split in enumerate(preference.tree):
            values = self.rows[:, split.column]
            if len(np.unique(values)) <= _MOST_VALUES:
                continue
            for part in _PARTS:
                about = part * float(np.ptp(values))
                near = split._replace(bound=round_between(split.bound - about, split.bound + about))
                moved = replace(preference, tree=(*preference.tree[:number], near, *preference.tree[number + 1 :]))
                if self.distance(moved) <= most:
                    preference = moved
                    break
        return preference

    def _drawn(self, exact: SimplifiedPreference, bound: float) -> SimplifiedPreference:
        """A tree with as few levels as may be within a divergence."""
        leaf = leaves_of(exact.tree, self.rows)
        masses = np.bincount(leaf, self.weights, len(exact.scores)).astype(np.float64)
        low, high = 1, len(exact.levels)
        while low < high:
            middle = (low + high) // 2
            near = self.distance(replace(exact, scores=drawn_to_levels(exact.scores, masses, middle))) <= bound
            low, high = (low, middle) if near else (middle + 1, high)
        few = replace(exact, scores=drawn_to_levels(exact.scores, masses, low))
        none = replace(few, scores=np.where(few.scores == few.scores.min(), 0.0, few.scores))
        return none if none.scores.any() and self.distance(none) <= bound else few


def _factor(
    name: str, num_labels: int, preference: AbstractPreference, table: DesignTable, pool: Floats
) -> SimplifiedFactor:
    predicted = np.clip(preference.predict(pool).mean, 0.0, MAX_SCORE)
    numbers = [str(number) for number in range(len(table.group_names))]
    shares = {int(found.name): found for found in preference.explain(numbers)}
    relevances = tuple(replace(shares[number], name=name) for number, name in enumerate(table.group_names))
    return SimplifiedFactor(name, num_labels, relevances, predicted)


def _above_the_lowest(preference: AbstractPreference, pool: Floats) -> Floats:
    mean = preference.predict(pool).mean
    return mean - mean.min()
