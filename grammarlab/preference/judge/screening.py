"""A quick measure of how much each of thousands of columns may explain, to choose those that are compared exactly."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.judge.cuts import MAX_BINS, BinnedColumns

_NUM_COARSE = 8
"""Number of bins of the screening: enough for a band or a wave, few enough to explain little by chance."""


def gains(columns: BinnedColumns, labels: Ints, scores: Floats) -> Floats:
    """[C] estimated gain of log-likelihood by a mean for each bin of each column, less what chance gains.

    Args:
        columns: the columns of n labels.
        labels: [m] indices of the labels that count.
        scores: [n] scores of all labels.
    """
    codes = columns.codes[:, labels]
    coarse = np.where(
        columns.sizes[:, None] > _NUM_COARSE, codes * _NUM_COARSE // np.maximum(columns.sizes[:, None], 1), codes
    )
    return explained(coarse, min(_NUM_COARSE, MAX_BINS), scores[labels])


def explained(codes: Ints, width: int, scores: Floats) -> Floats:
    """[C] estimated gain of log-likelihood by a mean for each code of a row, less what chance gains.

    Args:
        codes: [C, m] 0 to ``width`` - 1.
        width: number of possible codes.
        scores: [m] scores.
    """
    num, m = codes.shape
    centred = scores - scores.mean()
    total = float(centred @ centred)
    if not total > 0.0 or m < 2:
        return np.zeros(num)
    flat = (codes + np.arange(num)[:, None] * width).reshape(-1)
    number = np.bincount(flat, minlength=num * width).reshape(num, width)
    sums = np.bincount(flat, np.broadcast_to(centred, codes.shape).reshape(-1), num * width).reshape(num, width)
    share = (sums**2 / np.maximum(number, 1)).sum(axis=1) / total
    occupied = (number > 0).sum(axis=1)
    unexplained = np.maximum(1.0 - share, 1.0 / (m + 1.0) ** 2)
    return -0.5 * m * np.log(unexplained) - 0.5 * (occupied - 1) * (
        1.0 + np.log(np.maximum(m / np.maximum(m - occupied, 1), 1))
    )
