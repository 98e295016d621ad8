"""A quick measure of how much each of thousands of columns may explain, to choose those that are compared exactly."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import ROUNDING, Flags, Floats, Ints
from grammarlab.preference.growth.ranks import binned

COARSE_BINS = 8
"""Number of bins of a column: enough for a band or a wave, few enough to explain little by chance."""


def coarse_bins(columns: Floats) -> Ints:
    """[C, n] bin of each label by each of columns [n, C]."""
    return binned(columns, COARSE_BINS)


def gains(coarse: Ints, labels: Ints, scores: Floats) -> Floats:
    """[C] estimated gain of log-likelihood by a mean for each bin of each column, less what chance gains.

    Args:
        coarse: [C, n] bins of all n labels, see `coarse_bins`.
        labels: [m] indices of the labels that count.
        scores: [n] scores of all labels.
    """
    return explained(coarse[:, labels], COARSE_BINS, scores[labels])


def gains_of_parts(coarse: Ints, parts: Flags, scores: Floats) -> Floats:
    """[P, C] the same for parts [P, n] of the labels, all at once; 0 for a part of equal scores."""
    width, members = COARSE_BINS, parts.T.astype(np.float64)
    in_bin = (coarse[:, None, :] == np.arange(width)[:, None]).reshape(-1, len(scores)).astype(np.float64)
    centred = scores - scores.mean()
    shape = (len(coarse), width, len(parts))
    number = (in_bin @ members).reshape(shape)
    sums = (in_bin @ (members * centred[:, None])).reshape(shape)
    size, all_sums, squares = (part @ members for part in (np.ones(len(scores)), centred, centred**2))
    correction = all_sums**2 / np.maximum(size, 1.0)
    total = squares - correction
    between = (sums**2 / np.maximum(number, 1.0)).sum(axis=1) - correction
    worth = gain_of_share(between / np.maximum(total, ROUNDING), (number > 0.0).sum(axis=1), size)
    return np.where((total > ROUNDING) & (size >= 2.0), worth, 0.0).T


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
    return gain_of_share(share, occupied, m)


def gain_of_share(share: Floats, occupied: Ints, num: float | Floats) -> Floats:
    """Gain of log-likelihood of codes that explain a share of the variance, less what chance gains."""
    unexplained = np.maximum(1.0 - share, 1.0 / (num + 1.0) ** 2)
    return -0.5 * num * np.log(unexplained) - 0.5 * (occupied - 1) * (
        1.0 + np.log(np.maximum(num / np.maximum(num - occupied, 1), 1))
    )
