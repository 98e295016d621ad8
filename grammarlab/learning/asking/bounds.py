"""Questions about models near a bound on continuous draws, so that few labels narrow it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def between(margins: Floats, asked: Ints, num: int) -> Ints:
    """Models that narrow a bound: evenly spaced, by rank, between the nearest scored models on both sides.

    With num models per round, the interval between the two sides shrinks by a factor of num + 1 per round.

    Args:
        margins: [m] signed distance of each model of the pool to the bound
            (`grammarlab.features.search.thresholds.margins`).
        asked: [n] pool indices of the scored models.
        num: largest number of models; fewer if there are no more between the two.

    Returns:
        Different pool indices, none of them in ``asked``.

    >>> between(np.arange(-8.0, 9.0), np.array([0, 4, 16]), 3).tolist()
    [7, 10, 13]
    """
    known = margins[asked]
    low = known[known < 0.0].max(initial=-np.inf)
    high = known[known >= 0.0].min(initial=np.inf)
    inside = np.flatnonzero((margins > low) & (margins < high) & np.isfinite(margins))
    inside = np.setdiff1d(inside, asked)
    inside = inside[np.argsort(margins[inside], kind="stable")]
    num = min(num, len(inside))
    return inside[((np.arange(num) + 1) * len(inside)) // (num + 1)]
