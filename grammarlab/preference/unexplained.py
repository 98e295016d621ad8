"""The hypothesis that no column explains the scores: every design draws its value from one distribution.

With h(v) the probability of a value v of the grid and p(y | v) the likelihood of a score under a person's error
(`grammarlab.preference.person`), n scores have the log-likelihood

    sum_i log sum_v h(v) p(y_i | v) + sum_v log(h(v)) / G,

whose second term is one pseudo-count, spread evenly over the G values. Expectation-maximisation finds h. Parts of the
scores are held out in turn, so that a distribution is not better for having seen the scores that it predicts.
A single value for all designs would be a straw man: it explains no scores that differ, so anything else seems proven.
Values are those of the cells (`grammarlab.preference.cells.cells.grid_of`): a finer grid would gain more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import SEVERAL, Floats, Ints
from grammarlab.preference.person import (
    PERSONS,
    Intervals,
    Person,
    intervals_of,
    log_likelihood,
    possible_values,
    prior_of_values,
)

NUM_FOLDS = 8
"""Number of parts of the scores, each held out once."""
_NUM_ITERATIONS = 60
"""Iterations of expectation-maximisation: more change held-out likelihoods by less than a tenth of a nat."""


@dataclass(frozen=True, eq=False)
class Unexplained:
    """The best distribution of values, and the most likely person under it."""

    grid: Floats
    """[G] possible values, in points."""
    probabilities: Floats
    """[G] probability of each value; the sum is 1."""
    person: Person
    """The most likely person."""
    log_evidence: float
    """Log-likelihood of held-out scores in nats, less the price of the person."""
    held_out: Floats
    """[K, G] the same without the scores of each part."""
    level: float
    """Mean value of the scored designs, in points, given their scores and that none is a blunder."""

    @property
    def sd(self) -> float:
        """Standard deviation of a score of any design, in points."""
        variance = self.probabilities @ (self.grid - self.probabilities @ self.grid) ** 2
        return float(np.sqrt(variance + self.person.noise**2))


def unexplained(
    labels: Floats | Intervals, fold: Ints, grid: Floats, persons: Sequence[Person] = PERSONS
) -> Unexplained:
    """The hypothesis for some labels.

    Args:
        labels: [n] scores of 0 to 100, or intervals of labels that are not scores.
        fold: [n] part of each label, from 0, see `folds_of`. If there is only one, it is predicted without any label.
        grid: [G] possible values, in points.
        persons: candidates.
    """
    intervals = labels if isinstance(labels, Intervals) else intervals_of(labels)
    # There are few different scores, however many are given.
    first, kind = intervals.different()
    different = intervals.take(first)
    likelihoods = np.stack([np.exp(log_likelihood(different, grid, *person).astype(np.float64)) for person in persons])
    num_folds = int(fold.max()) + 1
    number = np.bincount(fold * len(first) + kind, minlength=num_folds * len(first)).reshape(num_folds, len(first))
    times = number.sum(axis=0).astype(np.float64)
    distributions = distribution(likelihoods, times - number)
    predicted = distributions @ np.swapaxes(likelihoods, 1, 2)
    log_evidence = (number * np.log(predicted)).sum(axis=(1, 2)) - np.array([person.price for person in persons])
    best = int(np.argmax(log_evidence))
    probabilities = distribution(likelihoods[best], times[None])[0]
    joint = probabilities * np.exp(log_likelihood(different, grid, persons[best].noise, 0.0))
    level = float(np.average(joint @ grid / joint.sum(axis=1), weights=times))
    return Unexplained(
        grid=grid,
        probabilities=probabilities,
        person=persons[best],
        log_evidence=float(log_evidence[best]),
        held_out=distributions[best],
        level=level,
    )


def log_evidence_of_values(scores: Floats) -> float:
    """Log-evidence of one distribution of values, whatever it is, less the price of the most likely person, in nats.

    Values are draws of a Dirichlet process whose mean is the prior of a value, with a concentration of 1. Scores are
    predicted one after the other: the next one by h, which then moves by 1 / (i + 2) towards the posterior of its value
    (predictive recursion, Newton 2002). For scores without errors this is exact. With errors, other orders give other
    numbers: it is the mean over some random orders of the sorted scores.

    Args:
        scores: [n] 0-100.

    >>> float(np.exp(log_evidence_of_values(np.array([0.0, 0.0])) + PERSONS[0].price).round(2))
    0.11
    """
    different, kind = np.unique(scores, return_inverse=True)
    likelihoods = np.stack([np.exp(log_likelihood(different, possible_values(), *person)) for person in PERSONS])
    randomness = np.random.default_rng(0)
    orders = np.stack([randomness.permutation(np.sort(kind)) for _ in range(SEVERAL)])
    values = np.tile(prior_of_values(), (len(PERSONS), SEVERAL, 1))
    total = np.zeros((len(PERSONS), SEVERAL))
    for number, kinds in enumerate(orders.T):
        joint = values * likelihoods[:, kinds]
        predicted = joint.sum(axis=2)
        total += np.log(predicted)
        values += (joint / predicted[:, :, None] - values) / (number + 2.0)
    means = np.logaddexp.reduce(total, axis=1) - np.log(SEVERAL)
    return float((means - np.array([person.price for person in PERSONS])).max())


def distribution(likelihoods: Floats, counts: Floats) -> Floats:
    """[..., K, G] distributions of values by expectation-maximisation, each of the labels that count for it.

    Args:
        likelihoods: [..., n, G] likelihood of each label for each value, > 0.
        counts: [K, n] >= 0, how often each label counts.
    """
    size = likelihoods.shape[-1]
    values = np.full((*likelihoods.shape[:-2], len(counts), size), 1.0 / size)
    for _ in range(_NUM_ITERATIONS):
        expected = values @ np.swapaxes(likelihoods, -1, -2)
        values = values * ((counts / expected) @ likelihoods) + 1.0 / size
        values /= values.sum(axis=-1, keepdims=True)
    return values


def folds_of(rows: Floats, seed: int, num: int = NUM_FOLDS) -> Ints:
    """[n] number of the part of each label, from 0, with about as many different rows in each; equal rows together.

    If they were apart, one would predict the other.

    Args:
        rows: [n, F] rows of the labels.
        seed: seed of the random parts.
        num: largest number of parts; fewer if there are fewer different rows.
    """
    _, row = np.unique(rows, axis=0, return_inverse=True)
    different = int(row.max()) + 1
    num = min(num, different)
    # Every part has a row, since the numbers of the first rows are permuted among themselves.
    order = np.random.default_rng(seed).permutation(different)
    return (order % num)[row.reshape(-1)]
