"""Lower bounds of the cost of an alignment: for the rest of two rows, and for size changes in one column.

The bounds of two rows, by dynamic programming, hold for any other rows.
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
        """`_pair_bounds` of this limit or of a larger one that was computed before."""
        cached = self._bounds.get((one, other))
        if cached is not None and cached[0] >= limit:
            return cached[1], 0
        result, num_visited = _pair_bounds(self, one, other, limit)
        self._bounds[one, other] = limit, result
        return result, num_visited

    def over(self, above: int, below: int) -> bool:
        """Whether a layer of one row is above a layer of another one."""
        return above != below and self.rows[above].layers[0] < self.rows[below].layers[-1]

    def slack(self, row: int) -> int:
        """Units of columns in which a row can be empty."""
        return self.most - self.rows[row].remaining[0]


class Strains:
    """Lower bounds on the error of sizes, column by column."""

    def __init__(self, problem: PairProblem) -> None:
        self.problem = problem
        self.costs: dict[tuple[int, int, int, int, int, int], int] = {}

    def least_cost(self, states: Sequence[int], column: Sequence[RowStep]) -> int:
        """Least cost of equal widths of the narrowest and the widest fixed element of a column from these states.

        Sizes with a total difference of d become equal at a cost of at least d^2 / |c|^2, where c is the difference of
        the counts of each symbol.
        """
        fixed = [
            (step.size, row)
            for row, step in enumerate(column)
            if step.fixed and step.kind != EMPTY and not (self.problem.gaps and step.kind == PARTIAL)
        ]
        if len(fixed) < 2:
            return 0
        (low, narrow), (high, wide) = min(fixed), max(fixed)
        if low == high:
            return 0
        key = (narrow, states[narrow], column[narrow].state, wide, states[wide], column[wide].state)
        cost = self.costs.get(key)
        if cost is None:
            counts = self._symbols(narrow, states[narrow], column[narrow])
            counts.subtract(self._symbols(wide, states[wide], column[wide]))
            square = sum(times**2 for times in counts.values())
            cost = self.costs[key] = int(self.problem.prices.strain * (high - low) ** 2 / square)
        return cost

    def _symbols(self, row: int, state: int, step: RowStep) -> Counter[str]:
        word = self.problem.rows[row].word
        return Counter(letter.symbol for letter in word[(state + 1) // 2 : (step.state + 1) // 2])


def _pair_bounds(problem: PairProblem, one: int, other: int, limit: int) -> tuple[Bounds, int]:
    """Bounds for two rows, one < other, on paths up to a limit, and the number of visited pairs of steps."""
    pair = _Pair(problem, one, other)
    first, second = pair.first, pair.second
    forward_costs: list[dict[int, int]] = [{} for _ in range(first.last + 1)]
    forward_costs[0][0] = 0
    moves: list[dict[int, list[tuple[int, int, int]]]] = [{} for _ in range(first.last + 1)]
    num_visited = 0
    for first_state in range(first.last + 1):
        row_costs = forward_costs[first_state]
        for second_state in range(second.last + 1):
            so_far = row_costs.get(second_state)
            if so_far is None:
                continue
            next_moves = moves[first_state][second_state] = list(pair.moves(first_state, second_state, limit - so_far))
            num_visited += len(next_moves) + 1
            for cost, next_first, next_second in next_moves:
                next_costs = forward_costs[next_first]
                if next_costs.get(next_second, limit + 1) > so_far + cost:
                    next_costs[next_second] = so_far + cost
    bounds: Bounds = [{} for _ in range(first.last + 1)]
    bounds[first.last][second.last] = 0
    for first_state in range(first.last, -1, -1):
        row_costs = bounds[first_state]
        for second_state in sorted(moves[first_state], reverse=True):
            best = row_costs.get(second_state, limit + 1)
            for cost, next_first, next_second in moves[first_state][second_state]:
                best = min(best, cost + bounds[next_first].get(next_second, limit + 1))
            if best + forward_costs[first_state][second_state] <= limit:
                row_costs[second_state] = best
    return bounds, num_visited


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
            any(row.hides for index, row in enumerate(problem.rows[:other]) if index != one),
        )
        self.counts = len(self.first.layers), len(self.second.layers)

    def moves(self, first_state: int, second_state: int, limit: int) -> Iterator[tuple[int, int, int]]:
        """Cost of a column and the states after it, for columns up to a limit."""
        first_steps, second_steps = self.first.steps(first_state), self.second.steps(second_state)
        error, merge = self.prices.error, self.prices.merge
        widest = min(limit // error, self.tolerance) if error else self.tolerance
        fixed_ones = first_steps.fixed[: bisect_right(first_steps.fixed_merged, limit // (merge * self.counts[0]))]
        most = bisect_right(second_steps.fixed_merged, limit // (merge * self.counts[1]))
        for one in (*((first_steps.empty,) if first_steps.empty else ()), *fixed_ones, *first_steps.elastic):
            base = merge * self.counts[0] * one.merged
            if base > limit:
                continue
            if second_steps.empty is not None:
                yield from self._priced(one, second_steps.empty, base, limit)
            fixed, elastic = second_steps.fixed[:most], second_steps.elastic
            if one.kind != EMPTY:
                first = bisect_left(second_steps.fixed_sizes, one.size - widest) if one.fixed else 0
                fixed = fixed[first : bisect_right(second_steps.fixed_sizes, one.size + widest)]
                if one.fixed:
                    elastic = elastic[: bisect_right(second_steps.elastic_sizes, one.size + widest)]
            if not one.fixed:
                fixed = second_steps.fixed[:most]
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
