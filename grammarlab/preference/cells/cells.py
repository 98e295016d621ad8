"""Cells: sets of labels that share one value, and their evidence.

The value of a cell is one of a grid from 0 to 100. A priori it is 0 with some probability (disliked designs), or any.
The evidence of a cell C is

    log sum_v p(v) prod_{i in C} p(y_i | v).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from grammarlab.arrays import MANY, Floats, Ints
from grammarlab.preference.person import DISLIKED, Intervals, Person, Singles, log_likelihood, possible_values

_GRID_SHARE = 0.8
"""Share of the prior of values on the even grid; the rest is on given scores."""
_FAINT_SDS, _FAINT_FACTOR = 1.5, 0.1
"""Values below this many standard deviations of the noise are this many times as likely; 0 gets the difference."""


def grid_of(scores: Floats) -> Floats:
    """[G] possible values of a cell, ascending: an even grid, and given scores, of many different ones some.

    Args:
        scores: [n] 0-100.
    """
    given = np.quantile(np.unique(scores), np.linspace(0.0, 1.0, MANY), method="nearest")
    return np.union1d(possible_values(), given)


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
        """The labels for another person."""
        return replace(self, noise=person.noise, blunders=person.blunders)

    def log_evidence(self, members: Singles) -> Floats:
        """[k] log-evidence of parts of the labels.

        Args:
            members: [k, n] 1 if a label is in a part, else 0. An empty part has evidence 0.
        """
        return self._evidence(members @ self.log_likelihood)

    def of_labels(self, labels: Ints) -> float:
        """Log-evidence of one cell."""
        return float(self._evidence(self.log_likelihood[labels].sum(axis=0, keepdims=True))[0])

    def posterior(self, cell: Ints) -> Floats:
        """[G] probability of each value of a cell."""
        sums = self.log_likelihood[cell].sum(axis=0)
        odds = self._prior * np.exp(sums - sums.max())
        return (odds / odds.sum()).astype(np.float64)

    def best_possible(self, labels: Ints) -> float:
        """Upper bound on the evidence of divisions of a cell."""
        return float(self.log_likelihood[labels].max(axis=1).sum())

    @property
    def terms(self) -> Floats:
        """[n, G] terms of the labels, whose sums over a part give its evidence."""
        return self._terms

    @cached_property
    def _terms(self) -> Floats:
        return self.log_likelihood.astype(np.float64)

    def of_sums(self, sums: Floats) -> Floats:
        """[...] log-evidence of parts from the sums [..., G] of their terms; an empty part has 0."""
        parts = sums.reshape(-1, sums.shape[-1]).astype(np.float32)
        return self._evidence(parts).reshape(sums.shape[:-1]).astype(np.float64)

    def _evidence(self, sums: Singles) -> Floats:
        """[k] log-evidence of parts whose log-likelihoods for each value are [k, G]."""
        highest = sums.max(axis=1, keepdims=True)
        return np.log(np.exp(sums - highest) @ self._prior + np.finfo(np.float32).tiny) + highest[:, 0]

    @cached_property
    def _prior(self) -> Singles:
        """[G] prior of the value of a cell."""
        even = np.isin(self.grid, possible_values())
        prior = (1.0 - DISLIKED) * (_GRID_SHARE * even / even.sum() + (1.0 - _GRID_SHARE) / len(self.grid))
        # A person with errors gives a few points to designs of value 0; real levels are higher.
        faint = (self.grid > 0.0) & (self.grid < _FAINT_SDS * self.noise)
        prior[0] += DISLIKED + (1.0 - _FAINT_FACTOR) * prior[faint].sum()
        prior[faint] *= _FAINT_FACTOR
        return prior.astype(np.float32)
