"""Overlaps of parcels: what two parcels share belongs to the one with the smaller id."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely

from grammarlab.arrays import Flags, Ints
from grammarlab.city.parcels import Outlines
from grammarlab.errors import AssetError

MIN_OVERLAP = 1.0
"""Square metres; smaller overlaps are those of rounded corners."""
_ROWS = 64
"""Outlines whose neighbours are looked up at a time: each may have all others."""
_MOST_PAIRS_EACH = 100
"""Average number of outlines whose boxes may meet that of one outline: a parcel has about six neighbours."""
_MOST_PAIRS = 1_000_000
"""The same for small maps, in all."""


@dataclass(frozen=True, eq=False)
class Disjoint:
    """Outlines without overlaps."""

    outline: Outlines
    """[N] the largest piece that is left of each outline; the whole one of a covered outline."""
    is_covered: Flags
    """[N] whether less than `MIN_OVERLAP` of an outline is left."""
    is_cut: Flags
    """[N] whether something was taken from an outline."""


def disjoint(outline: Outlines) -> Disjoint:
    """Outlines without what they share with earlier ones.

    Args:
        outline: [N] valid polygons in metres, in the order of their ids.

    Raises:
        AssetError: If so many of them lie on each other that they are not parcels; it does not name the file.
    """
    first, second = _overlapping(outline)
    result = outline.copy()
    is_covered, is_cut = (np.zeros(len(outline), dtype=np.bool_) for _ in range(2))
    order = np.lexsort((first, second))
    first, second = first[order], second[order]
    rows, starts = np.unique(second, return_index=True)
    offsets = np.append(starts, len(second))
    for row, start, end in zip(rows, offsets[:-1], offsets[1:], strict=True):
        # What an earlier outline lost to a still earlier one belongs to that one, so all count as they were.
        rest = shapely.difference(outline[row], shapely.union_all(outline[first[start:end]]))
        pieces = [piece for piece in shapely.get_parts(rest) if isinstance(piece, shapely.Polygon)]
        largest = max(pieces, key=shapely.area, default=shapely.Polygon())
        is_covered[row] = largest.area < MIN_OVERLAP
        if not is_covered[row]:
            is_cut[row], result[row] = True, largest
    return Disjoint(result, is_covered, is_cut)


def _overlapping(outline: Outlines) -> tuple[Ints, Ints]:
    """Rows of all pairs of outlines that share more than `MIN_OVERLAP`, the smaller first."""
    parts = [_sharing(outline, *pair) for pair in _neighbours(outline)]
    empty = np.zeros(0, dtype=np.int64)
    firsts, seconds = zip(*parts, strict=True) if parts else ((), ())
    return np.concatenate([empty, *firsts]), np.concatenate([empty, *seconds])


def _neighbours(outline: Outlines) -> Iterator[tuple[Ints, Ints]]:
    """Rows of pairs of outlines whose boxes share more than `MIN_OVERLAP`, the smaller first."""
    tree = shapely.STRtree(outline)
    bounds = shapely.bounds(outline)
    most = max(_MOST_PAIRS_EACH * len(outline), _MOST_PAIRS)
    for start in range(0, len(outline), _ROWS):
        second, first = tree.query(outline[start : start + _ROWS])
        second += start
        is_pair = first < second
        first, second = first[is_pair], second[is_pair]
        most -= len(first)
        if most < 0:
            raise AssetError("too many of its outlines lie on each other: expected parcels beside each other")
        low = np.maximum(bounds[first, :2], bounds[second, :2])
        size = np.minimum(bounds[first, 2:], bounds[second, 2:]) - low
        is_large = (size > 0).all(axis=1) & (size.prod(axis=1) > MIN_OVERLAP)
        yield first[is_large], second[is_large]


def _sharing(outline: Outlines, first: Ints, second: Ints) -> tuple[Ints, Ints]:
    """The pairs among these that share more than `MIN_OVERLAP`."""
    shapely.prepare(outline[second])
    # Most neighbours share an edge and no area, which is found out four times as fast as the area.
    is_meeting = shapely.relate_pattern(outline[second], outline[first], "T********")
    first, second = first[is_meeting], second[is_meeting]
    is_shared = shapely.area(shapely.intersection(outline[first], outline[second])) > MIN_OVERLAP
    return first[is_shared], second[is_shared]
