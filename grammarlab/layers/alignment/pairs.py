"""Lower bounds on the cost of aligning the remainders of two rows, for any other rows (dynamic programming).

Lower bounds on the change of symbol sizes that makes the elements of one column equally wide.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from grammarlab.layers.alignment.rows import EMPTY, OPAQUE, PARTIAL, AlignedRow, RowStep

Bounds = list[dict[int, int]]
"""[state of one row][state of the other] lower bound of the remaining cost; missing entries exceed the limit."""


@dataclass(frozen=True, slots=True)
class Prices:
    """Integer prices of an alignment's parts."""

    error: int
    """Price of a unit of length."""
    merge: int
    """Price of a merged letter, >= 1: the finer of two equally good alignments is better."""
    strain: float = 0.0
    """Price of a square unit of change of sizes."""


@dataclass(frozen=True, slots=True)
class PairProblem:
    """Rows to align."""

    rows: Sequence[AlignedRow]
    """The m different rows, in the order of their topmost layers."""
    prices: Prices
    least: int
    """Least sum of the widths of columns, units."""
    most: int
    """Largest sum of the widths of columns, units."""
    tolerance: int
    """Largest error of a column, units."""
    gaps: bool = False
    """Whether elements with letters that are not opaque may be narrower than their column."""
    finest: bool = False
    """Whether to leave out a column that two cheaper columns with the same look can replace."""
    _bounds: dict[tuple[int, int], tuple[int, Bounds]] = field(default_factory=dict)
    """Bounds of pairs, each for its largest limit so far."""

    def bounds(self, one: int, other: int, limit: int) -> tuple[Bounds, int]:
        """`pair_bounds` of this limit or of a larger one that was computed before."""
        known = self._bounds.get((one, other))
        if known is not None and known[0] >= limit:
            return known[1], 0
        found, looked = pair_bounds(self, one, other, limit)
        self._bounds[one, other] = limit, found
        return found, looked

    def over(self, above: int, below: int) -> bool:
        """Whether a layer of one row is above a layer of another one."""
        return above != below and self.rows[above].layers[0] < self.rows[below].layers[-1]

    def slack(self, row: int) -> int:
        """Units of columns in which a row can be empty."""
        return self.most - self.rows[row].left[0]


def pair_bounds(problem: PairProblem, one: int, other: int, limit: int) -> tuple[Bounds, int]:
    """Bounds for two rows, one < other, on paths up to a limit, and the number of visited pairs of steps."""
    pair = _Pair(problem, one, other)
    first, second = pair.first, pair.second
    paid: list[dict[int, int]] = [{} for _ in range(first.last + 1)]
    paid[0][0] = 0
    moves: list[dict[int, list[tuple[int, int, int]]]] = [{} for _ in range(first.last + 1)]
    looked = 0
    for at in range(first.last + 1):
        here = paid[at]
        for to in range(second.last + 1):
            so_far = here.get(to)
            if so_far is None:
                continue
            made = moves[at][to] = list(pair.moves(at, to, limit - so_far))
            looked += len(made) + 1
            for cost, next_at, next_to in made:
                ahead = paid[next_at]
                if ahead.get(next_to, limit + 1) > so_far + cost:
                    ahead[next_to] = so_far + cost
    bounds: Bounds = [{} for _ in range(first.last + 1)]
    bounds[first.last][second.last] = 0
    for at in range(first.last, -1, -1):
        here = bounds[at]
        for to in sorted(moves[at], reverse=True):
            best = here.get(to, limit + 1)
            for cost, next_at, next_to in moves[at][to]:
                best = min(best, cost + bounds[next_at].get(next_to, limit + 1))
            if best + paid[at][to] <= limit:
                here[to] = best
    return bounds, looked


