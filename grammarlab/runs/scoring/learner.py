"""Learns from the scores of a session and chooses models, in a process of its own."""

from __future__ import annotations

import secrets
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.evaluation.divergence import jensen_shannon
from grammarlab.evaluation.preparation import options_of
from grammarlab.features.vocabulary import Options
from grammarlab.language.grammar import Grammar
from grammarlab.preference.base import MAX_SCORE, AbstractPreference
from grammarlab.preference.factors import ProductPreference
from grammarlab.preference.fitting import fit
from grammarlab.preference.grouped import GroupedPreference
from grammarlab.preference.queries import Situation, Way, liked_are_rare, propose
from grammarlab.runs.derive_batch import compiled
from grammarlab.runs.learn.factors import Answers, grown, searched
from grammarlab.runs.learn.labels import FEATURES
from grammarlab.runs.scoring.crew import Handler, Report
from grammarlab.runs.scoring.knowledge import ModelPool
from grammarlab.runs.scoring.rows import Models, Rows, Scored
from grammarlab.runs.scoring.tasks import Choice, Choose, Factors, Features, Learned, Predicted, Prepare, Update

Floats = NDArray[np.float64]

WARM_UP = 32
"""Models that the fit before the first one is about: as many as two grids of 4x4 show."""
MOST_RELEVANCES = 8
"""Entries of what matters most."""


def learner(text: str, name: str, assets: str, seed: int, size: int, wide: bool) -> Handler:
    """What does `Prepare`, `Update` and `Choose` tasks for a session.

    Args:
        text: of the rule file.
        name: of the grammar.
        assets: folder of meshes and images.
        seed: of the session.
        size: of its pool, before that is widened.
        wide: whether it has been widened for rare models.
    """
    return _Learner(compiled(text, name)[0], Path(assets), ModelPool(seed, size, wide)).do


