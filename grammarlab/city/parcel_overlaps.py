"""Overlaps of parcels: what two parcels share belongs to the one with the smaller id."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from grammarlab.arrays import Flags, Ints
from grammarlab.city.outline_boxes import BoxTree, around, neighbourhoods
from grammarlab.city.packed_outlines import PackedOutlines
from grammarlab.errors import AssetError

MIN_OVERLAP = 1.0
"""Square metres; smaller overlaps are those of rounded corners."""
_ROWS = 64
"""Outlines whose neighbours are looked up at a time: each may have all others."""
_PAIRS = 4096
"""Least number of pairs that are compared at a time, whose outlines are in memory."""
_MOST_PAIRS_EACH = 100
"""Average number of outlines whose boxes may meet that of one outline: a parcel has about six neighbours."""
_MOST_PAIRS = 1_000_000
"""The same for small maps, in all."""


@dataclass(frozen=True, eq=False)
class Disjoint:
    """Outlines without overlaps."""

    outlines: PackedOutlines
    """[N] the largest piece that is left of each outline; the whole one of a covered outline."""
    is_covered: Flags
    """[N] whether less than `MIN_OVERLAP` of an outline is left."""
    is_cut: Flags
    """[N] whether something was taken from an outline."""


def disjoint(outlines: PackedOutlines, rows: Ints) -> Disjoint:
    """Outlines without what they share with earlier ones.

    Args:
        outlines: [N] polygons in metres, in the order of their ids.
        rows: [M] ascending rows of the valid ones: the others neither take nor lose anything.

    Raises:
        AssetError: If so many of them lie on each other that they are not parcels; it does not name the file.
    """
    first, second = _overlapping(outlines, rows)
    is_covered, is_cut = (np.zeros(len(outlines), dtype=np.bool_) for _ in range(2))
    order = np.lexsort((first, second))
    first, second = first[order], second[order]
    losing, starts = np.unique(second, return_index=True)
    rest = np.full(len(losing), None, dtype=object)
    for index, (row, earlier) in enumerate(zip(losing.tolist(), np.split(first, starts[1:]), strict=False)):
        # What an earlier outline lost to a still earlier one belongs to that one, so all count as they were.
        left = shapely.difference(outlines[row : row + 1][0], shapely.union_all(outlines[earlier]))
        pieces = [piece for piece in shapely.get_parts(left) if isinstance(piece, shapely.Polygon)]
        rest[index] = max(pieces, key=shapely.area, default=shapely.Polygon())
    is_covered[losing] = shapely.area(rest) < MIN_OVERLAP
    cut = np.flatnonzero(~is_covered[losing])
    is_cut[losing[cut]] = True
    return Disjoint(outlines.with_rows(losing[cut], rest[cut]), is_covered, is_cut)


def _overlapping(outlines: PackedOutlines, rows: Ints) -> tuple[Ints, Ints]:
    """Rows of all pairs of outlines that share more than `MIN_OVERLAP`, the smaller first."""
    parts = [_sharing(outlines, *pairs) for pairs in _many(_neighbours(outlines, rows))]
    empty = np.zeros(0, dtype=np.int64)
    firsts, seconds = zip(*parts, strict=True) if parts else ((), ())
    return np.concatenate([empty, *firsts]), np.concatenate([empty, *seconds])


def _neighbours(outlines: PackedOutlines, rows: Ints) -> Iterator[tuple[Ints, Ints]]:
    """Rows of pairs of outlines whose boxes share more than `MIN_OVERLAP`, the smaller first."""
    bounds = outlines.bounds
    most = max(_MOST_PAIRS_EACH * len(rows), _MOST_PAIRS)
    for block in neighbourhoods(bounds[rows]):
        tree = BoxTree(bounds, rows, around(bounds[rows[block]]))
        for some in np.split(rows[block], np.arange(_ROWS, len(block), _ROWS)):
            index, first = tree.query(shapely.box(*bounds[some].T))
            second = some[index]
            is_pair = first < second
            first, second = first[is_pair], second[is_pair]
            most -= len(first)
            if most < 0:
                raise AssetError("too many of its outlines lie on each other: expected parcels beside each other")
            low = np.maximum(bounds[first, :2], bounds[second, :2])
            size = np.minimum(bounds[first, 2:], bounds[second, 2:]) - low
            is_large = (size > 0).all(axis=1) & (size.prod(axis=1) > MIN_OVERLAP)
            yield first[is_large], second[is_large]


def _many(parts: Iterable[tuple[Ints, Ints]]) -> Iterator[tuple[Ints, Ints]]:
    """The same pairs, many at a time."""
    group: list[tuple[Ints, Ints]] = []
    num = 0
    for part in parts:
        group.append(part)
        num += len(part[0])
        if num >= _PAIRS:
            yield _joined(group)
            group, num = [], 0
    if num:
        yield _joined(group)


def _joined(parts: Sequence[tuple[Ints, Ints]]) -> tuple[Ints, Ints]:
    firsts, seconds = zip(*parts, strict=True)
    return np.concatenate(firsts), np.concatenate(seconds)


def _sharing(outlines: PackedOutlines, first: Ints, second: Ints) -> tuple[Ints, Ints]:
    """The pairs among these that share more than `MIN_OVERLAP`."""
    rows, place = np.unique(np.concatenate([first, second]), return_inverse=True)
    outline = outlines[rows]
    one, other = outline[place[: len(first)]], outline[place[len(first) :]]
    shapely.prepare(other)
    # Most neighbours share an edge and no area, which is found out four times as fast as the area.
    is_meeting = np.flatnonzero(shapely.relate_pattern(other, one, "T********"))
    shared = shapely.area(shapely.intersection(one[is_meeting], other[is_meeting]))
    pairs = is_meeting[shared > MIN_OVERLAP]
    return first[pairs], second[pairs]
