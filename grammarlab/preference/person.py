"""The person: the likelihood of a label of any kind given the value of a design, and a prior of its errors.

All models of values take both from here: cells, processes, lines, and the hypothesis that nothing is explained.

A score y means the interval [y - h, y + h] of its scale, open at 0 and 100, where scores are clipped. A score differs
from the value v by normal noise of standard deviation sigma, and with probability pi it is a blunder, a random score:

    p(y | v) = (1 - pi) [Phi((y + h - v) / sigma) - Phi((y - h - v) / sigma)] + pi (length of the interval) / 100

Stars are scores with a larger h, and thumbs tell the side of the person's middle on which the value lies. A comparison
is such an interval of the difference of two values, each with its own noise:

    p(a rather than b | v_a, v_b) = (1 - pi) Phi((v_a - v_b) / (sqrt(2) sigma)) + pi / 2

If ties are allowed, two models are called equal if the difference seems smaller than a few points (Rao and Kupper
1967), and a blunder is one of three answers. If v_b is normal around m_b with variance s^2, the likelihood of v_a is
the same with m_b instead of v_b and 2 sigma^2 + s^2 instead of 2 sigma^2.

A priori, sigma is any of `NOISES`, and pi is one of `BLUNDERS` with a probability in proportion to exp(-40 pi):
blunders explain any score, so they are the last explanation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.polynomial.hermite_e import hermegauss
from numpy.typing import NDArray
from scipy.special import ndtr

from grammarlab.arrays import Floats, Ints, distinct_rows
from grammarlab.preference.base import MAX_SCORE, SCORE_STEP
from grammarlab.preference.labels import SCORES, Kind

NOISES = (0.5, 1.5, 3.0, 5.0, 7.5, 10.0, 13.0, 17.0, 22.0, 28.0)
"""Candidates of sigma, in points."""
BLUNDERS = (0.002, 0.03, 0.06, 0.1, 0.15, 0.25)
"""Candidates of pi."""
PRICE_OF_BLUNDERS = 40.0
"""Log-prior of pi: minus this times pi, in nats."""
EXACT_NOISE = NOISES[1]
"""Largest noise of a person without errors, in points."""
MODEL_NOISES = NOISES[2:]
"""Noises around values of models, which miss the person's values by some points."""
MODEL_NOISE = MODEL_NOISES[0]
"""The least of these, in points."""
START_NOISES = NOISES[6::-3]
"""Noises that searches start with, in points, largest first: trees found under much noise stay small, trees found under
little noise explain the noise."""
START_BLUNDERS = BLUNDERS[1]
"""Probability of blunders that searches start with, and where none is estimated."""
NOISE_PRIOR = (1.0, 1.0)
"""For a model that needs a density of sigma: the median in points, and the standard deviation of log sigma."""

DISLIKED = 0.25
"""Prior probability that a value is 0."""
VALUE_STEP = 4.0
"""Step of the possible values, in points."""

TIE_DIFFERENCE = 5.0
"""Difference in points below which a person who uses ties calls two models equal."""
_MIN_LIKELIHOOD = 1e-12
"""Smallest likelihood of a score, for any noise."""
_NUM_NODES = 15
"""Number of nodes of means over a normal distribution, odd, so that one is at the mean. More are only slower."""

Singles = NDArray[np.float32]


class Person(NamedTuple):
    """Errors of a person."""

    noise: float
    """sigma: standard deviation of a score around its value, in points."""
    blunders: float
    """pi: probability of a random score."""

    @property
    def price(self) -> float:
        """Minus the log of the prior, up to a constant, in nats."""
        return PRICE_OF_BLUNDERS * self.blunders

    @property
    def errs(self) -> bool:
        """Whether it has more than the least errors."""
        return self.noise > NOISES[0] or self.blunders > BLUNDERS[0]


PERSONS = tuple(Person(noise, blunders) for noise in NOISES for blunders in BLUNDERS)
"""All candidates."""
START_PERSONS = tuple(Person(noise, START_BLUNDERS) for noise in START_NOISES)
"""Those that searches start with."""


