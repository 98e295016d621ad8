"""Bins of the labels of a node by a column: of about as many labels each, and the intervals that stand out.

A narrow interval of liked designs would be a part of one bin, in which disliked ones are more. The interval with the
largest sum of scores, less their mean, and the one with the smallest have bins of their own, whatever their width.
"""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.growth.ranks import bins_of_ranks, ranks_of


def node_bins(columns: Floats, scores: Floats, most: int) -> Ints:
    """[C, n] bin of each label by each of some columns, ascending by value, from 0.

    Args:
        columns: [n, C] columns, n >= 1.
        scores: [n] scores of the labels.
        most: columns of at most so many values have a bin for each; of more, so many bins, and those of intervals.

    >>> column = np.arange(12.0)[:, None]
    >>> node_bins(column, np.where(np.arange(12) == 4, 90.0, 0.0), 2).tolist()
    [[0, 0, 0, 0, 1, 2, 3, 3, 3, 3, 3, 3]]
    """
    ranks = ranks_of(columns)
    many = np.flatnonzero(ranks.max(axis=1, initial=-1) >= most)
    if len(many):
        ranks[many] = _binned(ranks[many], scores - scores.mean(), most)
    return ranks


def _binned(ranks: Ints, centred: Floats, most: int) -> Ints:
    """[C, n] bins of ranks [C, n]."""
    bins = bins_of_ranks(ranks, most)
    num, width = bins.shape
    starts = np.zeros((num, width + 1), dtype=bool)
    starts[:, 1:width] = bins[:, 1:] > bins[:, :-1]
    flat = (ranks + np.arange(num)[:, None] * width).reshape(-1)
    sums = np.bincount(flat, np.broadcast_to(centred, ranks.shape).reshape(-1), num * width).reshape(num, width)
    below = np.concatenate([np.zeros((num, 1)), np.cumsum(sums, axis=1)], axis=1)
    each = np.arange(num)
    for sign in (1.0, -1.0):
        end = (sign * below - np.minimum.accumulate(sign * below, axis=1)).argmax(axis=1)
        before = np.arange(width + 1) <= end[:, None]
        starts[each, np.where(before, sign * below, np.inf).argmin(axis=1)] = True
        starts[each, end] = True
    starts[:, 0] = False
    return np.take_along_axis(np.cumsum(starts[:, :width], axis=1), ranks, axis=1)
