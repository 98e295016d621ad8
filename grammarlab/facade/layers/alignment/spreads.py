"""Widths of letters that have none of their own: how far columns let each of them spread.

Letters of one symbol get one size in the end. So the spreads of a symbol's letters that are unsized or split may differ
by the tolerance at most, and by no more from its preferred size if it has one. Where two of them share an element, each
may have any part of it: a spread is an interval. Where it is known which letters of other rows a letter is as wide as,
sizes of these have to change so that letters of one symbol are equal, which costs something.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

from grammarlab.facade.layers.alignment.pairs import PairProblem
from grammarlab.facade.layers.alignment.rows import EMPTY, PARTIAL, AlignedRow, RowStep, may_be_empty

Interval = tuple[int, int]
"""Units, at least and at most."""
_ANY: Interval = (0, 1 << 62)
_NONE: Interval = (0, 0)
Counts = tuple[int, ...] | None
"""How often each symbol with a size stands in what is exactly as wide as a letter; None where that is not known."""


class Widths(NamedTuple):
    """What is known of letters without a width of their own, after some columns."""

    symbols: tuple[Interval, ...]
    """The largest that a letter of the symbol is at least, and the smallest that one is at most."""
    opened: tuple[Interval, ...]
    """Of each row, its letter that goes on in the next column."""
    firsts: tuple[Counts, ...] = ()
    """Of each symbol, what its first letter is as wide as; empty where strains do not count."""
    begun: tuple[Counts, ...] = ()
    """The same of the letters that go on."""


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
        # Symbols with sizes, for what letters are as wide as.
        units = {
            letter.symbol: size
            for row in problem.rows
            for letter, size in zip(row.word, row.sizes, strict=True)
            if letter.size is not None
        }
        self.units, self.place = tuple(units.values()), {symbol: at for at, symbol in enumerate(units)}
        if problem.prices.strain and self.rows:
            firsts = [self._counts([symbol]) if symbol in sized else None for symbol in symbols]
            nothing = (0,) * len(units)
            self.start = self.start._replace(firsts=tuple(firsts), begun=(nothing,) * len(problem.rows))

    def after(
        self,
        widths: Widths,
        before: Sequence[int],
        column: Sequence[RowStep],
        high: int,
        *,
        elastic: bool,
        span: int,
    ) -> tuple[Widths, int] | None:
        """What is known after one more column of this width; None when letters of a symbol differ too much.

        Besides, what it costs at least that sizes have to change for all that, in units of cost.

        Args:
            widths: what was known before it.
            before: the states of rows before it.
            column: its elements.
            high: units, its width.
            elastic: whether it may be wider.
            span: units, of all columns with this one.
        """
        tolerance = self.problem.tolerance
        symbols, opened = list(widths.symbols), list(widths.opened)
        firsts, begun, strain = list(widths.firsts), list(widths.begun), 0
        whole = self._whole(before, column) if firsts else None
        for tracked in self.rows:
            step = column[tracked.row]
            share = high - step.size
            part: Interval = (share if len(step.loose) == 1 else 0, _ANY[1] if elastic else share)
            goes_on = step.state // 2 if step.state % 2 else -1
            for place, letter in enumerate(step.loose):
                spread = part
                counts = self._rest(whole, tracked.row, before[tracked.row], step)
                if place == 0:
                    so_far = opened[tracked.row]
                    spread = (so_far[0] + part[0], so_far[1] + part[1])
                    opened[tracked.row] = _NONE
                    if firsts:
                        counts = _sum(begun[tracked.row], counts)
                        begun[tracked.row] = self.start.begun[tracked.row]
                if letter == goes_on:
                    opened[tracked.row] = spread
                    if firsts:
                        begun[tracked.row] = counts
                number = tracked.symbol.get(letter)
                if number is None:
                    continue
                least, most = symbols[number]
                known = (max(least, spread[0]), most if letter == goes_on else min(most, spread[1]))
                if known[0] > known[1] + tolerance:
                    return None
                if letter != goes_on:
                    symbols[number] = known
                    if firsts and counts is not None:
                        strain = max(strain, self._strain(firsts[number], counts))
                        firsts[number] = firsts[number] or counts
        after = Widths(tuple(symbols), tuple(opened), tuple(firsts), tuple(begun))
        reaches = not self.bounded or all(
            self._reaches(tracked, column, after, span) for tracked in self.rows if tracked.apart
        )
        return (after, strain) if reaches else None

    def _counts(self, symbols: Sequence[str]) -> tuple[int, ...]:
        counts = [0] * len(self.units)
        for symbol in symbols:
            counts[self.place[symbol]] += 1
        return tuple(counts)

    def _whole(self, before: Sequence[int], column: Sequence[RowStep]) -> Counts:
        """What a column is exactly as wide as: its widest element whose letters all have sizes."""
        gaps = self.problem.gaps
        fixed = [
            (step.size, -at)
            for at, step in enumerate(column)
            if step.fixed and step.kind != EMPTY and not (gaps and step.kind == PARTIAL)
        ]
        if not fixed:
            return None
        at = -max(fixed)[1]
        word = self.problem.rows[at].word
        return self._counts([letter.symbol for letter in word[(before[at] + 1) // 2 : (column[at].state + 1) // 2]])

    def _rest(self, whole: Counts, row: int, before: int, step: RowStep) -> Counts:
        """What the only letter without a width of its own in an element is as wide as, in a column of this width."""
        gapped = self.problem.gaps and step.kind == PARTIAL
        if whole is None or gapped or len(step.loose) > 1:
            return None
        word = self.problem.rows[row].word
        own = [word[at].symbol for at in range((before + 1) // 2, (step.state + 1) // 2) if at not in step.loose]
        return tuple(one - other for one, other in zip(whole, self._counts(own), strict=True)) if own else whole

    def _strain(self, one: Counts, other: tuple[int, ...]) -> int:
        """What it costs at least that two widths become one; see `Strains`."""
        if one is None or one == other:
            return 0
        more = [first - second for first, second in zip(one, other, strict=True)]
        gap = sum(times * unit for times, unit in zip(more, self.units, strict=True))
        return int(self.problem.prices.strain * gap**2 / sum(times**2 for times in more))

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


def _sum(one: Counts, other: Counts) -> Counts:
    if one is None or other is None:
        return None
    return tuple(first + second for first, second in zip(one, other, strict=True))


def _strict(row: AlignedRow, tracked: dict[int, int]) -> tuple[bool, ...]:
    strict = [not may_be_empty(row.word, len(row.word))]
    for at in range(len(row.word) - 1, -1, -1):
        inside = strict[-1] and (row.word[at].size is not None or at in tracked)
        strict += [inside, inside and not may_be_empty(row.word, at)]
    return tuple(reversed(strict))


def _apart(row: AlignedRow) -> bool:
    runs = [list(run) for _, run in groupby(row.word, key=lambda letter: letter.transparent)]
    return all(sum(letter.transparent or letter.size is None for letter in run) <= 1 for run in runs)
