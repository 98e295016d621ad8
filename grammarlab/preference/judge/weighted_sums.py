"""Sums of columns that scores choose: with weights, or with signs only.

A weighted sum is one of draws, counts and flags, above or below a bound of which is liked. The weights are those of a
logistic regression of being liked, to which columns are added one by one, relative to the weight that matters most and
rounded to one digit or to two. The price is that of the columns and of the digits.

A signed sum is one of three columns or more with any signs. There are too many to make them all, so each grows by the
column that explains most; its price is that of its choice among all of its size.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import comb
from typing import NamedTuple

import numpy as np
from scipy.special import expit, gammaln

from grammarlab.arrays import Floats
from grammarlab.preference.base import SEVERAL
from grammarlab.preference.growth.screening import coarse_bins, gains
from grammarlab.preference.judge.votes import MAX_TERMS
from grammarlab.preference.lines.distinct import Distinct
from grammarlab.preference.newton import Height, climbed

_SPREAD = 10.0
"""Standard deviation of the weight per standard deviation of a column, before any score."""
_MAX_SIGNED = 120
"""Largest number of columns that grow into signed sums, those that explain most: all pairs of the beam and these are
tried."""


class WeightedSum(NamedTuple):
    """A weighted sum of columns."""

    columns: tuple[int, ...]
    """Indices of the columns, the one that matters most first."""
    weights: tuple[float, ...]
    """Their weights; the first is 1."""
    price: float
    """Description length in nats: of the number of columns, of the set of columns, and of the digits and signs."""

    def values(self, columns: Floats) -> Floats:
        """[n] the sum, for columns [n, F]."""
        return columns[:, list(self.columns)] @ np.array(self.weights)


def weighted_sums(columns: Floats, scores: Floats) -> Iterator[WeightedSum]:
    """Sums that may explain scores: of all columns, and of those alone that are no flags.

    Args:
        columns: [n, F] numbers.
        scores: [n] 0-100.

    >>> columns = np.random.default_rng(0).random((200, 6))
    >>> scores = 100.0 * (columns[:, 1] - 0.5 * columns[:, 4] > 0.2)
    >>> any(some.columns == (1, 4) and some.weights == (1.0, -0.5) for some in weighted_sums(columns, scores))
    True
    """
    liked = scores > (scores.min() + scores.max()) / 2.0
    if not 0 < liked.sum() < len(liked):
        return
    is_flag = ((columns == 0.0) | (columns == 1.0)).all(axis=0)
    seen = set[tuple[tuple[int, ...], tuple[float, ...]]]()
    for chosen in (np.flatnonzero(~is_flag), np.arange(columns.shape[1])):
        distinct = Distinct.of(columns[:, chosen])
        for terms, weights in _grown(distinct.table(columns[:, chosen]), liked.astype(np.float64)):
            raw = weights / distinct.scales[terms]
            order = np.argsort(-np.abs(weights), kind="stable")
            indices = tuple(chosen[distinct.columns[terms]][order].tolist())
            for digits in (1, 2):
                rounded = _rounded(raw[order] / raw[order[0]], digits)
                if (indices, rounded) not in seen and all(rounded):
                    seen.add((indices, rounded))
                    yield WeightedSum(indices, rounded, _price(len(distinct.columns), len(indices), digits))


def _price(num: int, size: int, digits: int) -> float:
    """Price of a sum of some of a number of columns; a factor of 10 more or less is as likely as none."""
    of_set = size * np.log(num) - gammaln(size + 1) + size * np.log(2.0)
    return float(of_set + np.log(2.0) + (size - 1) * np.log(2.0 * 3.0 * 9.0 * 10.0 ** (digits - 1)))


def _rounded(weights: Floats, digits: int) -> tuple[float, ...]:
    return tuple(float(f"{weight:.{digits}g}") for weight in weights.tolist())


def _grown(table: Floats, liked: Floats) -> Iterator[tuple[list[int], Floats]]:
    """Sets of two columns or more, each with one more column than the one before, and their weights."""
    terms, weights = list[int](), np.zeros(1)
    for _ in range(min(MAX_TERMS, table.shape[1])):
        design = np.column_stack([np.ones(len(table)), table[:, terms]])
        weights = _fitted(design, liked, weights)
        expected = expit(design @ weights)
        gains = np.abs((liked - expected) @ table)
        gains[terms] = -1.0
        terms.append(int(np.argmax(gains)))
        weights = np.append(weights, 0.0)
        design = np.column_stack([design, table[:, terms[-1]]])
        weights = _fitted(design, liked, weights)
        if len(terms) > 1:
            yield list(terms), weights[1:]


def _fitted(design: Floats, liked: Floats, weights: Floats) -> Floats:
    """Weights [k] of a logistic regression."""
    prior = np.append(0.0, np.full(design.shape[1] - 1, 1.0 / _SPREAD**2))

    def height(weights: Floats) -> Height:
        sums = design @ weights
        expected = expit(sums)
        return Height(
            float(liked @ sums - np.logaddexp(0.0, sums).sum() - 0.5 * prior @ weights**2),
            design.T @ (liked - expected) - prior * weights,
            (design.T * np.maximum(expected * (1.0 - expected), 1e-6)) @ design + np.diag(prior),
        )

    return climbed(height, weights)


class SignedSum(NamedTuple):
    """A sum of columns with signs."""

    columns: tuple[int, ...]
    """Indices of the columns."""
    signs: tuple[int, ...]
    """1 or -1 for each column; 1 for the first."""
    price: float
    """Log of the number of sizes, and of the sums of its size, in nats."""

    def values(self, columns: Floats) -> Floats:
        """[n] the sum, for columns [n, F]."""
        return columns[:, list(self.columns)] @ np.array(self.signs, dtype=np.float64)


def signed_sums(columns: Floats, scores: Floats) -> Iterator[SignedSum]:
    """Sums that may explain scores more than each column alone.

    Args:
        columns: [n, F] numbers.
        scores: [n] 0-100.

    >>> columns = np.random.default_rng(0).random((200, 9))
    >>> liked = columns[:, 7] - columns[:, 0] - columns[:, 4] > -0.4
    >>> next(signed_sums(columns, 90.0 * liked)).columns
    (0, 4, 7)
    """
    width, every = columns.shape[1], np.arange(len(scores))
    if not np.ptp(scores) > 0.0:
        return
    worth = gains(coarse_bins(columns), every, scores)
    ranked: list[int] = (1 + np.argsort(-worth, kind="stable")[:_MAX_SIGNED]).tolist()
    beam: list[tuple[int, ...]] = [(number,) for number in ranked[:SEVERAL]]
    for size in range(2, min(MAX_TERMS, width) + 1):
        listed = list(dict.fromkeys(longer for members in beam for longer in _longer(members, sorted(ranked))))
        signs = np.zeros((width, len(listed)))
        for column, members in enumerate(listed):
            signs[[abs(member) - 1 for member in members], column] = np.sign(members)
        worth = gains(coarse_bins(columns @ signs), every, scores)
        beam = [listed[index] for index in np.argsort(-worth, kind="stable")[:SEVERAL].tolist()]
        price = float(np.log(MAX_TERMS - 2) + np.log(comb(width, size)) + (size - 1) * np.log(2.0))
        for members in beam if size > 2 else ():
            indices, of_members = np.abs(members) - 1, np.sign(members)
            yield SignedSum(tuple(indices.tolist()), tuple(of_members.tolist()), price)


def _longer(members: tuple[int, ...], numbers: Iterable[int]) -> Iterator[tuple[int, ...]]:
    """Sums with one more of some columns: its number from 1 with its sign, ascending by number."""
    for index in set(numbers).difference(map(abs, members)):
        for signed in (index, -index):
            ordered = sorted((*members, signed), key=abs)
            # The opposite sum says the same.
            yield tuple(ordered) if ordered[0] > 0 else tuple(-member for member in ordered)
