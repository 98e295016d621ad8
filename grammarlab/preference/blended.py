"""The default preference: cells that pool their scores, or Gaussian processes, as held-out scores tell.

Cells (`grammarlab.preference.partition`) beat processes where a person has few values and errs, processes
(`grammarlab.preference.grouped`) beat cells where many parts or draws add up, and where scores are exact. Neither
evidence can be trusted against the other's: what counts is how well each predicts scores that it has not seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.preference import grouped, partition
from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Floats, Ints, Prediction, Relevance, Rows
from grammarlab.preference.explain import level_of
from grammarlab.preference.grouped import GroupedPreference
from grammarlab.preference.likelihood import expected_score, value_of
from grammarlab.preference.observations import checked_groups, checked_kinds, checked_labels
from grammarlab.preference.partition import NOISES, PartitionPreference
from grammarlab.preference.splits import Flags

SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Shares of the process that are tried."""
FOLDS = 3
FEWEST = 16
"""With fewer labels there is nothing to hold out, and the process is believed."""
MOST = 160
"""Labels that are held out in turn; of more, a part with the same distribution of scores."""
_AS_GOOD = 1.02
"""Losses that differ by less tell nothing."""
_UNDERSTATED = 2.0
"""A process explains some noise by its function, and sees little of it where scores end at 0: at most so many times."""


@dataclass(frozen=True, eq=False)
class BlendedPreference(AbstractPreference):
    """`method="blended"`: what `fit` found."""

    process: GroupedPreference
    partition: PartitionPreference
    share: float
    """Of the process in predictions, 0 to 1; the rest is the partition's."""

    @property
    def num_columns(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride] - told by both parts
        """F: how many columns the rows have."""
        return self.process.num_columns

    def predict(self, rows: Rows) -> Prediction:
        mean, square = np.zeros(1), np.zeros(1)
        for share, preference in self._counting():
            part = preference.predict(rows)
            within = part.mean if preference is self.partition else value_of(part.mean, *self._erring)
            mean, square = mean + share * within, square + share * (part.std**2 + within**2)
        return Prediction(mean, np.sqrt(np.maximum(square - mean**2, 0.0)))

    def column_weights(self) -> Floats:
        return self.process.column_weights()

    @property
    def _erring(self) -> tuple[float, float]:
        """Noise and blunders that the process has taken for means: each part knows too much where it does not fit."""
        noise = float(np.sqrt(self.process.explanations[0].posterior.hyperparameters.noise))
        told = min(self.partition.noise, _UNDERSTATED * noise)
        return max(told, NOISES[0]), self.partition.blunders if told > NOISES[0] else 0.0

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        total = np.zeros(len(group_names))
        # By number: two groups may have one name.
        numbers = [str(number) for number in range(len(group_names))]
        for share, preference in self._counting():
            for found in preference.explain(numbers):
                total[int(found.name)] += share * found.share
        shares = zip(group_names, total.tolist(), strict=True)
        entries = [Relevance(name, share, level_of(share)) for name, share in shares]
        return sorted(entries, key=lambda relevance: -relevance.share)

    def _counting(self) -> Iterator[tuple[float, AbstractPreference]]:
        if self.share > 0.0:
            yield self.share, self.process
        if self.share < 1.0:
            yield 1.0 - self.share, self.partition


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    groups: ArrayLike | None = None,
    continuous: ArrayLike | None = None,
    seed: int = 0,
    warm: AbstractPreference | None = None,
) -> BlendedPreference:
    """Both kinds of preference, and the share of each that predicts held-out scores best.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100.
        groups: [F] group numbers; every column its own group when there are none.
        continuous: [F] which columns are no counts; none of them when left out.
        seed: of random starts and draws, and of what is held out.
        warm: not used.

    Raises:
        UsageError: when labels or groups are out of range.
    """
    table, values = checked_labels(rows, scores)
    numbers = checked_groups(groups, table.shape[1])
    drawn = checked_kinds(continuous, len(numbers))
    cells = partition.fit(table, values, groups=numbers, continuous=drawn, seed=seed)
    process = grouped.fit(table, values, groups=numbers, continuous=drawn, seed=seed)
    share = 1.0 if len(values) < FEWEST else _share(table, values, numbers, drawn, seed, cells)
    return BlendedPreference(process, cells, share)


def _share(
    rows: Floats, scores: Floats, groups: Ints, continuous: Flags, seed: int, cells: PartitionPreference
) -> float:
    """The share of the process that predicts held-out scores best."""
    randomness = np.random.default_rng(seed)
    some = np.sort(randomness.permutation(len(scores))[:MOST])
    rows, scores = rows[some], scores[some]
    # Equal rows are held out together: otherwise one would tell the other.
    _, row = np.unique(rows, axis=0, return_inverse=True)
    fold = randomness.permutation(FOLDS * (1 + int(row.max()) // FOLDS))[row.reshape(-1)] % FOLDS
    predicted = np.zeros((2, len(scores)))
    for number in range(FOLDS):
        held, known = fold == number, fold != number
        if held.any() and known.any():
            process = grouped.fit(rows[known], scores[known], groups=groups, continuous=continuous, seed=seed, starts=1)
            predicted[0, held] = process.predict(rows[held]).mean
            with threadpool_limits(1, "blas"):
                predicted[1, held] = cells.without(rows[known], scores[known], continuous).predict(rows[held]).mean
    predicted[1] = expected_score(predicted[1], cells.noise, cells.blunders)
    missed = np.clip(predicted, 0.0, MAX_SCORE) - scores
    losses = [float(np.sum((share * missed[0] + (1.0 - share) * missed[1]) ** 2)) for share in SHARES]
    # Of shares that do about as well, the smallest: what cells say is simpler.
    return next(share for share, loss in zip(SHARES, losses, strict=True) if loss <= _AS_GOOD * min(losses))
