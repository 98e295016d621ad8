"""Ranks of labels by the values of columns, and bins of ranks."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats, Ints


def ranks_of(columns: Floats) -> Ints:
    """[C, n] index of each value among the different values of its column, for columns [n, C].

    >>> ranks_of(np.array([[0.5], [0.1], [0.5], [0.9]])).tolist()
    [[1, 0, 1, 2]]
    """
    rows = np.ascontiguousarray(columns.T)
    # Equal values have one rank, so their order does not matter.
    order = np.argsort(rows, axis=1)
    ranks = np.empty(rows.shape, dtype=np.int64)
    np.put_along_axis(ranks, order, _steps(np.take_along_axis(rows, order, axis=1)), axis=1)
    return ranks


def bins_of_ranks(ranks: Ints, most: int) -> Ints:
    """[C, R] bin of each rank of columns [C, n]: by the number of labels with a smaller value."""
    num_columns, num = ranks.shape
    num_ranks = int(ranks.max()) + 1
    flat = ranks + np.arange(num_columns)[:, None] * num_ranks
    count = np.bincount(flat.reshape(-1), minlength=num_columns * num_ranks).reshape(num_columns, num_ranks)
    return _steps((np.cumsum(count, axis=1) - count) * most // num)


def binned(columns: Floats, most: int) -> Ints:
    """[C, n] bin of each label, ascending by value, from 0, for columns [n, C].

    Args:
        columns: [n, C] columns.
        most: columns of at most so many values have a bin for each; of more, at most so many bins of about as many
            labels.
    """
    codes = ranks_of(columns)
    many = np.flatnonzero(codes.max(axis=1, initial=-1) >= most)
    if len(many):
        codes[many] = np.take_along_axis(bins_of_ranks(codes[many], most), codes[many], axis=1)
    return codes


def _steps(ascending: Floats | Ints) -> Ints:
    """[C, n] index of each value among the different values of its row, which is ascending."""
    steps = np.zeros(ascending.shape, dtype=np.int64)
    np.cumsum(ascending[:, 1:] > ascending[:, :-1], axis=1, out=steps[:, 1:])
    return steps
