"""Strips of one axis as the shortest patterns with shared loops.

Cuts common to all strips divide them into blocks. Repeated runs of blocks become loops with one counter in every
strip: at any size the strips are equally long, and cells that are side by side stay so.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property

from grammarlab.layers.patterns import Linear
from grammarlab.layers.strip_words import Key, Strip, StripAssignment, Strips, air_cuts, build

_ONE = Linear(1, ())
_MIN_GAIN = 2.0
"""Gain in repeated length of the axis that justifies taking a strip apart; strips that repeat together stay in step."""
_MOST_STRIPS = 12
"""Largest number of strips that are tried together; of more, only equal cells are shared."""


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


@dataclass(frozen=True, slots=True)
class Item:
    """Letters of a pattern, and their number of copies."""

    keys: tuple[Key, ...]
    count: Linear = _ONE


@dataclass(frozen=True, eq=False)
class StripPatterns:
    """The strips of an axis as patterns."""

    strips: Strips
    items: tuple[tuple[Item, ...], ...]
    """Items of each strip."""
    unsized: frozenset[Key]
    """Letters that take the remaining length: those of a separate strip that span the loops of others."""


def patterns_of(assignment: StripAssignment, counter: str) -> StripPatterns:
    """Patterns with loops over as much of the axis as possible; of these, the shortest.

    A strip whose cells span a repeated part of the others would prevent its repetition. Such a strip is separated, with
    loops and a counter of its own. Strips are tried one after the other.

    Args:
        assignment: strips of an axis.
        counter: name of the counter of all loops; names of others are derived from it.
    """
    num = len(assignment.intervals)
    joined = list(range(num)) if num <= _MOST_STRIPS else list(range(min(num, 1)))
    best = _best(assignment, joined)
    for strip in joined[1:]:
        fewer = [other for other in joined if other != strip]
        division = _best(assignment, fewer)
        if division.covered > _MIN_GAIN * best.covered:
            joined, best = fewer, division
    return best.patterns(counter)


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
    cumulative = [0]
    for price in prices:
        cumulative.append(cumulative[-1] + price)
    same = _matches(word)
    # Cost, letters outside of loops, and the first run of each suffix.
    best: list[tuple[int, int, Run | None]] = [(0, 0, None)] * (num + 1)
    for start in range(num - 1, -1, -1):
        cost, plain, _ = best[start + 1]
        option = (cost + prices[start], plain + 1, Run(start, 1))
        for length in range(1, (num - start) // 2 + 1):
            repeated = 1 + same[length][start] // length
            price = cumulative[start + length] - cumulative[start] + loop
            for times in range(2, repeated + 1):
                cost, plain, _ = best[start + length * times]
                if (cost + price, plain) < option[:2]:
                    option = (cost + price, plain, Run(start, length, times))
        best[start] = option
    runs, start = [], 0
    while (run := best[start][2]) is not None:
        runs.append(run)
        start = run.end
    return tuple(runs)


def cost_of(runs: Sequence[Run], prices: Sequence[int], loop: int = 1) -> int:
    """Cost of runs, see `shortest`."""
    return sum(sum(prices[run.start : run.start + run.length]) + (loop if run.times > 1 else 0) for run in runs)


def _best(assignment: StripAssignment, joined: Sequence[int]) -> _Division:
    """The best division of strips that repeat together."""
    plain = _Division(assignment, (), joined)
    cuts = air_cuts(assignment, joined) if len(joined) > 1 else []
    if not cuts:
        return plain
    finer = _Division(assignment, cuts, joined)
    return min(
        plain, finer, key=lambda division: (-round(division.covered / assignment.lines[-1], 6), division.joint.cost)
    )


class _Division:
    """Strips that repeat together, and strips that repeat separately."""

    def __init__(self, assignment: StripAssignment, cuts: Sequence[int], joined: Sequence[int]) -> None:
        self.strips = strips = build(assignment, joined, cuts)
        self.joined, self.lines = joined, assignment.lines
        self.joint = _Joint([strips.strips[index] for index in joined])
        self.apart = {index: _Joint([strip]) for index, strip in enumerate(strips.strips) if index not in joined}

    @cached_property
    def covered(self) -> float:
        """Length of the axis that repeats in the joint strips, metres."""
        return float(sum(self.lines[high] - self.lines[low] for low, high in self.joint.loops()))

    def patterns(self, counter: str) -> StripPatterns:
        """All patterns, with counters."""
        counts, counters = _counts(self.joint.runs, counter), 1
        items: list[tuple[Item, ...]] = []
        unsized: set[Key] = set()
        for index, strip in enumerate(self.strips.strips):
            if index in self.joined:
                items.append(self.joint.items(self.joined.index(index), counts))
                continue
            separate = self.apart[index]
            counters += bool(separate.loops())
            items.append(separate.items(0, _counts(separate.runs, f"{counter}{counters}")))
            if not separate.loops():
                unsized |= _widest(strip, self.joint, self.strips)
        return StripPatterns(self.strips, tuple(items), frozenset(unsized))


class _Joint:
    """Joint strips, cut at their common lines."""

    def __init__(self, strips: Sequence[Strip]) -> None:
        cuts = [{end for _, end in strip.cells} for strip in strips]
        self.cuts = sorted(set.intersection(*cuts)) if cuts else []
        self.blocks: list[tuple[tuple[Key, ...], ...]] = []
        positions = [0] * len(strips)
        for cut in self.cuts:
            block = []
            for strip_index, strip in enumerate(strips):
                start = positions[strip_index]
                while positions[strip_index] < len(strip.cells) and strip.cells[positions[strip_index]][1] <= cut:
                    positions[strip_index] += 1
                block.append(strip.keys[start : positions[strip_index]])
            self.blocks.append(tuple(block))
        prices = [sum(map(len, block)) for block in self.blocks]
        block_index = {block: index for index, block in enumerate(dict.fromkeys(self.blocks))}
        self.runs = shortest([block_index[block] for block in self.blocks], prices, len(strips))
        self.cost = cost_of(self.runs, prices, len(strips))

    def items(self, strip: int, counts: Sequence[Linear]) -> tuple[Item, ...]:
        """The pattern of a strip."""
        return tuple(
            Item(tuple(key for block in self.blocks[run.start : run.start + run.length] for key in block[strip]), count)
            for run, count in zip(self.runs, counts, strict=True)
        )

    def loops(self) -> list[tuple[int, int]]:
        """Lines between which the strips repeat."""
        starts = [0, *self.cuts]
        return [(starts[run.start], starts[run.end]) for run in self.runs if run.times > 1]


def _matches(word: Sequence[Hashable]) -> list[list[int]]:
    """[shift][start] number of letters from a start that equal those a shift later; for shifts up to n / 2."""
    num = len(word)
    lengths = [[0] * (num + 1)]
    for shift in range(1, num // 2 + 1):
        row = [0] * (num + 1)
        for start in range(num - shift - 1, -1, -1):
            row[start] = row[start + 1] + 1 if word[start] == word[start + shift] else 0
        lengths.append(row)
    return lengths


def _counts(runs: Sequence[Run], counter: str) -> list[Linear]:
    """Number of copies of each run: in proportion to the run with the fewest copies.

    >>> [count.constant for count in _counts([Run(0, 2, 5), Run(10, 1, 2), Run(12, 1)], "k")]
    [1, 0, 1]
    """
    least = min((run.times for run in runs if run.times > 1), default=1)
    return [Linear(run.times % least, ((counter, run.times // least),)) if run.times > 1 else _ONE for run in runs]


def _widest(strip: Strip, joint: _Joint, strips: Strips) -> set[Key]:
    """The letters of the symbol with the largest total length, of those that span a repeated part."""
    length: dict[Key, float] = {}
    for cell, key in zip(strip.cells, strip.keys, strict=True):
        if cell in strip.visible and any(cell[0] < high and low < cell[1] for low, high in joint.loops()):
            length[key] = length.get(key, 0.0) + float(strips.sizes[key[1]])
    return {max(length, key=lambda key: length[key])} if length else set()
