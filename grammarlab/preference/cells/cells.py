"""Cells: sets of labels that share one value, and their evidence.

The value of a cell is one of a grid from 0 to 100. A priori it is 0 with some probability (disliked designs), one of
the values that other cells seem to have, or any. The evidence of a cell C is

    log sum_v p(v | other cells) prod_{i in C} p(y_i | v).

Values of other cells are counted without the labels of C: a score that was given once is not a level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.cells.split_ranking import Ranked, rank
from grammarlab.preference.cells.splits import Splits
from grammarlab.preference.likelihood import Intervals, Singles, log_likelihood

ZERO = 0.25
"""Prior probability that the value of a cell is 0."""
SHARED = 0.6
"""Prior probability that it has the value of other cells, once there are `_ENOUGH` of them."""
_ENOUGH = 6.0
_STEP = 4.0
_ON_GRID = 0.8
"""Share of the prior of new values on the even grid; the rest is on given scores."""
_MOST_SCORES = 24
_FEWER_SCORES = 12
_FAINT, _OF_FAINT = 1.5, 0.1
"""Values below this many standard deviations of the noise are this many times as likely; 0 gets the difference."""
_TINY = 1e-30
_NONE = 1e-5
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
    given = np.unique(scores.round(3))
    if len(given) > _MOST_SCORES:
        given = np.quantile(given, np.linspace(0.0, 1.0, _FEWER_SCORES))
    return np.unique(np.concatenate([np.arange(0.0, MAX_SCORE + _STEP / 2.0, _STEP), given]))


@dataclass(frozen=True, eq=False)
class ScoreCells:
    """Labels, with the error model of the person."""

    splits: Splits
    scores: Floats
    """[n] scores."""
    grid: Floats
    """[G] possible values."""
    noise: float
    """Standard deviation in points."""
    blunders: float
    """Probability of a random score."""
    levels: Levels | None = None
    """Values of earlier cells; None if there are none."""
    said: Intervals | None = None
    """[n] intervals of the labels; None if they are scores."""

    @cached_property
    def log_likelihood(self) -> Singles:
        """[n, G] log-likelihood of each label for each value."""
        said = self.scores if self.said is None else self.said
        return log_likelihood(said, self.grid, self.noise, self.blunders)

    @cached_property
    def _known(self) -> dict[bytes, Ranked | None]:
        """Cache of ranked cells: trees share most of their cells near the root."""
        return {}

    def log_evidence(self, members: Singles, labels: Ints) -> Floats:
        """[k] log-evidence of parts of some labels.

        Args:
            members: [k, c] 1 if a label is in a part, else 0. An empty part has evidence 0.
            labels: [c] indices.
        """
        return self._evidence(members @ self._told[labels])

    def of_cell(self, cell: Ints) -> float:
        """Evidence of one cell."""
        return float(self._evidence(self._told[cell].sum(axis=0, keepdims=True))[0])

    def posterior(self, cell: Ints) -> Floats:
        """[G] probability of each value of a cell."""
        sums = self._told[cell].sum(axis=0, keepdims=True)
        log_likelihood = sums[0, : len(self.grid)]
        odds = self._prior(sums)[0] * np.exp(log_likelihood - log_likelihood.max())
        return (odds / odds.sum()).astype(np.float64)

    def best_possible(self, cell: Ints) -> float:
        """Upper bound on the evidence of divisions of a cell."""
        return float(self.log_likelihood[cell].max(axis=1).sum())

    def ranked(self, cell: Ints, ahead: bool = False) -> Ranked | None:
        """Splits of a cell; None if there are none.

        Args:
            cell: labels.
            ahead: whether to look one step ahead.
        """
        key = bytes([ahead]) + cell.tobytes()
        if key not in self._known:
            self._known[key] = rank(self.splits, cell, self._told[cell], self._evidence, ahead=ahead)
        return self._known[key]

    def _evidence(self, sums: Singles) -> Floats:
        """[k] log-evidence of parts whose sums of `_told` are [k, 2 G + 1]."""
        size = len(self.grid)
        log_likelihood = sums[:, :size]
        highest = log_likelihood.max(axis=1, keepdims=True)
        likelihood = np.exp(log_likelihood - highest)
        if self.levels is None:
            odds = likelihood @ self._base[0]
        else:
            # The prior is a mixture, so its parts are added up without making it for each part.
            own, every = (likelihood @ self._mixed).T
            outside = every - np.einsum("kg,kg->k", likelihood, sums[:, size:-1])
            share, number = self._shared(sums)
            odds = own * (1.0 - share) + share * np.maximum(outside, 0.0) / np.maximum(number, _TINY)
        return np.log(odds + _TINY) + highest[:, 0]

    def _prior(self, sums: Singles) -> Singles:
        """[k or 1, G] prior of the values of parts, given the values of labels outside."""
        if self.levels is None:
            return self._base
        outside = np.maximum(self._all[len(self.grid) : -1] - sums[:, len(self.grid) : -1], 0.0)
        share, number = (column[:, None] for column in self._shared(sums))
        prior = self._base * (1.0 - share) + share * outside / np.maximum(number, _TINY)
        return prior.astype(np.float32)

    def _shared(self, sums: Singles) -> tuple[Singles, Singles]:
        """[k] prior probability that a part has the value of a cell outside, and [k] number of these cells."""
        number = np.maximum(self._all[-1] - sums[:, -1], np.float32(0.0))
        share = np.where(number > _NONE, SHARED * np.minimum(number / _ENOUGH, 1.0), 0.0)
        return share.astype(np.float32), number

    @cached_property
    def _told(self) -> Singles:
        """[n, G] log-likelihood of labels; with levels [n, 2 G + 1]: also their values, and shares of a cell."""
        if self.levels is None:
            return self.log_likelihood
        return np.column_stack([self.log_likelihood, self.levels.values, self.levels.shares])

    @cached_property
    def _all(self) -> Singles:
        """The sum of all labels."""
        return self._told.sum(axis=0)

    @cached_property
    def _mixed(self) -> Singles:
        """[G, 2] prior without other cells, and the sum of the values of all cells."""
        return np.column_stack([self._base[0], self._all[len(self.grid) : -1]])

    @cached_property
    def _base(self) -> Singles:
        """[1, G] prior of the values of a cell, independent of other cells."""
        even = np.isin(self.grid, np.arange(0.0, MAX_SCORE + _STEP / 2.0, _STEP))
        prior = (1.0 - ZERO) * (_ON_GRID * even / even.sum() + (1.0 - _ON_GRID) / len(self.grid))
        # A person with errors gives a few points to designs of value 0; real levels are higher.
        faint = (self.grid > 0.0) & (self.grid < _FAINT * self.noise)
        prior[0] += ZERO + (1.0 - _OF_FAINT) * prior[faint].sum()
        prior[faint] *= _OF_FAINT
        return prior[None].astype(np.float32)


def levels_of(cells: ScoreCells, found: Sequence[tuple[float, Sequence[Ints]]]) -> Levels:
    """Values of the cells of divisions of all labels.

    Args:
        cells: the labels and the error model.
        found: the share of each division, all together 1, and its cells.
    """
    values, shares = np.zeros(cells.log_likelihood.shape), np.zeros(len(cells.scores))
    for share, parts in found:
        for cell in parts:
            values[cell] += share * cells.posterior(cell) / len(cell)
            shares[cell] += share / len(cell)
    return Levels(values.astype(np.float32), shares.astype(np.float32))
