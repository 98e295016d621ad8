"""Weighted sums of columns that scores choose.

A weighted sum is one of quantities, a bound on which or a band of which is liked: twice the width less the height, or
one ornament for each 120 square metres. Its columns and weights are those along which the scores oscillate most: with
centred scores s, the share of their variance that a wave of the sum u explains is |sum_i s_i exp(i u_i)|^2, twice over
the number of scores and their variance. Half a wave is a bound and a wave is a band, and the sum over all pairs of
columns, of given weights, is a product of two matrices (Zhu and Zeng, 2006, Fourier methods for estimating the central
subspace, Journal of the American Statistical Association 101). Sums begin with every single column and grow by one
column at a time, since only the whole relation explains much; the best ones are compared by the evidence of their best
cut, with weights rounded to steps of different size. The price is that of the columns and of the steps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from grammarlab.arrays import FEW, MANY_COLUMNS, NUM_LEVELS, ROUNDING, SEVERAL, Flags, Floats, Ints
from grammarlab.preference.growth.cuts import best_cuts
from grammarlab.preference.growth.node_bins import node_bins
from grammarlab.preference.growth.screening import COARSE_BINS, gain_of_share
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.judge.votes import MAX_TERMS

_PHASES = (0.35, 0.7, 1.4)
"""Weights of a column that are tried, in radians per standard deviation. Others are between them."""
_STEPS = (0.25, 0.125, 0.0625)
"""Steps of weights, relative to the largest, all for columns of standard deviation 1."""
_SAME = 0.98
"""Correlation of columns from which on they are one, the cheaper of the two."""


class Measures(NamedTuple):
    """M numbers of n designs that may be parts of a weighted sum."""

    values: Floats
    """[n, M]"""
    prices: Floats
    """[M] description length of each, in nats."""
    can_be_added: Callable[[Sequence[int]], bool] = lambda _: True
    """Whether a sum of some of them is short enough to be written."""


class WeightedSum(NamedTuple):
    """A weighted sum of columns."""

    columns: tuple[int, ...]
    """Indices of the columns, the one that matters most first."""
    weights: tuple[float, ...]
    """Their weights; the first is 1."""
    price: float
    """Description length in nats: of the number of columns, of the columns, and of the weights."""

    def values(self, columns: Floats) -> Floats:
        """[n] the sum, for columns [n, F]."""
        return columns[:, list(self.columns)] @ np.array(self.weights)


def weighted_sums(measures: Measures, evidence: LeafEvidence, explained: float) -> list[WeightedSum]:
    """Sums of which a bound or a band may explain scores.

    Args:
        measures: what may be added.
        evidence: the scores, for a likely person.
        explained: evidence of what is explained without such sums, in nats.

    >>> from grammarlab.preference.person import START_PERSONS
    >>> columns = np.random.default_rng(0).random((200, 6))
    >>> scores = 100.0 * (np.abs(columns[:, 1] - 0.5 * columns[:, 4]) < 0.1)
    >>> measures, evidence = Measures(columns, np.full(6, np.log(6.0))), LeafEvidence.of(scores, START_PERSONS[0])
    >>> best = weighted_sums(measures, evidence, -1e3)[0]
    >>> best.columns, best.weights
    ((1, 4), (1.0, -0.5))
    """
    chosen = _different(measures.values, measures.prices)
    # No column explains more than the scores themselves.
    possible = _explained([evidence.scores], evidence)[0] - explained
    if len(chosen) < 2 or not possible > measures.prices[chosen[:2]].sum():
        return []
    waves = _Waves.of(measures.values[:, chosen], measures.prices[chosen], evidence.scores)
    grown = [wave for wave in waves.grown() if measures.can_be_added(chosen[list(wave.columns)].tolist())]
    rounded = _rounded_sums(grown, waves, evidence)
    return [some._replace(columns=tuple(chosen[list(some.columns)].tolist())) for some in rounded[:SEVERAL]]


def _different(columns: Floats, prices: Floats) -> Ints:
    """Indices of columns [n, F] that differ from each other and distinguish enough designs, the cheapest first."""
    num, every = len(columns), np.arange(len(columns))[:, None]
    ascending = np.sort(columns, axis=0)
    first = np.zeros(columns.shape, dtype=np.int64)
    first[1:] = np.where(ascending[1:] > ascending[:-1], every[1:], 0)
    longest = (every - np.maximum.accumulate(first, axis=0)).max(axis=0, initial=0) + 1
    # What distinguishes less than a bin of the designs is a flag of few, and no part of a sum.
    varied = np.flatnonzero(longest <= (1.0 - 1.0 / COARSE_BINS) * num)
    varied = varied[np.argsort(prices[varied], kind="stable")]
    table = (columns[:, varied] - columns[:, varied].mean(axis=0)) / columns[:, varied].std(axis=0)
    same = np.abs(table.T @ table) > _SAME * num
    stays = np.ones(len(varied), dtype=bool)
    # A column stays if none of the cheaper ones that stay says the same.
    for index in range(len(varied)):
        if stays[index]:
            stays[index + 1 :] &= ~same[index, index + 1 :]
    return varied[stays]


class _Wave(NamedTuple):
    """A weighted sum as a phase."""

    columns: tuple[int, ...]
    weights: Floats
    """[k] radians per standard deviation of each column."""
    loss: float
    """Price of the columns less the estimated gain, in nats."""

    def without(self, index: int) -> _Wave:
        """The sum of the other columns."""
        columns = self.columns[:index] + self.columns[index + 1 :]
        return self._replace(columns=columns, weights=np.delete(self.weights, index))


@dataclass(frozen=True, eq=False)
class _Waves:
    """C different columns, and n scores that waves of their sums may explain."""

    columns: Floats
    """[n, C]"""
    prices: Floats
    """[C]"""
    table: Floats
    """[n, C] the columns with mean 0 and variance 1."""
    trials: NDArray[np.float32]
    """[P, 2, n, C] cosine and sine of each column for each weight that is tried."""
    same: Flags
    """[C, C] whether columns say the same, so that no sum has both."""
    scores: Floats
    """[n] of mean 0 and norm 1."""

    @classmethod
    def of(cls, columns: Floats, prices: Floats, scores: Floats) -> _Waves:
        """Waves of columns [n, C] that are not constant, for scores [n] that are not equal."""
        table = (columns - columns.mean(axis=0)) / columns.std(axis=0)
        trials = np.array([(np.cos(phase * table), np.sin(phase * table)) for phase in _PHASES], dtype=np.float32)
        centred = scores - scores.mean()
        same = np.abs(table.T @ table) > _SAME * len(table)
        return cls(columns, prices, table, trials, same, centred / np.linalg.norm(centred))

    def grown(self) -> Iterator[_Wave]:
        """The best sums of each size, of two columns or more, also with one of their columns exchanged or left out.

        They begin with one of the first columns, which may have led to the others without being needed beside them.
        Sums with a column exchanged or left out are offered, but do not grow.
        """
        numbers = np.array([len(np.unique(column)) > COARSE_BINS for column in self.columns.T])
        # Numbers before flags, and then the cheapest first.
        roots = np.argsort(~numbers, kind="stable")[:MANY_COLUMNS]
        waves = [_Wave((root,), np.ones(1), 0.0) for root in roots.tolist()]
        for _ in range(min(MAX_TERMS, len(self.prices)) - 1):
            waves = self._fitted(self._longer(waves))
            best = _best(waves)
            best = _best([*best, *self._fitted(self._longer(_shorter(best)))])
            yield from best
            yield from _best(self._fitted([wave for wave in _shorter(best) if len(wave.columns) > 1]))

    def _longer(self, waves: Sequence[_Wave]) -> list[_Wave]:
        """Different sums with one column more: the best few of those that begin with the same column."""
        if not waves:
            return []
        members, weights, sums = self._of_variance_one(waves)
        share = np.zeros((len(members), len(self.prices)), dtype=np.float32)
        trial = np.zeros(share.shape, dtype=np.int64)
        pairs = [(of_sum, sign * phase) for of_sum in _PHASES[1:] for phase in _PHASES for sign in (1.0, -1.0)]
        amplitudes = (each for of_sum in _PHASES[1:] for each in self._amplitudes(of_sum * sums))
        for number, squared in enumerate(amplitudes):
            trial[squared > share] = number
            share = np.maximum(share, squared)
        loss = self.prices[members].sum(axis=1)[:, None] + self.prices - self._gain(2.0 * share / len(self.scores))
        loss[self.same[members].any(axis=1)] = np.inf
        longer: list[_Wave] = []
        for row, order in enumerate(np.argsort(loss, axis=1, kind="stable")[:, :FEW].tolist()):
            for column in order:
                of_sum, weight = pairs[trial[row, column]]
                wave = _Wave(
                    (*members[row].tolist(), column), np.append(of_sum * weights[row], weight), float(loss[row, column])
                )
                if np.isfinite(wave.loss):
                    longer.append(wave)
        of_root: dict[int, list[_Wave]] = {}
        for wave in _different_sets(longer):
            of_root.setdefault(wave.columns[0], []).append(wave)
        return [wave for several in of_root.values() for wave in several[:FEW]]

    def _of_variance_one(self, waves: Sequence[_Wave]) -> tuple[Ints, Floats, Floats]:
        """[B, k] columns, [B, k] weights and [B, n] sums of variance 1; sums that are constant are left out."""
        members, weights = np.array([wave.columns for wave in waves]), np.array([wave.weights for wave in waves])
        sums = np.einsum("nbk,bk->bn", self.table[:, members], weights)
        sizes = sums.std(axis=1)
        varying = sizes > ROUNDING
        scale = sizes[varying, None]
        return members[varying], weights[varying] / scale, sums[varying] / scale

    def _amplitudes(self, phases: Floats) -> Iterator[NDArray[np.float32]]:
        """[B, C] squared amplitudes of sums with one column more, for each weight of it that is tried."""
        real, imaginary = ((self.scores * wave(phases)).astype(np.float32) for wave in (np.cos, np.sin))
        for cosines, sines in self.trials:
            product, other = real @ cosines, imaginary @ sines
            mixed, turned = real @ sines, imaginary @ cosines
            yield (product - other) ** 2 + (mixed + turned) ** 2
            yield (product + other) ** 2 + (mixed - turned) ** 2

    def _gain(self, share: Floats) -> Floats:
        """Estimated gain of log-likelihood by a wave that explains a share of the variance of the scores."""
        return gain_of_share(share, np.ones(1, dtype=np.int64), len(self.scores))

    def _of_one_turn(self, phases: Floats, peak: Floats) -> Floats:
        """[B] share of the variance of scores that one turn of each wave explains.

        Designs more than half a turn away from what is liked are disliked, whatever the wave repeats.

        Args:
            phases: [B, n] of each design.
            peak: [B] phases of liked designs, up to any number of turns.
        """
        best = np.zeros(len(phases))
        for turns in (-1, 0, 1):
            away = np.minimum(np.abs(phases - peak[:, None] - 2.0 * np.pi * turns), np.pi)
            values = np.cos(away)
            values -= values.mean(axis=1, keepdims=True)
            size = np.maximum((values**2).sum(axis=1), ROUNDING)
            best = np.maximum(best, np.maximum(values @ self.scores, 0.0) ** 2 / size)
        return best

    def _fitted(self, waves: Sequence[_Wave]) -> list[_Wave]:
        """Sums of k columns each, with the weights near by of which the amplitude is largest, by Newton's method."""
        if not waves:
            return []
        members, weights = np.array([wave.columns for wave in waves]), np.array([wave.weights for wave in waves])
        table = self.table.T[members]
        scored = self.scores * np.exp(1j * np.einsum("bkn,bk->bn", table, weights))
        for _ in range(FEW):
            amplitude, slope = scored.sum(axis=1), 1j * (table @ scored[:, :, None])[:, :, 0]
            bend = np.conj(amplitude)[:, None, None] * ((table * scored[:, None]) @ table.transpose(0, 2, 1))
            gradient = (np.conj(amplitude)[:, None] * slope).real
            sizes, directions = np.linalg.eigh((np.conj(slope)[:, :, None] * slope[:, None] - bend).real)
            along = np.einsum("bij,bi->bj", directions, gradient) / np.maximum(np.abs(sizes), ROUNDING)
            step = np.einsum("bij,bj->bi", directions, along)
            step *= np.minimum(1.0, _PHASES[0] / np.maximum(np.abs(step).max(axis=1), ROUNDING))[:, None]
            trial = self.scores * np.exp(1j * np.einsum("bkn,bk->bn", table, weights + step))
            better = (np.abs(trial.sum(axis=1)) > np.abs(amplitude))[:, None]
            weights, scored = np.where(better, weights + step, weights), np.where(better, trial, scored)
        gain = self._gain(self._of_one_turn(np.einsum("bkn,bk->bn", table, weights), np.angle(scored.sum(axis=1))))
        loss = self.prices[members].sum(axis=1) - gammaln(members.shape[1] + 1) - gain
        return [_Wave(*each) for each in zip(map(tuple, members.tolist()), weights, loss.tolist(), strict=True)]


