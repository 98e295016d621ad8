"""Labels of several kinds as observations of rows, for processes, and as intervals of values, for cells.

Observations are found by expectation propagation (Minka 2001) for values with a joint normal prior: each label is
replaced by a normal site, so that mean and variance of its value are right given all other sites. For a
single label the result is exact; for comparisons it is that of Chu and Ghahramani (2005) with better means.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cholesky, solve_triangular

from grammarlab.arrays import MAX_STEPS, ROUNDING, Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.preference.base import MAX_SCORE, Rows, dense_rows
from grammarlab.preference.labels import COMPARISONS, Kind
from grammarlab.preference.observations import Differences, Observations, checked_labels, observe
from grammarlab.preference.person import (
    MODEL_NOISE,
    START_BLUNDERS,
    Intervals,
    intervals_of,
    intervals_of_kinds,
    matched,
)
from grammarlab.preference.processes.posterior import Hyperparameters, condition, squared_distances

_LEAST_PRECISION = 1e-8
"""Precision, per squared point, of a site that says nothing: a deviation of 10,000 points."""
_DAMPING = 0.7
"""Step of a site towards its new value in a sweep; all sites move at once, so full steps would overshoot."""
_TOLERANCE = 1e-4
"""Change of a mean, as a share of its deviation, below which sweeps end."""
_MIDDLE_GRID = np.arange(5.0, 96.0, 2.5)
"""Candidate values at which thumbs turn, in points, around 50."""
_SD_OF_MIDDLE = 20.0
"""Standard deviation of the middle of people, around 50."""


class Sites(NamedTuple):
    """Normal observations equivalent to the labels."""

    precisions: Floats
    """[k] > 0, one over the variance of each observation."""
    shifts: Floats
    """[k] means times precisions."""
    mean: Floats
    """[k] posterior means of the values."""
    covariance: Floats
    """[k, k] posterior covariance of the values."""

    @property
    def variances(self) -> Floats:
        """[k] variances of the normal observations."""
        return 1.0 / self.precisions

    @property
    def means(self) -> Floats:
        """[k] means of the normal observations."""
        return self.shifts / self.precisions

    def cavity(self) -> tuple[Floats, Floats]:
        """Mean [k] and variance [k] of each value, given all other labels."""
        marginal = np.maximum(np.diagonal(self.covariance), ROUNDING)
        precision = np.maximum(1.0 / marginal - self.precisions, _LEAST_PRECISION)
        return (self.mean / marginal - self.shifts) / precision, 1.0 / precision


@dataclass(frozen=True, eq=False)
class Judgements:
    """Labels of several kinds: first the scores, then the others."""

    rows: Floats
    """[N, F] the different rows of the labels."""
    scores: Floats
    """[p + k] scores in points, 0-100."""
    kinds: tuple[Kind, ...]
    """[p + k] kinds: p of ``score`` and then k others."""
    first: Ints
    """[p + k] index of the row of each label."""
    second: Ints
    """[p + k] index of the row that a comparison is with; -1 for other kinds."""

    @property
    def num_scores(self) -> int:
        """Number of scores."""
        return self.kinds.count("score")

    @property
    def plain(self) -> slice:
        """The scores."""
        return slice(0, self.num_scores)

    @property
    def rest(self) -> slice:
        """All other labels."""
        return slice(self.num_scores, None)

    @property
    def mixing(self) -> Floats:
        """[k, N] linear map from values of rows to labels other than scores: differences for comparisons."""
        first, second = self.first[self.rest], self.second[self.rest]
        mixing = np.zeros((len(first), len(self.rows)))
        mixing[np.arange(len(first)), first] = 1.0
        compared = np.flatnonzero(second >= 0)
        mixing[compared, second[compared]] = -1.0
        return mixing

    def take(self, indices: Ints) -> Judgements:
        """Selected labels, ascending."""
        kinds = tuple(self.kinds[index] for index in indices.tolist())
        return Judgements(self.rows, self.scores[indices], kinds, self.first[indices], self.second[indices])

    def thinned(self, most: int) -> Judgements:
        """At most so many of the labels, an even selection by score, with their rows."""
        total = len(self.scores)
        if total <= most:
            return self
        by_score = np.argsort(self.scores, kind="stable")
        part = self.take(np.sort(by_score[np.arange(most) * total // most]))
        compared = part.second >= 0
        used = np.unique(np.append(part.first, part.second[compared]))
        second = np.where(compared, np.searchsorted(used, part.second), -1)
        return replace(part, rows=self.rows[used], first=np.searchsorted(used, part.first), second=second)

    def intervals(self, middle: float) -> Intervals:
        """[k] intervals of labels other than scores, of values or of differences of two.

        Args:
            middle: values above it get a thumb up.
        """
        return intervals_of_kinds(self.scores[self.rest], self.kinds[self.rest], middle)

    def scored(self) -> Observations | None:
        """The scores; None if there are none."""
        rows = self.first[self.plain]
        return observe(self.rows[rows], self.scores[self.plain]) if len(rows) else None


@dataclass(frozen=True, eq=False)
class LabelObservations:
    """Observations from labels of several kinds, under one kernel."""

    observations: Observations
    """Observations for processes: scores, and sites instead of all other labels."""
    search_observations: Observations
    """Observations for a search for kernels: scores, and estimates instead of all other labels. They do not contain the
    prior of the kernel, so that another kernel does not need it."""
    row_pairs: Ints
    """[n, 2] indices of the rows of each observation."""
    bounds: Intervals
    """[p + k] interval of each label, of a value or of a difference."""
    rows: Floats
    """[c, F] rows of the labels, for cells; comparisons have two."""
    scores: Floats
    """[c] approximate value of each row."""
    intervals: Intervals
    """[c] interval of each label for one value; for comparisons, given all other labels of the other value."""
    label: Ints
    """[c] index of the label of each row."""


def judgements_of(rows: Rows, scores: ArrayLike, kinds: Sequence[Kind], others: Rows) -> Judgements:
    """Labels of several kinds, checked.

    Args:
        rows: [n, F] rows of the models.
        scores: [n] 0-100.
        kinds: [n] kinds of the labels.
        others: [n, F] rows of the other models of comparisons; arbitrary for other kinds.

    Raises:
        UsageError: If the numbers do not agree, or a value is not finite or out of range.
    """
    table, values = checked_labels(rows, scores)
    other_rows = dense_rows(others, "others")
    if other_rows.shape != table.shape or len(kinds) != len(table):
        raise UsageError(
            f"kinds, others: expected one kind and one row of {table.shape[1]} columns for each of {len(table)} "
            f"labels, found {len(kinds)} kinds and a table of {list(other_rows.shape)}."
        )
    compared = np.array([kind in COMPARISONS for kind in kinds])
    different, row_of = np.unique(np.concatenate([table, other_rows[compared]]), axis=0, return_inverse=True)
    second = np.full(len(table), -1)
    second[compared] = row_of.reshape(-1)[len(table) :]
    first = row_of.reshape(-1)[: len(table)]
    # Scores first; the rest in an order independent of the order of the labels, since sums depend on it.
    number = np.unique(np.array(kinds), return_inverse=True)[1].reshape(-1)
    is_other = np.array([kind != "score" for kind in kinds])
    order = np.lexsort((values, number, second, first, is_other))
    return Judgements(
        different, values[order], tuple(kinds[index] for index in order.tolist()), first[order], second[order]
    )


def label_observations(judgements: Judgements, hyperparameters: Hyperparameters, middle: float) -> LabelObservations:
    """Observations from labels under a kernel."""
    mean, covariance = _given_scores(judgements, hyperparameters)
    mixing, intervals = judgements.mixing, judgements.intervals(middle)
    noise = max(float(np.sqrt(hyperparameters.noise)), MODEL_NOISE)
    spread = covariance @ mixing.T
    sites = propagate(mixing @ mean, mixing @ spread, intervals, noise, START_BLUNDERS)
    # Posterior of the rows, given all sites.
    inner = np.linalg.solve(mixing @ spread + np.diag(sites.variances), spread.T)
    mean, covariance = mean + inner.T @ (sites.means - mixing @ mean), covariance - spread @ inner
    if (judgements.second >= 0).all():
        # Comparisons alone leave the level of all values open, as in `condition`.
        mean = mean - mean[np.append(judgements.first, judgements.second)].mean()
    observations, row_pairs = _observations(judgements, sites.means, sites.variances)
    cavity_means, cavity_variances = sites.cavity()
    noise_variances = intervals.deviation(noise) ** 2
    # An observation is the value plus its noise, between the bounds.
    _, means, variances = matched(intervals, cavity_means, cavity_variances + noise_variances, 0.0, 0.0)
    search_observations, _ = _observations(judgements, means, np.maximum(variances, noise_variances))
    bounds = intervals_of(judgements.scores[judgements.plain]) + intervals
    rows, scores, cell_intervals, label = _for_cells(judgements, intervals, sites, mean, covariance)
    return LabelObservations(
        observations=observations,
        search_observations=search_observations,
        row_pairs=row_pairs,
        bounds=bounds,
        rows=rows,
        scores=scores,
        intervals=cell_intervals,
        label=label,
    )


def propagate(mean: Floats, covariance: Floats, intervals: Intervals, noise: float, blunders: float) -> Sites:
    """Sites for labels of values.

    Args:
        mean: [k] prior means of the values.
        covariance: [k, k] prior covariance of the values.
        intervals: [k] interval of each label.
        noise: standard deviation of the noise of a value, > 0.
        blunders: probability of a blunder.
    """
    sites = _sites(mean, covariance, np.full(len(intervals), _LEAST_PRECISION), np.zeros(len(intervals)))
    for _ in range(MAX_STEPS):
        cavity_means, cavity_variances = sites.cavity()
        _, means, variances = matched(intervals, cavity_means, cavity_variances, noise, blunders)
        precisions = np.maximum(1.0 / variances - 1.0 / cavity_variances, _LEAST_PRECISION)
        shifts = means * (1.0 / cavity_variances + precisions) - cavity_means / cavity_variances
        converged = np.all(np.abs(means - sites.mean) <= _TOLERANCE * np.sqrt(cavity_variances))
        sites = _sites(
            mean,
            covariance,
            sites.precisions + _DAMPING * (precisions - sites.precisions),
            sites.shifts + _DAMPING * (shifts - sites.shifts),
        )
        if converged:
            break
    return sites


def middle_of(judgements: Judgements, hyperparameters: Hyperparameters) -> float:
    """Value at which a person's thumbs turn, from the scores of the models; 50 without scores."""
    thumbs = np.array([kind == "thumb" for kind in judgements.kinds])
    if not thumbs.any() or not judgements.num_scores:
        return MAX_SCORE / 2.0
    mean, covariance = _given_scores(judgements, hyperparameters)
    rows = judgements.first[thumbs]
    thumb_labels = judgements.take(np.flatnonzero(thumbs))
    noise = max(float(np.sqrt(hyperparameters.noise)), MODEL_NOISE)
    values, variances = mean[rows], np.maximum(np.diagonal(covariance)[rows], ROUNDING)
    log_posteriors = [
        float(matched(thumb_labels.intervals(middle), values, variances, noise, START_BLUNDERS)[0].sum())
        - 0.5 * ((middle - MAX_SCORE / 2.0) / _SD_OF_MIDDLE) ** 2
        for middle in _MIDDLE_GRID.tolist()
    ]
    return float(_MIDDLE_GRID[int(np.argmax(log_posteriors))])


