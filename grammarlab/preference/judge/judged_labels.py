"""Which labels are judged if there are very many."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats, Ints

MAX_LABELS = 384
"""Largest number of labels that are judged, and of a smooth leaf: time grows with the third power of their number."""


def selected(scores: Floats) -> Ints:
    """Ascending indices of at most `MAX_LABELS` labels, an even selection by score."""
    num = min(MAX_LABELS, len(scores))
    return np.sort(np.argsort(scores, kind="stable")[np.arange(num) * len(scores) // max(num, 1)])