def _best(waves: Iterable[_Wave]) -> list[_Wave]:
    """The best sums of different columns."""
    return _different_sets(waves)[:SEVERAL]


def _shorter(waves: Iterable[_Wave]) -> list[_Wave]:
    """Different sums without one of their columns."""
    return _different_sets(wave.without(index) for wave in waves for index in range(len(wave.columns)))


def _different_sets(waves: Iterable[_Wave]) -> list[_Wave]:
    """The best sum of each set of columns, the best one first."""
    different: dict[frozenset[int], _Wave] = {}
    for wave in sorted(waves, key=lambda each: each.loss):
        different.setdefault(frozenset(wave.columns), wave)
    return list(different.values())


class _Cells(NamedTuple):
    """A weighted sum with rounded weights."""

    columns: tuple[int, ...]
    """The one that matters most first."""
    step: float
    cells: tuple[int, ...]
    """[k - 1] numbers of steps of the weights of the other columns, not 0, relative to the first for columns of
    standard deviation 1."""

    def near(self) -> Iterator[_Cells]:
        """These weights, and those with one weight a step larger or smaller."""
        yield self
        for index, sign in product(range(len(self.cells)), (-1, 1)):
            cell = self.cells[index] + sign
            if cell and abs(cell) * self.step <= 1.0:
                yield self._replace(cells=(*self.cells[:index], cell, *self.cells[index + 1 :]))

    def rounded(self, prices: Floats, scales: Floats) -> WeightedSum:
        """The sum for columns of these prices [C] and standard deviations [C]."""
        first, *others = self.columns
        weights = [1.0]
        for column, cell in zip(others, self.cells, strict=True):
            unit = self.step * scales[first] / scales[column]
            weights.append(_decimal(cell * unit, abs(unit) / 2.0))
        size = len(self.columns)
        of_columns = prices[list(self.columns)].sum() - gammaln(size + 1) + np.log(MAX_TERMS - 1)
        # Which column matters most, the step, and which of the steps on both sides of 0.
        of_weights = np.log(size) + np.log(len(_STEPS)) + (size - 1) * np.log(2.0 / self.step)
        return WeightedSum(self.columns, tuple(weights), float(of_columns + of_weights))


