"""Simplification of a learned preference to a function of few features, from which a grammar can be made.

Predictions of the pool become regression trees, from the simplest one whose density is within `TOLERANCE` of the
predicted one to one that follows it closely. Leaves with nearly equal scores are merged to few levels, and small
scores are set to 0, within the tolerance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.learning.designs.design_space import Designs
from grammarlab.learning.round import State, Study
from grammarlab.learning.targets.divergence import agreement
from grammarlab.learning.targets.explanation import Words, words_of
from grammarlab.learning.targets.unknown_part import are_equal, knowledge_of, voices_of
from grammarlab.preference.base import MAX_SCORE, SCORE_STEP, AbstractPreference, Relevance
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.held_out_share import NUM_FOLDS
from grammarlab.preference.regression_tree import MAX_CODES, Split, grow, leaves_of, means_of, round_between
from grammarlab.preference.simplified import SimplifiedPreference, drawn_to_levels

TOLERANCE = 0.005
"""Largest divergence in nats from the predictions, on the pool, for fewer rules and rounder numbers."""
_TREE_TOLERANCE = 0.004
"""Part of `TOLERANCE` for the tree, in nats."""
REST = TOLERANCE - _TREE_TOLERANCE
"""The rest of it, for fewer levels or branches."""
NEGLIGIBLE_JS = 2e-4
"""Divergence in nats that rounder numbers are always worth; a tree this near needs no more leaves."""
_SIZE_RATIOS = (1.0, 1.25, 1.6, 2.0, 3.0)
"""Ratios of the leaves of further candidates to the leaves of the smallest tree that is near enough."""
SMALL_SHARES = (0.02, 0.005, 0.001)
"""Candidates for what may be left out, largest first: moves of a bound to be rounder, as shares of the range of a
quantity, and probabilities of branches."""
MIN_LEAF = 60
"""Smallest number of designs of a pool in each leaf of a tree that says that nothing there is liked."""


@dataclass(frozen=True)
class SimplifiedFactor:
    """One liked factor of a preference."""

    name: str
    num_labels: int
    relevances: tuple[Relevance, ...]
    """Relevance of the groups of columns, in the order of their numbers."""
    predicted: Floats
    """[m] score of each design of the pool, 0 to 100."""
    unexplained: float = 0.0
    """Share of the original that is kept because no pattern is known yet, 0 to 1."""
    explained: float | None = None
    """Share of the variance of held-out scores that is explained, 0 to 1; None if no scores were held out."""
    num_comparisons: int = 0
    """How many of the labels compare two designs."""
    are_equal: bool = False
    """Whether all labels are scores, and these are equal."""


@dataclass(frozen=True)
class Predicted:
    """Predictions for the designs of a pool."""

    factors: tuple[SimplifiedFactor, ...]
    scores: Floats
    """[m] all factors together, 0 to 100, at least one above 0."""
    shares: Floats
    """[F] relevance of each column of the table to the preference."""
    words: Words
    """The predictions in words."""
    findings: tuple[str, ...] = ()
    """Remarks for the user about them."""


@dataclass(frozen=True)
class Simplified:
    """A simple function of the columns, and its distance from the predictions."""

    preference: SimplifiedPreference
    js: float
    """Divergence in nats, on the pool."""


def predict(study: Study[Designs], state: State) -> Predicted:
    """Predictions of a state for the pool.

    Args:
        study: the pool and its tables.
        state: a state in which something is liked.
    """
    table, pool_designs = study.table(state), study.tables(state.wide).pool_designs
    pool, possible = table.rows[: len(pool_designs.pool)], pool_designs.weights > 0.0
    factors = tuple(
        _factor(
            state.answers[name].factor,
            len(state.answers[name].scores),
            len(state.answers[name].scores) - len(state.answers[name].scored.scores),
            state.preferences[name],
            are_equal(state, name),
            [study.space.display_names.text(group) for group in table.group_names],
            pool,
        )
        for name in state.liked
    )
    shares = np.max([[entry.share for entry in factor.relevances] for factor in factors], axis=0)[table.groups]
    scores = product([factor.predicted for factor in factors])
    if scores[possible].any():
        is_relative = all(factor.num_comparisons == factor.num_labels for factor in factors)
        # Comparisons leave open how high scores are.
        described = scores * (MAX_SCORE / scores[possible].max()) if is_relative else scores
        addresses, display = study.tables(state.wide).addresses, study.space.display_names
        words = words_of(table, described, pool_designs.weights, addresses, display)
        knowledge = knowledge_of(study, state, bool(words.likes or words.dislikes))
        words = replace(words, knowledge=knowledge, voices=tuple(voices_of(state).values()))
        return Predicted(factors, scores, shares, words)
    ranks = np.prod([_above_the_lowest(state.preferences[name], pool) for name in state.liked], axis=0)
    finding = (
        "none of the models of the pool is predicted to be liked, so only the order of the predictions is used: score "
        "more models like those that you like"
    )
    scores = ranks if ranks[possible].any() else np.ones(len(pool))
    return Predicted(factors, scores, shares, Words((), ()), (finding,))


def product(scores: Sequence[Floats]) -> Floats:
    """[n] of factors one score, 0 to 100."""
    return MAX_SCORE * np.prod(np.minimum(np.array(scores), MAX_SCORE) / MAX_SCORE, axis=0)


def simpler(rows: Floats, scores: Floats, weights: Floats, columns: Ints, max_leaves: int) -> Iterator[Simplified]:
    """Simple functions near the scores, beginning with the smallest one within the tolerance.

    If there is none, only the smallest one at most `TOLERANCE` farther than the nearest tree. Trees grow on two
    thirds of the designs, and are measured on the others, since a large tree overfits.

    Args:
        rows: [n, F] rows of the designs of a pool, in the units of the features.
        scores: [n] >= 0, at least one positive together with its weight.
        weights: [n] >= 0, importance weight of each design.
        columns: [C] candidate columns, most preferred first.
        max_leaves: largest number of leaves of a tree.
    """
    path = _Path.grown(rows, scores, weights, columns, max_leaves)
    if not path.smallest:
        yield path.nearly_nearest()
        return
    last = 0
    for size in dict.fromkeys(min(int(path.smallest * factor), len(path.js)) for factor in _SIZE_RATIOS):
        if last and path.js[last - 1] < NEGLIGIBLE_JS:
            break
        yield from path.drawn(size)
        last = size


def smallest(rows: Floats, scores: Floats, weights: Floats, columns: Ints, max_leaves: int) -> Simplified:
    """The smallest function within `TOLERANCE`; if there is none, at most so much farther than the nearest tree.

    Args:
        rows: [n, F] rows of the designs of a pool; this and the others as in `simpler`.
        scores: [n].
        weights: [n].
        columns: [C].
        max_leaves: largest number of leaves of a tree.
    """
    return _Path.grown(rows, scores, weights, columns, max_leaves).nearly_nearest()


def simplified(rows: Floats, scores: Floats, weights: Floats, tree: Sequence[Split]) -> Simplified:
    """The function with the splits of a given tree and the mean scores of its leaves, in round numbers.

    Args:
        rows: [n, F] rows of the designs of a pool; this and the others as in `simpler`.
        scores: [n].
        weights: [n].
        tree: splits of the rows.
    """
    path = _Path(rows, scores, weights, tuple(tree), ())
    exact = path.preference(len(tree) + 1)
    return path.rounded(exact, max(_TREE_TOLERANCE, path.distance(exact) + REST))


@dataclass(frozen=True)
class _Path:
    """A tree and the measured divergences of its prefixes."""

    rows: Floats
    scores: Floats
    weights: Floats
    tree: tuple[Split, ...]
    js: tuple[float, ...]
    """Divergence of the trees of 1, 2, … leaves on designs that they did not grow on."""

    @classmethod
    def grown(cls, rows: Floats, scores: Floats, weights: Floats, columns: Ints, max_leaves: int) -> _Path:
        held_out = np.arange(len(rows)) % NUM_FOLDS == 0
        if not (weights * scores)[held_out].any() or not (weights * scores)[~held_out].any():
            held_out[:] = True
        is_training = ~held_out if not held_out.all() else held_out
        tree = grow(rows[is_training], scores[is_training], weights[is_training], columns, max_leaves)
        js: list[float] = []
        for size in range(1, len(tree) + 2):
            leaf = leaves_of(tree[: size - 1], rows)
            means = means_of(leaf[is_training], size, scores[is_training], weights[is_training])[leaf]
            js.append(agreement(scores[held_out], means[held_out], weights[held_out]).js)
            if js[-1] < NEGLIGIBLE_JS:
                break
        return cls(rows, scores, weights, tree, tuple(js))

    @property
    def smallest(self) -> int:
        """Number of leaves of the smallest tree that is near enough; 0 if none is."""
        return next((size for size, js in enumerate(self.js, 1) if js <= _TREE_TOLERANCE), 0)

    def preference(self, size: int) -> SimplifiedPreference:
        """The tree with a number of leaves."""
        tree = self.tree[: size - 1]
        leaf = leaves_of(tree, self.rows)
        return SimplifiedPreference(tree, means_of(leaf, size, self.scores, self.weights))

    def nearly_nearest(self) -> Simplified:
        """The smallest tree within `TOLERANCE`; if there is none, at most so much farther than the nearest one."""
        size = 1 + int(np.argmin(self.js))
        nearest_tree = self.preference(size)
        nearest = self.distance(nearest_tree)
        limit = max(_TREE_TOLERANCE, nearest) if nearest <= TOLERANCE else nearest + _TREE_TOLERANCE
        exact = next(
            (tree for tree in map(self.preference, range(1, size)) if self.distance(tree) <= limit), nearest_tree
        )
        return self.rounded(exact, limit if nearest <= TOLERANCE else limit + REST)

    def simplified(self, preference: SimplifiedPreference) -> Simplified:
        return Simplified(preference.pruned(), self.distance(preference))

    def distance(self, preference: SimplifiedPreference) -> float:
        return agreement(self.scores, preference(self.rows), self.weights).js

    def drawn(self, size: int) -> Iterator[Simplified]:
        """The tree with a number of leaves: with as few levels as possible, and nearly unchanged."""
        exact = self.preference(size)
        exact_js = self.distance(exact)
        for bound in (_TREE_TOLERANCE, exact_js + NEGLIGIBLE_JS):
            yield self.simplified(self._round(self._drawn(exact, max(bound, exact_js)), max(_TREE_TOLERANCE, exact_js)))

    def rounded(self, exact: SimplifiedPreference, bound: float) -> Simplified:
        """A tree with as few levels and as round bounds as possible within a divergence."""
        return self.simplified(self._round(self._drawn(exact, bound), bound))

    def _round(self, preference: SimplifiedPreference, bound: float) -> SimplifiedPreference:
        """The same with rounder bounds that hardly change the density."""
        most = min(bound, self.distance(preference) + NEGLIGIBLE_JS)
        for number, split in enumerate(preference.tree):
            values = self.rows[:, split.column]
            if len(np.unique(values)) <= MAX_CODES:
                continue
            for part in SMALL_SHARES:
                about = part * float(np.ptp(values))
                near = split._replace(bound=round_between(split.bound - about, split.bound + about))
                moved = replace(preference, tree=(*preference.tree[:number], near, *preference.tree[number + 1 :]))
                if self.distance(moved) <= most:
                    preference = moved
                    break
        return preference

    def _drawn(self, exact: SimplifiedPreference, bound: float) -> SimplifiedPreference:
        """A tree with as few levels as possible within a divergence."""
        leaf = leaves_of(exact.tree, self.rows)
        masses = np.bincount(leaf, self.weights, len(exact.scores)).astype(np.float64)
        low, high = 1, len(exact.levels)
        while low < high:
            middle = (low + high) // 2
            near = self.distance(replace(exact, scores=drawn_to_levels(exact.scores, masses, middle))) <= bound
            low, high = (low, middle) if near else (middle + 1, high)
        few = replace(exact, scores=drawn_to_levels(exact.scores, masses, low))
        # Nobody means a difference as small as that of the first ones, so a file needs no rare branches for it.
        is_negligible = few.scores < few.scores.max() * SCORE_STEP / MAX_SCORE
        for is_disliked, most in (
            (is_negligible, max(bound, _TREE_TOLERANCE)),
            (few.scores == few.scores.min(), bound),
        ):
            none = replace(few, scores=np.where(is_disliked, 0.0, few.scores))
            if none.scores.any() and self.distance(none) <= most:
                few = none
        return few


def _factor(
    name: str,
    num_labels: int,
    num_comparisons: int,
    preference: AbstractPreference,
    is_equal: bool,
    group_names: Sequence[str],
    pool: Floats,
) -> SimplifiedFactor:
    predicted = np.clip(preference.predict(pool).mean, 0.0, MAX_SCORE)
    numbers = [str(number) for number in range(len(group_names))]
    shares = {int(relevance.name): relevance for relevance in preference.explain(numbers)}
    relevances = tuple(replace(shares[number], name=name) for number, name in enumerate(group_names))
    factor = SimplifiedFactor(
        name=name,
        num_labels=num_labels,
        relevances=relevances,
        predicted=predicted,
        num_comparisons=num_comparisons,
        are_equal=is_equal,
    )
    if not isinstance(preference, BlendedPreference):
        return factor
    return replace(factor, unexplained=preference.unexplained, explained=preference.explained_variance)


def _above_the_lowest(preference: AbstractPreference, pool: Floats) -> Floats:
    mean = preference.predict(pool).mean
    return mean - mean.min()
