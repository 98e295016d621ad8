"""Types of columns, ragged lists as values plus offsets, and basic operations on columns.

A ragged list of N rows is ``values`` of length ``offsets[N]`` and ``offsets`` of length N + 1: row i is
``values[offsets[i]:offsets[i + 1]]``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
AnyFloats = NDArray[np.floating]
"""Numbers of single or double precision, as pictures are made of."""

_MOST_PLACES = 8
"""Largest ratio of possible to given values for which marking flags is faster than sorting."""


def offsets_from_counts(counts: NDArray[np.integer]) -> Ints:
    """Offsets [N + 1] of a ragged list from the length of each row [N].

    >>> offsets_from_counts(np.array([2, 0, 3])).tolist()
    [0, 2, 2, 5]
    """
    offsets = np.zeros(len(counts) + 1, dtype=np.int64)
    np.cumsum(counts, out=offsets[1:])
    return offsets


def row_of_value(counts: NDArray[np.integer]) -> Ints:
    """Row of each value of a ragged list.

    >>> row_of_value(np.array([2, 0, 3])).tolist()
    [0, 0, 2, 2, 2]
    """
    return np.repeat(np.arange(len(counts), dtype=np.int64), counts)


def index_in_row(counts: NDArray[np.integer]) -> Ints:
    """Index of each value of a ragged list within its row.

    >>> index_in_row(np.array([2, 0, 3])).tolist()
    [0, 1, 0, 1, 2]
    """
    starts = np.cumsum(counts) - counts
    return np.arange(int(np.sum(counts)), dtype=np.int64) - np.repeat(starts, counts)


def take_rows(offsets: NDArray[np.integer], rows: NDArray[np.integer]) -> tuple[Ints, Ints]:
    """Indices of the values of chosen rows, and the offsets of the list of these rows.

    Args:
        offsets: [N + 1] offsets of a ragged list.
        rows: [K] rows to take, in any order, repeats allowed.

    Returns:
        Indices into the values, and the new offsets [K + 1].

    >>> where, offsets = take_rows(np.array([0, 2, 2, 5]), np.array([2, 0]))
    >>> where.tolist(), offsets.tolist()
    ([2, 3, 4, 0, 1], [0, 3, 5])
    """
    starts = offsets[rows]
    counts = offsets[np.asarray(rows) + 1] - starts
    where = np.repeat(starts, counts) + index_in_row(counts)
    return where.astype(np.int64, copy=False), offsets_from_counts(counts)


def distinct(values: NDArray[np.integer], limit: int) -> Ints:
    """The different values, ascending, of a column of integers in 0 <= value < limit.

    >>> distinct(np.array([4, 1, 4]), 6).tolist()
    [1, 4]
    """
    if limit > _MOST_PLACES * len(values):
        return np.unique(values).astype(np.int64)
    present = np.zeros(limit, dtype=bool)
    present[values] = True
    return np.flatnonzero(present)


def distinct_counts(values: NDArray[np.integer], limit: int) -> tuple[Ints, Ints]:
    """The different values, ascending, of a column of integers in 0 <= value < limit, and how often each occurs.

    >>> different, counts = distinct_counts(np.array([4, 1, 4]), 6)
    >>> different.tolist(), counts.tolist()
    ([1, 4], [1, 2])
    """
    if limit > _MOST_PLACES * len(values):
        different, counts = np.unique(values, return_counts=True)
        return different.astype(np.int64), counts
    counts = np.bincount(values, minlength=limit)
    different = np.flatnonzero(counts > 0)  # nonzero of flags is twice as fast as of integers
    return different, counts[different]


def connected(num: int, one: Ints, other: Ints) -> Ints:
    """[num] connected component of each node of an undirected graph, numbered in the order of their first nodes.

    Args:
        num: number of nodes.
        one: [E] one end of each edge.
        other: [E] the other end.

    >>> connected(5, np.array([3, 4]), np.array([1, 3])).tolist()
    [0, 1, 2, 1, 1]
    """
    # Imported here, since few models need it and it takes a third of the time to start.
    from scipy.sparse import coo_array  # noqa: PLC0415
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    graph = coo_array((np.ones(len(one), dtype=np.int8), (one, other)), shape=(num, num))
    _, label = connected_components(graph, directed=False)
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[inverse]
