"""CGA's ``setback``, ``shapeL``, ``shapeU`` and ``shapeO``: selected edges moved inwards by individual distances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, take_rows
from grammarlab.geometry.meshes.cleanup import merged_points
from grammarlab.geometry.meshes.measure import STRAIGHT
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.planar import RELATIVE_TOLERANCE, Polygons, lay_flat, rectangle_sizes, regroup
from grammarlab.geometry.meshes.vectors import cross, unit
from grammarlab.geometry.outlines.patches import Patch, alike, fill, in_order, rings, stamp, stamp_patch
from grammarlab.geometry.outlines.straight_skeleton import Loop, merge, sweep
from grammarlab.geometry.outlines.wavefront import BLUNT_CONVEX, BLUNT_REFLEX
from grammarlab.geometry.selectors import classify

REMAINDER = -1
"""Group of the remainder of a face; as the group of an edge: the edge does not move."""


@dataclass(frozen=True, slots=True)
class Setback:
    """Faces cut into strips and remainders."""

    meshes: Meshes
    """M meshes whose faces are the pieces."""
    group: Indices
    """[F] the group of the edges of each strip, or `REMAINDER`."""


def setback(meshes: Meshes, distances: Floats, groups: Indices | None = None) -> Setback:
    """Strips swept by edges of faces that move inwards, and remainders.

    Strips of neighbouring edges of one group are one piece, which begins with its first edge; a strip around the whole
    face has a keyhole. A strip that passes a fixed edge may have several parts. The remainder of a face, which
    may be several pieces, begins at the first edge of which it has a part. Between moved edges strips are mitred.
    Beside an edge that stays, or moves less, a strip ends on the line of that edge, as far as that has moved; on the
    bisector where the outline turns left by at most 15 or right by at most 45 degrees, as in CityEngine. An edge of a
    step in the outline that its neighbours pass has no strip, and theirs end at the step. Pieces are ordered by face,
    then by first edge, the remainder last. A face without area, or whose edges cross, is its own remainder.

    Args:
        meshes: M meshes.
        distances: [C] setback of the edge that leaves each corner, in metres; an edge does not move if it is not
            above 0 (relative to the size of the face). It may be infinite; beyond 31,623 sizes of the face all are
            equal.
        groups: [C] strips of different groups are kept apart, `REMAINDER` leaves an edge where it is; every edge of a
            face is its own group when left out.
    """
    polygons = lay_flat(meshes)
    edge_number = np.arange(len(distances)) - np.repeat(polygons.offsets[:-1], polygons.counts)
    group = edge_number if groups is None else groups
    extents = polygons.extents()[polygons.face_of_corner()]
    moves = (group != REMAINDER) & (distances > RELATIVE_TOLERANCE * extents)
    # Of an edge without limit only its speed matters. Halfway to the tolerance, so that others still move by more than
    # that while it crosses the face, but by less than is seen (0.1 mm on a lot of 30 m, if their distance is 4 m).
    most = extents / math.sqrt(RELATIVE_TOLERANCE)
    moved = np.where(moves, np.minimum(distances, most), 0.0)
    rectangular, sizes = rectangle_sizes(polygons)
    fast = _fitting(polygons, np.flatnonzero(rectangular), sizes, moved)
    batches: list[Meshes] = []
    rows: list[Indices] = []
    leads: list[Indices] = []
    for members, faces, edges in _by_pattern(polygons, fast, moved, group):
        xy = _rectangle_nodes(sizes[members], moved[_four(polygons, members)])
        batches.append(stamp(polygons, members, xy, np.zeros(xy.shape[:2]), range(4), faces, [0] * len(faces)))
        rows.append(members)
        leads.append(_lead_corners(polygons, members, edges))
    slow = np.setdiff1d(np.arange(len(polygons)), fast)
    keys = [_parameters(polygons, row, moved, group) for row in slow.tolist()]
    for members, xy, (steps, names) in alike(polygons, slow, keys):
        patch, edges = _setback_patch(xy, steps, names)
        batches.append(stamp_patch(polygons, members, patch))
        rows.append(members)
        leads.append(_lead_corners(polygons, members, edges))
    if not batches:
        return Setback(meshes, np.zeros(0, np.int64))
    return _assembled(meshes, batches, rows, leads, group)


def wing_depths(meshes: Meshes, depths: Mapping[str, Floats | float]) -> Floats:
    """[C] setbacks in metres of the edges that leave corners, for CGA's ``shapeL``, ``shapeU`` and ``shapeO``.

    The wings are the strips of `setback` with all edges in one group; what remains is the rest.

    Args:
        meshes: M meshes, in the axes of their scopes.
        depths: [M] or one for all: depth of the wing on each of the sides ``front``, ``right``, ``back``, ``left``.
    """
    outward = edge_normals(meshes)
    mesh = meshes.mesh_of_face()[meshes.face_of_corner()]
    distances = np.zeros(len(meshes.corners))
    for side, depth in depths.items():
        chosen = classify(outward, side)
        distances[chosen] = np.broadcast_to(np.asarray(depth, np.float64), len(meshes))[mesh[chosen]]
    return distances


def edge_normals(meshes: Meshes) -> Floats:
    """[C, 3] for the edge that leaves each corner, the unit normal that points out of its face within its plane."""
    polygons = lay_flat(meshes)
    along = polygons.points[polygons.next_corner()] - polygons.points
    return unit(cross(along, polygons.axes[polygons.face_of_corner(), 2]))


def _four(polygons: Polygons, rectangles: Indices) -> Indices:
    """[K, 4] the corners of rectangles."""
    return polygons.offsets[rectangles][:, None] + np.arange(4)


def _fitting(polygons: Polygons, rectangles: Indices, sizes: Floats, moved: Floats) -> Indices:
    """Whether rectangles have a remainder."""
    steps = moved[_four(polygons, rectangles)]
    across = np.stack([steps[:, 1] + steps[:, 3], steps[:, 0] + steps[:, 2]], axis=1)
    return rectangles[(across < sizes[rectangles] * (1.0 - RELATIVE_TOLERANCE)).all(axis=1)]


def _rectangle_nodes(sizes: Floats, steps: Floats) -> Floats:
    """[K, 8, 2] corners of rectangles, then of their remainders after steps [K, 4] of their edges."""
    width, depth = sizes.T
    x = np.stack([0.0 * width, width, width, 0.0 * width], axis=1)
    y = np.stack([0.0 * depth, 0.0 * depth, depth, depth], axis=1)
    left, right = steps[:, 3], width - steps[:, 1]
    bottom, top = steps[:, 0], depth - steps[:, 2]
    inner_x = np.stack([left, right, right, left], axis=1)
    inner_y = np.stack([bottom, bottom, top, top], axis=1)
    return np.stack([np.concatenate([x, inner_x], axis=1), np.concatenate([y, inner_y], axis=1)], axis=2)


def _by_pattern(
    polygons: Polygons, rectangles: Indices, moved: Floats, group: Indices
) -> list[tuple[Indices, list[Loop], list[int]]]:
    """Rectangles by which edges move and which of those share a group, with the pieces over `_rectangle_nodes`."""
    corner = _four(polygons, rectangles)
    names = group[corner]
    first_alike = (names[:, :, None] == names[:, None, :]).argmax(axis=2)
    pattern = np.where(moved[corner] > 0.0, first_alike, REMAINDER)
    distinct, inverse = np.unique(pattern, axis=0, return_inverse=True)
    return [(rectangles[inverse.ravel() == i], *_rectangle_pieces(names)) for i, names in enumerate(distinct.tolist())]


def _rectangle_pieces(names: Sequence[int]) -> tuple[list[Loop], list[int]]:
    """Strips and remainder of a rectangle, and their first edges."""
    inner = [4 + i if max(names[i], names[i - 1]) >= 0 else i for i in range(4)]
    strips: dict[int, tuple[Loop, ...]] = {
        i: ((i, (i + 1) % 4, inner[(i + 1) % 4], inner[i]),) for i in range(4) if names[i] >= 0
    }
    if list(names) == [0, 0, 0, 0]:
        pieces: list[tuple[int, Loop]] = [(0, (0, 1, 5, 4, 7, 6, 5, 1, 2, 3))]
    else:
        pieces = sorted(
            piece for loops, edge_of in _joined(strips, names) for piece in _from_first_edge(loops, edge_of)
        )
    pieces.append((REMAINDER, tuple(inner)))
    return [face for _, face in pieces], [lead for lead, _ in pieces]


def _joined(
    strips: dict[int, tuple[Loop, ...]], names: Sequence[int], xy: Floats | None = None, num_corners: int = 0
) -> list[tuple[list[Loop], dict[tuple[int, ...], int]]]:
    """For each group the outlines and holes of the strips of its edges, and these edges by the nodes at their ends.

    Args:
        strips: the area that each edge sweeps.
        names: [C] group of the edge that leaves each corner.
        xy: [N, 2] the nodes, if strips may have parts of edges in common.
        num_corners: number of nodes at the beginning that are corners of the polygon.
    """
    groups: dict[int, list[int]] = {}
    for edge in strips:
        groups.setdefault(names[edge], []).append(edge)
    result = []
    for edges in groups.values():
        areas = [loop for edge in edges for loop in strips[edge]]
        loops = merge(areas) if xy is None or len(edges) == 1 else _merged(xy, areas, num_corners)
        result.append((loops, {strips[edge][0][:2]: edge for edge in edges}))
    return result


def _merged(xy: Floats, areas: Sequence[Loop], num_corners: int) -> list[Loop]:
    """The outlines of areas, also where an edge of one is a part of an edge of another.

    The outlines have no corners there, but for those of the polygon, which are the first of the nodes, and for the
    places to which its corners in straight lines move.
    """
    slack = RELATIVE_TOLERANCE * float(np.ptp(xy, axis=0).max())
    first = merged_points(np.column_stack((xy, np.zeros(len(xy)))), slack).tolist()
    welded = [tuple(first[node] for node in area) for area in areas]
    nodes = sorted({node for area in welded for node in area})
    divided = [tuple(node for arc in _arcs(area) for node in _divided(xy, arc, nodes, slack)) for area in welded]
    from_corner = {area[0]: area for area in welded}
    to_corner = {area[1]: area for area in welded}
    straight = {
        from_corner[corner][-1]
        for corner in from_corner.keys() & to_corner.keys()
        if _is_between(xy[corner], xy[to_corner[corner][0]], xy[from_corner[corner][1]], slack)[0]
    }
    outlines = []
    for loop in merge(divided):
        bends = tuple(
            node
            for before, node, after in zip((loop[-1], *loop[:-1]), loop, (*loop[1:], loop[0]), strict=True)
            if node < num_corners or node in straight or not _is_between(xy[node], xy[before], xy[after], slack)[0]
        )
        outlines.append(bends)
    return outlines


def _arcs(loop: Loop) -> list[tuple[int, int]]:
    return list(zip(loop, loop[1:] + loop[:1], strict=True))


def _divided(xy: Floats, arc: tuple[int, int], nodes: Sequence[int], slack: float) -> list[int]:
    """The beginning of an edge and the nodes within it, in order."""
    within, share = _is_between(xy[list(nodes)], xy[arc[0]], xy[arc[1]], slack)
    places = [(float(share[i]), nodes[i]) for i in np.flatnonzero(within).tolist() if nodes[i] not in arc]
    return [arc[0], *(node for _, node in sorted(places))]


def _is_between(points: Floats, start: Floats, end: Floats, slack: float) -> tuple[NDArray[np.bool_], Floats]:
    """Whether points [..., 2] lie within an edge, and the share of the edge before each."""
    along = end - start
    length = float(np.hypot(*along))
    offset = points - start
    reach = (offset @ along) / max(length, slack)
    aside = np.abs(offset[..., 1] * along[0] - offset[..., 0] * along[1]) / max(length, slack)
    return (reach > slack) & (reach < length - slack) & (aside <= slack), reach


def _from_first_edge(faces: Sequence[Loop], edge_of: dict[tuple[int, ...], int]) -> list[tuple[int, Loop]]:
    """Strips of a group, each beginning with its first edge, which comes with it."""
    result = []
    for face in faces:
        arcs = _arcs(face)
        # The area that an edge sweeps behind a fixed edge may be disconnected from it.
        lead, start = min(
            ((edge_of[arc], i) for i, arc in enumerate(arcs) if arc in edge_of), default=(min(edge_of.values()), 0)
        )
        result.append((lead, face[start:] + face[:start]))
    return result


def _parameters(
    polygons: Polygons, row: int, moved: Floats, group: NDArray[np.integer]
) -> tuple[tuple[float, ...], tuple[int, ...]]:
    where = slice(polygons.offsets[row], polygons.offsets[row + 1])
    return tuple(moved[where].tolist()), tuple(group[where].tolist())


def _setback_patch(xy: Floats, steps: Sequence[float], names: Sequence[int]) -> tuple[Patch, list[int]]:
    """The pieces of a polygon, and the first edge of each."""
    loops = rings(xy)
    corners = [corner for ring in loops for corner in ring]
    moving = _without_passed_edges(loops, xy, steps)
    result = sweep([xy[ring] for ring in loops], [moving[corner] for corner in corners], 1.0, bisector_cuts=True)
    if result is None:
        whole = tuple(range(len(xy)))
        return Patch(xy, np.zeros(len(xy)), whole, (whole,), (0,)), [REMAINDER]
    strips = {i: result.faces[i] for i, corner in enumerate(corners) if moving[corner] > 0.0 and result.faces[i]}
    names = [names[corner] for corner in corners]
    passed = {i: arc for i, arc in enumerate(_ends(loops)) if moving[corners[i]] != steps[corners[i]]}
    pieces = sorted(
        piece
        for areas, edge_of in _joined(strips, names, result.xy, len(corners))
        for piece in _from_first_edge(
            fill(result.xy, areas), _with_passed(edge_of, areas, result.xy, passed, names) if passed else edge_of
        )
    )
    kept = _half_moved(loops, xy, moving)
    rest = fill(result.xy, result.rest_from_first_edge(range(len(corners))))
    pieces += [(REMAINDER, _with_corners(result.xy, face, kept)) for face in rest]
    faces = tuple(face for _, face in pieces)
    leads = [REMAINDER if edge == REMAINDER else corners[edge] for edge, _ in pieces]
    return Patch(result.xy, np.zeros(len(result.xy)), tuple(corners), faces, (0,) * len(faces)), leads


def _ends(loops: Sequence[Sequence[int]]) -> list[tuple[int, int]]:
    """The nodes at both ends of each edge, where nodes are numbered loop after loop."""
    ends: list[tuple[int, int]] = []
    for ring in loops:
        first, count = len(ends), len(ring)
        ends += [(first + i, first + (i + 1) % count) for i in range(count)]
    return ends


def _with_passed(
    edge_of: dict[tuple[int, ...], int],
    areas: Sequence[Loop],
    xy: Floats,
    passed: Mapping[int, tuple[int, int]],
    names: Sequence[int],
) -> dict[tuple[int, ...], int]:
    """The edges of a group by their ends, with those that others have passed: a strip may begin with them."""
    group = names[min(edge_of.values())]
    place_of = {(*xy[start], *xy[end]): edge for edge, (start, end) in passed.items() if names[edge] == group}
    arcs = {arc: place_of.get((*xy[arc[0]], *xy[arc[1]])) for loop in areas for arc in _arcs(loop)}
    return edge_of | {arc: edge for arc, edge in arcs.items() if edge is not None}


def _without_passed_edges(loops: Sequence[Sequence[int]], xy: Floats, steps: Sequence[float]) -> list[float]:
    """The setbacks, 0 for edges of steps that vanish: what moves past a step ends there, as in CityEngine.

    A step is a straight edge between a reflex and a convex corner, one of them not blunt, or several edges with blunt
    corners between them, with hardly turning edges before and behind it. It vanishes where these edges pass one
    another.
    """
    result = list(steps)
    for ring in loops:
        size = float(np.ptp(xy[ring], axis=0).max())
        edges = np.array(ring)[_lengths(xy[ring]) > RELATIVE_TOLERANCE * size]
        for passed in _passed_edges(xy[edges], np.array(steps)[edges], RELATIVE_TOLERANCE * size):
            for edge in edges[passed].tolist():
                result[edge] = 0.0
    return result


def _lengths(ring: Floats) -> Floats:
    return np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)


def _passed_edges(ring: Floats, steps: Floats, slack: float) -> list[Indices]:
    """The edges of each step of an outline [n, 2] that vanishes: where its ends come closer than `slack`, in metres."""
    along = (np.roll(ring, -1, axis=0) - ring) / _lengths(ring)[:, None]
    sine, cosine = _turn(np.roll(along, 1, axis=0), along)
    is_sharp = (sine < -BLUNT_REFLEX) | (sine > BLUNT_CONVEX) | (cosine <= 0.0)
    ends = [np.flatnonzero(is_sharp), np.flatnonzero(is_sharp | (np.abs(sine) > STRAIGHT))]
    start, end = np.concatenate(ends), np.concatenate([np.roll(corners, -1) for corners in ends])
    turn, total = _turn(along[start - 1], along[end])
    is_step = (sine[start] * sine[end] < 0.0) & (turn >= -BLUNT_REFLEX) & (turn <= BLUNT_CONVEX) & (total > 0.0)
    is_step &= is_sharp[start] | is_sharp[end]
    start, end = start[is_step], end[is_step]
    # Where the moved lines of the edges at both ends meet those of their neighbours, or the bisectors of blunt corners.
    before = np.where(is_sharp[start], steps[start - 1], steps[start])
    after = np.where(is_sharp[end], steps[end], steps[end - 1])
    first, last = _moved(along, steps, start), _moved(along, steps, end - 1)
    first += ((before - cosine[start] * steps[start]) / sine[start])[:, None] * along[start]
    last += ((cosine[end] * steps[end - 1] - after) / sine[end])[:, None] * along[end - 1]
    chord = ring[end] - ring[start]
    is_passed = ((chord + last - first) * chord).sum(axis=1) < slack * np.hypot(*chord.T)
    passed = zip(start[is_passed].tolist(), end[is_passed].tolist(), strict=True)
    return [np.arange(a, b if a < b else b + len(ring)) % len(ring) for a, b in passed]


def _moved(along: Floats, steps: Floats, edges: Indices) -> Floats:
    """[K, 2] how far edges move inwards."""
    return steps[edges, None] * np.stack([-along[edges, 1], along[edges, 0]], axis=1)


def _turn(before: Floats, after: Floats) -> tuple[Floats, Floats]:
    """Sines and cosines of the turns between directions [K, 2]."""
    return before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1)


def _half_moved(loops: Sequence[Sequence[int]], xy: Floats, steps: Sequence[float]) -> list[int]:
    """Reflex corners of one edge that moves and one that stays: corners of the remainder too, as in the runtime."""
    found = []
    for ring in loops:
        for before, corner, after in zip([ring[-1], *ring[:-1]], ring, [*ring[1:], ring[0]], strict=True):
            (ax, ay), (bx, by) = xy[corner] - xy[before], xy[after] - xy[corner]
            if ax * by - ay * bx < 0.0 and (steps[before] > 0.0) != (steps[corner] > 0.0):
                found.append(corner)
    return found


def _with_corners(xy: Floats, face: Loop, corners: Sequence[int]) -> Loop:
    """An outline with those of some points that lie within one of its edges as further corners."""
    result = list(face)
    for corner in corners:
        for index, (start, end) in enumerate(zip(result, [*result[1:], result[0]], strict=True)):
            along, offset = xy[end] - xy[start], xy[corner] - xy[start]
            length = float(along @ along)
            share = float(along @ offset) / length if length > 0.0 else 0.0
            aside = abs(float(along[0] * offset[1] - along[1] * offset[0]))
            if corner not in result and 0.0 < share < 1.0 and aside <= RELATIVE_TOLERANCE * length:
                result.insert(index + 1, corner)
                break
    return tuple(result)


def _lead_corners(polygons: Polygons, members: Indices, edges: Sequence[int]) -> Indices:
    """[K, P] the corner where the first edge of each piece begins, or `REMAINDER`."""
    lead = np.array(edges, np.int64)
    return np.where(lead == REMAINDER, REMAINDER, polygons.offsets[members][:, None] + lead)


def _assembled(
    meshes: Meshes, batches: Sequence[Meshes], rows: Sequence[Indices], leads: Sequence[Indices], group: Indices
) -> Setback:
    pieces_per_face = np.concatenate([np.full(len(lead), lead.shape[1]) for lead in leads])
    order = np.argsort(np.concatenate(rows), kind="stable")
    offsets = np.concatenate([[0], np.cumsum(pieces_per_face)])
    where, _ = take_rows(offsets, order)
    lead = np.concatenate([lead.ravel() for lead in leads])[where]
    labels = np.where(lead == REMAINDER, REMAINDER, group[np.maximum(lead, 0)])
    return Setback(regroup(in_order(batches, rows), meshes.mesh_faces), labels)
