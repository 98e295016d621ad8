"""Parts of meshes between planes, for ``split`` and trim planes.

Closed meshes stay closed: a cap closes each cut that goes around, also in open meshes. A face in the plane of a cut
goes to one side only: to the side that it bounds.

A face that leaves the kept side once is cut by the rule of Sutherland and Hodgman ("Reentrant polygon clipping", CACM
17(1), 1974): keep the corners on the kept side, and add a point where an edge passes the plane. A face that leaves the
kept side more than once or touches the plane is rejoined along the cut: sorted along the cut, its k-th exit is joined
to its k-th entry, since the gaps between them lie inside the face.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, index_in_row, offsets_from_counts, row_of_value, take_rows
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.cut_caps import caps
from grammarlab.geometry.meshes.edges import joined
from grammarlab.geometry.meshes.measure import area_vectors, is_closed
from grammarlab.geometry.meshes.mesh import Indices, Meshes, Soup
from grammarlab.geometry.meshes.ragged import cycles, distinct_keys, max_rows, next_in_row, sum_rows
from grammarlab.geometry.meshes.triangulate import joined_over_bridges
from grammarlab.geometry.meshes.vectors import cross, dot

_TOLERANCE = 1e-9
"""Largest distance of points on a plane, as a share of the largest coordinate of their mesh."""
_THIN = 1e-3
"""Metres from a trim plane within which points lie on it: no slivers are cut off or left, as in CityEngine."""


def slabs(meshes: Meshes, mesh: NDArray[np.integer], axis: int, low: Floats, high: Floats) -> Meshes:
    """The parts of meshes between two planes across an axis.

    Parts do not overlap: volumes of the parts of a closed mesh, and areas of the parts of an open
    one, add up to those of the whole. A face across the axis at the end of a mesh belongs to the slab at that end.

    Args:
        meshes: the meshes to cut.
        mesh: [N] the mesh that each part is cut from.
        axis: 0, 1 or 2, the axis that runs from `low` to `high`.
        low: [N] beginning of each part, in metres.
        high: [N] end of each part, at least `low`.

    Returns:
        N meshes with unmoved points; some may be empty. Faces keep their order; caps come last, or
        first if the first face was cut away.
    """
    extent = _extent(meshes, axis)
    face, part = _faces_within(meshes, mesh, axis, low, high, extent)
    sides = [_side(meshes, mesh, extent, face, part, level, sign) for level, sign in ((low, 1.0), (high, -1.0))]
    meshes, capped = _closed_meshes(meshes, mesh, sides[0].is_cut | sides[1].is_cut)
    faces, points, owner = _gathered(meshes, mesh, face, part)

    cuts = []
    for side in sides:
        if not side.is_cut.any():
            continue
        distance = side.sign * (points[:, axis] - side.level.take(owner))
        # Parts that end before the plane keep their points to the last bit, whatever they are cut with.
        on_plane = (np.abs(distance) <= extent.slack[mesh].take(owner)) & side.is_cut.take(owner)
        distance[on_plane] = 0.0
        points[on_plane, axis] = side.level.take(owner[on_plane])
        normals = np.zeros((len(mesh), 3))
        normals[:, axis] = side.sign
        # `rank` is still the number of the face within the slabs that a piece was cut from.
        is_crossing = side.crosses.take(faces.rank)
        result = _cut_faces(faces.where(is_crossing), points, distance, normals)
        # Interpolation can differ from the plane in the last bit, but parts must end where their neighbours begin.
        result.points[:, axis] = side.level.take(result.mesh_of_point)
        points, owner = np.concatenate((points, result.points)), np.concatenate((owner, result.mesh_of_point))
        faces = Soup.concatenate([faces.where(~is_crossing), result.faces])
        cuts.append((side, np.append(on_plane, np.ones(len(result.points), bool)), normals))

    if len(cuts) == 2:
        # Pieces of the second cut stand behind the others; a cap begins at the first face that it closes.
        faces = faces.take(np.argsort(faces.rank, kind="stable"))
    closing = []
    for side, on_plane, normals in cuts:
        # A single face has no cut that goes around.
        needs_cap = side.is_cut & (np.diff(meshes.mesh_faces) > 1)[mesh]
        if needs_cap.any():
            flags = np.append(on_plane, np.zeros(len(points) - len(on_plane), bool))
            rank = np.where(side.lost_first, -1, len(face))
            closing.append(caps(faces.where(needs_cap.take(faces.mesh)), points, flags, normals, rank, capped))
    return Soup.concatenate([faces, *closing]).meshes(points, owner, len(mesh))


def trimmed(meshes: Meshes, mesh: Indices, normal: Floats, level: Floats) -> Meshes:
    """Meshes without what lies beyond planes; cuts are not closed.

    Args:
        meshes: M meshes.
        mesh: [P] the mesh that each plane trims, ascending.
        normal: [P, 3] unit normals of the planes.
        level: [P] a point beyond a plane has ``normal @ point > level``.
    """
    number = index_in_row(np.bincount(mesh, minlength=len(meshes)))
    for turn in range(int(number.max(initial=-1)) + 1):
        rows = np.flatnonzero(number == turn)
        normals, levels = np.zeros((len(meshes), 3)), np.zeros(len(meshes))
        normals[mesh[rows]], levels[mesh[rows]] = normal[rows], level[rows]
        meshes = _part_behind(meshes, normals, levels)
    return meshes


def _part_behind(meshes: Meshes, normals: Floats, levels: Floats) -> Meshes:
    """The part of each mesh where ``normal @ point <= level``, without caps; a normal of zero leaves a mesh whole.

    Args:
        meshes: M meshes.
        normals: [M, 3] unit normals or zero.
        levels: [M] metres.
    """
    of_point = meshes.mesh_of_point()
    distance = levels.take(of_point) - dot(normals.take(of_point, axis=0), meshes.points)
    distance[np.abs(distance) <= np.maximum(_slack(meshes), _THIN).take(of_point)] = 0.0
    faces = Soup.of_faces(meshes, np.arange(meshes.num_faces))
    at_corner = distance.take(faces.rows)
    highest, lowest = max_rows(at_corner, faces.offsets, 0.0), -max_rows(-at_corner, faces.offsets, 0.0)
    crossing = (highest > 0.0) & (lowest < 0.0)
    cut = _cut_faces(faces.where(crossing), meshes.points, distance, -normals)
    kept = Soup.concatenate([faces.where(~crossing & (lowest >= 0.0)), cut.faces])
    points = np.concatenate((meshes.points, cut.points))
    return kept.meshes(points, np.concatenate((of_point, cut.mesh_of_point)), len(meshes))


@dataclass(frozen=True, slots=True)
class _Extent:
    """Beginnings and ends of faces and meshes along an axis."""

    face_low: Floats
    """[F]"""
    face_high: Floats
    """[F]"""
    low: Floats
    """[M]"""
    high: Floats
    """[M]"""
    slack: Floats
    """[M] distance below which points lie on a plane."""


def _extent(meshes: Meshes, axis: int) -> _Extent:
    height = meshes.points[:, axis].take(meshes.corner_points())
    face_low = -max_rows(-height, meshes.face_offsets, -np.inf)
    face_high = max_rows(height, meshes.face_offsets, -np.inf)
    low = -max_rows(-face_low, meshes.mesh_faces, -np.inf)
    high = max_rows(face_high, meshes.mesh_faces, -np.inf)
    return _Extent(face_low, face_high, low, high, _slack(meshes))


def _slack(meshes: Meshes) -> Floats:
    """[M] distance below which points of a mesh lie on a plane."""
    x, y, z = np.abs(meshes.points.T)
    return _TOLERANCE * max_rows(np.maximum(np.maximum(x, y), z), meshes.mesh_points, 0.0)


def _faces_within(
    meshes: Meshes, mesh: NDArray[np.integer], axis: int, low: Floats, high: Floats, extent: _Extent
) -> tuple[Indices, Indices]:
    """Faces [K] that reach into slabs, and the slab of each, ascending."""
    face, part_faces = take_rows(meshes.mesh_faces, mesh)
    part = row_of_value(np.diff(part_faces))
    begin, end = extent.face_low.take(face), extent.face_high.take(face)
    slack = extent.slack[mesh]
    is_thick = high - low > slack
    # A slab of thickness 0 has no inside.
    first, last = np.where(is_thick, low + slack, np.inf), np.where(is_thick, high - slack, -np.inf)
    within = (end > first.take(part)) & (begin < last.take(part))
    flat = np.flatnonzero(end - begin <= slack.take(part))
    if len(flat):
        rises = area_vectors(meshes)[face[flat], axis] < 0.0
        within[flat] = _owns_flat(begin[flat], rises, mesh[part[flat]], low[part[flat]], high[part[flat]], extent)
    chosen = np.flatnonzero(within)
    return face.take(chosen), part.take(chosen)


def _owns_flat(
    height: Floats, rises: Flags, mesh: NDArray[np.integer], low: Floats, high: Floats, extent: _Extent
) -> Flags:
    """[K] whether slabs own faces that lie across the axis.

    Args:
        height: [K] position of the face.
        rises: [K] whether the face bounds the region above it.
        mesh: [K] the mesh of the face.
        low: [K] beginning of the slab.
        high: [K] end of the slab.
        extent: extent of the meshes.
    """
    slack = extent.slack[mesh]
    above = (height <= extent.low[mesh] + slack) | (rises & (height < extent.high[mesh] - slack))
    at_low, at_high = np.abs(height - low) <= slack, np.abs(height - high) <= slack
    between = (height > low) & (height < high) & ~at_low & ~at_high
    return between | (at_low & above) | (at_high & ~above)


@dataclass(frozen=True, slots=True)
class _Side:
    """One side of slabs: their low ends or their high ends."""

    level: Floats
    """[N] position of the plane along the axis."""
    sign: float
    """1 where the kept side lies above the plane, -1 where below."""
    is_cut: Flags
    """[N] whether the mesh reaches beyond the plane."""
    crosses: Flags
    """[K] whether faces that reach into the slabs reach beyond the plane."""
    lost_first: Flags
    """[N] whether the first face of the mesh lies beyond the plane."""


def _side(
    meshes: Meshes,
    mesh: NDArray[np.integer],
    extent: _Extent,
    face: Indices,
    part: Indices,
    level: Floats,
    sign: float,
) -> _Side:
    """The side beyond the low (sign 1) or high (sign -1) ends of slabs."""
    near, far = (extent.face_low, extent.face_high) if sign > 0.0 else (extent.face_high, extent.face_low)
    reach = extent.low if sign > 0.0 else extent.high
    slack = extent.slack[mesh]
    is_cut = sign * (level - reach[mesh]) > slack
    is_flat = extent.face_high - extent.face_low <= extent.slack[meshes.mesh_of_face()]
    crosses = (sign * (level.take(part) - near.take(face)) > slack.take(part)) & ~is_flat.take(face)
    lost_first = is_cut.copy()
    filled = np.flatnonzero(np.diff(meshes.mesh_faces)[mesh] > 0)
    first = meshes.mesh_faces[:-1][mesh[filled]]
    lost_first[filled] &= sign * (far[first] - level[filled]) <= slack[filled]
    return _Side(level, sign, is_cut, crosses, lost_first)


def _gathered(meshes: Meshes, mesh: NDArray[np.integer], face: Indices, part: Indices) -> tuple[Soup, Floats, Indices]:
    """Faces of parts over a table in which every part has its own copy of the points, and the owners of those points.

    The rank of each face is its number in `face`.
    """
    where, offsets = take_rows(meshes.face_offsets, face)
    candidates, candidate_offsets = take_rows(meshes.mesh_points, mesh)
    base = candidate_offsets[:-1].take(part)
    rows = meshes.corners.take(where) + np.repeat(base, np.diff(offsets))
    data = None if meshes.data is None else meshes.data.take(where, face)
    soup = Soup(rows, offsets, part, np.arange(len(face)), meshes.tags.take(face), data)
    return soup, meshes.points.take(candidates, axis=0), row_of_value(np.diff(candidate_offsets))


def _closed_meshes(meshes: Meshes, mesh: NDArray[np.integer], is_cut: Flags) -> tuple[Meshes, Flags]:
    """Meshes of which those that are closed share points, and [N] whether a part is cut from one of them.

    The sheets of a roof have points of their own, and yet are closed together. Uncut parts are not looked at.
    """
    is_candidate = np.zeros(len(meshes), bool)
    is_candidate[mesh[is_cut]] = True
    # A single face is never closed: this common case does not need its edges.
    candidates = np.flatnonzero(is_candidate & (np.diff(meshes.mesh_faces) > 1))
    closed = np.zeros(len(meshes), bool)
    closed[candidates] = is_closed(meshes.take(candidates))
    is_open = is_candidate & (np.diff(meshes.mesh_faces) > 1) & ~closed
    if is_open.any():
        together = joined(meshes, is_open)
        closed[is_open] = is_closed(together.take(np.flatnonzero(is_open)))
        corner_mesh = meshes.mesh_of_corner()
        is_joined = is_open & closed
        meshes = replace(meshes, corners=np.where(is_joined[corner_mesh], together.corners, meshes.corners))
    return meshes, closed[mesh]


@dataclass(frozen=True, slots=True)
class _Cut:
    """Faces on the kept side of a plane, and the points made where edges pass it."""

    faces: Soup
    """The pieces; rows from the number of old points on are new points."""
    points: Floats
    """[Q, 3] new points in metres."""
    mesh_of_point: Indices
    """[Q] the mesh of each new point."""


def _cut_faces(faces: Soup, points: Floats, distance: Floats, normals: Floats) -> _Cut:
    """The parts of faces where the distance is positive.

    Faces that share an edge get the same new point on it. The first edge of a piece is the rest of the first edge
    of its face. Otherwise it is the edge along the cut, or if another piece has the first edge, the one after it.

    Args:
        faces: faces with corners on both sides of the plane.
        points: [P, 3] the table of points in metres.
        distance: [P] distance of each point from the plane, positive on the kept side, exactly zero on the plane.
        normals: [M, 3] normal of the plane that cuts each mesh.
    """
    walk, new_points, owner = _walked(faces, points, distance)
    difficult = _is_difficult(walk)
    if not difficult.any():
        return _Cut(_remains(walk), new_points, owner)
    simple = _walk_of_faces(walk, np.flatnonzero(~difficult))
    rest = _rejoined(_walk_of_faces(walk, np.flatnonzero(difficult)), np.concatenate((points, new_points)), normals)
    return _Cut(Soup.concatenate([_remains(simple), rest]), new_points, owner)


@dataclass(frozen=True, slots=True)
class _Walk:
    """Corners of faces in cyclic order, and the plane that cuts them."""

    faces: Soup
    following: Indices
    """[C] the next corner."""
    distance: Floats
    """[C] distance of each corner from the plane, positive on the kept side."""
    edge_row: Indices
    """[C] row of the point where the edge after the corner leaves or enters the kept side; arbitrary for others."""
    edge_data: CornerData | None
    """Values of corners there."""


def _walked(faces: Soup, points: Floats, distance: Floats) -> tuple[_Walk, Floats, Indices]:
    """The walk around faces, the new points [Q, 3] and their meshes [Q]."""
    following = next_in_row(faces.offsets)
    here = distance.take(faces.rows)
    there = here.take(following)
    corners = np.flatnonzero((here > 0.0) != (there > 0.0))
    start, end = here.take(corners), there.take(corners)
    passing = np.flatnonzero((start != 0.0) & (end != 0.0))
    edge_row = faces.rows.copy()
    edge_row[corners] = faces.rows.take(np.where(start == 0.0, corners, following.take(corners)))
    corners = corners.take(passing)
    new, new_points = _crossings(faces.rows.take(corners), faces.rows.take(following.take(corners)), points, distance)
    edge_row[corners] = new + len(points)
    edge_data = None if faces.data is None else _edge_data(faces.data, following, here, there)
    owner = np.empty(len(new_points), np.int64)
    owner[new] = faces.mesh.take(row_of_value(np.diff(faces.offsets)).take(corners))
    return _Walk(faces, following, here, edge_row, edge_data), new_points, owner


def _edge_data(data: CornerData, following: Indices, here: Floats, there: Floats) -> CornerData:
    """Values [C] where the edge after each corner passes the plane; arbitrary for edges that do not.

    Args:
        data: values of corners.
        following: [C] the next corner.
        here: [C] distance of each corner from the plane.
        there: [C] distance of the next corner.
    """
    step = here - there
    share = np.divide(here, step, out=np.zeros_like(here), where=step != 0.0)[:, None]
    begin, end = data.values, data.values.take(following, axis=0)
    return replace(data, values=begin + share * (end - begin))


def _crossings(start: Indices, end: Indices, points: Floats, distance: Floats) -> tuple[Indices, Floats]:
    """For directed edges [X], the number of their new point, and the new points, one for each undirected edge."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    first, number = distinct_keys(low * len(points) + high)
    low, high = low.take(first), high.take(first)
    share = distance.take(low) / (distance.take(low) - distance.take(high))
    begin = points.take(low, axis=0)
    return number, begin + share[:, None] * (points.take(high, axis=0) - begin)


