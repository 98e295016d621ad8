"""Rounding of percentages to multiples of a step, with a sum of 100."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from grammarlab.arrays import Floats

EXACT = 0.0
"""Step of exact probabilities."""
DIGITS = 12
"""Number of decimals of a probability; further decimals are rounding errors."""


def are_equal(probabilities: Floats | float, others: Floats | float) -> bool:
    """Whether probabilities differ from others by rounding errors only.

    >>> are_equal(np.array([0.5, 0.5]), np.array([0.5, 0.5 + 1e-14])), are_equal(0.5, 0.5 + 1e-9)
    (True, False)
    """
    return np.allclose(probabilities, others, rtol=10.0**-DIGITS, atol=0.0)


def learnable_step(num: int) -> float:
    """Step of shares that are learned from a number of models: a tenth of a percent, smaller for many models.

    Rounding then changes a share of a half by at most a tenth of its standard error.

    >>> learnable_step(1), learnable_step(1_000_000)
    (0.001, 0.0001)
    """
    return min(0.001, float(10.0 ** np.floor(np.log10(0.1 / np.sqrt(num)))))


def rounded(probabilities: Sequence[float], step: float) -> list[float]:
    """Probabilities as multiples of a step; the largest one gets the rest to 1.

    Probabilities that would become 0 keep one digit.

    Args:
        probabilities: above 0, summing to 1.
        step: >= 0; 0.01 for whole percents.

    >>> rounded([0.1527, 0.2473, 0.6], 0.01), rounded([0.0004, 0.9996], 0.01)
    ([0.15, 0.25, 0.6], [0.0004, 0.9996])
    """
    if step == EXACT:
        return list(probabilities)
    exact = np.array(probabilities)
    result = np.rint(exact / step) * step
    result = np.where(result > 0.0, result, [float(f"{p:.0e}") for p in exact])
    largest = int(exact.argmax())
    result[largest] = 1.0 - np.delete(result, largest).sum()
    result = np.round(result, DIGITS)
    return result.tolist() if (result > 0.0).all() else list(probabilities)


def rounded_parts(probabilities: Floats, original: Floats, branches: Sequence[object], step: float) -> Floats:
    """Probabilities [parts] of an attribute, rounded per range.

    Args:
        probabilities: [parts] summing to 1.
        original: [parts] original probabilities; adjacent parts of one branch in unchanged proportion are one range.
        branches: [parts] branch of each part.
        step: >= 0; 0.01 for whole percents.
    """
    ratio = probabilities / original
    if step == EXACT or np.allclose(ratio, 1.0, rtol=1e-12):
        return probabilities
    new = [True, *(a != b for a, b in pairwise(branches))]
    new = np.array(new) | (np.abs(np.diff(ratio, prepend=np.inf)) > 1e-12 * ratio)
    run = np.cumsum(new) - 1
    mass = np.bincount(run, probabilities)
    liked = mass > 0.0
    round_mass = np.zeros(len(mass))
    round_mass[liked] = rounded(mass[liked].tolist(), step)
    factor = np.divide(round_mass, mass, out=np.zeros(len(mass)), where=liked)
    return probabilities * factor[run]
