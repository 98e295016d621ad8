"""Learning from the scores of a session, and choice of models, in a worker process."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, cast

import numpy as np
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats
from grammarlab.asset_roots import AssetRoot
from grammarlab.learning.answers import Answers, answers_for
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.fitting import fit
from grammarlab.learning.interview import next_factor
from grammarlab.learning.questions import ask, ask_pairs
from grammarlab.learning.round import State, Study, answered, init, needs_wide, step
from grammarlab.learning.stopping import NUM_MORE, expected_gain
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.learning.targets.explanation import words_of
from grammarlab.learning.targets.unknown_part import is_explained, knowledge_of
from grammarlab.pages.record.judgements import Judgement
from grammarlab.pages.record.label_exchange import labels_of
from grammarlab.pages.record.model_grids import PAIRS
from grammarlab.pages.workers.tasks import (
    NUM_FITS,
    Choose,
    Contrast,
    Factors,
    Features,
    LearnedUpdate,
    ModelChoice,
    Predictions,
    Prepare,
    Update,
)
from grammarlab.pages.workers.worker_pool import Handler, Report
from grammarlab.preference.base import MAX_SCORE, AbstractPreference
from grammarlab.preference.factors import ProductPreference
from grammarlab.preference.queries import Way
from grammarlab.runs.sample.domains import opened

WARM_UP = 32
"""Number of models of the warm-up fit: those of two 4x4 grids."""
MOST_RELEVANCES = 8
"""Number of most relevant entries."""


def learner(suffix: str, text: str, name: str, assets: AssetRoot, seed: int, size: int, wide: bool) -> Handler:
    """Worker for `Prepare`, `Update` and `Choose` tasks of a session.

    Args:
        suffix: suffix of the file that describes the models.
        text: text of that file.
        name: name of that file, without its suffix.
        assets: folder of meshes and images.
        seed: seed of the session.
        size: size of the pool, before it is widened.
        wide: whether the pool has been widened for rare models.
    """
    return _LastUpdate(Study(opened(suffix, text, name, assets), Pool(seed, size, wide))).do


_InOrder = tuple[tuple[str, tuple[tuple[str, Judgement], ...]], ...]


def _in_order(factors: Factors) -> _InOrder:
    """Scores by factor and subject, in the order in which they were given, which says whether a taste has changed."""
    return tuple((name, tuple(scores.items())) for name, scores in factors.items())


class _LastUpdate:
    """Result of the last update."""

    def __init__(self, study: Study[Any]) -> None:
        self._study = study
        self._state = init(study)
        self._known: _InOrder = ()
        """Scores of the last update."""
        self._numbers: Mapping[str, int] = {}
        """Number of each factor at the last update; it stays when the factor is renamed."""
        # Different from the versions of an earlier process.
        self._version = secrets.randbits(48)
        self._number = self._version
        self._since: tuple[Floats, Floats] | None = None
        """[m] weights of the models of the pool from which changes are measured, and [m] predicted scores of them."""
        self._fits: dict[int, tuple[Floats, Floats]] = {}
        """The same of the last later updates, at most `NUM_FITS`, by number."""

    def do(self, request: Prepare | Update | Choose, report: Report) -> Any:
        # Predictions, as a step of learning, are of small matrices, and pictures are drawn meanwhile.
        with threadpool_limits(1, "blas"):
            return self._do(request, report)

    def _do(self, request: Prepare | Update | Choose, report: Report) -> Any:
        if isinstance(request, Prepare):
            return self._prepare(report)
        if isinstance(request, Update):
            return self._update(request, report)
        return self._choose(request, request.choice)

    def _prepare(self, report: Report) -> Features | None:
        self._study.tables(report=report)
        report(f"counting features of {len(self._study.pool):,} models", 0, 1)
        self._set_state(self._state, self._numbers)
        if not self._state.preferences:
            self._warm_up()
        return self._features(0)

    def _warm_up(self) -> None:
        """Fit a process to artificial scores, so that JAX compiles before the first update."""
        table = self._study.table(self._state)
        rows = table.rows[:WARM_UP]
        fit(rows, MAX_SCORE * (np.arange(len(rows)) % 2), groups=table.groups, method="grouped")

    def _update(self, request: Update, report: Report) -> LearnedUpdate:
        state = self._state if self._is_known(request) else self._learned(request, report)
        report("choosing models", 1, 1)
        # The state is consistent from here on.
        self._set_state(state, request.numbers)
        self._known = _in_order(request.factors)
        rows, product = self._study.table(state).rows, state.product
        predictions = {name: self._predictions(preference, rows) for name, preference in state.preferences.items()}
        liked = None if product is None else self._predictions(product, rows)
        chosen = None if request.choice is None else self._choose(request, request.choice)
        elsewhere = tuple(map(str, state.columns.elsewhere))
        divergence = 0.0 if request.choice is None else self._divergence(liked, request.since)
        left_out = _left_out(request.factors, state)
        (words, contrasts), gain = self._words(liked), expected_gain(self._study, state)
        features = self._features(request.known_version)
        return LearnedUpdate(
            features=features,
            wide=state.wide,
            elsewhere=elsewhere,
            factors=predictions,
            product=liked,
            left_out=left_out,
            js=divergence,
            chosen=chosen,
            words=words,
            contrasts=contrasts,
            is_explained=is_explained(state),
            gain=gain,
            turn=self._turn(tuple(request.factors)),
            number=self._number,
        )

    def _learned(self, request: Update, report: Report) -> State:
        # A pool that has been widened stays wide; it is widened only where new models are to be shown.
        start = replace(init(self._study), wide=self._state.wide or request.wide)
        answers = _answers(request.factors, self._study.space)
        return step(self._study, start, answers, report, widens=request.choice is not None)

    def _is_known(self, request: Update) -> bool:
        """Whether the last update learned from the same scores, and the same pool serves."""
        if (self._known, self._numbers) != (_in_order(request.factors), request.numbers):
            return False
        return self._state.wide or not (request.wide or (request.choice is not None and needs_wide(self._state)))

    def _turn(self, names: tuple[str, ...]) -> str:
        return names[next_factor(self._study, self._state, names, NUM_MORE)] if len(names) > 1 else ""

    def _words(self, product: Predictions | None) -> tuple[tuple[str, ...], tuple[Contrast, ...]]:
        """What is not known yet, and liked and disliked kinds, in words; and the choices of which these speak."""
        if product is None:
            return (), ()
        weights = self._study.tables(self._state.wide).pool_designs.weights
        scores = np.clip(product.mean[: len(weights)], 0.0, MAX_SCORE).astype(np.float64)
        addresses = self._study.tables(self._state.wide).addresses
        table, display = self._study.table(self._state), self._study.space.display_names
        words = words_of(table, scores, weights, addresses, display)
        contrasts = (
            Contrast(each.text, each.feature, tuple(map(str, each.examples)), each.without, each.having)
            for each in words.contrasts
        )
        knowledge = knowledge_of(self._study, self._state, bool(words.likes or words.dislikes))
        return (*knowledge, *words.lines), tuple(contrasts)

    def _set_state(self, state: State, numbers: Mapping[str, int]) -> None:
        self._version += (state.wide, state.columns) != (self._state.wide, self._state.columns)
        self._state, self._numbers = state, numbers

    def _features(self, known_version: int) -> Features | None:
        if self._version == known_version:
            return None
        table = self._study.table(self._state)
        return Features(self._version, table.rows.astype(np.float32), table.names)

    def _predictions(self, preference: AbstractPreference, rows: Floats) -> Predictions:
        prediction = preference.predict(rows)
        weights = _column_weights(preference)
        names = list(map(self._study.space.display_names.text, self._study.table(self._state).group_names))
        relevances = [entry for entry in preference.explain(names)[:MOST_RELEVANCES] if entry.level != "none"]
        return Predictions(
            prediction.mean.astype(np.float32),
            prediction.std.astype(np.float32),
            None if weights is None else weights.astype(np.float32),
            tuple((entry.name, entry.level, round(entry.share, 4)) for entry in relevances),
        )

    def _divergence(self, product: Predictions | None, since: int) -> float:
        """Divergence of the density from that of an earlier update; see `Update.since`.

        It is computed on the pool of that time.
        """
        weights = self._study.tables(self._state.wide).pool_designs.weights
        liking = np.ones(len(weights)) if product is None else np.maximum(product.mean[: len(weights)], 0.0)
        if since in self._fits:
            self._since = self._fits[since]
            self._fits.clear()
        self._number += 1
        self._fits[self._number] = weights, liking
        if len(self._fits) > NUM_FITS:
            del self._fits[min(self._fits)]
        previous_weights, previous_liking = self._since or (weights, np.ones(len(weights)))
        return jensen_shannon(
            _density(previous_weights, previous_liking), _density(previous_weights, liking[: len(previous_weights)])
        )

    def _choose(self, request: Update | Choose, choice: ModelChoice) -> tuple[str, ...]:
        state = _with_names(self._state, self._numbers, request.numbers)
        state = answered(replace(state, answers={}), _answers(request.factors, self._study.space))
        if choice.way == PAIRS:
            pairs = ask_pairs(self._study, state, choice.num // 2, choice.seed, factor=choice.factor)
            return tuple(str(address) for pair in pairs for address in pair)
        # One of the ways: the session checks it before it is sent here.
        way = cast("Way", choice.way)
        without = tuple(map(Address.parse, choice.without))
        chosen = ask(self._study, state, choice.num, choice.seed, factor=choice.factor, way=way, without=without)
        return tuple(map(str, chosen))


def _answers(factors: Factors, space: AbstractDesignSpace[Any]) -> tuple[Answers, ...]:
    # In the form of label files, so that learning from these is the same.
    labels = labels_of(factors, space.hashes[0])
    return tuple(answers_for(factor, labels, space.hashes) for factor in labels.factors)


def _with_names(state: State, before: Mapping[str, int], now: Mapping[str, int]) -> State:
    """The state with the current names of its factors; their numbers do not change."""
    names = {number: name for name, number in now.items()}
    new = {name: names.get(number, name) for name, number in before.items()}
    preferences = {new[name]: preference for name, preference in state.preferences.items()}
    return replace(state, preferences=preferences, liked=tuple(new[name] for name in state.liked))


def _density(weights: Floats, liking: Floats) -> Floats:
    """[m] unnormalized probability of each model; that of the grammar if no model is liked."""
    density = weights * liking
    return density if density.any() else weights


def _left_out(factors: Factors, state: State) -> tuple[str, ...]:
    """Reasons why factors are not part of the product."""
    reasons = []
    for name, scores in factors.items():
        if name not in state.liked and len(factors) > 1:
            why = "all its scores are 0" if scores else "it has no scores yet"
            why = (
                "its comparisons are all ties" if any(judgement.kind == "tie" for judgement in scores.values()) else why
            )
            reasons.append(f"Factor {name} is left out of the product: {why}.")
    if not state.liked:
        reasons.append("Nothing is liked yet: score at least one model above 0.")
    return tuple(reasons)


def _column_weights(preference: AbstractPreference) -> Floats | None:
    """[F] weights of the kernel; for a product, the sum over its factors."""
    if isinstance(preference, ProductPreference):
        parts = [_column_weights(factor) for factor in preference.factors.values()]
        weights = [part for part in parts if part is not None]
        return np.sum(weights, axis=0) if weights else None
    return preference.column_weights()
