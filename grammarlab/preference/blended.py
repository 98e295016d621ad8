"""The default preference: cells that pool their scores, or Gaussian processes, as held-out scores tell.

Cells (`grammarlab.preference.cells.partition`) beat processes where a person has few values and errs, processes
(`grammarlab.preference.processes.grouped`) beat cells where many parts or draws add up, and where scores are exact.
Neither evidence can be trusted against the other's: what counts is how well each predicts scores that it has not seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Floats, Ints, Prediction, Relevance, Rows
from grammarlab.preference.cells import partition
from grammarlab.preference.cells.partition import NOISES, PartitionPreference
from grammarlab.preference.cells.splits import Flags
from grammarlab.preference.explain import level_of
from grammarlab.preference.likelihood import expected_score, value_of
from grammarlab.preference.observations import checked_groups, checked_kinds, checked_labels
from grammarlab.preference.processes import grouped
from grammarlab.preference.processes.grouped import GroupedPreference

SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Shares of the process that are tried."""
FOLDS = 3
FEWEST = 16
"""With fewer labels there is nothing to hold out, and the process is believed."""
MOST = 160
"""Labels that are held out in turn; of more, a part with the same distribution of scores."""
_SMALL_PART = 0.05
"""Part of the highest prediction below which one is too small to divide by."""
_OF_MEDIAN = 1.4826
"""Standard deviation of normal errors by the median of their sizes."""
_UNDERSTATED = 2.0
"""A process explains some noise by its function, and sees little of it where scores end at 0: at most so many times."""


@dataclass(frozen=True, eq=False)
class BlendedPreference(AbstractPreference):
    """`method="blended"`: what `fit` found."""

    process: GroupedPreference
    partition: PartitionPreference
    share: float
    """Of the process in predictions, 0 to 1; the rest is the partition's."""
    missed: float = 0.0
    """By how much held-out scores were missed, as the standard deviation that has such a median; 0 where none were."""
    sketches: tuple[BlendedPreference, ...] = ()
    """Quick fits to parts of the labels, each without the scores that were held out from it."""

    @property
    def num_columns(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride] - told by both parts
        """F: how many columns the rows have."""
        return self.process.num_columns

    def predict(self, rows: Rows) -> Prediction:
        mean, square = np.zeros(1), np.zeros(1)
        for share, preference in self._counting():
            part = preference.predict(rows) if preference is self.partition else self.meant(rows)
            mean, square = mean + share * part.mean, square + share * (part.std**2 + part.mean**2)
        return Prediction(mean, np.sqrt(np.maximum(square - mean**2, 0.0)))

    def meant(self, rows: Rows) -> Prediction:
        """What the process expects to be meant, and how scores vary around it: it has learned means of scores."""
        told, own = self.process.predict(rows), self.process.explanations[0].posterior.hyperparameters.noise
        # A process that has explained noise by its function shows it where scores are held out.
        noise = max(self.noise, min(self.partition.noise, self.missed))
        deviation = np.sqrt(np.maximum(told.std**2 - own, 0.0) + noise**2)
        return Prediction(value_of(told.mean, *self._erring), deviation)

    def column_weights(self) -> Floats:
        return self.process.column_weights()

    @property
    def noise(self) -> float:
        """Standard deviation of a score around what was meant, in points."""
        return self._erring[0]

    @property
    def blunders(self) -> float:
        """How often a score was any score at all."""
        return self._erring[1]

    @property
    def num_labels(self) -> int:
        """Number of labels that cells were fitted to."""
        return len(self.partition.cells.scores)

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
    if len(values) < FEWEST:
        return BlendedPreference(process, cells, 1.0)
    return BlendedPreference(process, cells, *_share(table, values, numbers, drawn, seed, cells))


def _share(
    rows: Floats, scores: Floats, groups: Ints, continuous: Flags, seed: int, cells: PartitionPreference
) -> tuple[float, float, tuple[BlendedPreference, ...]]:
    """The share of the process that predicts held-out scores best, by how much it misses them, and who missed them."""
    randomness = np.random.default_rng(seed)
    some = np.sort(randomness.permutation(len(scores))[:MOST])
    rows, scores = rows[some], scores[some]
    # Equal rows are held out together: otherwise one would tell the other.
    _, row = np.unique(rows, axis=0, return_inverse=True)
    row = row.reshape(-1)
    fold = randomness.permutation(FOLDS * (1 + int(row.max()) // FOLDS))[row] % FOLDS
    predicted, parts = np.zeros((2, len(scores))), list[tuple[GroupedPreference, PartitionPreference]]()
    for number in range(FOLDS):
        held, known = fold == number, fold != number
        if held.any() and known.any():
            process = grouped.fit(rows[known], scores[known], groups=groups, continuous=continuous, seed=seed, starts=1)
            predicted[0, held] = process.predict(rows[held]).mean
            with threadpool_limits(1, "blas"):
                sketch = cells.without(rows[known], scores[known], continuous)
                predicted[1, held] = sketch.predict(rows[held]).mean
            parts.append((process, sketch))
    predicted[1] = expected_score(predicted[1], cells.noise, cells.blunders)
    predicted = np.clip(predicted, 0.0, MAX_SCORE)
    share = _best_share(predicted, scores, row)
    missed = share * predicted[0] + (1.0 - share) * predicted[1] - scores
    sketches = tuple(BlendedPreference(*part, share) for part in parts)
    return share, float(np.median(np.abs(missed))) * _OF_MEDIAN, sketches


def _best_share(predicted: Floats, scores: Floats, row: Ints) -> float:
    """The smallest share of the process that predicts scores about as well as the best one.

    A divergence between densities is, where it is small, a sum of squared errors beside what is expected. About as well
    means within a standard error of the difference: what cells say is simpler, and they know what is worth nothing.

    Args:
        predicted: [2, n] by the process and by the cells, 0-100.
        scores: [n] 0-100.
        row: [n] number of the design of each, from 0; what is missed of one design counts once.
    """
    expected = predicted.mean(axis=0)
    weights = 1.0 / (expected + _SMALL_PART * max(float(expected.max()), 1.0))
    shares = np.array(SHARES)[:, None]
    losses = weights * (shares * predicted[0] + (1.0 - shares) * predicted[1] - scores) ** 2
    worse = np.array([np.bincount(row, each) for each in losses - losses[losses.sum(axis=1).argmin()]])
    error = np.sqrt(worse.shape[1]) * worse.std(axis=1)
    return SHARES[int(np.argmax(worse.sum(axis=1) <= error))]
