"""A learned preference as a function of few features: what a grammar can be made of.

Predictions are drawn to the levels that a person gave again and again, and columns that tell no levels apart are left
out. What is left is a function of the values of some features, for any design.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import GrammarlabError
from grammarlab.features.pattern import Feature
from grammarlab.learning.answers import Answers
from grammarlab.learning.growth import num_conflicts
from grammarlab.learning.round import State, Study, places
from grammarlab.learning.tables import Table
from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Relevance
from grammarlab.preference.levels import levels_of, snapped
from grammarlab.preference.pruning import needed_columns
from grammarlab.preference.simplified import SimplifiedPreference

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TOLERANCE = 5e-4
"""Features are left out as long as they move no more than this part of what is liked."""


@dataclass(frozen=True)
class SimplifiedFactor:
    """One liked factor of a preference."""

    name: str
    num_labels: int
    relevances: tuple[Relevance, ...]
    """Of the groups of columns, in the order of their numbers."""
    predicted: Floats
    """[m] score of each design of the pool, 0 to 100."""
    simplified: SimplifiedPreference
    """The function of few columns that it becomes."""

    @property
    def drawn(self) -> Floats:
        """[m] the predictions, drawn to the levels."""
        return self.simplified.values


@dataclass(frozen=True)
class SimplifiedProduct:
    """All liked factors together, as a function of the features that they need."""

    factors: tuple[SimplifiedFactor, ...]
    columns: Ints
    """[K] columns of the table."""
    features: tuple[Feature, ...]
    """[K] the same as features."""
    names: tuple[str, ...]
    """[K] the same in words."""
    scales: Floats
    """[K] what to divide their values by."""

    @property
    def bound(self) -> float:
        """No score is larger."""
        highest = [factor.simplified.levels.max(initial=0.0) or MAX_SCORE for factor in self.factors]
        return float(product([np.array([level]) for level in highest])[0])

    def __call__(self, values: Floats) -> Floats:
        """The score [n] of values [n, K] of the features."""
        return self.of_rows(values / self.scales)

    def of_rows(self, rows: Floats) -> Floats:
        """The score [n] of the columns [n, K] of rows."""
        place = {column: number for number, column in enumerate(self.columns.tolist())}
        read = [[place[column] for column in factor.simplified.columns.tolist()] for factor in self.factors]
        return product([factor.simplified(rows[:, own]) for factor, own in zip(self.factors, read, strict=True)])


def simplify(
    study: Study, state: State, is_exact: Callable[[Feature], bool], *, prunes: bool = True
) -> SimplifiedProduct:
    """The preference of a state as a function of few features.

    Args:
        study: the pool and its tables.
        state: what was learned; something is liked.
        is_exact: whether the target can follow a feature exactly; others are looked at where the scores need them.
        prunes: whether columns that tell no levels apart are left out. A target that looks at continuous columns as
            they are wants all: the values of any one tell all designs of a pool apart.

    Raises:
        GrammarlabError: when no design of the pool is predicted to be liked.
    """
    tables, table = study.tables(state.wide), study.table(state)
    liked = [state.answers[name] for name in state.liked]
    candidates = np.flatnonzero([is_exact(feature) for feature in table.features])
    scored = [(places(tables, state.columns, answers), answers) for answers in liked]
    if any(_needs_all(table.rows[rows], answers, candidates) for rows, answers in scored):
        candidates = np.arange(len(table.features))
    pool, weights = table.rows[: len(tables.made.pool)], tables.made.weights
    factors = tuple(
        _simplified(answers, state.preferences[answers.factor], table, pool, weights, candidates, prunes)
        for answers in liked
    )
    used = dict.fromkeys(column for factor in factors for column in factor.simplified.columns.tolist())
    columns = np.array(list(used), dtype=np.int64)
    features, names = (tuple(values[column] for column in used) for values in (table.features, table.names))
    found = SimplifiedProduct(factors, columns, features, names, table.scales[columns])
    if not found.of_rows(pool[:, columns]).any():
        raise GrammarlabError(
            "none of the models looked at is predicted to be liked: what is liked may be too rare. Score more models "
            "like those that you like."
        )
    return found


def product(scores: Sequence[Floats]) -> Floats:
    """[n] of factors one score, 0 to 100."""
    return MAX_SCORE * np.prod(np.minimum(np.array(scores), MAX_SCORE) / MAX_SCORE, axis=0)


def _needs_all(rows: Floats, answers: Answers, candidates: Ints) -> bool:
    """Whether some designs with different scores are equal but for columns that are no candidates."""
    return num_conflicts(rows[:, candidates], answers.scores) > num_conflicts(rows, answers.scores)


def _simplified(
    answers: Answers,
    preference: AbstractPreference,
    table: Table,
    pool: Floats,
    weights: Floats,
    candidates: Ints,
    prunes: bool,
) -> SimplifiedFactor:
    predicted = np.clip(preference.predict(pool).mean, 0.0, MAX_SCORE)
    levels = levels_of(answers.scores)
    drawn = snapped(predicted, levels)
    numbers = [str(number) for number in range(len(table.group_names))]
    shares = {int(found.name): found for found in preference.explain(numbers)}
    relevances = tuple(replace(shares[number], name=name) for number, name in enumerate(table.group_names))
    share = np.array([relevance.share for relevance in relevances])[table.groups]
    order = candidates[np.argsort(-share[candidates], kind="stable")]
    needed = needed_columns(pool, drawn, weights, order, TOLERANCE) if prunes else order
    simplified = SimplifiedPreference(preference, needed, levels, pool, drawn, weights)
    return SimplifiedFactor(answers.factor, len(answers.scores), relevances, predicted, simplified)