class _Pair:
    """Two rows of a problem, whose columns are relaxed: any other row may be opaque."""

    def __init__(self, problem: PairProblem, one: int, other: int) -> None:
        self.first, self.second = problem.rows[one], problem.rows[other]
        self.prices, self.tolerance = problem.prices, problem.tolerance
        self.alone = len(problem.rows) == 2
        self.slack = problem.slack(one), problem.slack(other)
        self.over = problem.over(one, other), problem.over(other, one)
        # Other rows may explain gaps of both rows, so that empty elements have any size.
        self.excused = (
            any(row.hides for row in problem.rows[:one]),
            any(row.hides for at, row in enumerate(problem.rows[:other]) if at != one),
        )
        self.counts = len(self.first.layers), len(self.second.layers)

    def moves(self, at: int, to: int, limit: int) -> Iterator[tuple[int, int, int]]:
        """Cost of a column and the states after it, for columns up to a limit."""
        ones, others = self.first.steps(at), self.second.steps(to)
        error, merge = self.prices.error, self.prices.merge
        widest = min(limit // error, self.tolerance) if error else self.tolerance
        fixed_ones = ones.fixed[: bisect_right(ones.fixed_merged, limit // (merge * self.counts[0]))]
        most = bisect_right(others.fixed_merged, limit // (merge * self.counts[1]))
        for one in (*((ones.empty,) if ones.empty else ()), *fixed_ones, *ones.elastic):
            base = merge * self.counts[0] * one.merged
            if base > limit:
                continue
            if others.empty is not None:
                yield from self._priced(one, others.empty, base, limit)
            fixed, elastic = others.fixed[:most], others.elastic
            if one.kind != EMPTY:
                first = bisect_left(others.fixed_sizes, one.size - widest) if one.fixed else 0
                fixed = fixed[first : bisect_right(others.fixed_sizes, one.size + widest)]
                if one.fixed:
                    elastic = elastic[: bisect_right(others.elastic_sizes, one.size + widest)]
            if not one.fixed:
                fixed = others.fixed[:most]
            for other in (*fixed, *elastic):
                yield from self._priced(one, other, base, limit)

    def _priced(self, one: RowStep, other: RowStep, base: int, limit: int) -> Iterator[tuple[int, int, int]]:
        if not self._allowed(one, other):
            return
        error = self._error(one, other)
        cost = base + self.prices.merge * self.counts[1] * other.merged + self.prices.error * error
        if cost <= limit and error <= self.tolerance:
            yield cost, one.state, other.state

    def _allowed(self, one: RowStep, other: RowStep) -> bool:
        if one.kind == EMPTY and (other.kind == EMPTY or other.size > self.slack[0]):
            return False
        if other.kind == EMPTY and one.size > self.slack[1]:
            return False
        if self.alone and OPAQUE not in (one.kind, other.kind):
            return False
        if other.protected and one.kind == PARTIAL and self.over[0]:
            return False
        return not (one.protected and other.kind == PARTIAL and self.over[1])

    def _error(self, one: RowStep, other: RowStep) -> int:
        """Least error of a column with these elements, units."""
        if one.kind == EMPTY:
            return 0 if self.excused[0] else other.size
        if other.kind == EMPTY:
            return 0 if self.excused[1] or one.kind == OPAQUE else one.size
        if one.fixed and other.fixed:
            return abs(one.size - other.size)
        if one.fixed:
            return max(other.size - one.size, 0)
        return max(one.size - other.size, 0) if other.fixed else 0


class Strains:
    """Lower bounds on the error of sizes, column by column."""

    def __init__(self, problem: PairProblem) -> None:
        self.problem = problem
        self.known: dict[tuple[int, int, int, int, int, int], int] = {}

    def of(self, states: Sequence[int], column: Sequence[RowStep]) -> int:
        """Least cost of equal widths of the narrowest and the widest fixed element of a column from these states.

        Sizes with a total difference of d become equal at a cost of at least d^2 / |c|^2, where c is the difference of
        the counts of each symbol.
        """
        fixed = [
            (step.size, at)
            for at, step in enumerate(column)
            if step.fixed and step.kind != EMPTY and not (self.problem.gaps and step.kind == PARTIAL)
        ]
        if len(fixed) < 2:
            return 0
        (low, one), (high, other) = min(fixed), max(fixed)
        if low == high:
            return 0
        key = (one, states[one], column[one].state, other, states[other], column[other].state)
        found = self.known.get(key)
        if found is None:
            often = self._symbols(one, states[one], column[one])
            often.subtract(self._symbols(other, states[other], column[other]))
            square = sum(times**2 for times in often.values())
            found = self.known[key] = int(self.problem.prices.strain * (high - low) ** 2 / square)
        return found

    def _symbols(self, row: int, state: int, step: RowStep) -> Counter[str]:
        word = self.problem.rows[row].word
        return Counter(letter.symbol for letter in word[(state + 1) // 2 : (step.state + 1) // 2])
