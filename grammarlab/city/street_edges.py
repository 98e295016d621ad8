"""Widths of streets along the edges of lots.

Where lines of streets are known, an edge is on the nearest line within `REACH` of the middle of its open part that
lies outside with no parcel between. Elsewhere it is on a street of `DEFAULT_WIDTH` if most of it is not within `GAP` of
another parcel. Only its own parcel, lines, and parcels that it touches or that are between it and a line decide about
an edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city.lot_edges import LotEdges
from grammarlab.city.outline_boxes import BoxTree, around, neighbourhoods
from grammarlab.city.packed_outlines import Outlines, PackedOutlines
from grammarlab.city.street_lines import StreetLines

REACH = 30.0
"""Largest distance in metres between an edge and the centre line of its street."""
GAP = 0.3
"""Metres; parcels that are nearer to each other have no street between them."""
DEFAULT_WIDTH = 8.0
"""Width in metres of a street of unknown width."""
_LEAST_COSINE = 0.5
"""Streets within 60 degrees of the outward normal of an edge are in front of it."""
_MICROMETRE = 1e-6
_LEAST_OPEN = 0.5
"""Smallest share of the length of an edge on a street that is not along other parcels."""


@dataclass(frozen=True, slots=True, eq=False)
class OpenParts:
    """Parts of P edges that are not along other parcels."""

    share: Floats
    """[P] share of the length, 0 to 1."""
    middle: Floats
    """[P, 2] middle of the longest open part."""


def street_widths(
    edges: LotEdges, parcels: PackedOutlines, rows: Ints, streets: StreetLines | None, is_street_plot: Flags
) -> Floats:
    """[P] width in metres of the street along each edge; 0 for edges without a street and those of holes.

    Args:
        edges: edges of S lots, P in all.
        parcels: [N] outlines of all parcels, those of the lots included.
        rows: [S] the parcel of each lot.
        streets: lines of streets; None if they are unknown.
        is_street_plot: [N] whether a parcel is a street itself, or covers another one: it cuts no other one off.
    """
    ground = _Ground.of(parcels, np.flatnonzero(~is_street_plot), streets)
    widths = np.zeros(len(edges.points))
    for lots in neighbourhoods(ground.bounds[rows]):
        block, corners = edges.take(lots)
        widths[corners] = _widths_of_block(block, rows[lots], ground)
    return widths


@dataclass(frozen=True, slots=True, eq=False)
class _Ground:
    """Parcels that cut others off, and streets, with their search trees."""

    parcels: PackedOutlines
    """Outlines of all parcels."""
    bounds: Floats
    """[N, 4] boxes around them."""
    rows: Ints
    """Rows of those that cut others off."""
    streets: StreetLines | None
    street_tree: shapely.STRtree | None

    @classmethod
    def of(cls, parcels: PackedOutlines, rows: Ints, streets: StreetLines | None) -> _Ground:
        street_tree = None if streets is None else shapely.STRtree(streets.line)
        return cls(parcels, parcels.bounds, rows, streets, street_tree)

    def near(self, boxes: Floats) -> Ints:
        """Rows of the parcels whose boxes are within `GAP` of boxes [n, 4], at least one; ascending."""
        return self._meeting(boxes + np.array([-GAP, -GAP, GAP, GAP]))

    def on_parcels(self, lines: Outlines) -> Flags:
        """[K] whether lines meet one of the parcels."""
        is_on = np.zeros(len(lines), np.bool_)
        if len(lines):
            outlines = self.parcels[self._meeting(shapely.bounds(lines))]
            is_on[shapely.STRtree(outlines).query(lines, predicate="intersects")[0]] = True
        return is_on

    def _meeting(self, boxes: Floats) -> Ints:
        tree = BoxTree(self.bounds, self.rows, around(boxes))
        return np.unique(tree.query(shapely.box(*boxes.T))[1])


def _widths_of_block(edges: LotEdges, rows: Ints, ground: _Ground) -> Floats:
    """[P] widths of streets along the edges of some lots, whose parcels have these rows [S]."""
    low = np.minimum.reduceat(edges.points, edges.ring_offsets[edges.outline_offsets[:-1]])
    high = np.maximum.reduceat(edges.points, edges.ring_offsets[edges.outline_offsets[:-1]])
    near = ground.near(np.column_stack([low, high]))
    walls = LotEdges.of(ground.parcels[near])
    parts = _open_parts(edges, walls, rows[edges.outline], near[walls.outline])
    is_open = (parts.share >= _LEAST_OPEN) & ~edges.is_hole
    widths = np.zeros(len(edges.points))
    corners = np.flatnonzero(is_open)
    widths[corners] = _line_widths(parts.middle[corners], edges.normal[corners], ground)
    return widths


def _open_parts(edges: LotEdges, walls: LotEdges, owner: Ints, wall_owner: Ints) -> OpenParts:
    """Parts of edges that are not within `GAP` of another parcel.

    Args:
        edges: edges of lots, P in all.
        walls: edges of parcels, W in all.
        owner: [P] rows of the parcels of the edges.
        wall_owner: [W] rows of the parcels of the walls.
    """
    edge, wall = _near_pairs(edges, walls, owner, wall_owner)
    start, end = _covered(edges, walls, edge, wall)
    is_covering = end > start
    edge, start, end = edge[is_covering], start[is_covering], end[is_covering]
    # Every edge begins and ends with an interval without length, so that gaps lie between intervals.
    every = np.arange(len(edges.points))
    edge = np.concatenate([every, edge, every])
    start = np.concatenate([np.zeros(len(every)), start, edges.length])
    end = np.concatenate([np.zeros(len(every)), end, edges.length])
    return _open_between(edges, edge, start, end)


def _near_pairs(edges: LotEdges, walls: LotEdges, owner: Ints, wall_owner: Ints) -> tuple[Ints, Ints]:
    """Pairs of an edge and an edge of another parcel whose boxes are within `GAP`."""
    tree = shapely.STRtree(_segments(walls))
    boxes = shapely.bounds(_segments(edges)) + np.array([-GAP, -GAP, GAP, GAP])
    edge, wall = tree.query(shapely.box(*boxes.T))
    is_other = owner[edge] != wall_owner[wall]
    return edge[is_other], wall[is_other]


def _segments(edges: LotEdges) -> Outlines:
    return _lines(edges.points, edges.points[edges.next_corner])


def _lines(start: Floats, end: Floats) -> Outlines:
    return np.asarray(shapely.linestrings(np.stack([start, end], axis=1)), dtype=object)


def _covered(edges: LotEdges, walls: LotEdges, edge: Ints, wall: Ints) -> tuple[Floats, Floats]:
    """Start and end, in metres along each edge, of its part beside a wall: within `GAP` of it at right angles."""
    length = edges.length[edge]
    direction = edges.along[edge] / np.maximum(length, np.finfo(float).tiny)[:, None]
    offset = walls.points[wall] - edges.points[edge]
    step = walls.along[wall]
    along, along_step = (offset * direction).sum(axis=1), (step * direction).sum(axis=1)
    across = direction[:, 0] * offset[:, 1] - direction[:, 1] * offset[:, 0]
    across_step = direction[:, 0] * step[:, 1] - direction[:, 1] * step[:, 0]
    # The part of the wall in the strip of GAP on both sides of the line of the edge, as shares of the wall.
    safe = np.where(across_step == 0.0, np.finfo(float).tiny, across_step)
    with np.errstate(over="ignore"):
        one, other = (-GAP - across) / safe, (GAP - across) / safe
    low, high = np.clip(np.minimum(one, other), 0.0, 1.0), np.clip(np.maximum(one, other), 0.0, 1.0)
    is_outside = (across_step == 0.0) & (np.abs(across) > GAP)
    first, last = along + low * along_step, along + high * along_step
    start, end = np.clip(np.minimum(first, last), 0.0, length), np.clip(np.maximum(first, last), 0.0, length)
    return start, np.where(is_outside, start, end)


def _open_between(edges: LotEdges, edge: Ints, start: Floats, end: Floats) -> OpenParts:
    """Gaps between the intervals of each edge, of which the first and the last are its ends."""
    # Whole micrometres: sums are exact, so an edge has the same gaps whatever the other edges are.
    begin, finish = (np.round(column / _MICROMETRE).astype(np.int64) for column in (start, end))
    order = np.lexsort((finish, begin, edge))
    edge, begin, finish = edge[order], begin[order], finish[order]
    # Intervals of all edges on one line, one edge after the other, so that a running maximum never mixes them.
    first = np.searchsorted(edge, np.arange(len(edges.points)))
    length = finish[np.append(first[1:], len(finish)) - 1] if len(first) else finish
    shift = (np.cumsum(length + 1) - length)[edge]
    reached = np.maximum.accumulate(finish + shift) - shift
    gap = np.maximum(begin - np.concatenate([[0], reached[:-1]]), 0)
    gap[first] = 0
    open_length = np.add.reduceat(gap, first) if len(first) else gap
    longest = np.lexsort((-gap, edge))[first] if len(first) else first
    middle = (begin[longest] - gap[longest] / 2.0) * _MICROMETRE
    direction = edges.along / np.maximum(edges.length, np.finfo(float).tiny)[:, None]
    share = open_length * _MICROMETRE / np.maximum(edges.length, np.finfo(float).tiny)
    return OpenParts(share, edges.points + middle[:, None] * direction)


def _line_widths(middle: Floats, normal: Floats, ground: _Ground) -> Floats:
    """[K] width of the nearest street in front of points with no parcel between; 0 if there is none."""
    streets, tree = ground.streets, ground.street_tree
    if streets is None or tree is None:
        return np.full(len(middle), DEFAULT_WIDTH)
    point, line = tree.query(shapely.points(middle), predicate="dwithin", distance=REACH)
    views = shapely.shortest_line(shapely.points(middle[point]), streets.line[line])
    ends = shapely.get_coordinates(views).reshape(-1, 2, 2)
    view = ends[:, 1] - ends[:, 0]
    distance = np.hypot(*view.T)
    ahead = (view * normal[point]).sum(axis=1)
    # Parcels may reach to the middle of the street.
    is_ahead = (ahead >= _LEAST_COSINE * distance) | (distance <= GAP)
    point, line, view, distance = point[is_ahead], line[is_ahead], view[is_ahead], distance[is_ahead]
    is_clear = ~_is_blocked(middle[point], view, distance, ground)
    point, line, distance = point[is_clear], line[is_clear], distance[is_clear]
    width = np.where(np.isnan(streets.width[line]), DEFAULT_WIDTH, streets.width[line])
    order = np.lexsort((-width, distance, point))
    point, width = point[order], width[order]
    result = np.zeros(len(middle))
    nearest = np.flatnonzero(np.diff(point, prepend=-1) > 0)
    result[point[nearest]] = width[nearest]
    return result


def _is_blocked(origin: Floats, view: Floats, distance: Floats, ground: _Ground) -> Flags:
    """[K] whether a parcel lies between points and what is seen from them; the first `GAP` does not count."""
    skipped = np.minimum(GAP / np.maximum(distance, GAP), 1.0)[:, None]
    return ground.on_parcels(_lines(origin + skipped * view, origin + view)) & (distance > GAP)