@dataclass(frozen=True, slots=True)
class Intervals:
    """Intervals of labels: a value with noise lies between two bounds."""

    low: Floats
    """[n] points; minus infinity if the interval is open."""
    high: Floats
    """[n] points; infinity if the interval is open."""
    length: Floats
    """[n] probability of the label by chance, in percent."""
    looks: Floats
    """[n] number of values with noise: 1, or 2 in comparisons."""
    variance: Floats
    """[n] >= 0, variance of the bounds, in squared points; 0 if they are known."""

    def __len__(self) -> int:
        return len(self.low)

    def __add__(self, other: Intervals) -> Intervals:
        both = zip(self._columns(), other._columns(), strict=True)
        return Intervals(*(np.concatenate(pair) for pair in both))

    def take(self, selection: Ints | NDArray[np.bool_]) -> Intervals:
        """Selected intervals."""
        return Intervals(*(column[selection] for column in self._columns()))

    def different(self) -> tuple[Ints, Ints]:
        """Index [K] of the first of each different interval, ascending, and the number [n] of each."""
        return distinct_rows(*self._columns())

    def deviation(self, noise: float) -> Floats:
        """[n] standard deviation of labels around the value."""
        return np.sqrt(self.looks * (noise * noise) + self.variance)

    def _columns(self) -> tuple[Floats, ...]:
        return self.low, self.high, self.length, self.looks, self.variance


def intervals_of(scores: Floats, half_step: float = SCORE_STEP / 2.0) -> Intervals:
    """Intervals of scores [n] of 0 to 100 on a scale with a given step in points."""
    at_bottom, at_top = scores <= half_step / 2.0, scores >= MAX_SCORE - half_step / 2.0
    low = np.where(at_bottom, -np.inf, scores - half_step)
    high = np.where(at_top, np.inf, scores + half_step)
    length = np.where(at_bottom | at_top, half_step, 2.0 * half_step)
    return Intervals(low, high, length, np.ones(len(scores)), np.zeros(len(scores)))


def intervals_of_kinds(scores: Floats, kinds: Sequence[Kind], middle: float) -> Intervals:
    """Intervals of labels [n] of any kind: of values, or of differences of two.

    Args:
        scores: [n] 0-100, as in label tables.
        kinds: [n] kinds of the labels.
        middle: values above it get a thumb up, in points.

    >>> bounds = intervals_of_kinds(np.array([80.0, 75.0, 100.0, 100.0]), ["score", "stars", "thumb", "rather"], 50.0)
    >>> bounds.low.tolist(), bounds.high.tolist()
    ([79.5, 62.5, 50.0, 0.0], [80.5, 87.5, inf, inf])
    """
    names = np.array(kinds, dtype=object)
    thumb, rather, tied, up = names == "thumb", names == "rather", names == "tie", scores > MAX_SCORE / 2.0
    alike = TIE_DIFFERENCE if tied.any() else 0.0
    low, high = np.full(len(names), -np.inf), np.full(len(names), np.inf)
    low, high = np.where(thumb & up, middle, low), np.where(thumb & ~up, middle, high)
    low, high = np.where(rather, alike, np.where(tied, -alike, low)), np.where(tied, alike, high)
    length = np.where(rather | tied, MAX_SCORE / (3.0 if tied.any() else 2.0), MAX_SCORE / 2.0)
    for kind, half_step in (("score", SCORE_STEP / 2.0), ("stars", SCORES["stars"][1] / 2.0)):
        of_kind, steps = names == kind, intervals_of(scores, half_step)
        low, high = np.where(of_kind, steps.low, low), np.where(of_kind, steps.high, high)
        length = np.where(of_kind, steps.length, length)
    looks = np.where(rather | tied, 2.0, 1.0)
    return Intervals(low, high, length, looks, np.zeros(len(names)))


def possible_values() -> Floats:
    """[G] possible values of designs in points, from 0 to 100 in even steps."""
    return np.arange(0.0, MAX_SCORE + VALUE_STEP / 2.0, VALUE_STEP)


