"""The shortest description of a word: letters, and loops over runs of them."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Run:
    """Single letters of a word, or a repeated unit."""

    start: int
    """Index of the first letter."""
    length: int
    """Number of letters of the unit."""
    times: int = 1
    """Number of repeats; 1 for a single letter."""

    @property
    def end(self) -> int:
        """Index of the letter after it."""
        return self.start + self.length * self.times


def shortest(word: Sequence[Hashable], prices: Sequence[int], loop: int = 1) -> tuple[Run, ...]:
    """The cheapest runs that spell a word, by dynamic programming over its suffixes.

    A letter costs its price, a loop the prices of its unit and `loop`. Of equally cheap descriptions, the one with most
    repeated letters is taken, and of these the one with single letters before loops: `A(BA)^3` rather than `(AB)^3 A`.
    Loops are not nested. Takes O(n^2 log n) comparisons.

    Args:
        word: n letters.
        prices: [n] price of each letter, equal for equal letters, >= 0.
        loop: price of a loop, >= 0.

    >>> [(run.start, run.length, run.times) for run in shortest("ABABABA", [1] * 7)]
    [(0, 1, 1), (1, 2, 3)]
    """
    num = len(word)
    until = [0]
    for price in prices:
        until.append(until[-1] + price)
    same = _matches(word)
    # Cost, letters outside of loops, and the first run of each suffix.
    best: list[tuple[int, int, Run | None]] = [(0, 0, None)] * (num + 1)
    for at in range(num - 1, -1, -1):
        cost, plain, _ = best[at + 1]
        found = (cost + prices[at], plain + 1, Run(at, 1))
        for length in range(1, (num - at) // 2 + 1):
            repeated = 1 + same[length][at] // length
            price = until[at + length] - until[at] + loop
            for times in range(2, repeated + 1):
                cost, plain, _ = best[at + length * times]
                if (cost + price, plain) < found[:2]:
                    found = (cost + price, plain, Run(at, length, times))
        best[at] = found
    runs, at = [], 0
    while (run := best[at][2]) is not None:
        runs.append(run)
        at = run.end
    return tuple(runs)


def cost_of(runs: Sequence[Run], prices: Sequence[int], loop: int = 1) -> int:
    """Cost of runs, see `shortest`."""
    return sum(sum(prices[run.start : run.start + run.length]) + (loop if run.times > 1 else 0) for run in runs)


def _matches(word: Sequence[Hashable]) -> list[list[int]]:
    """[shift][place] number of letters from a place that equal those a shift later; for shifts up to n / 2."""
    num = len(word)
    found = [[0] * (num + 1)]
    for shift in range(1, num // 2 + 1):
        row = [0] * (num + 1)
        for at in range(num - shift - 1, -1, -1):
            row[at] = row[at + 1] + 1 if word[at] == word[at + shift] else 0
        found.append(row)
    return found
