"""From labels to a preference, and to a function of few features that a grammar can be made from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest
from grammarlab.derivation.selection import select_models
from grammarlab.errors import UsageError
from grammarlab.evaluation.learners import learner_of
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.scenario import MAX_PATH_LENGTH, FeatureOptions
from grammarlab.features.growth import conflicts
from grammarlab.features.pattern import Feature
from grammarlab.features.table import FeatureTable
from grammarlab.features.vocabulary import Options, Vocabulary, extract
from grammarlab.preference.base import AbstractPreference, Relevance
from grammarlab.preference.fitting import Method, fit
from grammarlab.preference.labels import Labels
from grammarlab.preference.levels import levels_of, snapped
from grammarlab.preference.pruning import needed_columns
from grammarlab.preference.simplified import SimplifiedPreference
from grammarlab.runs.learn.labelled_models import LabelledModels
from grammarlab.runs.learn.pool import Pool

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TOLERANCE = 5e-4
"""Features are left out as long as they move no more than this part of what is liked."""


@dataclass(frozen=True, slots=True)
class Answers:
    """What a person said about one factor."""

    name: str
    model: Ints
    """[n] the model of each label."""
    scores: Floats
    """[n] 0 to 100."""

    def per_model(self) -> tuple[Ints, Floats]:
        """The different models, and the mean score of each."""
        models, place = np.unique(self.model, return_inverse=True)
        return models, np.bincount(place, self.scores) / np.bincount(place)


@dataclass(frozen=True)
class Tables:
    """The features of all models, in the same columns."""

    pool: FeatureTable
    rows: Floats
    """[m, F] of the pool, scaled."""
    labelled: Floats
    """[n, F] of the labelled models, scaled."""
    exact: Ints
    """[E] the columns that an exact grammar can follow; all columns, where the labels need more than these."""


@dataclass(frozen=True)
class LearnedFactor:
    """One factor of a preference."""

    name: str
    num_labels: int
    preference: AbstractPreference
    relevances: tuple[Relevance, ...]
    """Of the groups of columns, in the order of their numbers."""
    predicted: Floats
    """[m] score of each model of the pool, not below 0."""
    simplified: SimplifiedPreference
    """The function of few columns that it becomes."""

    @property
    def drawn(self) -> Floats:
        """[m] the predictions, drawn to the levels."""
        return self.simplified.values


def answers_of(labels: Labels, labelled: LabelledModels) -> tuple[Answers, ...]:
    """The labels by factor.

    Raises:
        UsageError: when a factor has no score above 0, so that nothing is known about what is liked.
    """
    found = []
    for factor in labels.factors:
        rows = np.array([i for i, label in enumerate(labels) if label.factor == factor], dtype=np.int64)
        scores = labels.scores[rows]
        if not scores.any():
            raise UsageError(
                f"all {len(rows):,} scores of {factor!r} are 0, so nothing is liked and there is nothing to sample: "
                "score at least one model above 0."
            )
        found.append(Answers(factor, labelled.model[rows], scores))
    return tuple(found)


def tables_of(
    labelled: LabelledModels,
    pool: Pool,
    answers: Sequence[Answers],
    features: FeatureOptions,
    is_exact: Callable[[Feature], bool],
) -> Tables:
    """The features of the pool and of the labelled models.

    Paths are as long as it takes to tell apart models with different scores, and features are searched for where
    the families say so.
    """
    families = features.families
    options = Options(
        features.path_length,
        symbols="symbols" in families,
        draws="draws" in families,
        far_pairs="skips" in families,
        adjacent_pairs="siblings" in families,
    )
    options = replace(grown(labelled, answers, options), extra=searched(labelled, answers, features))
    vocabulary = Vocabulary.find([*pool.forests, *labelled.forests], options)
    of_pool, rows = vocabulary.apply(pool.forests), vocabulary.apply(labelled.forests).rows()
    exact = np.flatnonzero([is_exact(feature) for feature in of_pool.features])
    if _num_conflicts(rows[:, exact], answers) > _num_conflicts(rows, answers):
        exact = np.arange(len(of_pool.features))
    return Tables(of_pool, of_pool.rows(), rows, exact)


def _num_conflicts(rows: Floats, answers: Sequence[Answers]) -> int:
    """How many sets of labelled models with equal rows have different scores."""
    found = 0
    for factor in answers:
        models, scores = factor.per_model()
        found += len(conflicts(rows[models], scores))
    return found


def grown(labelled: LabelledModels, answers: Sequence[Answers], options: Options) -> Options:
    """The options with the shortest paths that leave the fewest models with equal rows and different scores."""
    fewest, best = -1, options
    for length in range(options.length, max(options.length, MAX_PATH_LENGTH) + 1):
        rows = extract(labelled.forests, replace(options, length=length)).rows()
        number = _num_conflicts(rows, answers)
        if fewest < 0 or number < fewest:
            fewest, best = number, replace(options, length=length)
        if not number:
            break
    return best


def searched(labelled: LabelledModels, answers: Sequence[Answers], features: FeatureOptions) -> tuple[Feature, ...]:
    """The features that are searched for in the labelled models, of the families that say so."""
    search = learner_of(METHODS["default"], features).search
    found: dict[Feature, None] = {}
    if search is not None:
        for factor in answers:
            models, scores = factor.per_model()
            if np.ptp(scores) > 0.0:
                found |= dict.fromkeys(search(selected(labelled.forests, models), scores))
    return tuple(found)


def selected(forests: Sequence[Forest], models: Ints) -> tuple[Forest, ...]:
    """Some models, counted through all forests, in ascending order."""
    found, first = [], 0
    for forest in forests:
        inside = models[(models >= first) & (models < first + forest.num_models)] - first
        if len(inside):
            found.append(select_models(forest, inside))
        first += forest.num_models
    return tuple(found)


def learn_factor(
    answers: Answers,
    tables: Tables,
    weights: Floats,
    *,
    method: Method = "grouped",
    seed: int = 0,
    tolerance: float = TOLERANCE,
) -> LearnedFactor:
    """Fits one factor and simplifies it.

    It is fitted twice: on all features, and on those only that an exact grammar can follow. Of two functions that
    explain the same scores, the one that needs fewer features is taken.

    Args:
        answers: the labels.
        tables: the features of the models.
        weights: [m] how much each model of the pool stands for.
        method: how to fit.
        seed: of the fit.
        tolerance: how much of the density leaving features out may move.
    """
    fits = [np.arange(len(tables.pool.features))]
    if len(tables.exact) < len(fits[0]):
        fits.append(tables.exact)
    found = [_fitted(answers, tables, weights, columns, method, seed, tolerance) for columns in fits]
    return min(found, key=lambda factor: len(factor.simplified.columns))


def _fitted(
    answers: Answers, tables: Tables, weights: Floats, columns: Ints, method: Method, seed: int, tolerance: float
) -> LearnedFactor:
    """One factor, fitted on some of the columns."""
    seen = np.isin(np.arange(len(tables.pool.features)), columns)
    # What is the same in all rows has no influence, and columns keep their numbers.
    rows, labelled = tables.rows * seen, tables.labelled * seen
    preference = fit(labelled[answers.model], answers.scores, groups=tables.pool.groups, method=method, seed=seed)
    predicted = np.maximum(preference.predict(rows).mean, 0.0)
    levels = levels_of(answers.scores)
    drawn = snapped(predicted, levels)
    numbers = [str(number) for number in range(len(tables.pool.group_names))]
    shares = {int(found.name): found for found in preference.explain(numbers)}
    relevances = tuple(replace(shares[number], name=name) for number, name in enumerate(tables.pool.group_names))
    share = np.array([relevance.share for relevance in relevances])[tables.pool.groups]
    order = tables.exact[np.argsort(-share[tables.exact], kind="stable")]
    needed = needed_columns(rows, drawn, weights, order, tolerance)
    simplified = SimplifiedPreference(preference, needed, levels, rows, drawn, weights)
    return LearnedFactor(answers.name, len(answers.scores), preference, relevances, predicted, simplified)
