"""Newton's method for a log-posterior, each step halved until it gains."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats

ENOUGH = 0.02
"""Gain of a step in nats, below which it is the last one."""


class Height(NamedTuple):
    """A log-posterior at a point, and how it changes there."""

    value: float
    """In nats."""
    gradient: Floats
    """[k]"""
    precision: Floats
    """[k, k] > 0, expected curvature with its sign turned."""


def climbed(height_at: Callable[[Floats], Height], start: Floats) -> Floats:
    """The point [k] where a log-posterior is highest, of those above a start.

    A part of a step that gains too little even along a straight line is not tried.

    >>> parabola = lambda point: Height(-float(point @ point), -2.0 * point, 2.0 * np.eye(len(point)))
    >>> climbed(parabola, np.array([3.0, -4.0])).tolist()
    [0.0, 0.0]
    """
    point, height = start, height_at(start)
    while True:
        step = np.linalg.solve(height.precision, height.gradient)
        slope, trial = float(height.gradient @ step), height_at(point + step)
        while trial.value <= height.value and slope >= ENOUGH:
            step, slope = step / 2.0, slope / 2.0
            trial = height_at(point + step)
        gain = trial.value - height.value
        if gain > 0.0:
            point, height = point + step, trial
        if not gain >= ENOUGH:
            return point
