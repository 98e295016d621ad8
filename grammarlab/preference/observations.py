"""Observations: checked labelled rows, with equal rows merged."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.preference.base import MAX_SCORE, Rows, dense_rows


@dataclass(frozen=True, slots=True)
class Differences:
    """Observations that are differences of two rows, and their variances."""

    others: Floats
    """[n, F] subtracted rows; arbitrary for observations of one row."""
    compared: Floats
    """[n] 1 if a row is subtracted, else 0."""
    variances: Floats
    """[n] variance of each observation; 0 for mean scores, which have the noise of their labels."""

    def take(self, chosen: Ints) -> Differences:
        """The values of selected observations."""
        return Differences(self.others[chosen], self.compared[chosen], self.variances[chosen])


@dataclass(frozen=True, slots=True)
class Observations:
    """Observations of distinct rows, or of differences between them.

    Different scores of one row are not an error: a person may change their mind, and rows may be too coarse to
    distinguish two models. They count as noisy measurements of one value. With Gaussian noise of one variance, the mean
    and the number of measurements are sufficient statistics, so that merging equal rows changes no prediction.

    Other observations are values of a row or differences of two, each with its own variance
    (`grammarlab.preference.processes.label_kinds`).
    """

    rows: Floats
    """[n, F] all different if there are only scores."""
    means: Floats
    """[n] mean score of each row's labels, 0-100."""
    counts: Floats
    """[n] number of labels of each row, >= 1."""
    spread: float
    """Sum over all labels of the squared distance to their row's mean: 0 where no labels contradict each other."""
    differences: Differences | None = None
    """Differences and variances; None if all observations are scores."""

    def take(self, chosen: Ints) -> Observations:
        """Selected rows; the spread is scaled by the number of labels beyond one per row."""
        extra = float(np.sum(self.counts - 1.0))
        repeats = float(np.sum(self.counts[chosen] - 1.0))
        spread = self.spread * repeats / extra if extra else 0.0
        differences = None if self.differences is None else self.differences.take(chosen)
        return Observations(self.rows[chosen], self.means[chosen], self.counts[chosen], spread, differences)

    @property
    def all_rows(self) -> Floats:
        """[N, F] rows, and all subtracted rows."""
        if self.differences is None:
            return self.rows
        return np.concatenate([self.rows, self.differences.others[self.differences.compared > 0.0]])

    def scaled(self, scales: Floats, highest: float) -> Observations:
        """Observations with rows divided by the scale of each column [F], and scores by the highest one."""
        differences = self.differences
        if differences is not None:
            differences = Differences(
                differences.others / scales, differences.compared, differences.variances / highest**2
            )
        return Observations(
            self.rows / scales, self.means / highest, self.counts, self.spread / highest**2, differences
        )

    def of_columns(self, columns: Ints) -> Observations:
        """Observations with selected columns only."""
        differences = self.differences and replace(self.differences, others=self.differences.others[:, columns])
        return replace(self, rows=self.rows[:, columns], differences=differences)


def observe(rows: Rows, scores: ArrayLike) -> Observations:
    """Check labels and merge equal rows, in the order of their first occurrence.

    Args:
        rows: [n, F] finite numbers, n >= 1.
        scores: [n] 0-100.

    Raises:
        UsageError: If the numbers of rows and scores differ, there are none, or a value is not finite or out of range;
            the message has its position.
    """
    table, values = checked_labels(rows, scores)
    _, first, group = np.unique(table, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    label_row = rank[group.reshape(-1)]
    counts = np.bincount(label_row).astype(np.float64)
    means = np.bincount(label_row, weights=values) / counts
    spread = float(np.sum((values - means[label_row]) ** 2))
    return Observations(table[first[order]], means, counts, spread)


def checked_labels(rows: Rows, scores: ArrayLike) -> tuple[Floats, Floats]:
    """Rows [n, F] and scores [n] of labels, n >= 1.

    Raises:
        UsageError: If the numbers of rows and scores differ, there are none, or a value is not finite or out of range;
            the message has its position.
    """
    table, values = dense_rows(rows), _checked_scores(scores)
    if len(table) != len(values):
        raise UsageError(f"scores: expected one per row, found {len(values)} scores for {len(table)} rows.")
    if not len(table):
        raise UsageError("scores: expected at least one label; score a model first.")
    return table, values


def _checked_scores(scores: ArrayLike) -> Floats:
    try:
        values = np.asarray(scores, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(f"scores: expected numbers from 0 to {MAX_SCORE:g} ({error}).") from error
    if values.ndim != 1:
        raise UsageError(f"scores: expected a list of numbers, found {values.ndim} axes.")
    bad = np.flatnonzero(~((values >= 0.0) & (values <= MAX_SCORE)))
    if len(bad):
        raise UsageError(
            f"scores: expected numbers from 0 to {MAX_SCORE:g}, found {values[bad[0]]:g} at index {bad[0]}. "
            "Leave out models without a score."
        )
    return values


def checked_groups(groups: Any, num_columns: int) -> Ints:
    """Group number of each column [F], >= 0; by default every column is its own group.

    Raises:
        UsageError: If they are not one non-negative integer per column.
    """
    if groups is None:
        return np.arange(num_columns)
    numbers = np.asarray(groups)
    if numbers.shape != (num_columns,) or (num_columns and (numbers.dtype.kind not in "iu" or numbers.min() < 0)):
        raise UsageError(f"groups: expected one integer >= 0 for each of the {num_columns} columns.")
    return numbers.astype(np.int64)


def checked_kinds(continuous: Any, num_columns: int) -> NDArray[np.bool_]:
    """[F] whether columns are continuous instead of counts; by default none is.

    Raises:
        UsageError: If there is not one flag per column.
    """
    flags = np.zeros(num_columns, dtype=bool) if continuous is None else np.asarray(continuous, dtype=bool)
    if flags.shape != (num_columns,):
        raise UsageError(f"continuous: expected one flag for each of the {num_columns} columns.")
    return flags


def thinned(observations: Observations, most: int, seed: int) -> Observations:
    """At most ``most`` of the rows, with about the same distribution of scores; the same ones for the same seed.

    The rows are sorted by score, ties in random order, and selected at even intervals.
    """
    total = len(observations.means)
    if total <= most:
        return observations
    shuffled = np.random.default_rng(seed).permutation(total)
    by_score = shuffled[np.argsort(observations.means[shuffled], kind="stable")]
    chosen = by_score[(np.arange(most) * total) // most]
    return observations.take(np.sort(chosen))