def prior_of_values() -> Floats:
    """[G] prior probability of each of `possible_values`."""
    num = len(possible_values())
    return np.append(DISLIKED, np.full(num - 1, (1.0 - DISLIKED) / (num - 1)))


def log_likelihood(scores: Floats | Intervals, values: Floats, noise: float, blunders: float) -> Singles:
    """[n, G] log p(y | v) of labels [n] for values [G], 0 to 100.

    Args:
        scores: scores of 0 to 100, or intervals.
        values: possible values.
        noise: sigma > 0, in points.
        blunders: pi, 0 to 1.

    >>> np.exp(log_likelihood(np.array([0.0, 50.0]), np.array([0.0, 50.0]), 0.1, 0.0)).round(3).tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    intervals = scores if isinstance(scores, Intervals) else intervals_of(scores)
    low, high, length = intervals.low[:, None], intervals.high[:, None], intervals.length[:, None]
    deviation = intervals.deviation(noise)[:, None]
    probability = ndtr((high - values) / deviation) - ndtr((low - values) / deviation)
    return np.log((1.0 - blunders) * probability + blunders * length / MAX_SCORE + _MIN_LIKELIHOOD).astype(np.float32)


def matched(
    intervals: Intervals, means: Floats, variances: Floats, noise: float, blunders: float
) -> tuple[Floats, Floats, Floats]:
    """Log-evidence [n], posterior mean [n] and variance [n] of values with normal priors, given labels.

    Args:
        intervals: [n] intervals of the labels.
        means: [n] prior means of the values.
        variances: [n] prior variances, > 0.
        noise: sigma >= 0, in points.
        blunders: pi, 0 to 1.
    """
    deviation = np.sqrt(variances + intervals.deviation(noise) ** 2)
    low, high = (intervals.low - means) / deviation, (intervals.high - means) / deviation
    evidence = (1.0 - blunders) * (ndtr(high) - ndtr(low)) + blunders * intervals.length / MAX_SCORE + _MIN_LIKELIHOOD
    # First and second derivative of the evidence by the mean, divided by it.
    slope = (1.0 - blunders) * (_density(low) - _density(high)) / deviation / evidence
    curvature = (1.0 - blunders) * (_moment(low) - _moment(high)) / deviation**2 / evidence
    variance = variances + variances**2 * (curvature - slope**2)
    return np.log(evidence), means + variances * slope, np.maximum(variance, 1e-6 * variances)


def expected_score(values: Floats, noise: float, blunders: float) -> Floats:
    """[m] mean score of values [m]: above the value near 0, below it near 100.

    >>> expected_score(np.array([0.0, 50.0]), 10.0, 0.0).round(2).tolist()
    [3.99, 50.0]
    """
    low, high = values / noise, (MAX_SCORE - values) / noise
    # E max(0, v + e) is v Phi(v / sigma) + sigma phi(v / sigma); the part above 100 is clipped in the same way.
    above_0 = values * ndtr(low) + noise * _density(low)
    above_100 = (values - MAX_SCORE) * ndtr(-high) + noise * _density(high)
    return (1.0 - blunders) * (above_0 - above_100) + blunders * MAX_SCORE / 2.0


def value_of(scores: Floats, noise: float, blunders: float) -> Floats:
    """[m] values with the given mean scores: the inverse of `expected_score`, within 0 to 100."""
    values = np.linspace(0.0, MAX_SCORE, 401)
    return np.interp(scores, expected_score(values, noise, blunders), values)


def mean_value(means: Floats, sds: Floats, noise: float, blunders: float = 0.0) -> Floats:
    """[m] mean of values whose mean score is normal, with given means [m] and standard deviations [m]."""
    nodes, masses = hermegauss(_NUM_NODES)
    return masses @ value_of(means + nodes[:, None] * sds, noise, blunders) / masses.sum()


def _density(deviations: Floats) -> Floats:
    return np.exp(-0.5 * deviations**2) / np.sqrt(2.0 * np.pi)


def _moment(deviations: Floats) -> Floats:
    """The normal density at x, times x: 0 at infinity."""
    finite = np.clip(deviations, -40.0, 40.0)
    return finite * _density(finite)
