"""Exact search for the cheapest alignments: A* over the states of all rows, within growing limits.

Paths that cost more than a limit are cut off by the bounds of `pairs.py`; while no path is found, the limit grows. So
the first path found is the cheapest, and a tight limit keeps the bounds cheap, since only nearby states are visited.
The used length of the canvas is part of the state. Of two paths to the same state, the one that used less and costs
less is kept.

If words are too long for an exact search, all words follow the longest one. For each number of letters per column, it
is cut into columns. Each other word is fitted to these columns independently, by dynamic programming. Whether the
result is an alignment is checked afterwards.
"""

from __future__ import annotations

import heapq
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from operator import itemgetter
from typing import NamedTuple

from grammarlab.layers.alignment.pairs import Bounds, PairProblem, Strains
from grammarlab.layers.alignment.rows import EMPTY, OPAQUE, PARTIAL, START, TRANSPARENT, AlignedRow, Column, RowStep
from grammarlab.layers.alignment.spreads import Spreads, Widths

Path = tuple[tuple[RowStep, ...], ...]
"""[n][m] elements of columns."""
_MAX_ROWS_OF_ALL_PAIRS = 6
"""Largest number of rows for which all pairs are bounded; with more rows, only pairs with the longest row are."""
_FIRST_LIMIT_DIVISOR = 1000
"""Inverse of the largest error within the first limit, as a fraction of the canvas."""
_GROWTH = 2
"""Growth factor of the limit."""


@dataclass(frozen=True, slots=True)
class SearchResult:
    """Result of a search."""

    paths: tuple[tuple[int, Path], ...]
    """Costs and paths, the cheapest first."""
    bound: int
    """Lower bound of the cost of paths that are not in `paths`."""
    done: bool
    """Whether `paths` has all paths, or the requested number."""
    guessed: tuple[tuple[int, Path], ...] = ()
    """A path found without search, if effort ran out before the first result; it may not be the cheapest."""
    steps: int = 0
    """Number of visited steps."""


def search(problem: PairProblem, count: int, effort: int, cutoff: int) -> SearchResult:
    """The `count` cheapest paths through the rows that cost at most `cutoff`."""
    prices, rows = problem.prices, problem.rows
    if any(row.remaining[0] > problem.most for row in rows):
        return SearchResult((), 0, done=True)
    if count == 1 and len(rows) == 1 and all(letter.hides for letter in rows[0].word):
        return _alone(problem, rows[0])
    letters = sum(len(row.layers) * len(row.word) for row in rows)
    ceiling = min(prices.error * sum(sum(row.sizes) for row in rows) + 2 * prices.merge * letters, cutoff)
    first_limit = prices.error * problem.most // _FIRST_LIMIT_DIVISOR
    limit = min(first_limit + 3 * prices.merge * max(len(row.layers) for row in rows), ceiling)
    trackers = Spreads(problem), Strains(problem) if prices.strain else None
    # The same steps of words are read in every search.
    num_visited, bound, paths = letters, 0, ()
    while True:
        tree = _Tree(problem, limit, count, effort - num_visited, trackers)
        result = tree.run()
        num_visited += tree.num_visited
        bound, paths = max(result.bound, bound), max(result.paths, paths, key=len)
        if result.done and (len(result.paths) == count or limit == ceiling):
            return SearchResult(paths, bound, done=True, steps=num_visited)
        if not result.done or num_visited >= effort:
            guessed = () if paths else _guess(problem, ceiling)
            num_visited += 0 if paths else letters * max(len(row.word) for row in rows)
            return SearchResult(paths, bound, done=False, guessed=guessed, steps=num_visited)
        limit = min(limit * _GROWTH, ceiling)


def _alone(problem: PairProblem, row: AlignedRow) -> SearchResult:
    """One word that hides all layers below: each of its letters is a column without cost."""
    if row.remaining[0] < problem.least and all(row.sizes):
        return SearchResult((), 0, done=True)
    path = tuple(
        (RowStep(size, 2 * index + 2, OPAQUE, letter.unoccludable, 0, () if size else (index,)),)
        for index, (letter, size) in enumerate(zip(row.word, row.sizes, strict=True))
    )
    return SearchResult(((0, path),), 0, done=True)


