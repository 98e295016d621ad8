"""Evidence of the scores of a leaf as a smooth function of one column: a Gaussian process.

The evidence is averaged over a few lengths. Clipping and blunders are left out, so a smooth function is believed too
seldom rather than too often.
"""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.preference.base import MAX_SCORE

LENGTHS = (0.15, 0.3, 0.6, 1.2)
"""Lengths of the process, in standard deviations of the column."""
_LEVEL = MAX_SCORE / 2.0
"""Prior mean of the values and prior standard deviation of their mean, in points."""
_STEP_DEVIATION = np.sqrt(1.0 / 12.0)
"""Standard deviation of rounding to whole points."""


class SmoothLeaf:
    """Scores of m labels as a smooth function of one column, for any noise."""

    def __init__(self, column: Floats, scores: Floats) -> None:
        """The function.

        Args:
            column: [m] values that differ.
            scores: [m] 0-100.
        """
        steps = (column[:, None] - column) / column.std()
        amplitude = max(float(scores.std()), 1.0)
        self._parts: list[tuple[Floats, Floats]] = []
        for length in LENGTHS:
            kernel = amplitude**2 * np.exp(-0.5 * (steps / length) ** 2) + _LEVEL**2
            eigenvalues, vectors = np.linalg.eigh(kernel)
            self._parts.append((np.maximum(eigenvalues, 0.0), (vectors.T @ (scores - _LEVEL)) ** 2))

    def log_evidence(self, noise: float) -> float:
        """Log-probability of the scores, each to the nearest point, averaged over the lengths."""
        variance = noise**2 + _STEP_DEVIATION**2
        each = [
            -0.5 * float((squares / (values + variance) + np.log(2.0 * np.pi * (values + variance))).sum())
            for values, squares in self._parts
        ]
        return float(np.logaddexp.reduce(each) - np.log(len(each)))
