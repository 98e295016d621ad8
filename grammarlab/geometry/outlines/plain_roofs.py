"""Pyramid, shed and single-ridge roofs: formulas over the corners of all faces, without a skeleton."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, offsets_from_counts, take_rows
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.planar import (
    RELATIVE_TOLERANCE,
    Polygons,
    lay_flat,
    rectangle_sizes,
    regroup,
    signed_areas,
    sums_by_row,
)
from grammarlab.geometry.outlines.patches import Patch, alike, fill, in_order, rings, stamp, stamp_patch
from grammarlab.geometry.outlines.straight_skeleton import Loop, loop_area, trace

_RECTANGLE_FACES = (
    ((1, 0, 3, 2), (0, 1, 5, 4), (2, 3, 4, 5), (1, 2, 5), (3, 0, 4)),
    ((1, 0, 3, 2), (1, 2, 5, 4), (3, 0, 4, 5), (0, 1, 4), (2, 3, 5)),
)
"""Underside, slopes and sides of a rectangle whose ridge (4, 5) runs along its first edge, or along its second."""
_UNDERSIDE, _SLOPE = -2, -1
"""Ranks of these faces before those of the sides, which are numbers of edges."""
_FEWEST_WITH_HOLE = 8
"""Corners of a triangle with a triangular hole and the bridge between them."""


def pyramids(meshes: Meshes, amount: Floats, is_height: bool) -> Meshes:
    """See `grammarlab.geometry.outlines.roofs.roof_pyramid`.

    Args:
        meshes: M meshes.
        amount: [F] heights in metres, or slopes (rise over run) from the middle of the first edge to the tip.
        is_height: whether `amount` has heights.
    """
    rims = _rims(lay_flat(meshes))
    polygons, face = rims.polygons, rims.polygons.face_of_corner()
    count = np.maximum(polygons.counts, 1)
    tip = sums_by_row(face, len(polygons), polygons.xy) / count[:, None]
    height = amount if is_height else amount * _distance_from_first_edge(polygons, tip)
    tips = polygons.lift(np.arange(len(polygons)), tip[:, None], height[:, None])[:, 0]
    edge = np.flatnonzero(rims.is_edge & ~rims.is_flat[face])
    over = len(polygons.xy) + face[edge]
    triangles = np.stack([rims.first_corner[edge], rims.first_corner[polygons.next_corner()[edge]], over], axis=1)
    sides = _Faces(face[edge], edge - polygons.offsets[face[edge]], np.full(len(edge), 3), triangles.ravel())
    points = np.concatenate([polygons.points, tips])
    owner = np.concatenate([face, np.arange(len(polygons))])
    return regroup(_solids(points, owner, len(polygons), [sides, _undersides(rims)]), meshes.mesh_faces)


def sheds(meshes: Meshes, amount: Floats, is_height: bool, index: Indices) -> Meshes:
    """See `grammarlab.geometry.outlines.roofs.roof_shed`.

    Args:
        meshes: M meshes.
        amount: [F] heights in metres, or slopes (rise over run); negative ones fall from the edge.
        is_height: whether `amount` has heights.
        index: [F] the edge from which the slope rises, counted cyclically.
    """
    rims = _rims(lay_flat(meshes))
    polygons, face = rims.polygons, rims.polygons.face_of_corner()
    count = np.maximum(polygons.counts, 1)
    lead = np.minimum(polygons.offsets[:-1] + index % count, max(len(polygons.xy) - 1, 0))
    start = polygons.xy[lead]
    along = polygons.xy[polygons.next_corner()[lead]] - start
    length = np.hypot(along[:, 0], along[:, 1])
    along = np.where((length > 0.0)[:, None], along, [1.0, 0.0]) / np.where(length > 0.0, length, 1.0)[:, None]
    relative = polygons.xy - start[face]
    ahead = along[face, 0] * relative[:, 1] - along[face, 1] * relative[:, 0]
    nearest, farthest = np.full(len(polygons), np.inf), np.full(len(polygons), -np.inf)
    np.minimum.at(nearest, face, ahead)
    np.maximum.at(farthest, face, ahead)
    depth = np.where(polygons.counts > 0, farthest - nearest, 0.0)
    solid = depth > 0.0
    slope = np.where(solid, amount / np.where(solid, depth, 1.0), 0.0) if is_height else amount
    rise = slope[face]
    height = np.where(rise >= 0.0, rise * (ahead - nearest[face]), rise * (ahead - farthest[face]))
    return regroup(_prisms(rims, height, lead), meshes.mesh_faces)


def ridges(meshes: Meshes, amount: Floats, is_height: bool) -> Meshes:
    """See `grammarlab.geometry.outlines.roofs.roof_ridge`.

    Args:
        meshes: M meshes; ridges run along their x axis.
        amount: [F] heights in metres, or slopes (rise over run).
        is_height: whether `amount` has heights.
    """
    polygons = lay_flat(meshes)
    direction = _directions(polygons)
    rectangular, sizes = rectangle_sizes(polygons)
    batches: list[Meshes] = []
    rows: list[Indices] = []
    is_aligned = np.zeros(len(polygons), np.bool_)
    for kind in range(2):
        parallel = np.abs(direction[:, 1 - kind]) <= RELATIVE_TOLERANCE
        members = np.flatnonzero(rectangular & parallel)
        is_aligned[members] = True
        if len(members):
            half = 0.5 * sizes[members, 1 - kind]
            xy = _rectangle_nodes(sizes[members], kind)
            height = np.zeros(xy.shape[:2])
            height[:, 4:] = (amount[members] if is_height else amount[members] * half)[:, None]
            batches.append(stamp(polygons, members, xy, height, range(4), _RECTANGLE_FACES[kind], (0,) * 5))
            rows.append(members)
    slow = np.flatnonzero(~is_aligned)
    keys = [(x, y, value) for (x, y), value in zip(direction[slow].tolist(), amount[slow].tolist(), strict=True)]
    for members, xy, (x, y, value) in alike(polygons, slow, keys):
        batches.append(stamp_patch(polygons, members, _ridge_patch(xy, np.array([x, y]), value, is_height)))
        rows.append(members)
    if not batches:
        return meshes
    return regroup(in_order(batches, rows), meshes.mesh_faces)


def _distance_from_first_edge(polygons: Polygons, tip: Floats) -> Floats:
    """[F] metres from the middle of the first edges to tips [F, 2]; 0 where there is no edge."""
    result = np.zeros(len(polygons))
    filled = np.flatnonzero(polygons.counts > 0)
    start = polygons.offsets[:-1][filled]
    middle = 0.5 * (polygons.xy[start] + polygons.xy[polygons.next_corner()[start]])
    result[filled] = np.hypot(*(tip[filled] - middle).T)
    return result


@dataclass(frozen=True, slots=True)
class _Rims:
    """Faces of a batch as the base of solids: corners at one place are one point, bridges are not edges."""

    polygons: Polygons
    first_corner: Indices
    """[C] the first corner of the same face at the same position."""
    is_edge: NDArray[np.bool_]
    """[C] whether the edge that leaves a corner is a real one, with length, and no side of a bridge."""
    is_flat: NDArray[np.bool_]
    """[F] whether faces have no area; they do not change."""


def _rims(polygons: Polygons) -> _Rims:
    face, following = polygons.face_of_corner(), polygons.next_corner()
    first_corner = np.arange(len(face))
    if (polygons.counts >= _FEWEST_WITH_HOLE).any():
        _, first, inverse = np.unique(
            np.column_stack([face, polygons.points]), axis=0, return_index=True, return_inverse=True
        )
        first_corner = first[inverse.ravel()]
    is_edge = first_corner != first_corner[following]
    if (first_corner != np.arange(len(face))).any():
        size = max(len(face), 1)
        forth, back = first_corner * size + first_corner[following], first_corner[following] * size + first_corner
        is_edge &= ~np.isin(forth, back)
    extent = polygons.extents()
    is_flat = ~(signed_areas(polygons) > RELATIVE_TOLERANCE * extent * extent)
    return _Rims(polygons, first_corner, is_edge, is_flat)


@dataclass(frozen=True, slots=True)
class _Faces:
    """Faces to be, of equal numbers of corners or ragged."""

    polygon: Indices
    """[K] the polygon of each face."""
    rank: Indices
    """[K] its index among the faces over that polygon."""
    counts: Indices
    """[K] corners of each."""
    corners: Indices
    """[S] points of all corners, one face after the other."""


def _solids(points: Floats, owner: Indices, num_solids: int, parts: list[_Faces]) -> Meshes:
    """One mesh for each polygon from faces over common points.

    Args:
        points: [P, 3] points; those that no face uses are left out.
        owner: [P] the polygon that each belongs to.
        num_solids: number of polygons.
        parts: the faces, in any order.
    """
    polygon = np.concatenate([part.polygon for part in parts])
    order = np.lexsort((np.concatenate([part.rank for part in parts]), polygon))
    corners = np.concatenate([part.corners for part in parts])
    where, face_offsets = take_rows(offsets_from_counts(np.concatenate([part.counts for part in parts])), order)
    corners = corners[where]
    used = np.zeros(len(points), np.bool_)
    used[corners] = True
    used_points = np.flatnonzero(used)
    used_points = used_points[np.argsort(owner[used_points], kind="stable")]
    mesh_points = offsets_from_counts(np.bincount(owner[used_points], minlength=num_solids))
    number = np.zeros(len(points), np.int64)
    number[used_points] = np.arange(len(used_points)) - mesh_points[owner[used_points]]
    mesh_faces = offsets_from_counts(np.bincount(polygon, minlength=num_solids))
    tags = np.zeros(len(order), np.int8)
    return Meshes(
        points=points[used_points],
        corners=number[corners],
        face_offsets=face_offsets,
        mesh_faces=mesh_faces,
        mesh_points=mesh_points,
        tags=tags,
    )


def _undersides(rims: _Rims) -> _Faces:
    """The faces turned over, beginning with their first edges; flat faces do not change."""
    polygons, face = rims.polygons, rims.polygons.face_of_corner()
    first, count = polygons.offsets[face], polygons.counts[face]
    index = np.arange(len(face)) - first
    turned = np.where(rims.is_flat[face], index, (1 - index) % np.maximum(count, 1))
    return _Faces(
        np.arange(len(polygons)), np.full(len(polygons), _UNDERSIDE), polygons.counts, rims.first_corner[first + turned]
    )


def _prisms(rims: _Rims, height: Floats, lead: Indices) -> Meshes:
    """Solids from each face up to a slope.

    Args:
        rims: the faces.
        height: [C] height of the slope over each corner, in metres, 0 or more.
        lead: [F] the corner at which the slope begins.
    """
    polygons, face = rims.polygons, rims.polygons.face_of_corner()
    highest = np.zeros(len(polygons))
    np.maximum.at(highest, face, height)
    rises = height[rims.first_corner] > RELATIVE_TOLERANCE * highest[face]
    top = np.where(rises, len(polygons.xy) + rims.first_corner, rims.first_corner)
    following = polygons.next_corner()
    faces = [_undersides(rims), _slopes(rims, top, lead)]
    wall = rims.is_edge & ~rims.is_flat[face]
    for first, second in ((True, True), (True, False), (False, True)):
        edge = np.flatnonzero(wall & (rises == first) & (rises[following] == second))
        ring = [rims.first_corner[edge], rims.first_corner[following[edge]]]
        ring += [top[following[edge]]] if second else []
        ring += [top[edge]] if first else []
        corners = np.stack(ring, axis=1)
        rank = edge - polygons.offsets[face[edge]]
        faces.append(_Faces(face[edge], rank, np.full(len(edge), len(ring)), corners.ravel()))
    tops = polygons.points + polygons.axes[face, 2] * height[:, None]
    points = np.concatenate([polygons.points, tops])
    return _solids(points, np.concatenate([face, face]), len(polygons), faces)


def _slopes(rims: _Rims, top: Indices, lead: Indices) -> _Faces:
    """The faces lifted to the points ``top`` [C], each beginning at its corner ``lead`` [F]; none for flat faces."""
    polygons = rims.polygons
    chosen = np.flatnonzero(~rims.is_flat)
    where, offsets = take_rows(polygons.offsets, chosen)
    face = np.repeat(chosen, np.diff(offsets))
    first, count = polygons.offsets[face], polygons.counts[face]
    turned = first + (where - first + lead[face] - first) % np.maximum(count, 1)
    return _Faces(chosen, np.full(len(chosen), _SLOPE), np.diff(offsets), top[turned])


def _directions(polygons: Polygons) -> Floats:
    """[F, 2] the x axis of the mesh in the frame of each face; the first edge for faces that look along x."""
    flat = polygons.axes[:, :2, 0]
    length = np.hypot(flat[:, 0], flat[:, 1])[:, None]
    is_defined = length > RELATIVE_TOLERANCE
    return np.where(is_defined, flat / np.where(is_defined, length, 1.0), [1.0, 0.0])


def _rectangle_nodes(sizes: Floats, kind: int) -> Floats:
    """[K, 6, 2] corners of rectangles, then the ends of the ridge along the first (0) or second (1) edge."""
    width, depth = sizes.T
    zero = 0.0 * width
    ends = [(zero, 0.5 * depth), (width, 0.5 * depth)] if kind == 0 else [(0.5 * width, zero), (0.5 * width, depth)]
    nodes = [(zero, zero), (width, zero), (width, depth), (zero, depth), *ends]
    return np.stack([np.stack(node, axis=1) for node in nodes], axis=1)


def _ridge_patch(xy: Floats, along: Floats, value: float, is_height: bool) -> Patch:
    """The roof over a polygon with a ridge along a unit vector [2]."""
    across = along[0] * xy[:, 1] - along[1] * xy[:, 0]
    low, high = float(across.min()), float(across.max())
    half = 0.5 * (high - low)
    side = across - 0.5 * (low + high)
    loops = rings(xy) if half > 0.0 else []
    if not loops or abs(sum(loop_area(xy, ring) for ring in loops)) <= RELATIVE_TOLERANCE * half * half:
        return Patch(xy, np.zeros(len(xy)), tuple(range(len(xy))), (tuple(range(len(xy))),), (0,))
    side[np.abs(side) <= RELATIVE_TOLERANCE * half] = 0.0
    corner_at = {tuple(xy[corner].tolist()): corner for ring in loops for corner in ring}
    bottom = tuple(corner_at[point] for point in map(tuple, xy.tolist()))
    underside = (bottom[1], bottom[0], *bottom[:1:-1])
    if value <= 0.0:
        return Patch(xy, np.zeros(len(xy)), tuple(range(len(xy))), (underside, bottom), (0, 0))
    nodes, paths, crossings = _cut(xy, side, loops)
    drop = half - np.abs(np.append(side, np.zeros(len(nodes) - len(xy))))
    height = np.where(drop > RELATIVE_TOLERANCE * half, drop, 0.0) * (value / half if is_height else value)
    top = [len(nodes) + i if height[i] > 0.0 else i for i in range(len(nodes))]
    crossings.sort(key=lambda node: float(nodes[node, 0] * along[0] + nodes[node, 1] * along[1]))
    ridge = [pair for pair in zip(crossings[::2], crossings[1::2], strict=True) if pair[0] != pair[1]]
    arcs = [arc for path in paths for arc in pairwise(path)]
    is_right = [any(node < len(xy) and side[node] < 0.0 for node in arc) for arc in arcs]
    left_arcs = [arc for arc, right_arcs in zip(arcs, is_right, strict=True) if not right_arcs]
    right_arcs = [arc for arc, right_arcs in zip(arcs, is_right, strict=True) if right_arcs]
    # Seen along the ridge, the part to its left has the ridge in forward direction on its border.
    slopes = fill(nodes, trace([*left_arcs, *ridge])) + fill(nodes, trace([*right_arcs, *((b, a) for a, b in ridge)]))
    faces: list[Loop] = [underside, *(tuple(top[node] for node in face) for face in slopes)]
    faces += [wall for wall in (_wall(path, top) for path in paths) if len(wall) > 2]
    heights = np.concatenate([np.zeros(len(nodes)), height])
    return Patch(np.concatenate([nodes, nodes]), heights, tuple(range(len(xy))), tuple(faces), (0,) * len(faces))


def _cut(xy: Floats, side: Floats, loops: list[list[int]]) -> tuple[Floats, list[Loop], list[int]]:
    """Edges of a polygon cut at the ridge.

    Returns:
        The corners and new nodes; for each edge the nodes along it; the node at each passage.
    """
    nodes = xy.tolist()
    paths: list[Loop] = []
    crossings: list[int] = []
    for ring in loops:
        for a, b in zip(ring, ring[1:] + ring[:1], strict=True):
            if (side[a] < 0.0) == (side[b] < 0.0):
                paths.append((a, b))
            elif side[a] == 0.0 or side[b] == 0.0:
                paths.append((a, b))
                crossings.append(a if side[a] == 0.0 else b)
            else:
                share = side[a] / (side[a] - side[b])
                paths.append((a, len(nodes), b))
                crossings.append(len(nodes))
                nodes.append([float(xy[a, k] + share * (xy[b, k] - xy[a, k])) for k in range(2)])
    return np.array(nodes), paths, crossings


def _wall(path: Loop, top: list[int]) -> Loop:
    """The vertical face from an edge up to the slopes."""
    return (path[0], path[-1], *(top[node] for node in reversed(path) if top[node] != node))
