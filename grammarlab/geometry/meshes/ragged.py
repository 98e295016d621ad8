"""Sums, neighbours and cycles in ragged lists, for polygon code; basic operations are in `grammarlab.arrays`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts, row_lengths, row_of_value

Indices = NDArray[np.int64]


def sum_rows(values: NDArray, offsets: Indices) -> NDArray:
    """[N] the sum of each row of a ragged list of numbers [V]; zero for empty rows.

    Values are added in order, so a row has the same sum in every batch.

    >>> sum_rows(np.array([1, 2, 3, 4]), np.array([0, 3, 3, 4])).tolist()
    [6, 0, 4]
    """
    if values.dtype.kind == "f":
        return np.bincount(row_of_value(row_lengths(offsets)), values, len(offsets) - 1)
    ends = np.zeros(len(values) + 1, np.int64)
    np.cumsum(values, out=ends[1:])
    return row_lengths(ends.take(offsets))


def max_rows(values: NDArray, offsets: Indices, empty: float) -> NDArray:
    """[N] the largest number of each row of a ragged list; ``empty`` for rows without any."""
    result = np.full(len(offsets) - 1, empty)
    filled = row_lengths(offsets) > 0
    if filled.any():
        result[filled] = np.maximum.reduceat(values, offsets[:-1][filled])
    return result


def any_rows(flags: NDArray[np.bool_], offsets: Indices) -> NDArray[np.bool_]:
    """[N] whether a row of a ragged list of flags has a true one."""
    return sum_rows(flags, offsets) > 0


def all_rows(flags: NDArray[np.bool_], offsets: Indices) -> NDArray[np.bool_]:
    """[N] whether all flags of a row are true; true for empty rows."""
    return ~any_rows(~flags, offsets)


def distinct_keys(keys: NDArray[np.integer]) -> tuple[Indices, Indices]:
    """Index of one occurrence of each different key, in ascending order of keys, and the number of each key.

    >>> where, number = distinct_keys(np.array([7, 3, 7]))
    >>> np.array([7, 3, 7])[where].tolist(), number.tolist()
    ([3, 7], [1, 0, 1])
    """
    order = np.argsort(keys)
    ranked = keys.take(order)
    is_first = np.ones(len(keys), bool)
    np.not_equal(ranked[1:], ranked[:-1], out=is_first[1:])
    number = np.empty(len(keys), np.int64)
    number[order] = np.cumsum(is_first) - 1
    return order[is_first], number


def next_in_row(offsets: Indices) -> Indices:
    """[V] index of the successor of each value of a ragged list with cyclic rows.

    >>> next_in_row(np.array([0, 3, 5])).tolist()
    [1, 2, 0, 4, 3]
    """
    following = np.arange(1, offsets[-1] + 1, dtype=np.int64)
    filled = row_lengths(offsets) > 0
    following[offsets[1:][filled] - 1] = offsets[:-1][filled]
    return following


def cycles(successor: Indices) -> tuple[Indices, Indices]:
    """The cycles of a permutation, each from its smallest element on.

    Pointer doubling: about log2 of the longest cycle passes over the columns.

    Args:
        successor: [V] a permutation of 0..V-1.

    Returns:
        The elements [V] cycle by cycle, and offsets of the cycles, ordered by their smallest elements.

    >>> order, offsets = cycles(np.array([2, 1, 4, 0, 3]))
    >>> order.tolist(), offsets.tolist()
    ([0, 2, 4, 3, 1], [0, 4, 5])
    """
    size = len(successor)
    smallest = np.arange(size, dtype=np.int64)
    jump = successor.astype(np.int64)
    while True:
        shorter = np.minimum(smallest, smallest[jump])
        if np.array_equal(shorter, smallest):
            break
        smallest, jump = shorter, jump[jump]
    back = np.empty(size, np.int64)
    back[successor] = np.arange(size)
    is_start = smallest == np.arange(size)
    back[is_start] = np.flatnonzero(is_start)
    rank = np.where(is_start, 0, 1)
    while True:
        ahead = rank[back]
        if not ahead.any():
            break
        rank = rank + ahead
        back = back[back]
    order = np.lexsort((rank, smallest))
    return order, offsets_from_counts(np.bincount(smallest, minlength=size)[is_start])
