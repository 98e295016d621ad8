"""Draws of Gaussian values given what was observed of them, by elliptical slice sampling.

A step mixes the values with a draw of their prior, g cos(t) + ν sin(t), and shrinks the range of the angle t until the
result is likely enough (I. Murray, R. Adams, D. MacKay, "Elliptical slice sampling", AISTATS 2010). It has no tuning
and keeps the posterior exactly, unlike the Gaussian of Laplace's approximation, which leaves much more open where all
answers agree (M. Kuss, C. Rasmussen, "Assessing approximate inference for binary Gaussian process classification",
2005).

Prior draws and angles are given, so a draw is a function of its arguments. As long as no decision changes, a step
shrinks differences between values, so those in the last bits stay there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from grammarlab.arrays import Floats

LogLikelihood = Callable[[Floats], float]
"""Logarithm of the likelihood of values."""
MAX_TRIES = 64
"""Most angles of a step; by then the range is empty, and the values stay."""


def drawn_values(start: Floats, steps: Iterable[tuple[Floats, Floats]], log_likelihood: LogLikelihood) -> Floats:
    """The last of a chain of values.

    Args:
        start: values with a likelihood above 0.
        steps: for each step a draw of the prior, of the shape of the values, and [1 + `MAX_TRIES`] uniform draws from 0
            to 1.
        log_likelihood: the likelihood.
    """
    values, now = start, log_likelihood(start)
    for prior, draws in steps:
        least = now + np.log(max(float(draws[0]), 1e-300))
        angle = 2.0 * np.pi * float(draws[1])
        low, high = angle - 2.0 * np.pi, angle
        for draw in draws[2:].tolist():
            moved = values * np.cos(angle) + prior * np.sin(angle)
            likelihood = log_likelihood(moved)
            if likelihood > least:
                values, now = moved, likelihood
                break
            low, high = (angle, high) if angle < 0.0 else (low, angle)
            angle = low + draw * (high - low)
    return values