class _Tree:
    """One search of paths that cost at most a limit."""

    def __init__(
        self, problem: PairProblem, limit: int, count: int, effort: int, trackers: tuple[Spreads, Strains | None]
    ) -> None:
        self.problem, self.limit, self.count, self.effort = problem, limit, count, effort
        self.rows, self.prices = problem.rows, problem.prices
        self.num = len(self.rows)
        self.num_visited = self.number = 0
        self.spreads, self.strains = trackers
        self.over = [
            sum(1 << above for above in range(self.num) if problem.over(above, below)) for below in range(self.num)
        ]
        # If some row is wide enough by itself, the least span always holds, and less span is never worse.
        self.wide = any(row.remaining[0] >= problem.least for row in self.rows)
        self.pairs: list[list[tuple[int, Bounds]]] = [[] for _ in self.rows]
        for one, other in self._pairs() if effort > 0 else ():
            if self.num_visited > effort:
                break
            bounds, num_visited = problem.bounds(one, other, limit)
            self.pairs[other].append((one, bounds))
            self.num_visited += num_visited
            if bounds[0].get(0, limit + 1) > limit:
                break

    def _pairs(self) -> Iterator[tuple[int, int]]:
        """Pairs to bound; first those of the longest rows, which most often prove that a limit is too low."""
        lengths = [row.remaining[0] for row in self.rows]
        hub = max(range(self.num), key=lambda index: (self.rows[index].remaining[0] > 0, len(self.rows[index].word)))
        pairs = [
            (one, other)
            for one, other in combinations(range(self.num), 2)
            if self.num <= _MAX_ROWS_OF_ALL_PAIRS or hub in (one, other)
        ]
        return iter(sorted(pairs, key=lambda pair: -min(lengths[pair[0]], lengths[pair[1]])))

    def run(self) -> SearchResult:
        start = tuple(0 for _ in self.rows)
        root = self._rest(start)
        if root is None:
            return SearchResult((), self.limit + 1, done=True)
        end = tuple(row.last for row in self.rows)
        heap = [self._first(root)]
        closed: dict[tuple[tuple[int, ...], bool, Widths], list[tuple[int, int, int]]] = {}
        paths: list[tuple[int, Path]] = []
        while heap:
            node = heapq.heappop(heap)
            if self.num_visited > self.effort:
                return SearchResult(tuple(paths), node.lower_bound, done=False)
            if node.states == end:
                if node.column and self._fills(node):
                    paths.append((node.cost, _path(node)))
                    if len(paths) == self.count:
                        return SearchResult(tuple(paths), node.cost, done=True)
                continue
            if self._dominated(closed.setdefault((node.states, node.elastic, node.widths), []), node):
                continue
            for child in self._children(node):
                heapq.heappush(heap, child)
            if self.num_visited > self.effort:  # some columns may be missing
                return SearchResult(tuple(paths), node.lower_bound, done=False)
        return SearchResult(tuple(paths), self.limit + 1, done=True)

    def _first(self, lower_bound: int) -> _Node:
        """The state before all columns."""
        start = tuple(0 for _ in self.rows)
        return _Node(
            lower_bound=lower_bound,
            ahead=0,
            number=0,
            cost=0,
            span=0,
            states=start,
            elastic=False,
            widths=self.spreads.start,
            strain=0,
            before=None,
            column=(),
        )

    def price(self, path: Path) -> int | None:
        """Cost of a path; None if it is not an alignment or costs more than the limit."""
        node = self._first(0)
        for steps in path:
            column = START
            for row, step in enumerate(steps):
                wider = self._with(column, step, row)
                if wider is None or self._error(wider) > self.problem.tolerance:
                    return None
                column = wider
            states = tuple(step.state for step in steps)
            if not (column.opaque and (column.fixed or column.low < 0)):
                return None
            after = self._after(node, column, states, 0)
            if after is None:
                return None
            node = after
        fills = self._fills(node) and node.span <= self.problem.most
        return node.cost if fills else None

    def _children(self, node: _Node) -> Iterator[_Node]:
        """States after each possible next column."""
        for column, states, least in self._columns(node):
            self.num_visited += 1
            after = self._after(node, column, states, least)
            if after is not None:
                yield after

    def _after(self, node: _Node, column: Column, states: tuple[int, ...], least: int) -> _Node | None:
        """The state after a column; None if letters of a symbol differ too much, or the cost exceeds the limit."""
        widths, span, strain = node.widths, node.span + column.high, node.strain
        if self.spreads.rows:
            after = self.spreads.after(
                widths, node.states, column.steps, column.high, elastic=not column.fixed, span=span
            )
            if after is None:
                return None
            widths, least_strain = after
            strain = max(strain, least_strain)
        if self.strains is not None:
            strain = max(self.strains.least_cost(node.states, column.steps), strain)
        more = strain - node.strain
        cost = node.cost + column.price + self.prices.error * self._error(column) + more
        if max(least + more, cost) > self.limit:
            return None
        self.number += 1
        return _Node(
            lower_bound=least + more,
            ahead=-sum(states),
            number=self.number,
            cost=cost,
            span=span,
            states=states,
            elastic=node.elastic or not column.fixed,
            widths=widths,
            strain=strain,
            before=node,
            column=column.steps,
        )

    def _dominated(self, reached: list[tuple[int, int, int]], node: _Node) -> bool:
        """Whether `count` paths reached this state that dominate this node; if not, the node is recorded."""
        span_is_free = self.wide or node.elastic
        paid = node.cost - node.strain
        better = sum(
            cost <= paid and strain <= node.strain and (span <= node.span if span_is_free else span == node.span)
            for cost, strain, span in reached
        )
        if better >= self.count:
            return True
        reached.append((paid, node.strain, node.span))
        return False

    def _fills(self, node: _Node) -> bool:
        return node.elastic or node.span >= self.problem.least

    def _rest(self, states: tuple[int, ...]) -> int | None:
        """Lower bound of the remaining cost; None if it exceeds the limit."""
        most = 0
        for row in range(self.num):
            rest = self._rest_of(row, states)
            if rest is None:
                return None
            most = max(most, rest)
        return most

    def _rest_of(self, row: int, states: tuple[int, ...]) -> int | None:
        """Lower bound of the remaining cost by the pairs of a row with those above it."""
        most = 0
        for other, bounds in self.pairs[row]:
            rest = bounds[states[other]].get(states[row])
            if rest is None:
                return None
            most = max(most, rest)
        return most

    def _error(self, column: Column) -> int:
        return column.high - column.low if column.low >= 0 else 0

    def _columns(self, node: _Node) -> Iterator[tuple[Column, tuple[int, ...], int]]:
        """All possible next columns, with the states after them and a lower bound of the total cost."""
        yield from self._more(node, START, (), 0, 0)

    def _more(
        self, node: _Node, column: Column, states: tuple[int, ...], rest: int, least_remaining: int
    ) -> Iterator[tuple[Column, tuple[int, ...], int]]:
        row = len(states)
        if row == self.num:
            if column.opaque and (column.fixed or column.low < 0):
                if self.problem.finest and column.price and self._is_coarse(node.states, column.steps):
                    return
                lower_bound = node.cost + column.price + self.prices.error * self._error(column) + rest
                yield column, states, max(lower_bound, node.lower_bound)
            return
        max_width = self.problem.most - node.span
        for step in self._steps(node, column, row):
            self.num_visited += 1
            if self.num_visited > self.effort:
                return
            wider = self._with(column, step, row)
            new_remaining = max(least_remaining, self.rows[row].remaining[step.state])
            if wider is None or wider.high + new_remaining > max_width or self._error(wider) > self.problem.tolerance:
                continue
            after = (*states, step.state)
            row_rest = self._rest_of(row, after)
            if row_rest is None:
                continue
            new_rest = max(rest, row_rest)
            if node.cost + wider.price + self.prices.error * self._error(wider) + new_rest <= self.limit:
                yield from self._more(node, wider, after, new_rest, new_remaining)

    def _is_coarse(self, states: Sequence[int], steps: Sequence[RowStep]) -> bool:
        """Whether a column can be cut between its letters: all elements with visible letters are the same."""
        contents: set[tuple[str, ...]] = set()
        for row, before, step in zip(self.rows, states, steps, strict=True):
            if step.kind == OPAQUE and step.fixed:
                letters = row.word[(before + 1) // 2 : (step.state + 1) // 2]
                contents.add(tuple(letter.symbol for letter in letters))
            elif step.kind != EMPTY and (step.kind != TRANSPARENT or step.merged or len(step.loose) != 1):
                return False
        return len(contents) == 1

    def _steps(self, node: _Node, column: Column, row: int) -> Iterator[RowStep]:
        """Elements of a row whose error is within the limit."""
        steps = self.rows[row].steps(node.states[row])
        if steps.empty is not None:
            yield steps.empty
        max_merged = (self.limit - node.cost - column.price) // (self.prices.merge * len(self.rows[row].layers))
        first, last, last_elastic = 0, bisect_right(steps.fixed_merged, max_merged), len(steps.elastic)
        if column.low >= 0:
            widest = self.problem.tolerance
            if self.prices.error:
                widest = min(widest, (self.limit - node.cost - column.price) // self.prices.error)
            first = bisect_left(steps.fixed_sizes, column.high - widest)
            last = min(bisect_right(steps.fixed_sizes, column.low + widest), last)
            last_elastic = bisect_right(steps.elastic_sizes, column.low + widest)
        yield from steps.fixed[first:last]
        yield from steps.elastic[:last_elastic]

    def _with(self, column: Column, step: RowStep, row: int) -> Column | None:
        """A column with one more element; None if that is not allowed."""
        low, bit = column.low, 1 << row
        if step.kind == EMPTY:
            if not column.opaque:
                low = 0
            return column._replace(steps=(*column.steps, step), low=low)
        if step.kind == PARTIAL and column.protected & bit:
            return None
        if step.protected and column.partial & self.over[row]:
            return None
        if step.fixed:
            low = step.size if low < 0 else min(low, step.size)
        return Column(
            steps=(*column.steps, step),
            low=low,
            high=max(column.high, step.size),
            fixed=column.fixed or step.fixed,
            opaque=column.opaque or step.kind == OPAQUE,
            partial=column.partial | (bit if step.kind == PARTIAL else 0),
            protected=column.protected | (self.over[row] if step.protected else 0),
            price=column.price + self.prices.merge * len(self.rows[row].layers) * step.merged,
        )


def _path(node: _Node) -> Path:
    columns = []
    current: _Node | None = node
    while current is not None and current.before is not None:
        columns.append(current.column)
        current = current.before
    return tuple(reversed(columns))


class _Node(NamedTuple):
    """A state of all rows."""

    lower_bound: int
    """Lower bound of the cost of the cheapest path through it."""
    ahead: int
    """Order of nodes with the same bound: smaller is nearer to the end."""
    number: int
    cost: int
    span: int
    states: tuple[int, ...]
    elastic: bool
    """Whether a column takes the remaining length."""
    widths: Widths
    strain: int
    """Lower bound of the cost of size changes, for the worst column only; part of `cost`."""
    before: _Node | None
    column: tuple[RowStep, ...]


def _guess(problem: PairProblem, ceiling: int) -> tuple[tuple[int, Path], ...]:
    """The cheapest valid one of the rough alignments."""
    tree = _Tree(problem, ceiling, 1, 0, (Spreads(problem), Strains(problem) if problem.prices.strain else None))
    valid = [(cost, path) for path in _rough_paths(problem) if (cost := tree.price(path)) is not None]
    return tuple(sorted(valid, key=itemgetter(0))[:1])


def _rough_paths(problem: PairProblem) -> Iterator[Path]:
    """Candidate paths with ever wider columns; the rules of columns are not checked."""
    solid = [all(letter.hides for letter in row.word) for row in problem.rows]
    lead = max(range(len(problem.rows)), key=lambda index: (solid[index], len(problem.rows[index].word)))
    row = problem.rows[lead]
    letters = len(row.word)
    for together in dict.fromkeys(-(-letters // num) for num in range(letters, 0, -1)):
        leading = _even_columns(row, together)
        if leading is None:
            continue
        widths = [step.size for step in leading]
        paths = [
            leading if index == lead else _fitted(problem, follower, widths)
            for index, follower in enumerate(problem.rows)
        ]
        if all(path is not None for path in paths):
            yield tuple(zip(*(path for path in paths if path is not None), strict=True))


def _even_columns(row: AlignedRow, together: int) -> list[RowStep] | None:
    """A row with the given number of letters per element; None if these letters cannot share an element."""
    elements: list[RowStep] = []
    state = 0
    while state < row.last:
        target_state = min(state + 2 * together, row.last)
        steps = row.steps(state)
        step = next(
            (candidate for candidate in (*steps.fixed, *steps.elastic) if candidate.state == target_state), None
        )
        if step is None:
            return None
        elements.append(step)
        state = target_state
    return elements


def _fitted(problem: PairProblem, row: AlignedRow, widths: Sequence[int]) -> list[RowStep] | None:
    """The elements of a row that fit columns best; None if none fit."""
    best: dict[int, tuple[int, tuple[RowStep, ...]]] = {0: (0, ())}
    for width in widths:
        after: dict[int, tuple[int, tuple[RowStep, ...]]] = {}
        for state, (cost, path) in best.items():
            steps = row.steps(state)
            for step in (*((steps.empty,) if steps.empty else ()), *steps.fixed, *steps.elastic):
                error = _width_error(step, width)
                if error > problem.tolerance:
                    continue
                # Squares spread the error over columns: a single large error may exceed the tolerance.
                total = cost + problem.prices.error * error**2 // problem.most + problem.prices.merge * step.merged
                if step.state not in after or total < after[step.state][0]:
                    after[step.state] = total, (*path, step)
        best = after
    return list(best[row.last][1]) if row.last in best else None


def _width_error(step: RowStep, width: int) -> int:
    """Difference of the widths of an element and a column, units."""
    if step.kind == EMPTY or step.fixed:
        return abs(width - step.size)
    return max(step.size - width, 0)
