"""Labelled rows as the methods use them: checked, with equal rows taken together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grammarlab.errors import UsageError
from grammarlab.preference.base import MAX_SCORE, Floats, Ints, Rows, dense_rows


@dataclass(frozen=True, slots=True)
class Beside:
    """Which observations are differences of two rows, and how certain they are."""

    others: Floats
    """[n, F] the rows that are subtracted; anything where none is."""
    compared: Floats
    """[n] 1 where a row is subtracted, else 0."""
    variances: Floats
    """[n] of each observation around what it is of; 0 for mean scores, which have the noise of their labels."""

    def take(self, chosen: Ints) -> Beside:
        """Of some of the observations."""
        return Beside(self.others[chosen], self.compared[chosen], self.variances[chosen])


@dataclass(frozen=True, slots=True)
class Observations:
    """Distinct rows, and what is known of each, or of differences between them.

    Scores of one row that differ are not an error: a person may change their mind, and rows may be too coarse to tell
    two models apart. They count as so many noisy looks at one value. With Gaussian noise of one variance the mean and
    the number of looks hold everything that the labels say about the function, so that taking equal rows together
    changes no prediction.

    Beside mean scores there may be observations of another kind: of a row or of a difference of two, each with a
    variance of its own (`grammarlab.preference.processes.propagation`).
    """

    rows: Floats
    """[n, F] all different where there are only scores."""
    means: Floats
    """[n] mean score of each row's labels, 0-100."""
    counts: Floats
    """[n] how many labels each row has, >= 1."""
    spread: float
    """Sum over all labels of the squared distance to their row's mean: 0 where no labels contradict each other."""
    beside: Beside | None = None
    """What else is known of the observations; None where all of them are scores."""

    def take(self, chosen: Ints) -> Observations:
        """Some of the rows; the spread is taken in proportion to the labels beyond one a row."""
        extra = float(np.sum(self.counts - 1.0))
        kept = float(np.sum(self.counts[chosen] - 1.0))
        spread = self.spread * kept / extra if extra else 0.0
        beside = None if self.beside is None else self.beside.take(chosen)
        return Observations(self.rows[chosen], self.means[chosen], self.counts[chosen], spread, beside)

    @property
    def looked_at(self) -> Floats:
        """[N, F] the rows, and all that are subtracted from some."""
        if self.beside is None:
            return self.rows
        return np.concatenate([self.rows, self.beside.others[self.beside.compared > 0.0]])

    def scaled(self, scales: Floats, highest: float) -> Observations:
        """The same with rows divided by the scale of each column [F], and scores by the highest one."""
        beside = self.beside
        if beside is not None:
            beside = Beside(beside.others / scales, beside.compared, beside.variances / highest**2)
        return Observations(self.rows / scales, self.means / highest, self.counts, self.spread / highest**2, beside)

    def of_columns(self, columns: Ints) -> Observations:
        """The same with some columns alone."""
        beside = self.beside and replace(self.beside, others=self.beside.others[:, columns])
        return replace(self, rows=self.rows[:, columns], beside=beside)


def observe(rows: Rows, scores: ArrayLike) -> Observations:
    """Check labels and take equal rows together, in the order in which they first appear.

    Args:
        rows: [n, F] finite numbers, n >= 1.
        scores: [n] 0-100.

    Raises:
        UsageError: when the numbers of rows and scores differ, there are none, or a value is not finite or out of
            range; the message names its place.
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
        UsageError: when the numbers of rows and scores differ, there are none, or a value is not finite or out of
            range; the message names its place.
    """
    table, values = dense_rows(rows), _checked_scores(scores)
    if len(table) != len(values):
        raise UsageError(f"scores: expected one a row, found {len(values)} scores for {len(table)} rows.")
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
            "Leave models out that have no score."
        )
    return values


def checked_groups(groups: Any, num_columns: int) -> Ints:
    """The group number of each column [F], >= 0; every column its own group when there are none.

    Raises:
        UsageError: when they are not one non-negative integer a column.
    """
    if groups is None:
        return np.arange(num_columns)
    numbers = np.asarray(groups)
    if numbers.shape != (num_columns,) or (num_columns and (numbers.dtype.kind not in "iu" or numbers.min() < 0)):
        raise UsageError(f"groups: expected one integer >= 0 for each of the {num_columns} columns.")
    return numbers.astype(np.int64)


def checked_kinds(continuous: Any, num_columns: int) -> NDArray[np.bool_]:
    """[F] which columns are no counts; none of them where it is not said.

    Raises:
        UsageError: when there is not one flag a column.
    """
    flags = np.zeros(num_columns, dtype=bool) if continuous is None else np.asarray(continuous, dtype=bool)
    if flags.shape != (num_columns,):
        raise UsageError(f"continuous: expected one flag for each of the {num_columns} columns.")
    return flags


def thinned(observations: Observations, most: int, seed: int) -> Observations:
    """At most ``most`` of the rows, with about the same distribution of scores; the same ones for the same seed.

    The rows are put in order of their score, ties in random order, and every so-many-th is taken.
    """
    total = len(observations.means)
    if total <= most:
        return observations
    shuffled = np.random.default_rng(seed).permutation(total)
    by_score = shuffled[np.argsort(observations.means[shuffled], kind="stable")]
    chosen = by_score[(np.arange(most) * total) // most]
    return observations.take(np.sort(chosen))