def _given_scores(judgements: Judgements, hyperparameters: Hyperparameters) -> tuple[Floats, Floats]:
    """Mean [N] and covariance [N, N] of the values of all rows, given the scores."""
    rows, scored = judgements.rows, judgements.scored()
    scaled = rows * np.sqrt(hyperparameters.weights)
    covariance = hyperparameters.amplitude * np.exp(-0.5 * squared_distances(scaled, scaled))
    if scored is None:
        return np.zeros(len(rows)), covariance
    posterior = condition(hyperparameters, scored)
    across = posterior.covariance_with_observed(rows)
    explained = np.linalg.solve(posterior.factor, across.T)
    return across @ posterior.solution, covariance - explained.T @ explained


def _sites(mean: Floats, covariance: Floats, precisions: Floats, shifts: Floats) -> Sites:
    """Sites, with mean and covariance of the values given them."""
    roots = np.sqrt(precisions)
    inner = roots[:, None] * covariance * roots
    inner.flat[:: len(mean) + 1] += 1.0
    factor = cholesky(inner, lower=True, overwrite_a=True, check_finite=False)
    explained = solve_triangular(factor, roots[:, None] * covariance, lower=True, check_finite=False)
    spread = covariance - explained.T @ explained
    return Sites(precisions, shifts, mean + spread @ (shifts - precisions * mean), spread)


