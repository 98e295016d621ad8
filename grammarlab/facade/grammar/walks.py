"""Sequences of columns and their probabilities: walks through the kinds of a facade's columns.

Columns or rows of one kind look alike. A walk begins with the facade's first column and ends with its last; it only has
transitions that occur in the facade, and its doors are as many and in the same order. All lengths are equally likely;
among walks of one length, the probability grows with the frequencies of the transitions in the facade.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from grammarlab.facade.grammar.bands import SAME_PLACE, Band, bands, repeated_runs
from grammarlab.facade.grammar.contents import Cell, alike, cell_of, nodes_between
from grammarlab.facade.looks import is_door
from grammarlab.facade.tree import Facade, X, Y

_WALL_STRETCH = 1.0 / 3.0
"""Largest relative difference of walls between equal elements."""
LONGEST = 60
"""Largest number of columns of a walk."""


@dataclass(frozen=True, slots=True)
class KindSequence:
    """The bands of a facade along one axis."""

    kind: tuple[int, ...]
    """[B] kind of each band, numbered by first occurrence."""
    size: tuple[float, ...]
    """[K] size of each kind, metres: that of its first band of elements, or the mean of bands of wall."""
    has_elements: tuple[bool, ...]
    """[K] whether it contains elements."""
    doors: tuple[bool, ...]
    """[K] whether it contains doors."""
    ends: tuple[int, ...] = ()
    """Kinds at an end, which never follow themselves."""
    edges: tuple[float, ...] = ()
    """[B + 1] bounds of the bands of a facade, metres; empty for a pattern without a facade."""

    def is_mean(self, kind: int) -> bool:
        """Whether the size of a kind differs from that of its first band, whose contents it has."""
        if not self.edges:
            return False
        first = self.kind.index(kind)
        own = self.edges[first + 1] - self.edges[first]
        return abs(self.size[kind] - own) > SAME_PLACE * (self.edges[-1] - self.edges[0])


@dataclass(frozen=True, slots=True)
class KindPattern:
    """A facade as columns and rows of kinds."""

    columns: KindSequence
    rows: KindSequence
    """Rows from the bottom up."""
    cells: tuple[tuple[Cell, ...], ...]
    """[row kinds][column kinds] content at each crossing."""


class WalkState(NamedTuple):
    """A state of a walk."""

    kind: int
    """Kind of the last column."""
    doors: int
    """Number of door columns so far."""
    columns: int
    """Number of columns so far."""


class WalkStep(NamedTuple):
    """A possible next column."""

    probability: float
    gap: int
    """Kind of the pier before it; -1 for none."""
    to: WalkState


@dataclass(frozen=True, slots=True)
class Walks:
    """All walks within a range of widths."""

    before: int
    """Kind of the pier before the first column; -1 for none."""
    after: int
    """Kind of the pier after the last one; -1 for none."""
    start: WalkState
    steps: dict[WalkState, tuple[WalkStep, ...]]
    """Possible next steps by state; states in the order of walks."""
    end: dict[WalkState, float]
    """Probability that a walk ends in a state."""
    sizes: dict[int, tuple[float, float]]
    """Least and largest width in metres, by number of columns."""
    total: float
    """Number of different walks."""


def walks(columns: KindSequence, low: float, high: float) -> Walks | None:
    """The walks whose width is certainly within a range; None if there are none.

    A column follows itself if it does so in the facade, or if there is no choice otherwise.

    Args:
        columns: columns of the facade.
        low: least width, metres.
        high: largest width, metres.
    """
    result = _walks(columns, _moves(columns), low, high)
    if result is None or result.total == 1.0:
        result = _walks(columns, _with_repeats(columns), low, high)
    return result


def equal_futures(
    found: Walks, doors: tuple[bool, ...], rounded: Callable[[Sequence[float]], Iterable[float | str]]
) -> dict[WalkState, WalkState]:
    """For each state, the first of those from which walks go on in the same ways, also behind later columns.

    A state at a door has no equal without one, so that the place of the door can be seen from its state.

    Args:
        found: the walks.
        doors: [K] whether each kind of columns contains doors.
        rounded: the compared values of the probabilities of the steps from a state, and of the end behind it if walks
            end there.
    """
    signatures: dict[WalkState, int] = {}
    numbers: dict[object, int] = {}
    first_of: dict[int, WalkState] = {}
    for state in reversed(found.steps):  # later states never lead to earlier ones
        steps = found.steps[state]
        ways = tuple((step.gap, step.to.kind, signatures[step.to]) for step in steps)
        probabilities = [step.probability for step in steps] + ([found.end[state]] if state in found.end else [])
        signature = doors[state.kind], ways, tuple(rounded(probabilities))
        signatures[state] = numbers.setdefault(signature, len(numbers))
    for state in found.steps:
        first_of.setdefault(signatures[state], state)
    return {state: first_of[signatures[state]] for state in found.steps}


def narrowest(columns: KindSequence, up_to: float) -> list[float]:
    """Width of the narrowest walk for each number of columns, metres, up to a little above a length; for messages."""
    result = _walks(columns, _with_repeats(columns), 0.0, max(up_to, sum(columns.size[kind] for kind in columns.kind)))
    return [] if result is None else [least for least, _ in result.sizes.values()]


def pattern_of(facade: Facade, stretch: float) -> KindPattern:
    """The pattern of a facade.

    Args:
        facade: the facade.
        stretch: largest relative difference of equal elements.
    """
    across, up = bands(facade, X), bands(facade, Y)
    joined = _joined(across, _column_kinds(across, _cells(facade, across, up), stretch))
    while len(joined) < len(across):
        across = joined
        joined = _joined(across, _column_kinds(across, _cells(facade, across, up), stretch))
    cells = _cells(facade, across, up)
    columns = _column_kinds(across, cells, stretch)
    rows = _kinds(up, stretch, lambda a, b: all(map(alike, cells[a], cells[b], [stretch] * len(across))))
    first_column = [columns.index(kind) for kind in range(max(columns) + 1)]
    first_row = [rows.index(kind) for kind in range(max(rows) + 1)]
    return KindPattern(
        _sequence(columns, across, [[row[index] for row in cells] for index in first_column]),
        _sequence(rows, up, [cells[index] for index in first_row]),
        tuple(tuple(cells[row][column] for column in first_column) for row in first_row),
    )


def _walks(columns: KindSequence, moves: dict[int, Counter[_Move]], low: float, high: float) -> Walks | None:
    standing = [kind for kind in columns.kind if columns.has_elements[kind]]
    if not standing:
        return None
    before, after = (kind if not columns.has_elements[kind] else -1 for kind in (columns.kind[0], columns.kind[-1]))
    fixed = standing[0], *(kind for kind in (before, after) if kind >= 0)
    start = WalkState(standing[0], int(columns.doors[standing[0]]), 1)
    following = _following(moves, [kind for kind in standing if columns.doors[kind]], columns.doors)
    slack = 1e-9 * max(high, 1.0)
    first, limit = sum(columns.size[kind] for kind in fixed), high + slack
    reached = _reached(start, following, first, limit)
    goal = standing[-1], sum(columns.doors[kind] for kind in standing)
    fits = {
        state: reach
        for state, reach in reached.items()
        if (state.kind, state.doors) == goal and low - slack <= reach.least and reach.most <= limit
    }
    if not fits:
        return None

    def going_on(state: WalkState) -> list[tuple[_Move, int, WalkState]]:
        return [step for step in following(state) if reached[state].least + step[0].length <= limit]

    future: dict[WalkState, float] = {}
    for state in reversed(reached):  # later states never lead to earlier ones
        ends = 1.0 / fits[state].weight if state in fits else 0.0
        future[state] = ends + sum(frequency * future.get(to, 0.0) for _, frequency, to in going_on(state))
    steps = {
        state: tuple(
            WalkStep(frequency * future[to] / future[state], move.gap, to)
            for move, frequency, to in going_on(state)
            if future.get(to, 0.0) > 0.0
        )
        for state in reached
        if future[state] > 0.0
    }
    end = {state: 1.0 / (reach.weight * future[state]) for state, reach in fits.items()}
    sizes = {state.columns: (reach.least, reach.most) for state, reach in fits.items()}
    return Walks(
        before=before,
        after=after,
        start=start,
        steps=steps,
        end=end,
        sizes=sizes,
        total=sum(reach.walks for reach in fits.values()),
    )


class _Move(NamedTuple):
    """A transition between kinds of columns."""

    gap: int
    kind: int
    length: float
    """Width of pier and column, metres."""


_Following = Callable[[WalkState], Iterator[tuple[_Move, int, WalkState]]]


def _following(moves: dict[int, Counter[_Move]], doors: list[int], is_door: tuple[bool, ...]) -> _Following:
    """The transitions from a state, their frequencies in the facade and the next states: doors are in order."""

    def following(state: WalkState) -> Iterator[tuple[_Move, int, WalkState]]:
        for move, frequency in moves[state.kind].items():
            if not is_door[move.kind]:
                yield move, frequency, WalkState(move.kind, state.doors, state.columns + 1)
            elif doors[state.doors : state.doors + 1] == [move.kind]:
                yield move, frequency, WalkState(move.kind, state.doors + 1, state.columns + 1)

    return following


def _reached(start: WalkState, following: _Following, first: float, high: float) -> dict[WalkState, _Reach]:
    """The states of walks of at most this width, those with fewer columns first."""
    reached = layer = {start: _Reach(first, first, 1.0, 1.0)}
    for _ in range(LONGEST):
        after: dict[WalkState, _Reach] = {}
        for state, reach in layer.items():
            for move, frequency, to in following(state):
                least, most = reach.least + move.length, reach.most + move.length
                if least > high:
                    continue
                reach_before = after.get(to, _Reach(least, most, 0.0, 0.0))
                after[to] = _Reach(
                    min(reach_before.least, least),
                    max(reach_before.most, most),
                    reach_before.weight + frequency * reach.weight,
                    reach_before.walks + reach.walks,
                )
        if not after:
            break
        reached, layer = reached | after, after
    return reached


class _Reach(NamedTuple):
    """The walks from the first column to a state."""

    least: float
    """Width of the narrowest one, metres."""
    most: float
    weight: float
    """Sum over walks of the products of their transitions' frequencies in the facade."""
    walks: float


