"""Widths of letters that have none of their own: how far columns let each of them spread.

Letters of one symbol get one size in the end. So the spreads of a symbol's letters that are unsized or split may differ
by the tolerance at most, and by no more from its preferred size if it has one. Where two of them share an element, each
may have any part of it: a spread is an interval.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

from grammarlab.facade.layers.alignment.pairs import PairProblem
from grammarlab.facade.layers.alignment.rows import AlignedRow, RowStep, may_be_empty

Interval = tuple[int, int]
"""Units, at least and at most."""
_ANY: Interval = (0, 1 << 62)
_NONE: Interval = (0, 0)


class Widths(NamedTuple):
    """What is known of letters without a width of their own, after some columns."""

    symbols: tuple[Interval, ...]
    """The largest that a letter of the symbol is at least, and the smallest that one is at most."""
    opened: tuple[Interval, ...]
    """Of each row, its letter that goes on in the next column."""


@dataclass(frozen=True)
class Tracked:
    """A row whose letters share symbols with others."""

    row: int
    symbol: dict[int, int]
    """By letter."""
    strict: tuple[bool, ...]
    """[2n + 1] whether after a state every letter has a size or is tracked, and none can make space."""
    apart: bool
    """Whether no two letters without a width of their own can share an element."""


class Spreads:
    """Which symbols of a problem are to be watched, and in which rows."""

    def __init__(self, problem: PairProblem) -> None:
        self.problem = problem
        letters = [letter for row in problem.rows for letter in row.word]
        often = Counter(letter.symbol for letter in letters if letter.size is None)
        sized = {letter.symbol for letter in letters if letter.size is not None and letter.transparent}
        symbols = sorted({*sized, *(symbol for symbol, times in often.items() if times > 1)})
        number = {symbol: at for at, symbol in enumerate(symbols)}
        start = [_ANY] * len(symbols)
        self.rows: list[Tracked] = []
        for at, row in enumerate(problem.rows):
            of: dict[int, int] = {}
            for place, letter in enumerate(row.word):
                if letter.symbol in number and (letter.transparent or letter.size is None):
                    of[place] = number[letter.symbol]
                if letter.symbol in sized and letter.size is not None:
                    start[number[letter.symbol]] = (row.sizes[place], row.sizes[place])
            if of:
                self.rows.append(Tracked(at, of, _strict(row, of), _apart(row)))
        # Where a column may be as wide as what is left, spans say nothing about what is still to come.
        self.bounded = not any(letter.size is None and not letter.transparent for letter in letters)
        self.start = Widths(tuple(start), (_NONE,) * len(problem.rows))

    def after(self, widths: Widths, column: Sequence[RowStep], high: int, *, elastic: bool, span: int) -> Widths | None:
        """What is known after one more column of this width; None when letters of a symbol differ too much.

        Args:
            widths: what was known before it.
            column: its elements.
            high: units, its width.
            elastic: whether it may be wider.
            span: units, of all columns with this one.
        """
        tolerance = self.problem.tolerance
        symbols, opened = list(widths.symbols), list(widths.opened)
        for tracked in self.rows:
            step = column[tracked.row]
            share = high - step.size
            part: Interval = (share if len(step.loose) == 1 else 0, _ANY[1] if elastic else share)
            goes_on = step.state // 2 if step.state % 2 else -1
            for place, letter in enumerate(step.loose):
                spread = part
                if place == 0:
                    before = opened[tracked.row]
                    spread = (before[0] + part[0], before[1] + part[1])
                    opened[tracked.row] = _NONE
                if letter == goes_on:
                    opened[tracked.row] = spread
                number = tracked.symbol.get(letter)
                if number is None:
                    continue
                least, most = symbols[number]
                known = (max(least, spread[0]), most if letter == goes_on else min(most, spread[1]))
                if known[0] > known[1] + tolerance:
                    return None
                if letter != goes_on:
                    symbols[number] = known
        after = Widths(tuple(symbols), tuple(opened))
        reaches = not self.bounded or all(
            self._reaches(tracked, column, after, span) for tracked in self.rows if tracked.apart
        )
        return after if reaches else None

    def _reaches(self, tracked: Tracked, column: Sequence[RowStep], widths: Widths, span: int) -> bool:
        """Whether what is left of a row may be as long as what is left of the canvas."""
        row, state = self.problem.rows[tracked.row], column[tracked.row].state
        tolerance = self.problem.tolerance
        least, most = row.left[state], 0
        for at in range(state // 2, len(row.word)):
            number = tracked.symbol.get(at)
            if number is None:
                most += row.sizes[at] + tolerance
                continue
            low, high = widths.symbols[number]
            done = widths.opened[tracked.row] if state % 2 and at == state // 2 else _NONE
            least += max(low - tolerance - done[1], 0)
            most += max(high, row.sizes[at]) + tolerance - done[0]
        if span + least > self.problem.most:
            return False
        return not tracked.strict[state] or span + most >= self.problem.least


def _strict(row: AlignedRow, tracked: dict[int, int]) -> tuple[bool, ...]:
    strict = []
    for state in range(row.last + 1):
        read = (state + 1) // 2
        known = all(letter.size is not None or at in tracked for at, letter in enumerate(row.word) if at >= state // 2)
        strict.append(known and not any(may_be_empty(row.word, at) for at in range(read, len(row.word) + 1)))
    return tuple(strict)


def _apart(row: AlignedRow) -> bool:
    runs = [list(run) for _, run in groupby(row.word, key=lambda letter: letter.transparent)]
    return all(sum(letter.transparent or letter.size is None for letter in run) <= 1 for run in runs)