def _is_difficult(walk: _Walk) -> Flags:
    """[F] whether faces leave the kept side more than once, or have corners on the plane without a kept neighbour."""
    offsets, following = walk.faces.offsets, walk.following
    ahead = walk.distance > 0.0
    then_ahead = ahead.take(following)
    difficult = sum_rows(ahead & ~then_ahead, offsets) > 1
    on_plane = walk.distance == 0.0
    if on_plane.any():
        has_kept_neighbour = then_ahead.copy()
        has_kept_neighbour[following] |= ahead
        difficult |= sum_rows(on_plane & ~has_kept_neighbour, offsets) > 0
        difficult |= sum_rows(on_plane & on_plane.take(following), offsets) > 0
    return difficult


def _remains(walk: _Walk) -> Soup:
    """Remaining parts of faces that leave the kept side once."""
    faces = walk.faces
    is_inside = walk.distance > 0.0
    is_next_inside = is_inside.take(walk.following)
    changes = is_inside != is_next_inside
    # Two slots per corner: the corner itself, then the point where the edge after it leaves or enters.
    filled = np.stack((is_inside, changes), axis=1)
    rows = np.stack((faces.rows, walk.edge_row), axis=1)[filled]
    counts = sum_rows(is_inside + changes.view(np.int8), faces.offsets)
    data = _with_edges(walk, np.flatnonzero(filled))
    pieces = replace(faces, rows=rows, offsets=offsets_from_counts(counts), data=data)
    first = faces.offsets[:-1]
    return pieces.begun_earlier(~is_inside.take(first) & ~is_next_inside.take(first))