def _moves(columns: KindSequence) -> dict[int, Counter[_Move]]:
    """Frequency of each transition between kinds in the facade, with the pier between them."""
    moves: dict[int, Counter[_Move]] = {kind: Counter() for kind in columns.kind if columns.has_elements[kind]}
    last, gap = -1, -1
    for kind in columns.kind:
        if not columns.has_elements[kind]:
            gap = kind
            continue
        if last >= 0:
            moves[last][_move(columns, gap, kind)] += 1
        last, gap = kind, -1
    return moves


def _move(columns: KindSequence, gap: int, kind: int) -> _Move:
    return _Move(gap, kind, columns.size[kind] + (columns.size[gap] if gap >= 0 else 0.0))


def _with_repeats(columns: KindSequence) -> dict[int, Counter[_Move]]:
    """Frequencies of `_moves`, with a transition from every column without a door to itself, except those at an end."""
    moves_of_kind = _moves(columns)
    usual = Counter(move.gap for moves in moves_of_kind.values() for move in moves).most_common(1)
    end = columns.kind[0] if not columns.has_elements[columns.kind[0]] else -1
    gap = usual[0][0] if usual else end
    for kind, moves in moves_of_kind.items():
        if not columns.doors[kind] and kind not in columns.ends:
            moves[_move(columns, next((move.gap for move in moves), gap), kind)] += 1
    return moves_of_kind


