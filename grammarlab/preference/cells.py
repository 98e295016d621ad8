"""Cells: sets of labels that share one value, and how well that explains their scores.

The value of a cell is one of a grid from 0 to 100. Beforehand it is 0 with some probability (what somebody does not
want), one of the values that other cells seem to have, or any. The evidence of a cell C is

    log sum_v p(v | other cells) prod_{i in C} p(y_i | v).

What other cells seem to have is counted without the labels of C: a score that was given once is no level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from grammarlab.preference.base import MAX_SCORE, Floats, Ints
from grammarlab.preference.likelihood import Singles, log_likelihood
from grammarlab.preference.splits import Flags, Splits

ZERO = 0.25
"""Prior probability that a cell is worth nothing."""
SHARED = 0.6
"""Prior probability that it is worth what others are, once there are `_ENOUGH` of them."""
_ENOUGH = 6.0
_STEP = 3.125
_ON_GRID = 0.8
"""Of the values that any cell may have, the part spread over the even grid; the rest over scores that were given."""
_MOST_SCORES = 32
_FEWER_SCORES = 24
_TINY = 1e-30


class Ranked(NamedTuple):
    """Ways to divide a cell; those that divide it alike are one."""

    log_posterior: Floats
    """[K] log of prior mass and evidence of the parts."""
    log_mass: Floats
    """[K] log of the prior mass."""
    member: Ints
    """[J] index into all splits."""
    of: Ints
    """[J] which of the K each is."""


@dataclass(frozen=True, eq=False)
class Levels:
    """What values labels seem to have, each cell counting once."""

    values: Singles
    """[n, G] share of a cell that a label is, times the posterior of the cell."""
    shares: Singles
    """[n] share of a cell that a label is."""

    @cached_property
    def all_values(self) -> Singles:
        """[G] of all labels together."""
        return self.values.sum(axis=0)

    @cached_property
    def all_shares(self) -> float:
        """Likewise."""
        return float(self.shares.sum())


def grid_of(scores: Floats) -> Floats:
    """[G] the values that a cell may have, ascending: an even grid, and the scores that were given.

    Args:
        scores: [n] 0-100.
    """
    given = np.unique(scores.round(3))
    if len(given) > _MOST_SCORES:
        given = np.quantile(given, np.linspace(0.0, 1.0, _FEWER_SCORES))
    return np.unique(np.concatenate([np.arange(0.0, MAX_SCORE + _STEP / 2.0, _STEP), given]))


@dataclass(frozen=True, eq=False)
class Cells:
    """Labels, and how somebody who scores is thought to err."""

    splits: Splits
    scores: Floats
    """[n]"""
    grid: Floats
    """[G]"""
    noise: float
    """Standard deviation in points."""
    blunders: float
    """How often any score at all is given."""
    levels: Levels | None = None
    """What earlier cells were worth; None as long as there are none."""

    @cached_property
    def log_likelihood(self) -> Singles:
        """[n, G] of each label for each value."""
        return log_likelihood(self.scores, self.grid, self.noise, self.blunders)

    @cached_property
    def _known(self) -> dict[bytes, Ranked | None]:
        """What has been ranked already: trees have most of their cells near the root in common."""
        return {}

    def log_evidence(self, members: Singles, labels: Ints) -> Floats:
        """[k] of parts of some labels.

        Args:
            members: [k, c] 1 where a label is in a part, else 0. An empty part has evidence 0.
            labels: [c] indices.
        """
        prior, sums = self._prior_and_likelihood(members, labels)
        highest = sums.max(axis=1, keepdims=True)
        return np.log((prior * np.exp(sums - highest)).sum(axis=1) + _TINY) + highest[:, 0]

    def of_cell(self, cell: Ints) -> float:
        """The evidence of one cell."""
        return float(self.log_evidence(np.ones((1, len(cell)), dtype=np.float32), cell)[0])

    def posterior(self, cell: Ints) -> Floats:
        """[G] the probability of each value of a cell of some labels."""
        prior, sums = self._prior_and_likelihood(np.ones((1, len(cell)), dtype=np.float32), cell)
        odds = prior[0] * np.exp(sums[0] - sums[0].max())
        return (odds / odds.sum()).astype(np.float64)

    def best_possible(self, cell: Ints) -> float:
        """No division of a cell has more evidence."""
        return float(self.log_likelihood[cell].max(axis=1).sum())

    def ranked(self, cell: Ints) -> Ranked | None:
        """The ways to divide a cell; None where there are none."""
        key = cell.tobytes()
        if key not in self._known:
            self._known[key] = self._rank(cell)
        return self._known[key]

    def _rank(self, cell: Ints) -> Ranked | None:
        parts = self.splits.parts[:, cell]
        in_two = np.flatnonzero((parts != parts[:, :1]).any(axis=1) & self._are_halves)
        # The side that the first label is on does not matter.
        halves = (parts[in_two] == 1) ^ (parts[in_two][:, :1] == 1)
        first, of = _different(halves)
        member, evidence, index = [in_two], [self._of_halves(halves[first], cell)], [of]
        if len(self.splits.many):
            members = self.splits.members[:, cell]
            occupied = np.add.reduceat(members.any(axis=1).astype(np.int64), self.splits.starts)
            several = np.flatnonzero(occupied > 1)
            member.append(self.splits.many[several])
            evidence.append(np.add.reduceat(self.log_evidence(members, cell), self.splits.starts)[several])
            index.append(len(first) + np.arange(len(several)))
        found, number = np.concatenate(member), np.concatenate(index)
        if not len(found):
            return None
        log_mass = np.log(np.bincount(number, np.exp(self.splits.log_prior[found])))
        return Ranked(np.concatenate(evidence) + log_mass, log_mass, found, number)

    def _of_halves(self, inside: Flags, cell: Ints) -> Floats:
        """[k] the evidence of both halves of a cell [k, c] together."""
        found = self.log_evidence(np.concatenate([inside, ~inside]).astype(np.float32), cell)
        return found[: len(inside)] + found[len(inside) :]

    def _prior_and_likelihood(self, members: Singles, labels: Ints) -> tuple[Singles, Singles]:
        """[k or 1, G] prior of the values of parts, given what labels outside are worth, and [k, G] log-likelihood."""
        sums = members @ self.log_likelihood[labels]
        if self.levels is None:
            return self._base, sums
        outside = np.maximum(self.levels.all_values - members @ self.levels.values[labels], 0.0)
        number = np.maximum(self.levels.all_shares - members @ self.levels.shares[labels], 0.0)
        total = outside.sum(axis=1, keepdims=True)
        share = np.where(total[:, 0] > 0.0, SHARED * np.minimum(number / _ENOUGH, 1.0), 0.0).astype(np.float32)[:, None]
        return self._base * (1.0 - share) + share * outside / np.maximum(total, _TINY), sums

    @cached_property
    def _base(self) -> Singles:
        """[1, G] prior of the values of a cell, whatever others are worth."""
        even = np.isin(self.grid, np.arange(0.0, MAX_SCORE + _STEP / 2.0, _STEP))
        prior = (1.0 - ZERO) * (_ON_GRID * even / even.sum() + (1.0 - _ON_GRID) / len(self.grid))
        prior[0] += ZERO
        return prior[None].astype(np.float32)

    @cached_property
    def _are_halves(self) -> Flags:
        """[S] which splits make two parts."""
        return self.splits.parts.max(axis=1, initial=0) == 1


def levels_of(cells: Cells, found: Sequence[tuple[float, Sequence[Ints]]]) -> Levels:
    """What the cells of some divisions of all labels are worth.

    Args:
        cells: what they were found with.
        found: the share of each division, all together 1, and its cells.
    """
    values, shares = np.zeros(cells.log_likelihood.shape), np.zeros(len(cells.scores))
    for share, parts in found:
        for cell in parts:
            values[cell] += share * cells.posterior(cell) / len(cell)
            shares[cell] += share / len(cell)
    return Levels(values.astype(np.float32), shares.astype(np.float32))


def _different(halves: Flags) -> tuple[Ints, Ints]:
    """[K] the first of each set of equal rows [J, c], and [J] which of these each row equals."""
    packed = np.ascontiguousarray(np.packbits(halves, axis=1))
    if not packed.size:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    _, first, of = np.unique(packed.view(f"V{packed.shape[1]}")[:, 0], return_index=True, return_inverse=True)
    return first, of.reshape(-1)