class _Learner:
    """What the last update found."""

    def __init__(self, grammar: Grammar, assets: Path, names: ModelPool) -> None:
        self._grammar, self._assets, self._names = grammar, assets, names
        self._derived: dict[bool, Models] = {}
        self._options = options_of(FEATURES, FEATURES.path_length)
        # So that no version is that of another process, which this one may replace.
        self._version = secrets.randbits(48)
        self._rows: Rows | None = None
        self._preferences: dict[int, AbstractPreference] = {}
        self._product: ProductPreference | None = None
        self._liked: tuple[int, ...] = ()
        self._before: tuple[Floats, Floats] | None = None
        """Of the models of the last update: how much each stands for, and how much it was liked."""

    def do(self, request: Prepare | Update | Choose, report: Report) -> Any:
        if isinstance(request, Prepare):
            return self._prepare(report)
        if isinstance(request, Update):
            return self._update(request, report)
        return self._choose(request, request.choice, report)

    def _models(self, names: ModelPool, report: Report) -> Models:
        """The models of a pool, derived when they are first asked for."""
        if names.wide not in self._derived:
            told = partial(report, f"deriving {len(names.names):,} models")
            narrow = self._derived.get(False)
            self._derived[names.wide] = Models(self._grammar, self._assets, names, narrow, told)
        return self._derived[names.wide]

    def _prepare(self, report: Report) -> Features | None:
        models = self._models(self._names, report)
        report(f"counting features of {len(models.names.names):,} models", 0, 1)
        self._learn_from(models, self._options, models.rows(self._options))
        self._warm_up()
        return self._features(0)

    def _warm_up(self) -> None:
        """Fits scores that nobody gave: what is compiled at a first fit is compiled before anybody waits for it."""
        if self._rows is not None and not self._preferences:
            rows = self._rows.pool[:WARM_UP]
            fit(rows, MAX_SCORE * (np.arange(len(rows)) % 2), groups=self._rows.groups)

    def _update(self, request: Update, report: Report) -> Learned:
        factors = {name: scores for name, scores in request.factors.items() if scores}
        total = len(factors) + 3
        models = self._models(self._pool_for(request), report)
        report("looking at scored models", 0, total)
        scored = models.scored(list(dict.fromkeys(name for scores in factors.values() for name in scores)))
        answers = [_answers(name, scores, scored) for name, scores in factors.items()]
        options = grown(scored.models, answers, options_of(FEATURES, FEATURES.path_length))
        options = replace(options, extra=searched(scored.models, answers, FEATURES))
        report("counting features", 1, total)
        rows = models.rows(options, scored)
        preferences: dict[str, AbstractPreference] = {}
        for number, answer in enumerate(answers):
            report(f"learning {answer.name}", 2 + number, total)
            preferences[answer.name] = fit(rows.scored[answer.model], answer.scores, groups=rows.groups)
        report("choosing models", total - 1, total)
        # From here on nothing is left half done.
        self._learn_from(models, options, rows)
        self._preferences = {request.numbers[name]: preference for name, preference in preferences.items()}
        liked = [name for name, scores in factors.items() if any(scores.values())]
        self._product = ProductPreference({name: preferences[name] for name in liked}) if liked else None
        self._liked = tuple(request.numbers[name] for name in liked)
        product = None if self._product is None else self._predicted(self._product, rows)
        chosen = None if request.choice is None else self._choose(request, request.choice, report)
        found = {name: self._predicted(preference, rows) for name, preference in preferences.items()}
        left_out = _left_out(request.factors, liked)
        features, elsewhere, wide = self._features(request.known), rows.names_elsewhere, self._names.wide
        return Learned(features, wide, elsewhere, found, product, left_out, self._moved(product), chosen)

    def _pool_for(self, request: Update) -> ModelPool:
        """The pool to learn about and to choose from: a wider one from when liked models have turned out to be rare."""
        names = self._names
        rare = (liked_are_rare(np.array(list(scores.values()))) for scores in request.factors.values())
        wide = request.wide or (request.choice is not None and any(rare))
        return names if names.wide or not wide else ModelPool(names.seed, names.size, wide=True)

    def _learn_from(self, models: Models, options: Options, rows: Rows) -> None:
        before = () if self._rows is None else self._rows.names_elsewhere
        known = (self._names.wide, self._options, before)
        self._version += (models.names.wide, options, rows.names_elsewhere) != known or not self._version
        self._names, self._options, self._rows = models.names, options, rows
        # A pool that has been widened is never narrowed again.
        self._derived = {models.names.wide: models}

    def _features(self, known: int) -> Features | None:
        if self._rows is None or self._version == known:
            return None
        return Features(self._version, self._rows.all.astype(np.float32), self._rows.names)

    def _predicted(self, preference: AbstractPreference, rows: Rows) -> Predicted:
        found = preference.predict(rows.all)
        weights = _column_weights(preference)
        matters = [entry for entry in preference.explain(rows.group_names)[:MOST_RELEVANCES] if entry.level != "none"]
        return Predicted(
            found.mean.astype(np.float32),
            found.std.astype(np.float32),
            None if weights is None else weights.astype(np.float32),
            tuple((entry.name, entry.level, round(entry.share, 4)) for entry in matters),
        )

    def _moved(self, product: Predicted | None) -> float:
        """How far the density is from that of the update before; at first, from that of the grammar.

        It is looked at on the models that there were to choose from then.
        """
        weights = self._derived[self._names.wide].pool.weights
        liking = np.ones(len(weights)) if product is None else np.maximum(product.mean[: len(weights)], 0.0)
        known, before = self._before or (weights, np.ones(len(weights)))
        self._before = weights, liking
        return jensen_shannon(_density(known, before), _density(known, liking[: len(known)]))

    def _choose(self, request: Update | Choose, choice: Choice, report: Report) -> tuple[str, ...]:
        by_number = {request.numbers[name]: scores for name, scores in request.factors.items()}
        if choice.factor:
            number = request.numbers[choice.factor]
            scores, preference = by_number[number], self._preferences.get(number)
        else:
            scores, preference = _product([by_number.get(number, {}) for number in self._liked]), self._product
        # One of the ways: the session checks it before it is sent here.
        way = cast("Way", choice.way)
        models = self._models(self._names, report)
        rows = self._rows_to_choose_from(models, way, list(scores))
        names = (*models.names.names, *rows.names_elsewhere)
        place = {name: number for number, name in enumerate(names)}
        known = {place[name]: score for name, score in scores.items() if name in place}
        situation = Situation(
            rows.all,
            np.arange(len(names)) < models.names.sizes[0],
            np.array(list(known), dtype=np.int64),
            np.array(list(known.values()), dtype=np.float64),
            preference,
            models.pool.weights,
        )
        return tuple(names[number] for number in propose(way, situation, choice.num, choice.seed))

    def _rows_to_choose_from(self, models: Models, way: Way, scored: Sequence[str]) -> Rows:
        """Of the pool; with the models already ranked, of all that have a score."""
        rows = models.rows(self._options) if self._rows is None else self._rows
        if way == "already ranked":
            known = {*models.names.index, *rows.names_elsewhere}.issuperset(scored)
            return rows if known else models.rows(self._options, models.scored(scored))
        return replace(rows, elsewhere=rows.elsewhere[:0], names_elsewhere=())


def _answers(name: str, scores: dict[str, float], scored: Scored) -> Answers:
    models = np.array([scored.place[model] for model in scores], dtype=np.int64)
    return Answers(name, models, np.array(list(scores.values()), dtype=np.float64))


def _density(weights: Floats, liking: Floats) -> Floats:
    """[m] how often models are made: that of the grammar where nothing is liked."""
    density = weights * liking
    return density if density.any() else weights


def _left_out(factors: Factors, liked: Sequence[str]) -> tuple[str, ...]:
    """Why some factors are not part of the product."""
    reasons = []
    for name, scores in factors.items():
        if name not in liked and len(factors) > 1:
            why = "all its scores are 0" if scores else "it has no scores yet"
            reasons.append(f"Factor {name} is left out of the product: {why}.")
    if not liked:
        reasons.append("Nothing is liked yet: score at least one model above 0.")
    return tuple(reasons)


def _product(factors: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """The models that have a score for all of some factors, and the product of these."""
    found = {}
    for model in factors[0] if factors else ():
        given = [scores[model] for scores in factors if model in scores]
        if len(given) == len(factors):
            found[model] = MAX_SCORE * float(np.prod(np.array(given) / MAX_SCORE))
    return found


def _column_weights(preference: AbstractPreference) -> Floats | None:
    """[F] of the kernel, of a product those of its factors together."""
    if isinstance(preference, ProductPreference):
        parts = [_column_weights(factor) for factor in preference.factors.values()]
        known = [part for part in parts if part is not None]
        return np.sum(known, axis=0) if known else None
    return preference.column_weights() if isinstance(preference, GroupedPreference) else None
