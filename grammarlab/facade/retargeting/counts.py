"""How often to repeat things so that rows of springs fit a size best: branch and bound over whole numbers.

A row of springs of length a, give q and energy e, repeated n times, beside some that stay, has the energy
e0 + sum n e + r^2 / g with r = size - a0 - sum n a and g = q0 + sum n q. For every u it is at least
e0 + sum n e + 2 u r - u^2 g, where the counts stand apart from each other, so that the least over any ranges of counts
is at hand; the best u makes that bound as large as it gets.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from heapq import heapify, heappop, heappush

import numpy as np

from grammarlab.facade.tree import Floats, Ints

_HALVINGS = 40
"""Of the range in which the best u is looked for; any u gives a bound."""
_IMPOSSIBLE = 10
"""After so many counts that are all impossible no others are tried."""
_BOXES = 20
"""How many boxes are halved for each try."""


@dataclass(frozen=True, eq=False)
class SpringRows:
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
    """[R] of what is not repeated; below 0 where one repetition brings less than the others do."""
    fixed_rest: float
    size: float
    """Metres that each row gets."""
    share: Floats
    """[S] how many there would be of each kind."""
    price: Floats
    """[S] > 0, energy that one more or less costs, and two more four times."""

    def unevenness(self, counts: Ints) -> float:
        """Cost of so many [S] of each kind."""
        return float(self.price @ np.square(counts - self.share))

    def energy(self, counts: Ints) -> float:
        """Of so many repetitions [S] of each kind, when nothing ties the rows to each other, without unevenness."""
        missing, give = self.size - self.fixed_length - self.length @ counts, self.fixed_give + self.give @ counts
        return float(self.fixed_rest + counts @ self.rest + (missing**2 / give).sum())

    def bound(self, least: Ints, most: Ints) -> float:
        """What no counts in these ranges [S] cost less than."""
        length, give = self.length.sum(axis=0), self.give.sum(axis=0)
        missing, fixed_give = float((self.size - self.fixed_length).sum()), float(self.fixed_give.sum())
        reach = (abs(missing) + float(most @ length)) / (fixed_give + float(least @ give))
        low, high = -reach, reach
        best = -np.inf
        for _ in range(_HALVINGS):
            u = 0.5 * (low + high)
            each = self.rest - 2.0 * u * length - u**2 * give
            counts = np.clip(np.rint(self.share - 0.5 * each / self.price), least, most)
            cost = float(counts @ each + self.price @ (counts - self.share) ** 2)
            best = max(best, self.fixed_rest + 2.0 * u * missing - u**2 * fixed_give + cost)
            if missing - counts @ length > u * (fixed_give + counts @ give):
                low = u
            else:
                high = u
        return best


@dataclass(frozen=True, slots=True)
class Box:
    """Ranges of counts to choose from."""

    rows: SpringRows
    least: Ints
    """[S]"""
    most: Ints
    """[S]"""
    owner: int = 0
    """Number of what is repeated, where there are several things to choose from."""

    def bound(self) -> float:
        """What nothing in the box costs less than."""
        if (self.least == self.most).all():
            return self.rows.energy(self.least) + self.rows.unevenness(self.least)
        return self.rows.bound(self.least, self.most)

    def uneven(self) -> float:
        """How far from their shares counts are at least."""
        return float(np.abs(np.clip(self.rows.share, self.least, self.most) - self.rows.share).sum())

    def halves(self) -> tuple[Box, Box]:
        """The box in two, across the range that is worth most metres."""
        across = int(((self.most - self.least) * self.rows.length.mean(axis=0)).argmax())
        middle = (self.least[across] + self.most[across]) // 2
        most, least = self.most.copy(), self.least.copy()
        most[across], least[across] = middle, middle + 1
        return replace(self, most=most), replace(self, least=least)


@dataclass(frozen=True, slots=True)
class BestCounts:
    """The best counts, as far as was looked."""

    owner: int
    """Of the box that they are from."""
    counts: Ints
    """[S]"""
    cost: float
    """Their energy and unevenness."""
    bound: float
    """No counts cost less than this; at most the cost."""
    tries: int
    """How many counts were solved for."""


def fewest(
    boxes: Sequence[Box], solve: Callable[[int, Ints], float], start: Ints, gap: float, slack: float, most_tries: int
) -> BestCounts:
    """Counts whose cost is within a gap of the least.

    Args:
        boxes: what to choose from.
        solve: the cost of an owner's counts; not below that of its rows of springs, infinite for what is impossible.
        start: [S] counts of the first owner to begin with.
        gap: part of the cost that does not matter.
        slack: cost that does not matter.
        most_tries: how many counts are solved for at most, and how many boxes are halved for each.
    """
    best, owner, cost, tries, halved = start, boxes[0].owner, solve(boxes[0].owner, start), 1, 0
    heap = [(box.bound(), box.uneven(), number, box) for number, box in enumerate(boxes)]
    heapify(heap)
    number = len(heap)
    bound = cost
    while heap:
        bound, _, _, box = heappop(heap)
        hopeless = tries >= _IMPOSSIBLE and np.isinf(cost)
        if bound >= cost * (1.0 - gap) - slack or tries >= most_tries or halved >= _BOXES * most_tries or hopeless:
            break
        if (box.least == box.most).all():
            found, tries = solve(box.owner, box.least), tries + 1
            if found < cost:
                best, owner, cost = box.least, box.owner, found
            continue
        halved += 1
        for half in box.halves():
            heappush(heap, (half.bound(), half.uneven(), number, half))
            number += 1
    else:
        bound = cost
    return BestCounts(owner, best, cost, min(bound, cost), tries)
