"""Lots whose edges are moved inwards, each by its own distance, with mitred corners.

What remains is at least so far from each edge. Most lots keep all their edges: their new corners are where the moved
lines of neighbouring edges meet. From the others, the area that each edge sweeps is cut off. Unlike in
`grammarlab.geometry.outlines.setback`, corners that hardly turn are mitred too, an edge sweeps all of its distance even
if it is short, and hundreds of thousands of lots take seconds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city.lot_edges import LotEdges
from grammarlab.city.outline_overlay import merged, overlaid
from grammarlab.city.packed_outlines import Outlines

_MITRE_LIMIT = 3.0
"""Largest length of a mitre, as a multiple of the larger distance: at a sharp reflex corner it is cut off."""
_LEAST_EDGE = 0.05
"""Metres; lots with a shorter edge after the move are cut instead."""
_OVERLAP = 0.01
"""Metres that swept areas reach out of the lot and over each other, so that rounding leaves no slivers."""
_PARALLEL = 1e-9
"""Sine of the angle between edges below which they are parallel."""


@dataclass(frozen=True, slots=True, eq=False)
class MovedEdges:
    """What remains of S lots."""

    outline: Outlines
    """[S] polygons, or several of them, or nothing."""
    is_whole: Flags
    """[S] whether each edge is still there, in the order of the lot's edges."""


@dataclass(frozen=True, slots=True, eq=False)
class _Mitres:
    """Corners of moved edges, by the edge [P]: in metres along it and beyond its ends."""

    before: Floats
    """From the start of the edge backwards to the start of the moved one."""
    after: Floats
    """From the end of the edge onwards to the end of the moved one."""
    is_convex: Flags
    """Whether the corner at the end of the edge is convex."""
    is_plain: Flags
    """Whether the lines of the moved edge and of the next one meet at a usual corner."""


def moved_inwards(edges: LotEdges, distances: Floats) -> MovedEdges:
    """What remains of lots.

    Args:
        edges: edges of S lots, which are valid polygons; P in all.
        distances: [P] distance in metres that each edge moves, >= 0.
    """
    mitres = _mitres(edges, distances)
    is_long = edges.length + mitres.before + mitres.after > _LEAST_EDGE
    lots = edges.polygons(edges.points)
    is_still = np.bincount(edges.outline, distances, minlength=len(edges)) == 0.0
    is_whole = np.bincount(edges.outline, ~(is_long & mitres.is_plain), minlength=len(edges)) == 0
    outline = edges.polygons(_starts(edges, distances, mitres))
    is_whole &= shapely.is_valid(outline)
    outline[is_still], is_whole[is_still] = lots[is_still], True
    cut, corners = edges.take(np.flatnonzero(~is_whole))
    outline[~is_whole] = overlaid(shapely.difference, lots[~is_whole], _swept(edges, distances, mitres, cut, corners))
    return MovedEdges(outline, is_whole)


def _mitres(edges: LotEdges, distances: Floats) -> _Mitres:
    """Where the lines of moved edges meet.

    With a turn t from an edge e to the next one f, that is (d_e cos t - d_f) / sin t beyond the end of e, and
    (d_f cos t - d_e) / sin t before the start of f.
    """
    after = edges.next_corner
    sine = edges.normal[:, 0] * edges.normal[after, 1] - edges.normal[:, 1] * edges.normal[after, 0]
    cosine = (edges.normal * edges.normal[after]).sum(axis=1)
    here, there = distances, distances[after]
    safe = np.where(np.abs(sine) > _PARALLEL, sine, 1.0)
    is_straight = (np.abs(sine) <= _PARALLEL) & (cosine > 0.0) & (here == there)
    end, start = (here * cosine - there) / safe, (there * cosine - here) / safe
    end, start = (np.where(is_straight, 0.0, part) for part in (end, start))
    limit = _MITRE_LIMIT * np.maximum(here, there)
    is_reflex = sine < 0.0
    # Beside an edge that moves less, at an obtuse reflex corner, the moved edge would be too near to its own end.
    is_near = is_reflex & (np.minimum(end, start) < 0.0)
    is_plain = (is_straight | (np.abs(sine) > _PARALLEL)) & (np.maximum(end, start) <= limit) & ~is_near
    before = np.empty(len(start))
    before[after] = start
    return _Mitres(before=before, after=end, is_convex=~is_reflex, is_plain=is_plain)


def _starts(edges: LotEdges, distances: Floats, mitres: _Mitres) -> Floats:
    """[P, 2] the starts of moved edges."""
    return edges.points - edges.normal * distances[:, None] - edges.direction * mitres.before[:, None]


def _swept(edges: LotEdges, distances: Floats, mitres: _Mitres, cut: LotEdges, corners: Ints) -> Outlines:
    """[K] areas that the edges of some lots sweep.

    Args:
        edges: edges of all lots.
        distances: [P] distance that each edge moves.
        mitres: mitres of all lots.
        cut: edges of the lots, Q in all.
        corners: [Q] their rows in ``edges``.
    """
    limit = _MITRE_LIMIT * distances
    # At a convex corner all that is in front of the line of the edge goes.
    starts_convex = mitres.is_convex[edges.shifted(-1)]
    before = np.where(starts_convex, distances, np.clip(mitres.before, 0.0, limit) + _OVERLAP)[corners]
    after = np.where(mitres.is_convex, distances, np.clip(mitres.after, 0.0, limit) + _OVERLAP)[corners]
    start, end = cut.points, cut.points[cut.next_corner]
    inwards = -cut.normal * distances[corners][:, None]
    outwards = cut.normal * _OVERLAP
    loops = np.stack(
        [
            start,
            start + outwards,
            end + outwards,
            end,
            end + inwards + cut.direction * after[:, None],
            start + inwards - cut.direction * before[:, None],
        ],
        axis=1,
    )
    moving = np.flatnonzero(distances[corners] > 0.0)
    areas = np.asarray(shapely.polygons(loops[moving]), dtype=object)
    row, index = np.unique(cut.outline[moving], return_inverse=True)
    swept = np.full(len(cut), shapely.GeometryCollection(), object)
    groups = np.asarray(shapely.geometrycollections(areas, indices=index), dtype=object)
    swept[row] = merged(groups)
    return swept
