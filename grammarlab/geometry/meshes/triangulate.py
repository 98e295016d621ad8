"""Triangles that cover the faces of meshes, and keyholes: holes joined to their outline by a doubled edge."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, index_in_row, offsets_from_counts, row_of_value, take_rows
from grammarlab.geometry.meshes.measure import face_normals, is_reflex
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.ragged import sum_rows


def triangulate(meshes: Meshes) -> tuple[Indices, Indices]:
    """Triangles with the orientation of their faces; no new points.

    Convex faces and all quads become fans, computed for all of them at once; other concave faces are triangulated by
    ear clipping. Faces of fewer than three corners have no triangles.

    Returns:
        [T, 3] rows of `Meshes.points`, and [T] the face of each triangle, ascending.
    """
    counts = np.diff(meshes.face_offsets)
    needs_look = np.flatnonzero(counts > 3)
    shift = np.zeros(len(counts), np.int64)
    is_irregular = np.zeros(len(counts), bool)
    if len(needs_look):
        shift[needs_look], is_irregular[needs_look] = _concavity(_subset(meshes, needs_look))
    fanned = np.flatnonzero(~is_irregular & (counts >= 3))
    triangles, face = _fans(meshes, fanned, shift[fanned])
    irregular = np.flatnonzero(is_irregular)
    if not len(irregular):
        return triangles, face
    clipped, clipped_face = _ears(meshes, irregular)
    triangles, face = np.concatenate((triangles, clipped)), np.concatenate((face, clipped_face))
    order = np.argsort(face, kind="stable")
    return triangles[order], face[order]


def keyhole(rings: Sequence[Floats]) -> Indices:
    """One cycle around an outline and all its holes.

    Holes are joined in descending order of their largest x. One that touches a corner that is already in the cycle is
    joined there; any other one from its first corner to the nearest visible corner, or from that of largest x if the
    first sees none.

    Args:
        rings: [n, 2] corners of the outline, counter-clockwise, then of each hole, clockwise.

    Returns:
        Indices into the corners of all rings, one after the other; both ends of every bridge appear twice. The
        first corner and edge are those of the outline.
    """
    points = np.concatenate(rings)
    starts = np.cumsum([0, *map(len, rings)])
    edges = np.concatenate(
        [np.column_stack((ring, np.roll(ring, -1))) for ring in (np.arange(a, b) for a, b in _spans(starts))]
    )
    place = _places(points)
    walk = np.arange(starts[1])
    for hole in sorted(range(1, len(rings)), key=lambda k: -float(rings[k][:, 0].max())):
        ring = np.arange(starts[hole], starts[hole + 1])
        touched = _touched(points, place, walk, ring)
        if touched is not None:
            index, first = touched
            # Before the corner, so that every corner keeps the edge that leaves it.
            walk = np.insert(walk, index or len(walk), np.roll(ring, -first))
            continue
        index, first = _bridge(points, walk, edges, ring)
        tip = int(ring[first])
        # The cycle begins with the first edge of the outline, which is never a bridge.
        head, tail = (walk[: index + 1], walk[index:]) if index else (np.append(walk, walk[0]), walk[:0])
        walk = np.concatenate((head, np.roll(ring, -first), [tip], tail))
        edges = np.vstack((edges, [[walk[index], tip]]))
    return walk


def joined_over_bridges(
    cycle: Indices, offsets: Indices, row: Indices, face: Indices, exits: Indices
) -> tuple[Indices, Indices, Flags]:
    """Loops that a cut leaves of faces with holes: those on both sides of an opened bridge are one.

    A loop that passes the cut begins with its first part, as in the runtime.

    Args:
        cycle: [N] nodes, loop after loop.
        offsets: [L + 1] into `cycle`.
        row: [N] point of each node.
        face: [N] face of each node; all of them have bridges.
        exits: nodes at which loops leave for the cut, the first part last.

    Returns:
        The loops, and whether each begins at the cut.
    """
    loops = [cycle[a:b].tolist() for a, b in pairwise(offsets.tolist())]
    of_loop = face[cycle[offsets[:-1]]]
    for number in np.unique(of_loop).tolist():
        members = np.flatnonzero(of_loop == number).tolist()
        while (opened := _opened(loops, members, row)) is not None:
            (one, i), (other, k) = opened
            # Without the bridge, and with its ends once.
            whole = [*loops[one][i + 1 :], *loops[one][: i + 1]]
            rest = [*loops[other][k + 1 :], *loops[other][: k + 1]]
            loops[one], loops[other] = [*whole, *rest[1:-1]], []
            members.remove(other)
    remaining = [loop for loop in loops if loop]
    at_cut = np.zeros(len(remaining), np.bool_)
    rank = {node: i for i, node in enumerate(exits.tolist())}
    for number, loop in enumerate(remaining):
        start = max(range(len(loop)), key=lambda i: rank.get(loop[i], -1))
        at_cut[number] = loop[start] in rank
        remaining[number] = [*loop[start:], *loop[:start]] if at_cut[number] else loop
    flat = np.array([node for loop in remaining for node in loop], np.int64)
    return flat, offsets_from_counts(np.array([len(loop) for loop in remaining], np.int64)), at_cut


def _opened(
    loops: Sequence[Sequence[int]], members: Sequence[int], row: Indices
) -> tuple[tuple[int, int], tuple[int, int]] | None:
    """Two loops of a face that pass an edge in opposite directions: both loops, and the nodes where it begins."""
    passed: dict[tuple[int, int], tuple[int, int]] = {}
    for number in members:
        ends = [int(row[node]) for node in loops[number]]
        for i, arc in enumerate(zip(ends, [*ends[1:], ends[0]], strict=True)):
            opposite = passed.get((arc[1], arc[0]))
            if opposite is not None and opposite[0] != number:
                return opposite, (number, i)
            passed[arc] = (number, i)
    return None


def contains(outline: Floats, inner: Floats) -> bool:
    """Whether most corners of a ring [m, 2] lie inside another ring [n, 2] that it does not cross."""
    a, b = outline, np.roll(outline, -1, axis=0)
    x, y = inner[:, :1], inner[:, 1:]
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
    crossing = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / rise
    odd = np.count_nonzero(spans & (x < crossing), axis=1) % 2 == 1
    return bool(2 * np.count_nonzero(odd) > len(inner))


def _concavity(faces: Meshes) -> tuple[Indices, NDArray[np.bool_]]:
    """For faces of four corners or more: the corner to fan from, and whether a fan is not enough.

    A quad with one reflex corner is covered by the fan from that corner.
    """
    reflex = is_reflex(faces)
    if not reflex.any():
        return np.zeros(faces.num_faces, np.int64), np.zeros(faces.num_faces, bool)
    counts = np.diff(faces.face_offsets)
    num_reflex = sum_rows(reflex, faces.face_offsets)
    is_dart = (counts == 4) & (num_reflex == 1)
    place_of_reflex = sum_rows(np.where(reflex, index_in_row(counts), 0), faces.face_offsets)
    return np.where(is_dart, place_of_reflex, 0), (num_reflex > 0) & ~is_dart


def _subset(meshes: Meshes, faces: Indices) -> Meshes:
    """Some of the faces as one mesh over the same points."""
    where, face_offsets = take_rows(meshes.face_offsets, faces)
    return Meshes(
        points=meshes.points,
        corners=meshes.corner_points()[where],
        face_offsets=face_offsets,
        mesh_faces=np.array([0, len(faces)]),
        mesh_points=np.array([0, len(meshes.points)]),
        tags=meshes.tags[faces],
    )


def _fans(meshes: Meshes, faces: Indices, shift: Indices) -> tuple[Indices, Indices]:
    """Triangles (c, c + k, c + k + 1) of faces, where c is the corner numbered `shift`."""
    starts = meshes.face_offsets[faces]
    sizes = meshes.face_offsets[faces + 1] - starts
    per_face = sizes - 2
    row = row_of_value(per_face)
    first = shift[row]
    second = first + index_in_row(per_face) + 1
    third = second + 1
    if shift.any():
        size = sizes[row]
        second, third = second % size, third % size
    corners = np.stack((first, second, third), axis=1) + starts[row][:, None]
    return meshes.corner_points().take(corners), faces[row]


def _ears(meshes: Meshes, faces: Indices) -> tuple[Indices, Indices]:
    """Triangles of concave faces, by ear clipping in the coordinate plane nearest to each face."""
    # Only batches with concave faces load the library.
    from mapbox_earcut import triangulate_float64  # noqa: PLC0415

    selected = _subset(meshes, faces)
    rows = selected.corner_points()
    flat = _flattened(selected, rows)
    triangles: list[Indices] = []
    for start, end in _spans(selected.face_offsets):
        ring = np.array([end - start], np.uint32)
        triangles.append(triangulate_float64(flat[start:end], ring).astype(np.int64) + start)
    per_face = np.array([len(part) // 3 for part in triangles], np.int64)
    corners = np.concatenate(triangles).reshape(-1, 3)
    a, b, c = flat[corners[:, 0]], flat[corners[:, 1]], flat[corners[:, 2]]
    corners = np.where((_turn(a, b, c) < 0.0)[:, None], corners[:, ::-1], corners)
    return rows[corners], faces[row_of_value(per_face)]


def _flattened(meshes: Meshes, rows: Indices) -> Floats:
    """[C, 2] corners without the coordinate along which the face normal is longest, still counter-clockwise."""
    normals = face_normals(meshes)[meshes.face_of_corner()]
    dropped = np.argmax(np.abs(normals), axis=1)
    corner = np.arange(len(rows))
    points = meshes.points[rows]
    u, v = points[corner, (dropped + 1) % 3], points[corner, (dropped + 2) % 3]
    u = np.where(normals[corner, dropped] < 0.0, -u, u)
    return np.column_stack((u, v))


def _spans(offsets: NDArray[np.integer]) -> list[tuple[int, int]]:
    return list(pairwise(offsets.tolist()))


def _places(points: Floats) -> Indices:
    """[N] a number for each point, equal for equal points."""
    places: dict[tuple[float, ...], int] = {}
    return np.array([places.setdefault(tuple(point), len(places)) for point in points.tolist()], np.int64)


def _touched(points: Floats, place: Indices, walk: Indices, ring: Indices) -> tuple[int, int] | None:
    """Index in the walk, and in the ring of a hole, of a corner at which both touch."""
    shared = np.isin(place[ring], place[walk])
    if not shared.any():
        return None
    first = int(np.argmax(shared))
    visits = np.flatnonzero(place[walk] == place[ring[first]])
    # Where several rings touch, the hole lies within the angle of one visit.
    within = _in_corner(points, walk, visits, int(ring[(first + 1) % len(ring)]))
    return int(visits[np.argmax(within)]), first


def _bridge(points: Floats, walk: Indices, edges: Indices, ring: Indices) -> tuple[int, int]:
    """Index in the walk, and in the ring of a hole, of the corners between which to join them."""
    farthest = int(np.argmax(points[ring, 0]))
    # Only the corner of largest x surely sees a corner of the walk: others may see just holes that are not in it. Even
    # that one sees none if it lies on an edge.
    for first in dict.fromkeys((0, farthest, *range(len(ring)))):
        index = _visible(points, walk, edges, int(ring[first]))
        if index is not None:
            return index, first
    return int(_nearest(points, walk, int(ring[farthest]))[0]), farthest


def _visible(points: Floats, walk: Indices, edges: Indices, tip: int) -> int | None:
    """Index in the walk of the nearest corner to which a bridge from the tip meets no edge."""
    nearest = _nearest(points, walk, tip)
    nearest = nearest[_in_corner(points, walk, nearest, tip)]
    begin, end, here = points[edges[:, 0]], points[edges[:, 1]], points[tip]
    while len(nearest):
        blocking = np.flatnonzero(_blocks(begin, end, points[walk[nearest[0]]], here))
        if not len(blocking):
            return int(nearest[0])
        # All corners behind the edge that hides most are out of sight, too; so only few are looked at.
        to_begin, to_end = begin[blocking] - here, end[blocking] - here
        angle = np.arctan2(np.abs(_cross(to_begin, to_end)), (to_begin * to_end).sum(axis=1))
        widest = blocking[np.argmax(angle)]
        nearest = nearest[~_blocks(begin[widest], end[widest], points[walk[nearest]], here)]
    return None


def _nearest(points: Floats, walk: Indices, tip: int) -> Indices:
    """Indices in the walk, the corners nearest to the tip first."""
    distance = np.hypot(*(points[walk] - points[tip]).T)
    return np.argsort(distance, kind="stable")


def _in_corner(points: Floats, walk: Indices, index: Indices, tip: int) -> Flags:
    """Whether the tip lies within the interior angles of the walk at these indices."""
    before, here, after = (points[walk[(index + k) % len(walk)]] for k in (-1, 0, 1))
    left_of_out = _turn(here, after, points[tip]) > 0.0
    left_of_in = _turn(before, here, points[tip]) > 0.0
    is_convex = _turn(before, here, after) > 0.0
    return np.where(is_convex, left_of_out & left_of_in, left_of_out | left_of_in)


def _turn(a: Floats, b: Floats, c: Floats) -> Floats:
    """Twice the signed area of triangles: positive if c lies to the left of the line from a to b."""
    return _cross(b - a, c - a)


def _cross(u: Floats, v: Floats) -> Floats:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def _blocks(a: Floats, b: Floats, p: Floats, q: Floats) -> Flags:
    """Whether edges from a to b meet bridges from p to q elsewhere than at a common end, or lie on them."""
    side_a, side_b = _turn(p, q, a), _turn(p, q, b)
    meets = (side_a * side_b <= 0.0) & (_turn(a, b, p) * _turn(a, b, q) <= 0.0)
    # Collinear edges always pass both tests; only those that overlap the bridge block it.
    low, high = np.maximum(np.minimum(a, b), np.minimum(p, q)), np.minimum(np.maximum(a, b), np.maximum(p, q))
    meets &= (low[..., 0] <= high[..., 0]) & (low[..., 1] <= high[..., 1])
    lies_along = (side_a == 0.0) & (side_b == 0.0) & ((low[..., 0] < high[..., 0]) | (low[..., 1] < high[..., 1]))
    is_common = _equal(a, p) | _equal(a, q) | _equal(b, p) | _equal(b, q)
    return meets & (~is_common | lies_along)


def _equal(a: Floats, b: Floats) -> Flags:
    return (a[..., 0] == b[..., 0]) & (a[..., 1] == b[..., 1])