def _with_edges(walk: _Walk, nodes: Indices, face: Indices | None = None) -> CornerData | None:
    """Values at nodes, two per corner: the corner itself, then the point on the edge after it.

    Args:
        walk: the corners of the faces.
        nodes: the nodes, corner by corner.
        face: the face of which each new face is a piece; by default, they are the same.
    """
    data, edge_data = walk.faces.data, walk.edge_data
    if data is None or edge_data is None:
        return None
    values = np.stack((data.values, edge_data.values), axis=1).reshape(-1, data.values.shape[1])
    return CornerData(values.take(nodes, axis=0), data.slots if face is None else data.slots.take(face))


def _walk_of_faces(walk: _Walk, chosen: Indices) -> _Walk:
    where, _ = take_rows(walk.faces.offsets, chosen)
    faces = walk.faces.take(chosen)
    edge_data = walk.edge_data and walk.edge_data.take(where, chosen)
    return _Walk(faces, next_in_row(faces.offsets), walk.distance.take(where), walk.edge_row.take(where), edge_data)


def _rejoined(walk: _Walk, points: Floats, normals: Floats) -> Soup:
    """The pieces of faces on the kept side.

    Corners on the plane that lie in a gap become corners of the piece, so that it shares them with other faces.

    Args:
        walk: the corners of the faces.
        points: [P, 3] the table of points in metres, new ones included.
        normals: [M, 3] normal of the plane that cuts each mesh.
    """
    bridged = _bridged(walk)
    if bridged.any() and not bridged.all():
        parts = [_rejoined(_walk_of_faces(walk, np.flatnonzero(f)), points, normals) for f in (~bridged, bridged)]
        return Soup.concatenate(parts)
    faces = walk.faces
    face = row_of_value(np.diff(faces.offsets))
    along = cross(area_vectors(faces.as_one_mesh(points)), normals[faces.mesh])
    is_inside = walk.distance > 0.0
    changes = is_inside != is_inside.take(walk.following)
    gaps = _gaps(walk, face, points, along)
    touching, gap, position = _corners_in_gaps(walk, face, points, along, gaps)

    # Two nodes per corner: the corner itself, then the point where the edge after it leaves or enters.
    rows = np.stack((faces.rows, walk.edge_row), axis=1).ravel()
    chains = np.flatnonzero(np.stack((is_inside, changes), axis=1).ravel())
    offsets = offsets_from_counts(sum_rows(is_inside + changes.view(np.int8), faces.offsets))
    successor = np.zeros(len(rows), np.int64)
    successor[chains] = chains.take(next_in_row(offsets))
    here, there = _bridges(gaps, touching, gap, position)
    successor[here] = there

    nodes = np.sort(np.concatenate((chains, 2 * touching)))
    renumbered = np.empty(len(rows), np.int64)
    renumbered[nodes] = np.arange(len(nodes))
    cycle, loop_offsets = cycles(renumbered[successor[nodes]])
    at_cut = np.zeros(len(loop_offsets) - 1, np.bool_)
    if bridged.any():
        node_face, exits = face[nodes // 2], renumbered[2 * gaps.leaving + 1]
        cycle, loop_offsets, at_cut = joined_over_bridges(cycle, loop_offsets, rows[nodes], node_face, exits)
    root = nodes[cycle[loop_offsets[:-1]]]
    source = face[root // 2]
    data = _with_edges(walk, nodes[cycle], source)
    loops = Soup(rows[nodes[cycle]], loop_offsets, faces.mesh[source], faces.rank[source], faces.tags[source], data)
    # The rest of the first edge of a face is its first node, if that belongs to its first corner.
    has_first = (root == chains[offsets[:-1]][source]) & (root // 2 == faces.offsets[:-1][source])
    keeps_first = np.zeros(len(offsets) - 1, bool)
    keeps_first[source[has_first]] = True
    return loops.begun_earlier(~keeps_first[source] & ~at_cut).without_repeats()


def _bridged(walk: _Walk) -> Flags:
    """[F] whether faces pass an edge in both directions: the bridge to a hole."""
    faces = walk.faces
    flags = np.zeros(len(faces.offsets) - 1, np.bool_)
    if not len(faces.rows):
        return flags
    face, start, end = row_of_value(np.diff(faces.offsets)), faces.rows, faces.rows.take(walk.following)
    # Few faces pass a point twice, and only those can pass an edge twice.
    num_rows = int(faces.rows.max()) + 1
    visits = np.sort(face * num_rows + start)
    again = visits[1:][visits[1:] == visits[:-1]]
    if len(again):
        chosen = np.isin(face, again // num_rows)
        sides = np.column_stack((face, np.minimum(start, end), np.maximum(start, end)))[chosen]
        distinct, counts = np.unique(sides, axis=0, return_counts=True)
        flags[distinct[counts > 1, 0]] = True
    return flags


@dataclass(frozen=True, slots=True)
class _Gaps:
    """G gaps in what remains of faces, sorted by face and along the cut."""

    leaving: Indices
    """[G] the corner before the edge at which a gap begins."""
    entering: Indices
    """[G] the corner before the edge at which it ends."""
    start: Floats
    """[G] its beginning along the cut."""
    end: Floats
    """[G] its end along the cut, before or after `start`."""


def _gaps(walk: _Walk, face: Indices, points: Floats, along: Floats) -> _Gaps:
    is_inside = walk.distance > 0.0
    is_next_inside = is_inside.take(walk.following)
    ends = []
    for corners in (np.flatnonzero(is_inside & ~is_next_inside), np.flatnonzero(~is_inside & is_next_inside)):
        here, there = walk.faces.rows[corners], walk.faces.rows[walk.following[corners]]
        inner, outer = np.where(is_inside[corners], here, there), np.where(is_inside[corners], there, here)
        direction = along[face[corners]]
        depth = np.abs(walk.distance[walk.following[corners]] - walk.distance[corners])
        # Edges that meet the plane in one point are sorted by their position slightly further inside.
        drift = dot(points[inner] - points[outer], direction) / depth
        position = dot(points[walk.edge_row[corners]], direction)
        order = np.lexsort((drift, position, face[corners]))
        ends.append((corners[order], position[order]))
    (leaving, start), (entering, end) = ends
    return _Gaps(leaving, entering, start, end)


def _corners_in_gaps(
    walk: _Walk, face: Indices, points: Floats, along: Floats, gaps: _Gaps
) -> tuple[Indices, Indices, Floats]:
    """Corners [T] on the plane within a gap, the gap of each, and its position in the gap."""
    on_plane = walk.distance == 0.0
    on_plane[walk.following[gaps.leaving]] = False
    on_plane[gaps.entering] = False
    corner = np.flatnonzero(on_plane)
    position = dot(points[walk.faces.rows[corner]], along[face[corner]])
    low, high = np.minimum(gaps.start, gaps.end), np.maximum(gaps.start, gaps.end)

    # A sweep along the cut of each face; at one place gaps end first and begin last.
    gap_face = face[gaps.leaving]
    count, spare = len(gap_face), len(corner)
    kind = np.repeat([0, 1, 2], [count, spare, count])
    order = np.lexsort(
        (kind, np.concatenate((high, position, low)), np.concatenate((gap_face, face[corner], gap_face)))
    )
    is_open = np.cumsum(np.array([-1, 0, 1])[kind[order]])
    latest = np.maximum.accumulate(np.where(kind[order] == 2, np.arange(len(order)), -1))
    inside = np.flatnonzero((kind[order] == 1) & (is_open == 1))
    gap = order[latest[inside]] - count - spare
    chosen = order[inside] - count
    return corner[chosen], gap, np.abs(position[chosen] - gaps.start[gap])


def _bridges(gaps: _Gaps, touching: Indices, gap: Indices, position: Floats) -> tuple[Indices, Indices]:
    """Nodes across the gaps and the node that follows each: from the exit over the touching corners to the entry."""
    number = np.arange(len(gaps.leaving))
    nodes = np.concatenate((2 * gaps.leaving + 1, 2 * touching, 2 * gaps.entering + 1))
    of_gap = np.concatenate((number, gap, number))
    far = np.full(len(number), np.inf)
    order = np.lexsort((np.concatenate((-far, position, far)), of_gap))
    goes_on = np.flatnonzero(np.diff(of_gap[order]) == 0)
    return nodes[order[goes_on]], nodes[order[goes_on + 1]]
