"""Words along one axis: the columns, or the rows, of several products side by side, and the gaps between them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.layers.covers import Interval, grouped

Key = tuple[int, int, frozenset[int]]
"""Shared properties of letters of one symbol: strip, class of size, products that show it. Gaps have strip -1."""
GAP = -1
"""Strip of the keys of gaps."""
MOST_CELLS = 190
"""Largest number of cells of a strip that are not gaps."""
_MOST_LETTERS = 400
"""Largest number of letters of a strip."""


@dataclass(frozen=True, slots=True)
class Strip:
    """A word along one axis, from line 0 to the last."""

    cells: tuple[Interval, ...]
    """[n] cells; each begins at the end of the previous one."""
    keys: tuple[Key, ...]
    """[n] keys of the symbols."""
    visible: frozenset[Interval]
    """Cells that products show; others are gaps, or cells of the first strip that are not visible here."""


@dataclass(frozen=True, eq=False)
class StripAssignment:
    """Assignment of intervals to strips."""

    sets: tuple[frozenset[Interval], ...]
    """[P] intervals of each product."""
    strip: tuple[int, ...]
    """[P] strip of each product, the strip with most elements first; -1 for a product of full length."""
    intervals: tuple[frozenset[Interval], ...]
    """[S] intervals of all products of each strip; they do not overlap."""
    lines: Floats
    """Coordinates of lines, metres."""
    tolerance: float
    """Largest difference of equal sizes, metres."""


@dataclass(frozen=True, eq=False)
class Strips:
    """Words of an axis."""

    strips: tuple[Strip, ...]
    sizes: Floats
    """Size of each class, metres."""


def assign_strips(
    sets: Sequence[frozenset[Interval]], weight: Sequence[int], lines: Floats, tolerance: float
) -> StripAssignment:
    """Few strips that contain all intervals of some sets, found greedily from large sets to small ones.

    Args:
        sets: [P] intervals that do not overlap, one set for each product.
        weight: [P] number of elements of each set.
        lines: coordinates of lines, metres.
        tolerance: largest difference of equal sizes, metres.
    """
    whole = frozenset({(0, len(lines) - 1)})
    merged: list[set[Interval]] = []
    strip_of = [-1] * len(sets)
    for index in sorted(
        (index for index, intervals in enumerate(sets) if intervals != whole), key=lambda index: (-weight[index], index)
    ):
        fitting = (
            number
            for number, others in enumerate(merged)
            if len(others | sets[index]) <= MOST_CELLS and _fit(sets[index], others)
        )
        strip_of[index] = next(fitting, len(merged))
        if strip_of[index] == len(merged):
            merged.append(set())
        merged[strip_of[index]] |= sets[index]
    return StripAssignment(tuple(sets), tuple(strip_of), tuple(map(frozenset, merged)), lines, tolerance)


def build(assignment: StripAssignment, joined: Collection[int], cuts: Collection[int] = ()) -> Strips:
    """The strips of an axis.

    Args:
        assignment: intervals of the strips.
        joined: strips whose gaps are cut at the cuts of the first strip, so that they share its letters.
        cuts: further lines at which gaps of joined strips are cut.
    """
    last = len(assignment.lines) - 1
    cells: list[list[Interval]] = []
    for number, visible in enumerate(assignment.intervals):
        lines = set(cuts) if number in joined else set()
        if number and number in joined:
            lines |= {end for _, end in cells[0]}
        cells.append(_filled(sorted(visible), last, lines))
    classes, sizes = _classes(sorted({cell for row in cells for cell in row}), assignment.lines, assignment.tolerance)
    strips: list[Strip] = []
    for number, (visible, row) in enumerate(zip(assignment.intervals, cells, strict=True)):
        first = dict(zip(strips[0].cells, strips[0].keys, strict=True)) if strips and number in joined else {}
        keys = [
            (number, classes[cell], _visible_in(assignment, number, cell))
            if cell in visible
            else first.get(cell, (GAP, classes[cell], frozenset[int]()))
            for cell in row
        ]
        strips.append(Strip(tuple(row), tuple(keys), visible))
    return Strips(tuple(strips), sizes)


def air_cuts(assignment: StripAssignment, joined: Collection[int]) -> list[int]:
    """For each gap common to all joined strips, the line where it begins, unless all strips are cut there."""
    strips = build(assignment, joined).strips
    common = set.intersection(*({end for _, end in strips[strip].cells} for strip in joined))
    occupied = sorted({cell for strip in joined for cell in assignment.intervals[strip]})
    cuts, reached = [], 0
    for begin, end in [*occupied, (len(assignment.lines) - 1,) * 2]:
        if reached < begin and not any(reached <= cut <= begin for cut in common if cut):
            cuts.append(reached)
        reached = max(reached, end)
    return [cut for cut in cuts if cut]


def _visible_in(assignment: StripAssignment, strip: int, cell: Interval) -> frozenset[int]:
    """Products that show a cell of a strip."""
    return frozenset(
        product for product, owner in enumerate(assignment.strip) if owner == strip and cell in assignment.sets[product]
    )


def _fit(intervals: frozenset[Interval], others: set[Interval]) -> bool:
    """Whether no interval overlaps a different one of the others."""
    return all(end <= low or high <= begin for begin, end in intervals - others for low, high in others - intervals)


def _filled(intervals: Sequence[Interval], last: int, lines: Collection[int]) -> list[Interval]:
    """Intervals with the gaps between them, cut at some lines, unless the result is too long."""
    cuts = sorted(lines) if len(lines) + 2 * len(intervals) < _MOST_LETTERS else []
    cells: list[Interval] = []
    for (_, before), (after, end) in pairwise([(0, 0), *intervals, (last, last)]):
        if before < after:
            cells += pairwise([before, *(cut for cut in cuts if before < cut < after), after])
        if after < end:
            cells.append((after, end))
    return cells


def _classes(cells: Sequence[Interval], lines: Floats, tolerance: float) -> tuple[dict[Interval, int], Floats]:
    length = np.array([lines[end] - lines[begin] for begin, end in cells])
    number = grouped(length, tolerance)
    sizes = np.bincount(number, length) / np.bincount(number) if len(cells) else np.zeros(0)
    return dict(zip(cells, number.tolist(), strict=True)), sizes
