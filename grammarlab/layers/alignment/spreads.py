"""Widths of letters without a fixed width: bounds on the length that each covers in the columns.

Letters of one symbol get one size in the end. So the spreads of a symbol's unsized or split letters may differ by at
most the tolerance, and from its preferred size, if it has one, by no more. If two of them share an element, each may
have any part of it: a spread is an interval. If a letter is exactly as wide as known letters of other rows, the sizes
of these have to change so that letters of one symbol are equal, and this change has a cost.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

from grammarlab.layers.alignment.pairs import PairProblem
from grammarlab.layers.alignment.rows import EMPTY, PARTIAL, AlignedRow, RowStep, may_be_empty

Interval = tuple[int, int]
"""Lower and upper bound, units."""
_ANY: Interval = (0, 1 << 62)
_NONE: Interval = (0, 0)
Counts = tuple[int, ...] | None
"""Number of letters of each sized symbol that together are exactly as wide as a letter; None if unknown."""


class Widths(NamedTuple):
    """Known bounds of letters without a fixed width, after some columns."""

    symbols: tuple[Interval, ...]
    """For each symbol, the largest lower bound and the smallest upper bound of its letters."""
    opened: tuple[Interval, ...]
    """For each row, bounds of the letter that continues in the next column."""
    firsts: tuple[Counts, ...] = ()
    """For each symbol, the counts of its first letter; empty if strains have no weight."""
    begun: tuple[Counts, ...] = ()
    """For each row, the counts of the letter that continues."""


@dataclass(frozen=True)
class Tracked:
    """A row whose letters share symbols with others."""

    row: int
    symbol: dict[int, int]
    """Symbol of each letter, by index of the letter."""
    strict: tuple[bool, ...]
    """[2n + 1] whether every letter after a state has a size or is tracked, and none can leave a gap."""
    apart: bool
    """Whether no two letters without a fixed width can share an element."""


class Spreads:
    """Symbols of a problem to track, and the rows in which they occur."""

    def __init__(self, problem: PairProblem) -> None:
        self.problem = problem
        letters = [letter for row in problem.rows for letter in row.word]
        occurrences = Counter(letter.symbol for letter in letters if letter.size is None)
        sized = {letter.symbol for letter in letters if letter.size is not None and letter.transparent}
        symbols = sorted({*sized, *(symbol for symbol, times in occurrences.items() if times > 1)})
        number = {symbol: index for index, symbol in enumerate(symbols)}
        start = [_ANY] * len(symbols)
        self.rows: list[Tracked] = []
        for index, row in enumerate(problem.rows):
            symbol_of_letter: dict[int, int] = {}
            for position, letter in enumerate(row.word):
                if letter.symbol in number and (letter.transparent or letter.size is None):
                    symbol_of_letter[position] = number[letter.symbol]
                if letter.symbol in sized and letter.size is not None:
                    start[number[letter.symbol]] = (row.sizes[position], row.sizes[position])
            if symbol_of_letter:
                self.rows.append(Tracked(index, symbol_of_letter, _strict(row, symbol_of_letter), _apart(row)))
        # If a column can take the remaining length, spans do not bound the remaining columns.
        self.bounded = not any(letter.size is None and not letter.transparent for letter in letters)
        self.start = Widths(tuple(start), (_NONE,) * len(problem.rows))
        # Symbols with sizes, for the counts of letters.
        units = {
            letter.symbol: size
            for row in problem.rows
            for letter, size in zip(row.word, row.sizes, strict=True)
            if letter.size is not None
        }
        self.units, self.unit_index = tuple(units.values()), {symbol: index for index, symbol in enumerate(units)}
        if problem.prices.strain and self.rows:
            firsts = [self._counts([symbol]) if symbol in sized else None for symbol in symbols]
            no_counts = (0,) * len(units)
            self.start = self.start._replace(firsts=tuple(firsts), begun=(no_counts,) * len(problem.rows))

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
        """Bounds after one more column of this width; None if letters of a symbol differ too much.

        The second value is a lower bound of the cost of the size changes that these bounds require, in units of cost.

        Args:
            widths: bounds before the column.
            before: states of the rows before it.
            column: elements of the column.
            high: width of the column, units.
            elastic: whether the column may be wider.
            span: total width of all columns including this one, units.
        """
        tolerance = self.problem.tolerance
        symbols, opened = list(widths.symbols), list(widths.opened)
        firsts, begun, strain = list(widths.firsts), list(widths.begun), 0
        whole = self._whole(before, column) if firsts else None
        for tracked in self.rows:
            step = column[tracked.row]
            share = high - step.size
            part: Interval = (share if len(step.loose) == 1 else 0, _ANY[1] if elastic else share)
            continued = step.state // 2 if step.state % 2 else -1
            for index, letter in enumerate(step.loose):
                spread = part
                counts = self._rest(whole, tracked.row, before[tracked.row], step)
                if index == 0:
                    so_far = opened[tracked.row]
                    spread = (so_far[0] + part[0], so_far[1] + part[1])
                    opened[tracked.row] = _NONE
                    if firsts:
                        counts = _sum(begun[tracked.row], counts)
                        begun[tracked.row] = self.start.begun[tracked.row]
                if letter == continued:
                    opened[tracked.row] = spread
                    if firsts:
                        begun[tracked.row] = counts
                number = tracked.symbol.get(letter)
                if number is None:
                    continue
                least, most = symbols[number]
                bounds = (max(least, spread[0]), most if letter == continued else min(most, spread[1]))
                if bounds[0] > bounds[1] + tolerance:
                    return None
                if letter != continued:
                    symbols[number] = bounds
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
            counts[self.unit_index[symbol]] += 1
        return tuple(counts)

    def _whole(self, before: Sequence[int], column: Sequence[RowStep]) -> Counts:
        """Counts that are exactly as wide as a column: those of its widest element whose letters all have sizes."""
        gaps = self.problem.gaps
        fixed = [
            (step.size, -row)
            for row, step in enumerate(column)
            if step.fixed and step.kind != EMPTY and not (gaps and step.kind == PARTIAL)
        ]
        if not fixed:
            return None
        row = -max(fixed)[1]
        word = self.problem.rows[row].word
        return self._counts([letter.symbol for letter in word[(before[row] + 1) // 2 : (column[row].state + 1) // 2]])

    def _rest(self, whole: Counts, row: int, before: int, step: RowStep) -> Counts:
        """Counts of the only letter without a fixed width in an element, in a column of this width."""
        gapped = self.problem.gaps and step.kind == PARTIAL
        if whole is None or gapped or len(step.loose) > 1:
            return None
        word = self.problem.rows[row].word
        sized = [
            word[index].symbol for index in range((before + 1) // 2, (step.state + 1) // 2) if index not in step.loose
        ]
        return tuple(one - other for one, other in zip(whole, self._counts(sized), strict=True)) if sized else whole

    def _strain(self, one: Counts, other: tuple[int, ...]) -> int:
        """Lower bound of the cost of making two widths equal; see `Strains`."""
        if one is None or one == other:
            return 0
        more = [first - second for first, second in zip(one, other, strict=True)]
        gap = sum(times * unit for times, unit in zip(more, self.units, strict=True))
        return int(self.problem.prices.strain * gap**2 / sum(times**2 for times in more))

    def _reaches(self, tracked: Tracked, column: Sequence[RowStep], widths: Widths, span: int) -> bool:
        """Whether the remainder of a row can be as long as the remaining canvas."""
        row, state = self.problem.rows[tracked.row], column[tracked.row].state
        tolerance = self.problem.tolerance
        least, most = row.remaining[state], 0
        for index in range(state // 2, len(row.word)):
            number = tracked.symbol.get(index)
            if number is None:
                most += row.sizes[index] + tolerance
                continue
            low, high = widths.symbols[number]
            covered = widths.opened[tracked.row] if state % 2 and index == state // 2 else _NONE
            least += max(low - tolerance - covered[1], 0)
            most += max(high, row.sizes[index]) + tolerance - covered[0]
        if span + least > self.problem.most:
            return False
        return not tracked.strict[state] or span + most >= self.problem.least


def _sum(one: Counts, other: Counts) -> Counts:
    if one is None or other is None:
        return None
    return tuple(first + second for first, second in zip(one, other, strict=True))


def _strict(row: AlignedRow, tracked: dict[int, int]) -> tuple[bool, ...]:
    strict = [not may_be_empty(row.word, len(row.word))]
    for index in range(len(row.word) - 1, -1, -1):
        inside = strict[-1] and (row.word[index].size is not None or index in tracked)
        strict += [inside, inside and not may_be_empty(row.word, index)]
    return tuple(reversed(strict))


def _apart(row: AlignedRow) -> bool:
    runs = [list(run) for _, run in groupby(row.word, key=lambda letter: letter.transparent)]
    return all(sum(letter.transparent or letter.size is None for letter in run) <= 1 for run in runs)
