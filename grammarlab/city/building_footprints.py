"""Footprints of buildings on lots: setbacks by kind of edge, perimeter rings, courtyards, smallest sizes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints, index_in_row, offsets_from_counts
from grammarlab.city.lot_edges import LotEdges
from grammarlab.city.lot_fronts import edge_setbacks, first_edges, sides_of_edges
from grammarlab.city.moved_edges import moved_inwards
from grammarlab.city.outline_overlay import overlaid
from grammarlab.city.packed_outlines import Outlines
from grammarlab.city.parcel_reasons import NARROW, SMALL
from grammarlab.city.plan import LotRules
from grammarlab.geometry.meshes.triangulate import keyhole

LARGE = "large"
"""Reason of lots whose footprint has too much area."""
_LEAST_HOLE = 1.0
"""Square metres; smaller holes are filled, as no building has such a court."""
_CLEANED = 0.02
"""Metres; corners that change a cut lot by less are slivers of cutting."""
_LEAST_TAIL, _LEAST_TAIL_SHARE = 1.0, 0.01
"""Square metres, and share of the area: the tip of a sharp corner is no tail."""
_ALIKE = 0.5
"""Metres between an edge of a footprint and the moved edge of the lot that it is a part of."""
_MITRE_LIMIT = 3.0
"""Largest length of a mitre of a court, as a multiple of the depth of the ring."""
_COSINE_ALIKE = np.cos(np.radians(20.0))


@dataclass(frozen=True, eq=False, kw_only=True)
class FootprintRequest:
    """What is built on S lots."""

    setbacks: Floats
    """[S, 3] metres at the front, the sides and the back."""
    is_ring: Flags
    """[S] whether there is a court in the middle, if there is room."""
    is_park: Flags
    """[S] whether any area is good, as for trees."""
    rules: LotRules

    def take(self, rows: Ints) -> FootprintRequest:
        """What is built on the lots at these rows."""
        return replace(self, setbacks=self.setbacks[rows], is_ring=self.is_ring[rows], is_park=self.is_park[rows])


@dataclass(frozen=True, eq=False, kw_only=True)
class BuildingFootprints:
    """Footprints on S lots, or why there are none."""

    reason: NDArray[np.object_]
    """[S] empty for lots with a footprint."""
    lot: Ints
    """[K] lots with a footprint, ascending."""
    edges: LotEdges
    """Edges of K polygons with holes, in metres of the frame, each beginning with the first edge of the footprint."""
    street_width: Floats
    """[P] width of the street along each edge in metres, 0 for none."""


def building_footprints(edges: LotEdges, widths: Floats, request: FootprintRequest) -> BuildingFootprints:
    """Footprints of the buildings on lots.

    Args:
        edges: edges of S lots, which are valid polygons.
        widths: widths of the streets along them in metres, 0 for none.
        request: what is built on the lots.
    """
    order = edges.starting_at(first_edges(edges, widths))
    edges, widths = edges.reordered(order), widths[order]
    distances = edge_setbacks(edges, sides_of_edges(edges, widths), request.setbacks)
    moved = moved_inwards(edges, distances)
    is_moved = np.bincount(edges.outline, distances, minlength=len(edges)) > 0.0
    outline = moved.outline.copy()
    cut = np.flatnonzero(~moved.is_whole)
    outline[cut] = _largest_piece(shapely.simplify(outline[cut], _CLEANED, preserve_topology=True))
    is_narrow, narrowed = _cut_tails(outline, is_moved, request.rules)
    changed = np.concatenate([cut, narrowed, _add_courts(outline, request), _fill_small_holes(outline)])
    reason = _reasons(outline, is_narrow, request)
    lot = np.flatnonzero(reason == "")
    footprints = LotEdges.of(outline[lot])
    footprint_widths = _widths_of_parts(footprints, edges, distances, widths, lot, np.isin(lot, changed))
    # A building behind another lot looks to the street, too.
    towards = edges.normal[edges.ring_offsets[edges.outline_offsets[:-1]]][lot]
    order = footprints.starting_at(first_edges(footprints, footprint_widths, towards))
    return BuildingFootprints(
        reason=reason, lot=lot, edges=footprints.reordered(order), street_width=footprint_widths[order]
    )


def _largest_piece(outlines: Outlines) -> Outlines:
    """[S] the largest polygon of each; of equal ones the westernmost; an empty polygon where there is none."""
    parts, row = shapely.get_parts(outlines, return_index=True)
    is_polygon = shapely.get_type_id(parts) == shapely.GeometryType.POLYGON
    parts, row = parts[is_polygon], row[is_polygon]
    west = shapely.bounds(parts).reshape(-1, 4)
    order = np.lexsort((west[:, 1], west[:, 0], -shapely.area(parts), row))
    first = order[np.flatnonzero(np.diff(row[order], prepend=-1))]
    result = np.full(len(outlines), shapely.Polygon(), object)
    result[row[first]] = parts[first]
    return result


def _cut_tails(outline: Outlines, is_moved: Flags, rules: LotRules) -> tuple[Flags, Ints]:
    """Cut off what is narrower than the smallest side from outlines.

    Args:
        outline: [S] polygons, which are changed.
        is_moved: [S] whether an outline may be changed: others are buildings or lots as they are.
        rules: what footprints must be like.

    Returns:
        [S] whether an outline has no place for a circle of the smallest side, and the rows of those that were cut.
    """
    radius = max(0.5 * rules.least_side - _CLEANED, 0.0)
    core = _valid(shapely.buffer(outline, -radius, join_style="mitre", mitre_limit=_MITRE_LIMIT))
    is_narrow = np.asarray(shapely.is_empty(core), dtype=np.bool_)
    rows = np.flatnonzero(is_moved & ~is_narrow)
    # A core grows back to the lines of its edges, which may meet beyond the outline.
    opened = _valid(shapely.buffer(core[rows], radius, join_style="mitre", mitre_limit=_MITRE_LIMIT))
    opened = _largest_piece(overlaid(shapely.intersection, opened, outline[rows]))
    lost = shapely.area(outline[rows]) - shapely.area(opened)
    is_cut = lost > np.maximum(_LEAST_TAIL, _LEAST_TAIL_SHARE * shapely.area(outline[rows]))
    outline[rows[is_cut]] = shapely.simplify(opened[is_cut], _CLEANED, preserve_topology=True)
    return is_narrow, rows[is_cut]


def _valid(outlines: Outlines) -> Outlines:
    """[S] outlines, repaired: mitred buffers may cross themselves."""
    rows = np.flatnonzero(~shapely.is_valid(outlines))
    outlines[rows] = shapely.make_valid(outlines[rows])
    return outlines


def _add_courts(outline: Outlines, request: FootprintRequest) -> Ints:
    """Put courts into the rings among outlines, and return the rows of those that have one."""
    rules = request.rules
    rows = np.flatnonzero(request.is_ring & (shapely.get_num_interior_rings(outline) == 0))
    inner = _valid(shapely.buffer(outline[rows], -rules.ring_depth, join_style="mitre", mitre_limit=_MITRE_LIMIT))
    parts, part_row = shapely.get_parts(shapely.simplify(inner, _CLEANED), return_index=True)
    is_court = (shapely.area(parts) >= max(rules.least_court, _LEAST_HOLE)) & (
        shapely.get_num_interior_rings(parts) == 0
    )
    parts, part_row = parts[is_court], part_row[is_court]
    with_court = np.unique(part_row)
    # The court is open ground inside, so its ring is a hole as it is.
    shells = shapely.get_exterior_ring(outline[rows[with_court]])
    holes = shapely.get_exterior_ring(parts)
    owner = np.searchsorted(with_court, part_row)
    index = np.concatenate([np.arange(len(shells)), owner])
    order = np.argsort(index, kind="stable")
    outline[rows[with_court]] = shapely.polygons(np.concatenate([shells, holes])[order], indices=index[order])
    return rows[with_court]


def _fill_small_holes(outline: Outlines) -> Ints:
    """Fill holes below `_LEAST_HOLE` of outlines, and return the rows of those that had one."""
    rows = np.flatnonzero(shapely.get_num_interior_rings(outline) > 0)
    rings, ring_row = shapely.get_rings(outline[rows], return_index=True)
    is_outer = np.diff(ring_row, prepend=-1) > 0
    is_filled = ~is_outer & (shapely.area(shapely.polygons(rings)) < _LEAST_HOLE)
    changed = np.unique(ring_row[is_filled])
    if len(rows):
        outline[rows] = shapely.polygons(rings[~is_filled], indices=ring_row[~is_filled])
    return rows[changed]


def _reasons(outline: Outlines, is_narrow: Flags, request: FootprintRequest) -> NDArray[np.object_]:
    """[S] why an outline is no footprint; empty for footprints."""
    rules = request.rules
    area = shapely.area(outline)
    conditions = [area <= 0.0, request.is_park, area < rules.least_area, area > rules.most_area, is_narrow]
    return np.select(conditions, [SMALL, "", SMALL, LARGE, NARROW], "").astype(object)


def _widths_of_parts(
    footprints: LotEdges, edges: LotEdges, distances: Floats, widths: Floats, lot: Ints, is_changed: Flags
) -> Floats:
    """[Q] width of the street along each edge of footprints: that of the edge of the lot that was moved there.

    Args:
        footprints: edges of K footprints, Q in all.
        edges: edges of S lots, P in all.
        distances: [P] distance that each was moved.
        widths: [P] widths of streets along them.
        lot: [K] lot of each footprint.
        is_changed: [K] whether a footprint has other edges than its lot.
    """
    result = np.zeros(len(footprints.points))
    _, same = edges.take(lot[~is_changed])
    result[~is_changed[footprints.outline]] = widths[same]
    part = np.flatnonzero(is_changed[footprints.outline] & ~footprints.is_hole)
    _, corners = edges.take(lot[is_changed])
    row, wall = _parts_of_moved(footprints, part, edges, corners, distances)
    is_same = lot[footprints.outline[part[row]]] == edges.outline[wall]
    row, wall = row[is_same], wall[is_same]
    first = np.flatnonzero(np.diff(row, prepend=-1))
    result[part[row[first]]] = widths[wall[first]]
    return result


def _parts_of_moved(
    footprints: LotEdges, part: Ints, edges: LotEdges, corners: Ints, distances: Floats
) -> tuple[Ints, Ints]:
    """Pairs of an edge of footprints, as a row of ``part``, and an edge of lots that was moved there, nearest first.

    Args:
        footprints: edges of footprints.
        part: some of these edges.
        edges: edges of lots, P in all.
        corners: some of these edges.
        distances: [P] distance that each was moved.
    """
    middle = footprints.points[part] + 0.5 * footprints.along[part]
    start = edges.points[corners] - edges.normal[corners] * distances[corners][:, None]
    end = start + edges.along[corners]
    # A mitre makes an edge longer by about its distance.
    beyond = edges.direction[corners] * distances[corners][:, None]
    tree = shapely.STRtree(_lines(start - beyond, end + beyond))
    row, wall = tree.query(shapely.points(middle), predicate="dwithin", distance=_ALIKE)
    cosine = (footprints.normal[part[row]] * edges.normal[corners[wall]]).sum(axis=1)
    row, wall = row[cosine > _COSINE_ALIKE], wall[cosine > _COSINE_ALIKE]
    away = shapely.distance(shapely.points(middle[row]), _lines(start, end)[wall])
    order = np.lexsort((corners[wall], away, row))
    return row[order], corners[wall[order]]


def _lines(start: Floats, end: Floats) -> Outlines:
    return np.asarray(shapely.linestrings(np.stack([start, end], axis=1)), dtype=object)


# As footprints of models ---------------------------------------------------------------------------------------------


def joined_rings(edges: LotEdges, widths: Floats) -> tuple[Ints, Floats, Ints]:
    """Cycles around polygons in which holes are joined to the outer ring by doubled edges.

    Args:
        edges: edges of K polygons, P in all.
        widths: [P] widths of the streets along them.

    Returns:
        [Q] corners; [Q] width of the street along the edge that leaves each, 0 for doubled edges; [K + 1] offsets of
        the cycles, each of which begins with the first edge of its polygon.
    """
    num_holes = np.diff(edges.outline_offsets) - 1
    starts = edges.ring_offsets[edges.outline_offsets]
    cycles = {row: _cycle(edges, row) for row in np.flatnonzero(num_holes > 0).tolist()}
    lengths = np.diff(starts)
    lengths[list(cycles)] = [len(cycle) for cycle in cycles.values()]
    offsets = offsets_from_counts(lengths)
    corners = np.zeros(offsets[-1], np.int64)
    simple = np.flatnonzero(num_holes == 0)
    counts = np.diff(starts)[simple]
    place = np.repeat(offsets[simple], counts) + index_in_row(counts)
    corners[place] = np.repeat(starts[simple], counts) + index_in_row(counts)
    for row, cycle in cycles.items():
        corners[offsets[row] : offsets[row + 1]] = cycle
    following = _following(corners, offsets)
    # By position, since rings may touch at a corner.
    is_edge = (edges.points[edges.next_corner[corners]] == edges.points[corners[following]]).all(axis=1)
    return corners, np.where(is_edge, widths[corners], 0.0), offsets


def _cycle(edges: LotEdges, row: int) -> Ints:
    """Corners around one polygon with holes."""
    rings = range(edges.outline_offsets[row], edges.outline_offsets[row + 1])
    bounds = [(edges.ring_offsets[ring], edges.ring_offsets[ring + 1]) for ring in rings]
    return bounds[0][0] + keyhole([edges.points[start:end] for start, end in bounds])


def _following(corners: Ints, offsets: Ints) -> Ints:
    """[Q] index of the next corner of each cycle."""
    following = np.arange(1, len(corners) + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    return following
