"""Tables of pairs, and mixed sets: which alternatives or parts go together, as the scores say.

The cells of the tables of a choice with all later ones are summed by one product of matrices. A table is a flag,
the cells with the highest means against the others; its price is that of the choice of the pair, of the number of these
cells and of the cells.

Mixed sets are two sets of parts that go, or do not go, together: nothing round beside anything angular.
A column tells whether a design has any part of one set and any of another one. Sets begin with the pairs of parts that
explain most. They gain one part at a time, since half of a set explains little, and of all sizes the best one loses,
gains and exchanges parts as long as this pays for the price: that of the choice of the parts, and log 2 for each, since
there is another one with even odds. The gain is that of likes and dislikes in the place of scores.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import comb, log
from typing import NamedTuple

import numpy as np
from scipy.special import xlogy

from grammarlab.arrays import MANY, MAX_STEPS, ROUNDING, SEVERAL, Flags, Floats, Ints
from grammarlab.preference.growth.screening import gain_of_share


class PairTable(NamedTuple):
    """A flag: whether two choices are a pair of a table."""

    first: int
    second: int
    cells: tuple[tuple[int, int], ...]
    """Numbers of alternatives that go together, 0 for no alternative."""
    price: float
    """Log of the number of tables, in nats."""

    def values(self, numbers: Ints) -> Floats:
        """[n] the flag, for numbers [n, K] of the alternatives of choices."""
        codes = numbers[:, self.first] * (int(numbers.max(initial=0)) + 1) + numbers[:, self.second]
        return np.isin(codes, [a * (int(numbers.max(initial=0)) + 1) + b for a, b in self.cells]).astype(np.float64)


def pair_tables(numbers: Ints, scores: Floats) -> Iterator[PairTable]:
    """Tables that may explain scores more than each choice alone.

    Args:
        numbers: [n, K] number of the alternative of each choice, 0 for none.
        scores: [n] 0-100.

    >>> numbers = np.indices((3, 3)).reshape(2, -1).T.repeat(8, axis=0)
    >>> table = next(pair_tables(numbers, 90.0 * (numbers[:, 0] == numbers[:, 1])))
    >>> table.cells
    ((0, 0), (1, 1), (2, 2))
    """
    num = numbers.shape[1]
    if num < 2 or not np.ptp(scores) > 0.0:
        return
    centred = scores - scores.mean()
    first, second = np.triu_indices(num, 1)
    shares, cells = (table[first, second] for table in _explained(numbers, centred))
    worth = gain_of_share(shares, cells.astype(np.int64), len(scores))
    for index in np.argsort(np.log(2.0) * cells - worth, kind="stable")[:MANY].tolist():
        i, j = int(first[index]), int(second[index])
        chosen, num_cells = _chosen(numbers[:, [i, j]], centred), int(cells[index])
        price = log(len(first)) + log(num_cells) + log(comb(num_cells, len(chosen)))
        yield PairTable(i, j, chosen, price)


def _explained(numbers: Ints, centred: Floats) -> tuple[Floats, Floats]:
    """[K, K] share of the variance of the scores that each table explains, and number of its cells; of i < j only."""
    num, widths = numbers.shape[1], numbers.max(axis=0) + 1
    starts = np.cumsum(widths) - widths
    held = np.zeros((len(numbers), int(widths.sum())))
    held[np.arange(len(numbers))[:, None], starts + numbers] = 1.0
    shares, cells = np.zeros((num, num)), np.zeros((num, num))
    for one in range(num):
        of_one, later = held[:, starts[one] : starts[one] + widths[one]], held[:, starts[one] :]
        counts, sums = of_one.T @ later, (of_one * centred[:, None]).T @ later
        places = starts[one:] - starts[one]
        shares[one, one:] = _of_tables(sums**2 / np.maximum(counts, 1.0), places)
        cells[one, one:] = _of_tables((counts > 0.0).astype(np.float64), places)
    # Scores may differ by less than any normal number.
    return shares / max(float(centred @ centred), np.finfo(np.float64).tiny), cells


def _of_tables(cells: Floats, columns: Ints) -> Floats:
    """[C] sums over the cells [A, B] of each table, from the first ones of their columns [C]."""
    return np.add.reduceat(cells.sum(axis=0), columns)


def _chosen(pairs: Ints, centred: Floats) -> tuple[tuple[int, int], ...]:
    """The cells with the highest means, as many as divide the scores best."""
    cells, index = np.unique(pairs, axis=0, return_inverse=True)
    counts = np.bincount(index.reshape(-1)).astype(np.float64)
    sums = np.bincount(index.reshape(-1), centred)
    order = np.argsort(-sums / counts, kind="stable")
    above, number = np.cumsum(sums[order])[:-1], np.cumsum(counts[order])[:-1]
    best = int(np.argmax(above**2 / (number * (len(pairs) - number)), keepdims=True)[0]) if len(above) else 0
    return tuple(sorted((int(a), int(b)) for a, b in cells[order[: best + 1]]))


# Mixed sets -----------------------------------------------------------------------------------------------------------

_Sets = tuple[frozenset[int], frozenset[int]]


class MixedSets(NamedTuple):
    """A flag: whether a design has any of one set of parts and any of another one."""

    first: tuple[int, ...]
    """Ascending indices of parts."""
    second: tuple[int, ...]
    """Ascending indices of other parts."""
    price: float
    """Description length in nats."""

    def values(self, has: Flags) -> Floats:
        """[n] the flag, for designs that have parts [n, F]."""
        first, second = (has[:, list(part)].any(axis=1) for part in (self.first, self.second))
        return np.asarray(first & second, dtype=np.float64)


def mixed_sets(has: Flags, scores: Floats) -> list[MixedSets]:
    """Sets that may explain scores, the best first, each once.

    Args:
        has: [n, F] which parts designs have, no two columns equal.
        scores: [n] 0-100.

    >>> has = np.random.default_rng(0).random((96, 8)) < 0.4
    >>> mixed = has[:, [0, 3]].any(axis=1) & has[:, [2, 5, 6]].any(axis=1)
    >>> mixed_sets(has, 90.0 * ~mixed)[0][:2]
    ((0, 3), (2, 5, 6))
    """
    if has.shape[1] < 2 or not np.ptp(scores) > 0.0:
        return []
    search = _Search(has.astype(np.float64), (scores - scores.min()) / np.ptp(scores))
    grown = {sets: loss for start, sign in search.starts() for sets, loss in [search.grown(start, sign)]}
    ranked = sorted(grown, key=lambda sets: (grown[sets], *map(sorted, sets)))
    return [MixedSets(tuple(sorted(one)), tuple(sorted(other)), search.price(one, other)) for one, other in ranked]


class _Search:
    """Growth of two sets of parts that designs have [n, F], by likes [n] from 0 to 1."""

    def __init__(self, has: Floats, likes: Floats) -> None:
        self._has, self._likes, self._mean = has, likes, float(likes.mean())

    def price(self, first: frozenset[int], second: frozenset[int]) -> float:
        """Log of the number of pairs of sets of these sizes, and log 2 for each of their parts."""
        num, one, other = self._has.shape[1], len(first), len(second)
        return log(comb(num, one)) + log(comb(num - one, other)) + (one + other - 1) * log(2.0)

    def starts(self) -> list[tuple[_Sets, float]]:
        """Pairs of parts, and whether designs that have both are liked more (1) or less (-1) than others."""
        first, second = np.triu_indices(self._has.shape[1], 1)
        number = (self._has.T @ self._has)[first, second]
        likes = ((self._has * self._likes[:, None]).T @ self._has)[first, second]
        best = np.argsort(-self._gains(number, likes), kind="stable")[:SEVERAL]
        sign = np.sign(likes[best] - number[best] * self._mean)
        pairs = zip(first[best].tolist(), second[best].tolist(), sign.tolist(), strict=True)
        return [((frozenset({one}), frozenset({other})), sign) for one, other, sign in pairs]

    def grown(self, sets: _Sets, sign: float) -> tuple[_Sets, float]:
        """The best sets that grow from others, and their price less what they explain, in nats."""
        best, least = sets, np.inf
        while sum(map(len, sets)) < MANY:
            sets, loss = min((self._with_one(sets, side, sign) for side in (0, 1)), key=lambda each: each[1])
            if not np.isfinite(loss):
                break
            best, least = (sets, loss) if loss < least else (best, least)
        for _ in range(MAX_STEPS):
            sets, loss = min(self._neighbours(best, sign), key=lambda each: each[1])
            if not loss < least - ROUNDING:
                break
            best, least = sets, loss
        one, other = sorted(best, key=sorted)
        return (one, other), least

    def _neighbours(self, sets: _Sets, sign: float) -> Iterator[tuple[_Sets, float]]:
        """Sets with one part more, less, or exchanged for one of either set."""
        yield from (change(sets, side, sign) for change, side in product((self._with_one, self._without), (0, 1)))
        for shorter in _shorter(sets):
            yield from (self._with_one(shorter, side, sign) for side in (0, 1))

    def _with_one(self, sets: _Sets, side: int, sign: float) -> tuple[_Sets, float]:
        """One of the sets with the best further part."""
        own, other = self._number(sets[side]), self._number(sets[1 - side]) > 0.0
        rows = other & (own > 0.0)
        further = [index for index in range(self._has.shape[1]) if not any(index in part for part in sets)]
        return self._changed(sets, side, sign, further, rows, other & (own == 0.0), 1.0)

    def _without(self, sets: _Sets, side: int, sign: float) -> tuple[_Sets, float]:
        """One of the sets without the part that it needs least."""
        own, other = self._number(sets[side]), self._number(sets[1 - side]) > 0.0
        members = sorted(sets[side]) if len(sets[side]) > 1 else []
        return self._changed(sets, side, sign, members, other & (own > 0.0), other & (own == 1.0), -1.0)

    def _changed(
        self, sets: _Sets, side: int, sign: float, parts: list[int], rows: Flags, changing: Flags, step: float
    ) -> tuple[_Sets, float]:
        """The best change of a set by one of some parts: the rows that change are those of the part among some."""
        if not parts:
            return sets, np.inf
        has = self._has[changing][:, parts]
        number = rows.sum() + step * has.sum(axis=0)
        likes = self._likes[rows].sum() + step * (self._likes[changing] @ has)
        gains = np.where((likes - number * self._mean) * sign > 0.0, self._gains(number, likes), -np.inf)
        best = int(gains.argmax())
        changed = sets[side] ^ {parts[best]}
        after = (changed, sets[1]) if side == 0 else (sets[0], changed)
        return after, self.price(*after) - float(gains[best])

    def _number(self, part: frozenset[int]) -> Floats:
        """[n] how many of a set designs have."""
        return self._has[:, sorted(part)].sum(axis=1)

    def _gains(self, number: Floats, likes: Floats) -> Floats:
        """Gain of log-likelihood by flags that so many designs have, with so many likes."""
        num, total = float(len(self._likes)), float(self._likes.sum())
        return _uncertainty(num, total) - _uncertainty(number, likes) - _uncertainty(num - number, total - likes)


def _shorter(sets: _Sets) -> Iterator[_Sets]:
    """Sets without one of their parts, as long as each keeps one."""
    first, second = sets
    yield from ((first - {part}, second) for part in sorted(first) if len(first) > 1)
    yield from ((first, second - {part}) for part in sorted(second) if len(second) > 1)


def _uncertainty(number: Floats | float, likes: Floats | float) -> Floats:
    """Minus the log-likelihood of so many likes of designs that are liked with one probability."""
    # Sums of likes that are taken away again may end below 0 or above their number by a rounding error.
    likes, dislikes = np.maximum(likes, 0.0), np.maximum(np.subtract(number, likes), 0.0)
    return xlogy(number, number) - xlogy(likes, likes) - xlogy(dislikes, dislikes)
