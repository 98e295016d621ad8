"""How often to repeat things so that rows of springs fit a size best: branch and bound over whole numbers.

A row of springs of length a, give q and energy e, repeated n times, beside some that stay, has the energy
e0 + sum n e + r^2 / g with r = size - a0 - sum n a and g = q0 + sum n q. For every u it is at least
e0 + sum n e + 2 u r - u^2 g, where the counts stand apart from each other, so that the least over any ranges of counts
is at hand; the best u makes that bound as large as it gets.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np

from grammarlab.facade.tree import Floats, Ints

_HALVINGS = 60


@dataclass(frozen=True, eq=False)
class Rows:
    """R rows of springs that get the same size, made of S kinds of springs, each as often in every row."""

    length: Floats
    """[R, S] metres."""
    give: Floats
    """[R, S]"""
    rest: Floats
    """[S] energy of one repetition over all rows."""
    fixed_length: Floats
    """[R] metres of what is not repeated."""
    fixed_give: Floats
    """[R] of what is not repeated; below 0 where one repetition brings less than the others."""
    fixed_rest: float
    size: float
    """Metres that each row gets."""

    def energy(self, counts: Ints) -> float:
        """Of so many repetitions [S] of each kind, when nothing ties the rows to each other."""
        missing = self.size - self.fixed_length - self.length @ counts
        return float(self.fixed_rest + counts @ self.rest + np.square(missing) @ (1.0 / (self.fixed_give + self.give @ counts)))

    def bound(self, least: Ints, most: Ints) -> tuple[float, Ints]:
        """No counts in these ranges [S] have less energy, and [S] counts that are near the best of them."""
        length, give = self.length.sum(axis=0), self.give.sum(axis=0)
        missing, fixed_give = float((self.size - self.fixed_length).sum()), float(self.fixed_give.sum())
        reach = (abs(missing) + float(most @ length)) / (fixed_give + float(least @ give))
        low, high = -reach, reach
        best, counts = -np.inf, least
        for _ in range(_HALVINGS):
            u = 0.5 * (low + high)
            price = self.rest - 2.0 * u * length - u**2 * give
            at = np.where(price < 0.0, most, least)
            value = self.fixed_rest + 2.0 * u * missing - u**2 * fixed_give + float(at @ price)
            if value > best:
                best, counts = value, at
            if missing - at @ length > u * (fixed_give + at @ give):
                low = u
            else:
                high = u
        return best, counts


@dataclass(frozen=True, slots=True)
class Found:
    """The counts of least energy, as far as is known."""

    counts: Ints
    """[S]"""
    energy: float
    bound: float
    """No other counts have less energy than this."""
    tries: int
    """How many counts were solved for."""


def fewest(
    problems: list[tuple[Rows, Ints, Ints]], solve: Callable[[Ints], float], gap: float, slack: float, most_tries: int
) -> Found:
    raise NotImplementedError
