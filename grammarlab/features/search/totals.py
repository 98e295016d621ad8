"""Totals of counts that explain scores: an odd number of gilded parts, at least two of three properties.

A total that matters by its parity cannot be found term by term, since each count alone tells nothing: all totals of few
counts are tried, as bits. Other totals are found term by term.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import comb
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.features.columns.feature_table import FeatureTable
from grammarlab.features.patterns.pattern import Draw, Pattern, Present, Total
from grammarlab.features.search.sums import changed

Words = NDArray[np.uint64]

Countable: TypeAlias = Pattern | Present | Draw
"""Features that totals add up."""

MAX_TERMS = 6
"""Largest number of counts in a total."""
MIN_SCORES = 32
"""Smallest number of scores; with fewer, some total of few counts explains anything."""
_MAX_TRIALS = 1_000_000
"""Largest number of totals of a size that are tried as bits, those of the most even columns."""
_MIN_SIDE = 0.05
"""Smallest share of liked and of disliked models for parities."""
_NUM_KEPT = 8
"""Number of parities of a size that are compared by scores."""
_MAX_COLUMNS = 32
"""Largest number of columns of which totals grow term by term, those that explain most alone."""
_MAX_VALUES = 12
"""Largest number of values of a total, smallest to largest."""
_NUM_STARTS = 4
"""Number of pairs that totals grow from."""
_MIN_GAIN = 8.0
"""Smallest gain in nats over the best single count."""


class FoundTotal(NamedTuple):
    """A total of counts."""

    weights: Ints
    """[F] -1, 0 or 1."""
    price: float
    """Log of the number of such totals: what its choice costs, in nats."""


def find_totals(counts: Ints, scores: Floats) -> list[FoundTotal]:
    """Totals of counts that explain scores better than one count; at most two.

    Args:
        counts: [n, F] counts of the features of n models.
        scores: [n] scores of the models.
    """
    if len(scores) < MIN_SCORES or counts.shape[1] < 2 or not np.ptp(scores) > 0.0:
        return []
    scores = (scores - scores.min()) / np.ptp(scores)  # squares of the smallest floats would be 0
    single = gains_of(counts.T, scores)
    least = max(0.0, float(single.max()) - float(np.log(counts.shape[1]))) + _MIN_GAIN
    columns = np.sort(np.argsort(-single, kind="stable")[:_MAX_COLUMNS])
    both = _odd(counts, scores, least), _several(counts, scores, columns, least)
    totals = [total for total in both if total is not None]
    same = len(totals) > 1 and np.array_equal(totals[0].weights, totals[1].weights)
    return totals[:1] if same else totals


def counted(table: FeatureTable) -> tuple[list[Countable], Ints]:
    """The features of a table that are counts, and their counts [n, F]."""
    indices = [index for index, feature in enumerate(table.features) if isinstance(feature, Pattern | Present | Draw)]
    counts = table.counts.toarray()[:, indices]
    integer_columns = np.flatnonzero((counts % 1.0 == 0.0).all(axis=0))
    features = (table.features[indices[index]] for index in integer_columns.tolist())
    return [item for item in features if isinstance(item, Pattern | Present | Draw)], counts[:, integer_columns].astype(
        np.int64
    )


def total_of(features: Sequence[Countable], weights: Ints) -> Total:
    """The weighted sum of counted features."""
    return Total(tuple((features[index], int(weights[index])) for index in np.flatnonzero(weights).tolist()))


def _odd(counts: Ints, scores: Floats, least: float) -> FoundTotal | None:
    """Total of the counts [n, F] whose parity explains most of scores [n]."""
    liked = scores > (scores.min() + scores.max()) / 2.0
    if min(liked.mean(), 1.0 - liked.mean()) < _MIN_SIDE:
        return None
    bits = (counts % 2 != counts[:1] % 2).T
    columns = np.flatnonzero(bits.any(axis=1))
    columns = columns[np.argsort(np.abs(bits[columns].mean(axis=1) - 0.5), kind="stable")]
    _, first = np.unique(bits[columns], axis=0, return_index=True)
    columns = columns[np.sort(first)]
    best, highest = None, least
    for terms in _parities(_packed(bits[columns]), _packed(liked[None])[0], len(scores)):
        parity = np.logical_xor.reduce(bits[columns[terms]], axis=0).astype(np.int64)
        price = float(np.log(comb(len(columns), len(terms))))
        worth = float(gains_of(parity[None], scores)[0]) - price
        if worth > highest and len(terms) > 1:
            weights = np.zeros(counts.shape[1], dtype=np.int64)
            weights[columns[terms]] = 1
            best, highest = FoundTotal(weights, price), worth
    return best


def _parities(columns: Words, liked: Words, num: int) -> Iterator[Ints]:
    """Sets of columns whose parity agrees, or disagrees, most with being liked, a few of each size.

    Args:
        columns: [C, W] bits of n models; of larger sets, only the first columns are tried.
        liked: [W] bits.
        num: n.
    """
    # Parities of all sets of the size before, in the order of their last column: of those before a column, the first.
    before = np.zeros((1, columns.shape[1]), dtype=np.uint64)
    for size in range(1, MAX_TERMS + 1):
        blocks, best = list[Words](), list[tuple[int, int]]()
        for column in range(size - 1, _width(len(columns), size)):
            parities = before[: comb(column, size - 1)] ^ columns[column]
            evenly = np.abs(2 * _number_of_ones(parities ^ liked) - num)
            better = np.flatnonzero(evenly > (best[-1][0] if len(best) == _NUM_KEPT else 0))
            better = better[np.argsort(-evenly[better], kind="stable")[:_NUM_KEPT]]
            best += [(int(evenly[index]), comb(column, size) + index) for index in better.tolist()]
            best = sorted(best, reverse=True)[:_NUM_KEPT]
            blocks.append(parities)
        yield from (_set_of(index, size) for _, index in best)
        if not blocks:
            return
        before = np.concatenate(blocks) if size < MAX_TERMS else before


def _set_of(rank: int, size: int) -> Ints:
    """The set of a size at a place in the order of last columns, then of the columns before them.

    >>> [_set_of(place, 2).tolist() for place in range(4)]
    [[0, 1], [0, 2], [1, 2], [0, 3]]
    """
    columns: list[int] = []
    for remaining in range(size, 0, -1):
        column = remaining - 1
        while comb(column + 1, remaining) <= rank:
            column += 1
        columns.append(column)
        rank -= comb(column, remaining)
    return np.array(columns[::-1], dtype=np.int64)


def _width(number: int, size: int) -> int:
    """Number of columns of which all sets of a size are tried."""
    while comb(number, size) > _MAX_TRIALS:
        number -= 1
    return number


def _number_of_ones(bits: Words) -> Ints:
    """[K] number of ones in words [K, W]."""
    counts = np.zeros(len(bits), dtype=np.int64)
    for word in bits.T:
        counts += np.bitwise_count(word)
    return counts


def _several(counts: Ints, scores: Floats, columns: Ints, least: float) -> FoundTotal | None:
    """Total of some columns of counts [n, F] whose number explains most of scores [n], found term by term."""
    values, width, price = counts[:, columns], len(columns), float(np.log(2.0 * counts.shape[1]))
    first, second = np.triu_indices(width, 1)
    pairs = np.repeat(np.eye(width, dtype=np.int64)[first], 2, axis=0)
    pairs[np.arange(len(pairs)), np.repeat(second, 2)] = np.tile([1, -1], len(first))
    worths = _priced(values, pairs, scores, price)
    best, highest = None, least
    for index in np.argsort(-worths, kind="stable")[:_NUM_STARTS].tolist():
        weights, worth = _climbed(values, scores, pairs[index], float(worths[index]), price)
        if worth > highest:
            best, highest = weights, worth
    if best is None:
        return None
    result = np.zeros(counts.shape[1], dtype=np.int64)
    result[columns] = best
    return FoundTotal(result, price * np.count_nonzero(best))


def _climbed(values: Ints, scores: Floats, weights: Ints, worth: float, price: float) -> tuple[Ints, float]:
    """Local search: the best change of one weight, while the value grows."""
    while True:
        trials = changed(weights.astype(np.float64), (1.0, -1.0)).astype(np.int64)
        terms = np.count_nonzero(trials, axis=1)
        trials = trials[(terms > 1) & (terms <= MAX_TERMS)]
        worths = _priced(values, trials, scores, price)
        index = int(np.argmax(worths))
        if worths[index] <= worth:
            return weights, worth
        weights, worth = trials[index], float(worths[index])


def _priced(values: Ints, weights: Ints, scores: Floats, price: float) -> Floats:
    """[K] worth of totals of columns [n, C] with weights [K, C], minus the price of their terms."""
    return gains_of((values @ weights.T).T, scores) - price * np.count_nonzero(weights, axis=1)


def gains_of(totals: Ints, scores: Floats) -> Floats:
    """[K] log-likelihood gained by a value for each number of totals [K, n]; minus infinity for too many numbers."""
    totals = totals - totals.min(axis=1, keepdims=True)
    sizes = totals.max(axis=1) + 1
    few = np.flatnonzero(sizes <= _MAX_VALUES)
    gains = np.full(len(totals), -np.inf)
    codes = np.arange(len(few))[:, None] * _MAX_VALUES + totals[few]
    shape = (len(few), _MAX_VALUES)
    number = np.bincount(codes.reshape(-1), minlength=shape[0] * shape[1]).reshape(shape)
    centred = scores - scores.mean()
    sums = np.bincount(codes.reshape(-1), np.tile(centred, len(few)), shape[0] * shape[1]).reshape(shape)
    shares = (sums**2 / np.maximum(number, 1)).sum(axis=1) / float(centred @ centred)
    values = (number > 0).sum(axis=1)
    gains[few] = _gained(shares, scores) - 0.5 * (values - 1) * np.log(len(scores))
    return gains


def _gained(shares: Floats, scores: Floats) -> Floats:
    """Log-likelihood gained by explaining shares of the variance of scores; at most what scores of two levels tell."""
    liked = float((scores > (scores.min() + scores.max()) / 2.0).mean())
    most = len(scores) * -sum(p * np.log(p) for p in (liked, 1.0 - liked) if p > 0.0)
    return np.minimum(-0.5 * len(scores) * np.log(np.maximum(1.0 - shares, 1e-9)), most)


def _packed(bits: NDArray[np.bool_]) -> Words:
    """[C, W] bits [C, n] in words of 64."""
    padded = np.pad(bits, ((0, 0), (0, -bits.shape[1] % 64)))
    return np.packbits(padded, axis=1).view(np.uint64)
