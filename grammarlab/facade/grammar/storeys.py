"""Storeys of a family of facades: repeated rows, and their possible numbers of turns."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import floor
from typing import NamedTuple

from grammarlab.errors import FacadeError
from grammarlab.facade.grammar.bands import Repeat, repeated_runs
from grammarlab.facade.grammar.contents import Cell
from grammarlab.facade.grammar.walks import KindSequence
from grammarlab.facade.looks import is_door, look_of

MOST_TIMES = 100
"""Largest number of turns of a run."""
MOST_CHOICES = 400
"""Largest number of combinations of turns."""

_STOREY_SHARE = 0.5
"""Least height of a row that is a storey, as a share of the highest row; lower ones are cornices and friezes."""


class Storeys(NamedTuple):
    """Runs of rows, and their numbers of turns."""

    runs: tuple[Repeat, ...]
    """Runs of the bands of rows, from the bottom up."""
    times: tuple[tuple[int, ...], ...]
    """Possible combinations of the numbers of turns of all runs."""
    heights: tuple[float, ...]
    """Height of the facade for each of these, metres."""


def storeys_of(rows: KindSequence, low: float, high: float) -> Storeys:
    """The storeys of facades within a range of heights.

    Runs of equal rows have any number of turns; if there are none, the uppermost row without a door does
    that is at least half as high as the highest one. All other rows
    occur once, those with doors always.

    Args:
        rows: bands of the facade.
        low: least height, metres.
        high: largest height, metres.

    Raises:
        FacadeError: If no number of rows gives such a height, or too many do.
    """
    runs = _runs(rows)
    sizes = [rows.size[kind] for kind in rows.kind]
    turn = [sum(sizes[run.start : run.start + run.period]) for run in runs]
    fixed = sum(sizes) - sum(run.turns * size for run, size in zip(runs, turn, strict=True))
    slack = 1e-9 * max(high, 1.0)
    most = [max(0, min(MOST_TIMES, floor((high + slack - fixed) / size))) for size in turn]
    num_ways = 1
    for times in most:
        num_ways *= times + 1
    if num_ways > 100 * MOST_CHOICES:
        raise FacadeError(f"{num_ways:,} combinations of rows are too many; use a narrower range of heights.")
    combinations: list[tuple[tuple[int, ...], float]] = []
    for times in product(*(range(count + 1) for count in most)):
        height = fixed + sum(count * size for count, size in zip(times, turn, strict=True))
        if low - slack <= height <= high + slack and height > 0.0:
            combinations.append((times, height))
    if not combinations:
        steps = ", ".join(f"{size:.3g}" for size in turn) or "nothing"
        raise FacadeError(
            f"no facade of this family is {low:g} to {high:g} m high: its fixed rows take {fixed:.4g} m, and rows of "
            f"{steps} m may be added. Use a wider range."
        )
    if len(combinations) > MOST_CHOICES:
        raise FacadeError(f"{len(combinations)} combinations of rows are too many; use a narrower range of heights.")
    return Storeys(runs, tuple(times for times, _ in combinations), tuple(height for _, height in combinations))


def floor_names(rows: KindSequence, cells: Sequence[Sequence[Cell]]) -> dict[int, str]:
    """Names of the bands of rows with windows or doors, by their index: their floors in the facade.

    Args:
        rows: bands of the facade, from the bottom up.
        cells: [row kinds][column kinds] content at each crossing.
    """
    opens = [any(look_of(thing).glazed or is_door(thing) for cell in row for thing in cell.things()) for row in cells]
    floors = [index for index, kind in enumerate(rows.kind) if opens[kind]]
    return {index: f"Floor{number}" if number > 1 else "GroundFloor" for number, index in enumerate(floors, start=1)}


def _runs(rows: KindSequence) -> tuple[Repeat, ...]:
    """Runs of rows without doors; first those that occur in the facade."""
    runs: list[Repeat] = []
    kinds = list(rows.kind)
    while True:
        longest = [run for run in repeated_runs(kinds) if not any(rows.doors[kind] for kind in _turn(rows, run))]
        if not longest:
            break
        run = longest[0]
        runs.append(run)
        # The items of a run belong to no other run: unique numbers replace them.
        kinds[run.start : run.end] = range(-1 - run.end, -1 - run.start)
    runs = [run for run in runs if any(rows.has_elements[kind] for kind in _turn(rows, run))]
    if runs:
        return tuple(sorted(runs))
    alone = [
        k
        for k, kind in enumerate(rows.kind)
        if rows.has_elements[kind] and not rows.doors[kind] and _is_storey(rows, k)
    ]
    if not alone:
        return ()
    highest = max(rows.size[rows.kind[k]] for k in alone)
    index = [k for k in alone if rows.size[rows.kind[k]] >= _STOREY_SHARE * highest][-1]
    with_gap = index > 0 and not rows.has_elements[rows.kind[index - 1]]
    return (Repeat(index - with_gap, 1 + with_gap, 1),)


def _turn(rows: KindSequence, run: Repeat) -> tuple[int, ...]:
    return rows.kind[run.start : run.start + run.period]


def _is_storey(rows: KindSequence, index: int) -> bool:
    """Whether a band is neither at the top nor at the bottom, unlike cornices and bases."""
    return 0 < index < len(rows.kind) - 1 or len(rows.kind) == 1
