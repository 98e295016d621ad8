"""LightGBM's gradient-boosted trees with the same interface, for comparison.

Trees are small, with few rows per leaf. Their number is chosen from the labels: `NUM_MEMBERS` ensembles each learn from
a bootstrap sample of the rows, and the number of trees is the one with the best predictions of rows outside the samples
(least squares). The mean is that of this number of trees on all labels; the uncertainty is the spread of the members
and their error outside their samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from lightgbm import Booster, Dataset, train
from numpy.typing import ArrayLike

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Prediction, Relevance, Rows, rows_to_predict
from grammarlab.preference.factors import level_of
from grammarlab.preference.observations import Observations, checked_groups, observe

NUM_MEMBERS = 8
"""Number of ensembles on bootstrap samples."""
MAX_TREES = 200
"""Largest number of trees of an ensemble."""
MIN_ROWS_TO_CHOOSE = 16
"""Smallest number of distinct rows for choosing the number of trees; with fewer it is `MAX_TREES`."""

_TREE_STEP = 10
"""Candidate numbers of trees are multiples of this."""
_PARAMETERS: dict[str, Any] = {
    "objective": "regression",
    "learning_rate": 0.1,
    "num_leaves": 8,
    "min_data_in_leaf": 1,
    "min_data_in_bin": 1,
    "lambda_l2": 1.0,
    "deterministic": True,
    "force_row_wise": True,
    "num_threads": 1,
    "verbosity": -1,
}


@dataclass(frozen=True)
class BoostedPreference(AbstractPreference):
    """Result of `fit` with `method="lightgbm"`: trees on all labels, and members for the uncertainty."""

    num_columns: int
    groups: Ints
    """[F] group number of each column, for `explain`."""
    ensemble: Booster
    """Trees learned from all labels."""
    members: tuple[Booster, ...]
    """Further ensembles, each learned from a bootstrap sample of the rows."""
    num_trees: int
    """Number of trees of each ensemble used for predictions."""
    error: float
    """Mean squared error at rows outside the samples of members, in squared scores; 0 if there are none."""

    def predict(self, rows: Rows) -> Prediction:
        table = rows_to_predict(rows, self.num_columns)
        if not len(table):
            return Prediction(np.empty(0), np.empty(0))
        spread = np.var([_predicted(member, table, self.num_trees) for member in self.members], axis=0)
        return Prediction(
            np.clip(_predicted(self.ensemble, table, self.num_trees), 0.0, MAX_SCORE), np.sqrt(spread + self.error)
        )

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        """Share of each group in the gain of all splits."""
        if len(self.groups) and len(group_names) <= self.groups.max():
            raise UsageError(f"group_names: expected {self.groups.max() + 1} names, found {len(group_names)}.")
        gains = self.ensemble.feature_importance("gain", self.num_trees)[: self.num_columns]
        shares = np.bincount(self.groups, gains, len(group_names)) / max(gains.sum(), np.finfo(np.float64).tiny)
        entries = [
            Relevance(name, share, level_of(share)) for name, share in zip(group_names, shares.tolist(), strict=True)
        ]
        return sorted(entries, key=lambda relevance: -relevance.share)


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    groups: ArrayLike | None = None,
    seed: int = 0,
    warm: AbstractPreference | None = None,
) -> BoostedPreference:
    """Boosted trees of least squares; their number is chosen by rows outside their samples.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100.
        groups: [F] group numbers, for `explain` only.
        seed: draws the bootstrap samples.
        warm: not used.

    Raises:
        UsageError: If labels or groups are out of range.
    """
    observations = observe(rows, scores)
    numbers = checked_groups(groups, observations.rows.shape[1])
    total = len(observations.means)
    samples = np.random.default_rng(seed).integers(0, total, (NUM_MEMBERS, total))
    members = tuple(_trained(observations, np.bincount(sample, minlength=total)) for sample in samples)
    tree_counts = np.arange(_TREE_STEP, MAX_TREES + 1, _TREE_STEP)
    errors = _errors_outside(members, observations, samples, tree_counts)
    best = int(np.argmin(errors)) if total >= MIN_ROWS_TO_CHOOSE else -1
    ensemble = _trained(observations, np.ones(total, dtype=np.int64))
    return BoostedPreference(len(numbers), numbers, ensemble, members, int(tree_counts[best]), float(errors[best]))


def _trained(observations: Observations, drawn: Ints) -> Booster:
    """Trees on the drawn rows, each repeated by its number of labels."""
    # Not as weights: LightGBM counts the rows of a leaf by dividing its weight, and finds none in light ones.
    labels = np.repeat(np.arange(len(drawn)), drawn * observations.counts.astype(np.int64))
    return train(_PARAMETERS, Dataset(_padded(observations.rows[labels]), observations.means[labels]), MAX_TREES)


def _errors_outside(members: Sequence[Booster], observations: Observations, samples: Ints, tree_counts: Ints) -> Floats:
    """Mean squared errors of the members at labels outside their samples, for each number of trees; 0 without any."""
    squared, weight = np.zeros(len(tree_counts)), 0.0
    for member, sample in zip(members, samples, strict=True):
        outside = observations.take(np.setdiff1d(np.arange(len(observations.means)), sample))
        if len(outside.means):
            predicted = np.array([_predicted(member, outside.rows, number) for number in tree_counts])
            squared += (predicted - outside.means) ** 2 @ outside.counts
            weight += outside.counts.sum()
    return squared / max(weight, 1.0)


def _predicted(booster: Booster, rows: Floats, num_trees: int) -> Floats:
    """[m] predictions of the first trees for rows [m, F]."""
    return np.asarray(booster.predict(_padded(rows), num_iteration=num_trees), dtype=np.float64)


def _padded(rows: Floats) -> Floats:
    """Rows with a constant column added, since LightGBM refuses rows without columns."""
    return np.pad(rows, ((0, 0), (0, 1)))
