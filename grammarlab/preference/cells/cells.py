"""Cells: sets of labels that share one value, and their evidence.

The value of a cell is one of a grid from 0 to 100. A priori it is 0 with some probability (disliked designs), one of
the values that other cells seem to have, or any. The evidence of a cell C is

    log sum_v p(v | other cells) prod_{i in C} p(y_i | v).

Values of other cells are counted without the labels of C: a score that was given once is not a level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.person import DISLIKED, Intervals, Person, Singles, log_likelihood, possible_values

SHARED_PROBABILITY = 0.6
"""Prior probability that it has the value of other cells, once there are `_NUM_SHARING` of them."""
_NUM_SHARING = 6.0
"""Number of other cells from which on a cell has their values with the probability `SHARED_PROBABILITY`."""
_GRID_SHARE = 0.8
"""Share of the prior of new values on the even grid; the rest is on given scores."""
_MAX_SCORES = 24
"""Largest number of different scores that are all on the grid."""
_NUM_QUANTILES = 12
"""Number of quantiles of the scores on the grid, if there are more different scores."""
_FAINT_SDS, _FAINT_FACTOR = 1.5, 0.1
"""Values below this many standard deviations of the noise are this many times as likely; 0 gets the difference."""
_MIN_NUM_CELLS = 1e-5
"""Number of cells below which there are none: sums of floats are not exact."""


@dataclass(frozen=True, eq=False)
class Levels:
    """Values that labels seem to have; each cell counts once."""

    values: Singles
    """[n, G] share of a label in its cell, times the posterior of the cell."""
    shares: Singles
    """[n] share of a label in its cell."""


def grid_of(scores: Floats) -> Floats:
    """[G] possible values of a cell, ascending: an even grid, and the given scores.

    Args:
        scores: [n] 0-100.
    """
    distinct = np.unique(scores.round(3))
    if len(distinct) > _MAX_SCORES:
        distinct = np.quantile(distinct, np.linspace(0.0, 1.0, _NUM_QUANTILES))
    return np.unique(np.concatenate([possible_values(), distinct]))


@dataclass(frozen=True, eq=False)
class ScoreCells:
    """Labels, with the error model of the person."""

    scores: Floats
    """[n] scores in points, 0-100."""
    grid: Floats
    """[G] possible values of a cell in points, ascending."""
    noise: float
    """Standard deviation in points."""
    blunders: float
    """Probability of a random score."""
    levels: Levels | None = None
    """Values of earlier cells; None if there are none."""
    intervals: Intervals | None = None
    """[n] intervals of the labels; None if they are scores."""

    @cached_property
    def log_likelihood(self) -> Singles:
        """[n, G] log-likelihood of each label for each value."""
        intervals = self.scores if self.intervals is None else self.intervals
        return log_likelihood(intervals, self.grid, self.noise, self.blunders)

    @property
    def person(self) -> Person:
        """The errors of the person."""
        return Person(self.noise, self.blunders)

    def for_person(self, person: Person) -> ScoreCells:
        """The labels for another person, whose values are not known yet."""
        return replace(self, noise=person.noise, blunders=person.blunders, levels=None)

    def log_evidence(self, members: Singles) -> Floats:
        """[k] log-evidence of parts of the labels.

        Args:
            members: [k, n] 1 if a label is in a part, else 0. An empty part has evidence 0.
        """
        return self._evidence(members @ self._terms)

    def of_labels(self, labels: Ints) -> float:
        """Log-evidence of one cell."""
        return float(self._evidence(self._terms[labels].sum(axis=0, keepdims=True))[0])

    def posterior(self, cell: Ints) -> Floats:
        """[G] probability of each value of a cell."""
        sums = self._terms[cell].sum(axis=0, keepdims=True)
        log_likelihood = sums[0, : len(self.grid)]
        odds = self._prior(sums)[0] * np.exp(log_likelihood - log_likelihood.max())
        return (odds / odds.sum()).astype(np.float64)

    def best_possible(self, labels: Ints) -> float:
        """Upper bound on the evidence of divisions of a cell."""
        return float(self.log_likelihood[labels].max(axis=1).sum())

    @cached_property
    def terms(self) -> Floats:
        """[n, W] terms of the labels, whose sums over a part give its evidence."""
        return self._terms.astype(np.float64)

    def of_sums(self, sums: Floats) -> Floats:
        """[...] log-evidence of parts from the sums [..., W] of their terms; an empty part has 0."""
        parts = sums.reshape(-1, sums.shape[-1]).astype(np.float32)
        return self._evidence(parts).reshape(sums.shape[:-1]).astype(np.float64)

    def _evidence(self, sums: Singles) -> Floats:
        """[k] log-evidence of parts whose sums of `_terms` are [k, 2 G + 1]."""
        size = len(self.grid)
        log_likelihood = sums[:, :size]
        highest = log_likelihood.max(axis=1, keepdims=True)
        likelihood = np.exp(log_likelihood - highest)
        if self.levels is None:
            odds = likelihood @ self._base[0]
        else:
            # The prior is a mixture, so its parts are added up without making it for each part.
            base, total = (likelihood @ self._mixed).T
            outside = total - np.einsum("kg,kg->k", likelihood, sums[:, size:-1])
            share, number = self._shared(sums)
            odds = base * (1.0 - share) + share * np.maximum(outside, 0.0) / np.maximum(number, _MIN_NUM_CELLS)
        return np.log(odds + np.finfo(np.float32).tiny) + highest[:, 0]

    def _prior(self, sums: Singles) -> Singles:
        """[k or 1, G] prior of the values of parts, given the values of labels outside."""
        if self.levels is None:
            return self._base
        outside = np.maximum(self._all[len(self.grid) : -1] - sums[:, len(self.grid) : -1], 0.0)
        share, number = (column[:, None] for column in self._shared(sums))
        prior = self._base * (1.0 - share) + share * outside / np.maximum(number, _MIN_NUM_CELLS)
        return prior.astype(np.float32)

    def _shared(self, sums: Singles) -> tuple[Singles, Singles]:
        """[k] prior probability that a part has the value of a cell outside, and [k] number of these cells."""
        number = np.maximum(self._all[-1] - sums[:, -1], np.float32(0.0))
        share = np.where(number > _MIN_NUM_CELLS, SHARED_PROBABILITY * np.minimum(number / _NUM_SHARING, 1.0), 0.0)
        return share.astype(np.float32), number

    @cached_property
    def _terms(self) -> Singles:
        """[n, G] log-likelihood of labels; with levels [n, 2 G + 1]: also their values, and shares of a cell."""
        if self.levels is None:
            return self.log_likelihood
        return np.column_stack([self.log_likelihood, self.levels.values, self.levels.shares])

    @cached_property
    def _all(self) -> Singles:
        """The sum of all labels."""
        return self._terms.sum(axis=0)

    @cached_property
    def _mixed(self) -> Singles:
        """[G, 2] prior without other cells, and the sum of the values of all cells."""
        return np.column_stack([self._base[0], self._all[len(self.grid) : -1]])

    @cached_property
    def _base(self) -> Singles:
        """[1, G] prior of the values of a cell, independent of other cells."""
        even = np.isin(self.grid, possible_values())
        prior = (1.0 - DISLIKED) * (_GRID_SHARE * even / even.sum() + (1.0 - _GRID_SHARE) / len(self.grid))
        # A person with errors gives a few points to designs of value 0; real levels are higher.
        faint = (self.grid > 0.0) & (self.grid < _FAINT_SDS * self.noise)
        prior[0] += DISLIKED + (1.0 - _FAINT_FACTOR) * prior[faint].sum()
        prior[faint] *= _FAINT_FACTOR
        return prior[None].astype(np.float32)


def levels_of(cells: ScoreCells, divisions: Sequence[tuple[float, Sequence[Ints]]]) -> Levels:
    """Values of the cells of divisions of all labels.

    Args:
        cells: the labels and the error model.
        divisions: the share of each division, all together 1, and its cells.
    """
    values, shares = np.zeros(cells.log_likelihood.shape), np.zeros(len(cells.scores))
    for share, parts in divisions:
        for cell in parts:
            values[cell] += share * cells.posterior(cell) / len(cell)
            shares[cell] += share / len(cell)
    return Levels(values.astype(np.float32), shares.astype(np.float32))
