"""Widths of streets in a column of a map: a number for all streets of a parcel, or a list with one for each edge.

A list is CGA's ``streetWidth``, as maps can hold it: a list of numbers, which is read as a text ``[8, 0, 0, 5.5]``, or
a text such as ``8;0;0;5.5``, with the edges of the outer ring as the map draws it. Then other parcels and lines of
streets do not matter.
"""

from __future__ import annotations

import re

import numpy as np
import shapely

from grammarlab.arrays import Floats, Ints, offsets_from_counts, row_of_value, take_rows
from grammarlab.city.drawn_edges import in_order
from grammarlab.city.lot_edges import LotEdges
from grammarlab.city.packed_outlines import Outlines
from grammarlab.city.parcels import Parcels
from grammarlab.city.plan_fields import PlanFields

_MOST_EDGES = 500
"""Largest number of edges of a ring with a list: each is compared with all edges of its lot."""
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def with_mapped_widths(
    edges: LotEdges, widths: Floats, parcels: Parcels, parcel: Ints, fields: PlanFields, name: str
) -> Floats:
    """[P] widths of streets, with those of a column where it has any.

    A list of another length than the ring of its parcel, or of more than `_MOST_EDGES`, is left out, and so is that of
    a parcel whose outline is not the one of the map, as it overlapped another.

    Args:
        edges: edges of S lots, P in all.
        widths: [P] widths that are known otherwise.
        parcels: all parcels.
        parcel: [S] the parcel of each lot.
        fields: fields of all parcels.
        name: name of the field with the widths.

    Raises:
        UsageError: If there is no such field, or it has other values.
    """
    column = fields.column(name)
    if column.dtype != np.object_:
        return _one_each(column.astype(np.float64)[parcel[edges.outline]], widths)
    lists = [_numbers(str(column[row])) for row in parcel.tolist()]
    single = np.array([numbers[0] if len(numbers) == 1 else np.nan for numbers in lists], np.float64)
    widths = _one_each(single[edges.outline], widths)
    lots, first = parcels.outlines.take(parcel), parcels.first_edge[parcel]
    counts = np.diff(lots.ring_offsets)[lots.offsets[:-1]] - 1
    is_list = counts == np.array([len(numbers) for numbers in lists], np.int64)
    lot = np.flatnonzero(is_list & (counts <= _MOST_EDGES) & (first != 0))
    known = np.array([width for row in lot.tolist() for width in in_order(lists[row], int(first[row]))], np.float64)
    rings = np.asarray(shapely.get_exterior_ring(lots[lot]), dtype=object)
    return _by_edge(edges, widths, lot, rings, known)


def _one_each(known: Floats, widths: Floats) -> Floats:
    """Widths of edges along streets, replaced where a number is known."""
    return np.where(np.isnan(known) | (widths <= 0.0), widths, np.maximum(known, 0.0))


def _by_edge(edges: LotEdges, widths: Floats, lot: Ints, rings: Outlines, known: Floats) -> Floats:
    """Widths of all edges of some lots: those of the nearest edges of the rings of their parcels.

    Args:
        edges: edges of all lots, P in all.
        widths: [P] widths of streets along them.
        lot: [K] the lots, ascending.
        rings: [K] outer rings of their parcels, W edges in all.
        known: [W] widths of streets along the edges of these rings.
    """
    points, ring = shapely.get_coordinates(rings, return_index=True)
    start = np.flatnonzero(np.diff(ring, append=-1) == 0)
    along = points[start + 1] - points[start]
    counts = np.bincount(ring, minlength=len(rings)) - 1
    corners = np.flatnonzero(np.isin(edges.outline, lot) & ~edges.is_hole)
    pairs, _ = take_rows(offsets_from_counts(counts), np.searchsorted(lot, edges.outline[corners]))
    row = row_of_value(counts[np.searchsorted(lot, edges.outline[corners])])
    offset = (edges.points[corners] + 0.5 * edges.along[corners])[row] - points[start[pairs]]
    share = (offset * along[pairs]).sum(axis=1) / np.maximum((along[pairs] ** 2).sum(axis=1), np.finfo(float).tiny)
    away = np.hypot(*(offset - np.clip(share, 0.0, 1.0)[:, None] * along[pairs]).T)
    order = np.lexsort((away, row))
    nearest = order[np.flatnonzero(np.diff(row[order], prepend=-1))]
    result = widths.copy()
    result[corners] = np.maximum(known[pairs[nearest]], 0.0)
    return result


def _numbers(text: str) -> list[float]:
    """The numbers in a text.

    >>> _numbers("[8, 0; 5.5]"), _numbers("")
    ([8.0, 0.0, 5.5], [])
    """
    return [float(number) for number in _NUMBER.findall(text)]
