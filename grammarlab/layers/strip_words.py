"""Words along one axis: the columns, or the rows, of several products side by side, and the gaps between them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from grammarlab.facade.tree import Floats
from grammarlab.layers.covers import Interval, grouped

Key = tuple[int, int, frozenset[int]]
"""Shared properties of letters of one symbol: strip, class of size, products that show it. Gaps have strip -1."""
GAP = -1
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
    own: frozenset[Interval]
    """Cells that products show; others are gaps, or cells of the first strip that are not visible here."""


@dataclass(frozen=True, eq=False)
class Places:
    """Assignment of intervals to strips."""

    sets: tuple[frozenset[Interval], ...]
    """[P] intervals of each product."""
    of: tuple[int, ...]
    """[P] strip of each product, the strip with most elements first; -1 for a product of full length."""
    own: tuple[frozenset[Interval], ...]
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


def places_of(sets: Sequence[frozenset[Interval]], weight: Sequence[int], lines: Floats, tolerance: float) -> Places:
    """Few strips that contain all intervals of some sets, found greedily from large sets to small ones.

    Args:
        sets: [P] intervals that do not overlap, one set for each product.
        weight: [P] number of elements of each set.
        lines: coordinates of lines, metres.
        tolerance: largest difference of equal sizes, metres.
    """
    whole = frozenset({(0, len(lines) - 1)})
    together: list[set[Interval]] = []
    of = [-1] * len(sets)
    for at in sorted((at for at, each in enumerate(sets) if each != whole), key=lambda at: (-weight[at], at)):
        fitting = (
            number
            for number, others in enumerate(together)
            if len(others | sets[at]) <= MOST_CELLS and _fit(sets[at], others)
        )
        of[at] = next(fitting, len(together))
        if of[at] == len(together):
            together.append(set())
        together[of[at]] |= sets[at]
    return Places(tuple(sets), tuple(of), tuple(map(frozenset, together)), lines, tolerance)


def build(places: Places, joined: Collection[int], cuts: Collection[int] = ()) -> Strips:
    """The strips of an axis.

    Args:
        places: intervals of the strips.
        joined: strips whose gaps are cut at the cuts of the first strip, so that they share its letters.
        cuts: further lines at which gaps of joined strips are cut.
    """
    last = len(places.lines) - 1
    cells: list[list[Interval]] = []
    for number, own in enumerate(places.own):
        lines = set(cuts) if number in joined else set()
        if number and number in joined:
            lines |= {end for _, end in cells[0]}
        cells.append(_filled(sorted(own), last, lines))
    classes, sizes = _classes(sorted({cell for each in cells for cell in each}), places.lines, places.tolerance)
    made: list[Strip] = []
    for number, (own, each) in enumerate(zip(places.own, cells, strict=True)):
        first = dict(zip(made[0].cells, made[0].keys, strict=True)) if made and number in joined else {}
        keys = [
            (number, classes[cell], _shown(places, number, cell))
            if cell in own
            else first.get(cell, (GAP, classes[cell], frozenset[int]()))
            for cell in each
        ]
        made.append(Strip(tuple(each), tuple(keys), own))
    return Strips(tuple(made), sizes)


def air_cuts(places: Places, joined: Collection[int]) -> list[int]:
    """For each gap common to all joined strips, the line where it begins, unless all strips are cut there."""
    strips = build(places, joined).strips
    common = set.intersection(*({end for _, end in strips[at].cells} for at in joined))
    taken = sorted({cell for at in joined for cell in places.own[at]})
    found, reached = [], 0
    for begin, end in [*taken, (len(places.lines) - 1,) * 2]:
        if reached < begin and not any(reached <= cut <= begin for cut in common if cut):
            found.append(reached)
        reached = max(reached, end)
    return [cut for cut in found if cut]


def _shown(places: Places, strip: int, cell: Interval) -> frozenset[int]:
    """Products that show a cell of a strip."""
    return frozenset(at for at, of in enumerate(places.of) if of == strip and cell in places.sets[at])


def _fit(intervals: frozenset[Interval], others: set[Interval]) -> bool:
    """Whether no interval overlaps a different one of the others."""
    return all(end <= low or high <= begin for begin, end in intervals - others for low, high in others - intervals)


def _filled(own: Sequence[Interval], last: int, lines: Collection[int]) -> list[Interval]:
    """Intervals with the gaps between them, cut at some lines, unless the result is too long."""
    cuts = sorted(lines) if len(lines) + 2 * len(own) < _MOST_LETTERS else []
    found: list[Interval] = []
    for (_, before), (after, end) in pairwise([(0, 0), *own, (last, last)]):
        if before < after:
            found += pairwise([before, *(cut for cut in cuts if before < cut < after), after])
        if after < end:
            found.append((after, end))
    return found


def _classes(cells: Sequence[Interval], lines: Floats, tolerance: float) -> tuple[dict[Interval, int], Floats]:
    length = np.array([lines[end] - lines[begin] for begin, end in cells])
    number = grouped(length, tolerance)
    sizes = np.bincount(number, length) / np.bincount(number) if len(cells) else np.zeros(0)
    return dict(zip(cells, number.tolist(), strict=True)), sizes
