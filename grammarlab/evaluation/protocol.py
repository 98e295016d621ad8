"""The simulated person: scores model after model, while the learned density is compared with the wanted one.

This is the protocol of section 4.7 of the paper, as an `init` and a `step`. Its quantities:

- labelled set: n models (5,000 in the paper's protocol) drawn independently from the grammar with density p at a fixed
  seed, repeats kept, each with its true score u_i = product of the factors' scores / 100. Nobody is asked about them.
- pool: m other models, which the query rule chooses from; a model is asked about at most once a factor.
- label: one true score (0-100) of one model for one factor. With several factors, a label for each counts.
- round: `Learner.batch` models for one factor; rounds take the factors in turn. Scores are exact.
- learned preference û_i: the product over factors of the predicted mean / 100, what is below 0 taken as 0; a factor
  without labels counts as 1.
- target weights p*_i = w_i u_i / sum_j w_j u_j and learned weights q_i = w_i û_i / sum_j w_j û_j, where w_i = 1 for
  ``base="grammar"`` (target density proportional to p u), 1 / p_i for ``base="uniform"`` (proportional to u).
  Where û is 0 everywhere, q_i = w_i / sum_j w_j.
- JS = H((p* + q) / 2) - H(p*) / 2 - H(q) / 2 in nats, 0 to ln 2; "original" is that of û = 1.
- path length k: features are counted for paths of up to k edges. A learner that may grow them adds one edge, up to
  `MAX_PATH_LENGTH`, whenever models with equal rows got different scores, and fits again.
- wide pool: a learner that is offered it gets many more models of the flattened grammar to ask about once liked models
  have turned out to be rare (`grammarlab.preference.queries.liked_are_rare`); so does a person in a scoring session.
- extra features: what `Learner.search` finds in the labelled derivations after each round. Where there are bounds on
  continuous draws among them, half of a round goes to models near them (`bounds.between`).

All randomness comes from one seed: the choice of models and the restarts of a fit in round r for factor f draw from
keys of (seed, r, f). So equal arguments give equal curves, and a curve for fewer labels is the beginning of a longer
one, except that the last batch may be cut short.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest
from grammarlab.evaluation.agreement import agreement
from grammarlab.evaluation.bounds import between
from grammarlab.evaluation.curves import Curve, Point
from grammarlab.evaluation.material import Columns, Material, Table
from grammarlab.evaluation.scenario import MAX_PATH_LENGTH
from grammarlab.evaluation.seeds import derived_seed
from grammarlab.features.growth import conflicts
from grammarlab.features.pattern import Feature
from grammarlab.preference.base import MAX_SCORE, AbstractPreference
from grammarlab.preference.factors import ProductPreference
from grammarlab.preference.queries import Situation, liked_are_rare

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Learner:
    """How to learn: the parts that methods differ in."""

    fit: Callable[[Floats, Floats, Ints, int, AbstractPreference | None], AbstractPreference]
    """Rows [n, F], scores [n], groups [F], a seed and the preference of the round before give a preference."""
    propose: Callable[[Situation, int, int], Ints]
    """A situation, a number of models and a seed give as many different pool indices, none of which was asked about."""
    batch: int = 8
    """Models a round, >= 1."""
    path_length: int = 2
    """Edges of the longest paths to begin with, >= 1."""
    grows: bool = True
    """Whether longer paths are taken in when models with equal rows got different scores."""
    search: Callable[[tuple[Forest, ...], Floats], tuple[Feature, ...]] | None = None
    """The derivations of all labelled models and their scores give features to look at besides; None for none."""
    widens: bool = False
    """Whether it is offered a wider pool where liked models are rare (`grammarlab.preference.queries`)."""


@dataclass(frozen=True, slots=True)
class FactorState:
    """What is known about one factor."""

    asked: Ints
    """[n] pool indices, in order."""
    scores: Floats
    """[n] what the person said, 0 to 100."""
    preference: AbstractPreference | None
    """None before the first label."""
    extra: tuple[Feature, ...] = ()
    """What was searched for and found to explain its scores."""


@dataclass(frozen=True, slots=True)
class State:
    """A simulated person between two rounds."""

    factors: tuple[FactorState, ...]
    rounds: int
    """Rounds done."""
    columns: Columns
    wide: bool = False
    """Whether it is offered a wider pool."""

    @property
    def labels(self) -> int:
        """Scores given so far, all factors together."""
        return sum(len(factor.asked) for factor in self.factors)


def init(material: Material, learner: Learner) -> State:
    """A person before the first round."""
    empty = FactorState(np.zeros(0, np.int64), np.zeros(0), None)
    return State((empty,) * len(material.factors), 0, Columns(learner.path_length))


def step(material: Material, learner: Learner, seed: int, num_labels: int, state: State) -> tuple[State, Point]:
    """One round: choose models, score them, fit, compare.

    Args:
        material: the models.
        learner: how to choose and fit.
        seed: of the whole curve, the same in every round; 0 <= seed < 2**64.
        num_labels: scores to give in this round, >= 1; fewer when the pool has no more.
        state: after the round before.

    Returns:
        The state after the round, and its point of the curve.
    """
    offered = _offered(material, state.wide)
    active = state.rounds % len(state.factors)
    choose_seed, fit_seed = (derived_seed(seed, state.rounds, active, lane) for lane in (0, 1))
    factor = _answer(offered, learner, state.columns, state.factors[active], active, num_labels, choose_seed)
    factor = _searched(offered, learner, factor)
    factors = (*state.factors[:active], factor, *state.factors[active + 1 :])
    wide = state.wide or (learner.widens and material.wider is not None and liked_are_rare(factor.scores))
    known = _offered(material, wide)
    columns = _columns(known, learner, factors, state.columns.path_length)
    changed = (columns, wide) != (state.columns, state.wide)
    again = [index == active or changed for index in range(len(factors))]
    before, table = offered.table(state.columns), known.table(columns)
    if wide != state.wide or not np.array_equal(before.groups, table.groups):
        # What was learned about other columns does not carry over.
        factors = tuple(replace(f, preference=None) for f in factors)
    factors = tuple(
        _fit(learner, table, f, fit_seed) if fit_it and len(f.asked) else f
        for f, fit_it in zip(factors, again, strict=True)
    )
    state = State(factors, state.rounds + 1, columns, wide)
    js, correlation = agreement(material.target, learned(material, state), material.weights)
    liked = sum(int((f.scores > 0).sum()) for f in factors)
    return state, Point(state.labels, js, correlation, liked)


def run(material: Material, learner: Learner, seed: int, max_labels: int) -> tuple[State, Curve]:
    """All rounds up to a number of labels, or until the pool is used up.

    Args:
        material: the models.
        learner: how to choose and fit.
        seed: 0 <= seed < 2**64.
        max_labels: >= 1; the last round is cut to it.
    """
    state, points = init(material, learner), []
    while state.labels < min(max_labels, material.pool_scores.size):
        state, point = step(material, learner, seed, min(learner.batch, max_labels - state.labels), state)
        points.append(point)
    return state, Curve(tuple(points))


def learned(material: Material, state: State) -> Floats:
    """[n] the learned preference of the labelled set, >= 0: 1 everywhere before the first label."""
    rows = _offered(material, state.wide).table(state.columns).labelled
    known = {
        name: factor.preference
        for name, factor in zip(material.factors, state.factors, strict=True)
        if factor.preference is not None
    }
    if not known:
        return np.ones(len(rows))
    return np.clip(ProductPreference(known).predict(rows).mean, 0.0, None) / MAX_SCORE


def _offered(material: Material, wide: bool) -> Material:
    return material.wider() if wide and material.wider is not None else material


def _answer(
    material: Material,
    learner: Learner,
    columns: Columns,
    factor: FactorState,
    active: int,
    num_labels: int,
    seed: int,
) -> FactorState:
    """The factor with the scores of newly chosen models."""
    table = material.table(columns)
    num_labels = min(num_labels, len(table.pool) - len(factor.asked))
    near = [between(material.margins(b), factor.asked, num_labels // 2 // len(columns.bounds)) for b in columns.bounds]
    near = np.unique(np.concatenate([np.zeros(0, np.int64), *near]))
    known = Situation(
        table.pool,
        material.pool_from_grammar,
        factor.asked,
        factor.scores,
        factor.preference,
        material.pool_weights,
    )
    proposed = np.asarray(learner.propose(known, num_labels, seed), np.int64)
    chosen = np.concatenate([near, proposed[~np.isin(proposed, near)]])[:num_labels]
    asked = np.concatenate([factor.asked, chosen])
    if len(chosen) != num_labels or len(np.unique(asked)) != len(asked):
        raise ValueError(f"a query rule must give {num_labels} new models; it gave {proposed.tolist()}.")
    return replace(factor, asked=asked, scores=material.pool_scores[asked, active])


def _searched(material: Material, learner: Learner, factor: FactorState) -> FactorState:
    """The factor with the extra features that its labels ask for."""
    if learner.search is None or np.ptp(factor.scores) == 0:
        return factor
    return replace(factor, extra=learner.search(material.examples(factor.asked), factor.scores))


def _fit(learner: Learner, table: Table, factor: FactorState, seed: int) -> FactorState:
    rows = table.pool[factor.asked]
    return replace(factor, preference=learner.fit(rows, factor.scores, table.groups, seed, factor.preference))


def _columns(material: Material, learner: Learner, factors: tuple[FactorState, ...], length: int) -> Columns:
    """All extra features, and paths just long enough that no two models with equal rows have different scores."""
    extra = tuple(dict.fromkeys(feature for factor in factors for feature in factor.extra))
    columns = Columns(length, extra)
    while learner.grows and columns.path_length < MAX_PATH_LENGTH:
        pool = material.table(columns).pool
        if not any(len(conflicts(pool[factor.asked], factor.scores)) for factor in factors):
            break
        columns = replace(columns, path_length=columns.path_length + 1)
    return columns
