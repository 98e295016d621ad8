"""Runs of repeated parts."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Repeat(NamedTuple):
    """Items that are repeated `turns` times."""

    start: int
    period: int
    turns: int

    @property
    def end(self) -> int:
        """The index after the run."""
        return self.start + self.period * self.turns


def repeated_runs(items: Sequence[Hashable]) -> list[Repeat]:
    """Runs that do not overlap, in their order: the one that saves the most items, and others with as many turns.

    A split divides its room evenly among its repeats, so that repeats with different numbers of turns cannot share a
    split.

    >>> repeated_runs("abcbcbcd"), repeated_runs("abc")
    ([Repeat(start=1, period=2, turns=3)], [])
    >>> [run.start for run in repeated_runs("wwdwwdwww")]
    [0, 6]
    """
    numbers = {item: place for place, item in enumerate(dict.fromkeys(items))}
    column = np.array([numbers[item] for item in items], dtype=np.int64)
    best = _longest(column)
    return [] if best is None else _beside(column, 0, best.turns)


def _beside(column: NDArray[np.int64], start: int, count: int) -> list[Repeat]:
    """The runs with this number of turns in a range of the items."""
    found = _longest(column, count)
    if found is None:
        return []
    left = _beside(column[: found.start], start, count)
    right = _beside(column[found.end :], start + found.end, count)
    return [*left, found._replace(start=start + found.start), *right]


def _longest(column: NDArray[np.int64], turns: int = 0) -> Repeat | None:
    """The run that saves the most items [N], with this number of turns if one is given."""
    best = None
    for period in range(1, len(column) // max(turns, 2) + 1):
        equal = np.concatenate([[0], column[period:] == column[:-period], [0]]).astype(np.int8)
        starts, ends = np.flatnonzero(np.diff(equal) == 1), np.flatnonzero(np.diff(equal) == -1)
        if not len(starts):
            continue
        longest = int(np.argmax(ends - starts))
        count = int(ends[longest] - starts[longest]) // period + 1
        if count < max(turns, 2):
            continue
        run = Repeat(int(starts[longest]), period, turns or count)
        if best is None or (run.turns - 1) * period > (best.turns - 1) * best.period:
            best = run
    return best
