"""Division of a length by ``split``: absolute, relative and floating sizes, and repeats.

Fixed sizes (absolute, or relative to the whole length) are assigned first; all floating sizes are then scaled by one
common factor so that they fill the rest. If there are floating sizes, the number of repeats of a group is chosen so
that this factor is above 0 and nearest to 1. Several groups share the number evenly, the first ones get the remainder;
a number that can be shared equally is preferred, as measured in another CGA runtime (`_imbalance`).
Without floating sizes, a group is repeated as often as it fits, and its last part is cut. Parts of size 0 are left
out; no part reaches beyond the length.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints

Amount: TypeAlias = "float | NDArray[np.floating]"
"""Metres, one number for all lengths or one per length."""

TOLERANCE = 1e-9
"""Smallest size of a part in metres; smaller parts are left out."""

_MOST_REPEATS = 2**31
_SMALLEST = 1e-200
"""Smallest divisor, in place of 0."""


class SplitSize(NamedTuple):
    """One size of a split, for N lengths."""

    value: Amount
    """Metres, one for all or [N]; below zero counts as zero."""
    floating: bool = False


class SplitRepeat(NamedTuple):
    """Sizes of a repeated group, in braces with a star."""

    sizes: tuple[SplitSize, ...]


Element: TypeAlias = SplitSize | SplitRepeat


class SplitPieces(NamedTuple):
    """K pieces made by one size of the split, ordered by length and then along it."""

    row: Ints
    """[K] index of the length that the piece belongs to."""
    start: Floats
    """[K] metres from the start of the length."""
    extent: Floats
    """[K] metres, > 0."""
    is_one_each: bool
    """Whether these are one piece of every length, so that `row` is 0, 1, 2, …"""
    element: int
    """Index of the size or repeated group of the split that it belongs to."""


class SplitRow(NamedTuple):
    """Pieces of N lengths by P sizes without repeats."""

    start: Floats
    """[P, N] metres from the start of the length."""
    extent: Floats
    """[P, N] metres; 0 for parts that are left out."""

    @property
    def is_full(self) -> bool:
        """Whether every length has a piece of every size."""
        return bool(self.extent.min(initial=np.inf) > TOLERANCE)

    def pieces(self) -> list[SplitPieces]:
        """The pieces without parts that are left out."""
        everyone = np.arange(self.start.shape[1])
        keep = self.extent > TOLERANCE
        if keep.all():
            return [
                SplitPieces(everyone, start, extent, True, element)
                for element, (start, extent) in enumerate(zip(self.start, self.extent, strict=True))
            ]
        return [
            SplitPieces(everyone[is_piece], start[is_piece], extent[is_piece], bool(is_piece.all()), element)
            for element, (is_piece, start, extent) in enumerate(zip(keep, self.start, self.extent, strict=True))
        ]


def divide(
    length: Floats, elements: Sequence[Element], check: Callable[[int], None] = lambda _count: None
) -> list[SplitPieces]:
    """Pieces of lengths [N], one `SplitPieces` for each size in the order of the text.

    Args:
        length: [N] metres.
        elements: sizes and repeated groups.
        check: called with the number of pieces, empty ones included, before they take memory; it may raise.

    >>> front, tiles = divide(np.array([7.0]), [SplitSize(1.0), SplitRepeat((SplitSize(2.9, floating=True),))])
    >>> front.extent.tolist(), tiles.start.tolist(), tiles.extent.tolist()
    ([1.0], [1.0, 4.0], [3.0, 3.0])
    """
    row = in_a_row(length, elements)
    if row is not None:
        check(row.start.size)
        return row.pieces()
    times = _repeats(length, elements)
    check(_count_pieces(len(length), elements, times))
    scale = _stretch(length, elements, times)
    reach = _reach(length)
    turns = iter(times)
    start: Amount = 0.0
    everyone = np.arange(len(length))
    pieces: list[SplitPieces] = []
    for index, element in enumerate(elements):
        if isinstance(element, SplitSize):
            extent = _extent(element, scale)
            pieces.append(_within(everyone, start, extent, length, reach, is_one_each=True, element=index))
            start = start + extent
        else:
            count = next(turns)
            extents = [_extent(size, scale) for size in element.sizes]
            pieces += _repeated(extents, count, start, length, reach, index)
            start = start + count * _sum(extents)
    return pieces


def in_a_row(length: Floats, elements: Sequence[Element]) -> SplitRow | None:
    """Pieces of lengths [N] without repeats; None if a size repeats.

    They are computed at once from cumulative sums: with few lengths, the number of array calls dominates the time.
    """
    if any(isinstance(element, SplitRepeat) for element in elements):
        return None
    metres, shares = _sums(cast("Sequence[SplitSize]", elements))
    end = metres
    if shares is not None:
        end = metres + shares * np.maximum(length - metres[-1], 0.0)
    end = np.where(end >= _reach(length), length, end)
    return SplitRow(end[:-1], end[1:] - end[:-1])


def _sums(sizes: Sequence[SplitSize]) -> tuple[Floats, Floats | None]:
    """Sums of the first 0 to P sizes, [P + 1, 1] or [P + 1, N].

    Returns:
        Metres of the fixed sizes, and shares of the sums of floating sizes; None without floating sizes.
    """
    if all(type(size.value) is float for size in sizes):
        return _constant_sums(tuple(sizes))  # ty: ignore[invalid-argument-type]
    columns = [np.atleast_1d(_positive(size.value)) for size in sizes]
    sums = np.zeros((2, len(sizes) + 1, max(len(column) for column in columns)))
    for index, (size, column) in enumerate(zip(sizes, columns, strict=True), start=1):
        sums[int(size.floating), index] = column
    metres, weights = np.cumsum(sums, axis=1)
    return metres, weights / np.maximum(weights[-1], _SMALLEST) if any(size.floating for size in sizes) else None


@lru_cache(maxsize=4096)
def _constant_sums(sizes: tuple[SplitSize, ...]) -> tuple[Floats, Floats | None]:
    values = np.array([0.0, *(_positive(size.value) for size in sizes)])[:, None]
    floating = np.array([False, *(size.floating for size in sizes)])[:, None]
    metres, weights = np.cumsum(values * ~floating, axis=0), np.cumsum(values * floating, axis=0)
    return metres, weights / weights[-1] if weights[-1] > 0.0 else None


def _count_pieces(num: int, elements: Sequence[Element], times: Sequence[Ints]) -> int:
    """Number of pieces of ``num`` lengths before empty ones are removed."""
    outside = sum(isinstance(element, SplitSize) for element in elements) * num
    groups = [element for element in elements if isinstance(element, SplitRepeat)]
    return outside + sum(int(count.sum()) * len(group.sizes) for group, count in zip(groups, times, strict=True))


def _repeats(length: Floats, elements: Sequence[Element]) -> list[Ints]:
    """Number of repeats [N] of each group, in the order of the text."""
    groups = [element for element in elements if isinstance(element, SplitRepeat)]
    if not groups:
        return []
    fixed, floats = _totals([element for element in elements if isinstance(element, SplitSize)])
    inner = [_totals(group.sizes) for group in groups]
    period = _sum([f + w for f, w in inner])
    ideal = len(groups) * (length - fixed - floats) / np.maximum(period, TOLERANCE)
    # What is not a number counts as no room.
    ideal = np.where(period > TOLERANCE, np.minimum(np.fmax(ideal, 0.0), _MOST_REPEATS), 0.0)
    if not any(size.floating for e in elements for size in (e.sizes if isinstance(e, SplitRepeat) else (e,))):
        return _share(ideal, len(groups))
    least = 0 if any(isinstance(e, SplitSize) and e.floating for e in elements) else 1
    best = _share(np.full(len(length), float(least)), len(groups))
    smallest = np.full(len(length), np.inf)
    # The factor decreases with the total; unequal groups move its crossing of 1 by less than one repeat of each.
    first = np.floor(ideal) - (len(groups) - 1)
    for step in range(2 * len(groups)):
        counts = _share(np.maximum(first + step, least), len(groups))
        factor = _factor(length, fixed, floats, inner, counts)
        error = np.where(factor > 0.0, np.abs(factor - 1.0) + _imbalance(counts, len(elements)), np.inf)
        nearer = error < smallest
        smallest = np.where(nearer, error, smallest)
        best = [np.where(nearer, new, old) for new, old in zip(counts, best, strict=True)]
    has_room = length - fixed > TOLERANCE
    return [np.where(has_room, count, 0) for count in best]


def _share(total: Floats, groups: int) -> list[Ints]:
    """A whole number of repeats shared evenly among groups; the first ones get the remainder."""
    whole = np.ceil(total - TOLERANCE).astype(np.int64)
    if groups == 1:
        return [whole]
    return [whole // groups + (whole % groups > group) for group in range(groups)]


def _imbalance(counts: Sequence[Ints], num_elements: int) -> Floats:
    """Cost [N] of groups that repeat unequally, on the scale of the factor's distance from 1.

    Mean over the elements of the split that have a part: a group counts with the distance of its share of the repeats
    from an equal share, a size of its own with 0.

    Args:
        counts: repeats [N] of each group.
        num_elements: number of sizes and groups of the split.
    """
    repeats = np.array(counts)
    share = repeats / np.maximum(repeats.sum(axis=0), 1)
    used = repeats > 0
    distance = np.where(used, np.abs(share - 1.0 / len(counts)), 0.0).sum(axis=0)
    return distance / np.maximum(num_elements - (~used).sum(axis=0), 1)


def _factor(
    length: Floats, fixed: Amount, floats: Amount, inner: Sequence[tuple[Amount, Amount]], counts: Sequence[Ints]
) -> Floats:
    """Common factor of all floating sizes under these repeats; very large without floating sizes."""
    room = length - fixed - _sum([count * f for count, (f, _) in zip(counts, inner, strict=True)])
    weights = floats + _sum([count * w for count, (_, w) in zip(counts, inner, strict=True)])
    has_weight = np.greater(weights, 0.0)
    if has_weight.all():
        return room / weights
    return np.divide(room, weights, out=np.full(len(length), 1e300), where=np.broadcast_to(has_weight, len(length)))


def _stretch(length: Floats, elements: Sequence[Element], times: Sequence[Ints]) -> Floats:
    """Factor [N] of floating sizes; 0 if the fixed sizes fill the length."""
    groups = [_totals(element.sizes) for element in elements if isinstance(element, SplitRepeat)]
    fixed, floats = _totals([element for element in elements if isinstance(element, SplitSize)])
    for count, (f, w) in zip(times, groups, strict=True):
        fixed, floats = fixed + count * f, floats + count * w
    weights = np.maximum(floats, _SMALLEST) if isinstance(floats, np.ndarray) else max(floats, _SMALLEST)
    return np.maximum(length - fixed, 0.0) / weights


def _reach(length: Floats) -> Floats:
    """Pieces that end beyond this end at the end of their length."""
    return length * (1.0 - TOLERANCE)


def _repeated(
    extents: Sequence[Amount], times: Ints, start: Amount, length: Floats, reach: Floats, element: int
) -> list[SplitPieces]:
    row = np.repeat(np.arange(len(length)), times)
    turn = np.arange(len(row)) - np.repeat(np.cumsum(times) - times, times)
    whole = length[row]
    period = _sum(extents)
    first = _rows_of(start, row) + turn * _rows_of(period, row)
    is_one_each = bool((times == 1).all())
    pieces = []
    for extent in extents:
        pieces.append(_within(row, first, _rows_of(extent, row), whole, reach[row], is_one_each, element))
        first = first + _rows_of(extent, row)
    return pieces


def _within(
    row: Ints, start: Amount, part_extent: Amount, length: Floats, reach: Floats, is_one_each: bool, element: int
) -> SplitPieces:
    """Pieces cut at the end of their length, without empty ones; ends near the end of the length are moved to it."""
    first: Floats = np.asarray(start, np.float64) if isinstance(start, np.ndarray) else np.zeros(len(row)) + start
    end = start + part_extent
    end = np.where(end >= reach, length, end)
    extent: Floats = end - first
    keep = extent > TOLERANCE
    if keep.all():
        return SplitPieces(row, first, extent, is_one_each, element)
    return SplitPieces(row[keep], first[keep], extent[keep], is_one_each=False, element=element)


def _extent(size: SplitSize, scale: Floats) -> Amount:
    value = _positive(size.value)
    return value * scale if size.floating else value


def _totals(sizes: Sequence[SplitSize]) -> tuple[Amount, Amount]:
    """Sums of the fixed and of the floating sizes."""
    fixed = _sum([_positive(size.value) for size in sizes if not size.floating])
    return fixed, _sum([_positive(size.value) for size in sizes if size.floating])


def _sum(values: Sequence[Amount]) -> Amount:
    total: Amount = 0.0
    for value in values:
        total = total + value
    return total


def _positive(value: Amount) -> Amount:
    return np.maximum(value, 0.0) if isinstance(value, np.ndarray) else max(value, 0.0)


def _rows_of(value: Amount, rows: Ints) -> Amount:
    return value[rows] if isinstance(value, np.ndarray) else value