def _rounded_sums(waves: Sequence[_Wave], table: _Waves, evidence: LeafEvidence) -> list[WeightedSum]:
    """The best sums with rounded weights, one for each set of columns, the best one first."""
    scales = table.columns.std(axis=0)
    starts = dict.fromkeys(cells for wave in waves for cells in _on_steps(wave))
    best: list[tuple[float, WeightedSum, _Cells]] = []
    for num in (len(starts), *(SEVERAL for _ in range(FEW))):
        listed = list(dict.fromkeys(near for cells in list(starts)[:num] for near in cells.near()))
        if not listed:
            return []
        sums = [cells.rounded(table.prices, scales) for cells in listed]
        worth = _explained([some.values(table.columns) for some in sums], evidence) - [some.price for some in sums]
        order = np.argsort(-worth, kind="stable").tolist()
        of_set: dict[frozenset[int], int] = {}
        for index in order:
            of_set.setdefault(frozenset(listed[index].columns), index)
        best = [(float(worth[index]), sums[index], listed[index]) for index in of_set.values()]
        starts = dict.fromkeys(cells for _, _, cells in best)
    return [some for _, some, _ in best]


def _on_steps(wave: _Wave) -> Iterator[_Cells]:
    """The weights rounded to each step; none where a weight would be 0."""
    order = np.argsort(-np.abs(wave.weights), kind="stable")
    columns = tuple(wave.columns[index] for index in order.tolist())
    relative = wave.weights[order[1:]] / wave.weights[order[0]]
    for step in _STEPS:
        cells = np.rint(relative / step).astype(np.int64)
        if cells.all():
            yield _Cells(columns, step, tuple(cells.tolist()))


def _decimal(middle: float, reach: float) -> float:
    """The number of fewest digits so near to another one, a power of ten if there is one.

    >>> _decimal(0.83, 0.1), _decimal(0.83, 0.2), _decimal(-38.7, 0.5)
    (0.8, 1.0, -39.0)
    """
    power = float(np.sign(middle) * 10.0 ** np.rint(np.log10(abs(middle))))
    shortest = (power, *(float(f"{middle:.{digits}g}") for digits in range(1, 17)))
    return next((number for number in shortest if abs(number - middle) <= reach), middle)


def _explained(sums: Sequence[Floats], evidence: LeafEvidence) -> Floats:
    """[K] evidence of the best cut by each of some columns [n]."""
    codes = node_bins(np.stack(sums, axis=1), evidence.scores, NUM_LEVELS)
    return best_cuts(codes, evidence.terms, evidence.of_sums).log_evidence