def _joined(columns: list[Band], kinds: list[int]) -> list[Band]:
    """The bands, with each repeated group of several columns, such as a bay of windows, merged into one."""
    for run in repeated_runs(kinds):
        if sum(band.has_elements for band in columns[run.start : run.start + run.period]) > 1:
            turns = range(run.start, run.end, run.period)
            bays = [Band(columns[k].start, columns[k + run.period - 1].end, has_elements=True) for k in turns]
            return [*columns[: run.start], *bays, *columns[run.end :]]
    return columns


def _column_kinds(across: list[Band], cells: list[list[Cell]], stretch: float) -> list[int]:
    return _kinds(across, stretch, lambda a, b: all(alike(row[a], row[b], stretch) for row in cells))


def _kinds(pieces: list[Band], stretch: float, is_same: Callable[[int, int], bool]) -> list[int]:
    """[B] the kind of each band. Walls may differ more in size, but each wall at an end has its own kind."""
    kinds: list[int] = []
    first: list[int] = []
    """The first band of each kind."""
    ends = {0, len(pieces) - 1}
    for index, band in enumerate(pieces):
        for earlier in first:
            other = pieces[earlier]
            if band.has_elements != other.has_elements or (
                not band.has_elements and (index in ends or earlier in ends)
            ):
                continue
            differ = stretch if band.has_elements else _WALL_STRETCH
            if abs(band.size - other.size) <= differ * max(band.size, other.size) and is_same(earlier, index):
                kinds.append(kinds[earlier])
                break
        else:
            kinds.append(len(first))
            first.append(index)
    return kinds


def _cells(facade: Facade, across: list[Band], up: list[Band]) -> list[list[Cell]]:
    """[rows][columns] content at each crossing of bands."""
    least = (SAME_PLACE * facade.size[0]).tolist()
    cells = []
    for row in up:
        nodes = nodes_between(facade, Y, row.start, row.end, least[Y])
        corners = [((column.start, row.start), (column.end, row.end)) for column in across]
        cells.append([cell_of(facade, nodes, low, high, least) for low, high in corners])
    return cells


def _sequence(kinds: list[int], pieces: list[Band], cells: list[list[Cell]]) -> KindSequence:
    """The bands as kinds, with the cells of the first of each."""
    size, has_elements = [], []
    for kind in range(max(kinds) + 1):
        those = [band for band, band_kind in zip(pieces, kinds, strict=True) if band_kind == kind]
        has_elements.append(those[0].has_elements)
        size.append(those[0].size if those[0].has_elements else sum(band.size for band in those) / len(those))
    doors = [any(is_door(thing) for cell in column for thing in cell.things()) for column in cells]
    edges = (pieces[0].start, *(band.end for band in pieces))
    return KindSequence(tuple(kinds), tuple(size), tuple(has_elements), tuple(doors), edges=edges)