def _observations(judgements: Judgements, means: Floats, variances: Floats) -> tuple[Observations, Ints]:
    """Scores, and normal observations [k] instead of all other labels; and [n, 2] indices of the rows of each."""
    rows, scored, rest = judgements.rows, judgements.scored(), judgements.rest
    # In the order of `observe`: that of their first occurrence.
    plain = judgements.first[judgements.plain]
    scored_rows = plain[np.sort(np.unique(plain, return_index=True)[1])]
    scores, counts, spread = (
        (np.zeros(0), np.zeros(0), 0.0) if scored is None else (scored.means, scored.counts, scored.spread)
    )
    first, second = judgements.first[rest], judgements.second[rest]
    row_pairs = np.column_stack(
        [np.append(scored_rows, first), np.append(scored_rows, np.where(second < 0, first, second))]
    )
    nothing = np.zeros(len(scored_rows))
    differences = Differences(
        rows[row_pairs[:, 1]], np.append(nothing, (second >= 0).astype(np.float64)), np.append(nothing, variances)
    )
    counts, means = np.append(counts, np.ones(len(first))), np.append(scores, means)
    return Observations(rows[row_pairs[:, 0]], means, counts, spread, differences), row_pairs


def _for_cells(
    judgements: Judgements, intervals: Intervals, sites: Sites, mean: Floats, covariance: Floats
) -> tuple[Floats, Floats, Intervals, Ints]:
    plain = judgements.plain
    rest = np.arange(judgements.num_scores, len(judgements.scores))
    compared = judgements.second[rest] >= 0
    alone, pairs = np.flatnonzero(~compared), np.flatnonzero(compared)
    a, b = judgements.first[rest[pairs]], judgements.second[rest[pairs]]
    bounds = intervals.take(pairs)
    to_first = _shifted(bounds, *_without(mean, covariance, a, b, sites, pairs, of_first=False), sign=1.0)
    to_second = _shifted(bounds, *_without(mean, covariance, a, b, sites, pairs, of_first=True), sign=-1.0)
    row_indices = np.concatenate([judgements.first[plain], judgements.first[rest[alone]], a, b])
    known_scores = np.concatenate([judgements.scores[plain], judgements.scores[rest[alone]]])
    scores = np.concatenate([known_scores, np.clip(mean[a], 0.0, MAX_SCORE), np.clip(mean[b], 0.0, MAX_SCORE)])
    row_intervals = intervals_of(judgements.scores[plain]) + intervals.take(alone) + to_first + to_second
    label = np.concatenate([np.arange(judgements.num_scores), rest[alone], rest[pairs], rest[pairs]])
    return judgements.rows[row_indices], scores, row_intervals, label


def _shifted(bounds: Intervals, means: Floats, variances: Floats, *, sign: float) -> Intervals:
    """Bounds of one side from bounds of a difference and the distribution of the other side."""
    low, high = (bounds.low, bounds.high) if sign > 0.0 else (-bounds.high, -bounds.low)
    return Intervals(low + means, high + means, bounds.length, bounds.looks, variances)


def _without(
    mean: Floats, covariance: Floats, a: Ints, b: Ints, sites: Sites, pairs: Ints, *, of_first: bool
) -> tuple[Floats, Floats]:
    """Mean and variance of one side of each comparison, given all other labels."""
    side = a if of_first else b
    across = covariance[side, a] - covariance[side, b]
    between = covariance[a, a] - 2.0 * covariance[a, b] + covariance[b, b]
    precision, shift = sites.precisions[pairs], sites.shifts[pairs]
    cavity_factor = np.maximum(1.0 - precision * between, 1e-6)
    means = mean[side] + across * (precision * (mean[a] - mean[b]) - shift) / cavity_factor
    return means, np.maximum(covariance[side, side] + across**2 * precision / cavity_factor, 0.0)
