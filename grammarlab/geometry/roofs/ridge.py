"""Roofs with a single ridge across the whole face: CGA's ``roofRidge``."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from grammarlab.geometry.meshes.mesh import Floats, Indices, Meshes
from grammarlab.geometry.meshes.planar import RELATIVE_TOLERANCE, Polygons, lay_flat, rectangle_sizes, regroup
from grammarlab.geometry.outlines.patches import Patch, alike, fill, in_order, rings, stamp, stamp_patch
from grammarlab.geometry.outlines.skeleton import Loop, loop_area, trace

_RECTANGLE_FACES = (
    ((0, 1, 5, 4), (2, 3, 4, 5), (1, 2, 5), (3, 0, 4), (0, 3, 2, 1)),
    ((1, 2, 5, 4), (3, 0, 4, 5), (0, 1, 4), (2, 3, 5), (0, 3, 2, 1)),
)
"""Slopes, sides and underside of a rectangle whose ridge (4, 5) runs along its first edge, or along its second."""


def ridges(meshes: Meshes, amount: Floats, is_height: bool) -> Meshes:
    """See `grammarlab.geometry.roofs.kinds.roof_ridge`.

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


def _directions(polygons: Polygons) -> Floats:
    """[F, 2] the x axis of the mesh in the frame of each face; the first edge for faces that look along x."""
    flat = polygons.axes[:, :2, 0]
    length = np.hypot(flat[:, 0], flat[:, 1])[:, None]
    known = length > RELATIVE_TOLERANCE
    return np.where(known, flat / np.where(known, length, 1.0), [1.0, 0.0])


def _rectangle_nodes(sizes: Floats, kind: int) -> Floats:
    """[K, 6, 2] corners of rectangles, then the ends of the ridge along the first (0) or second (1) edge."""
    width, depth = sizes.T
    zero = 0.0 * width
    ends = [(zero, 0.5 * depth), (width, 0.5 * depth)] if kind == 0 else [(0.5 * width, zero), (0.5 * width, depth)]
    places = [(zero, zero), (width, zero), (width, depth), (zero, depth), *ends]
    return np.stack([np.stack(place, axis=1) for place in places], axis=1)


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
    bottom = tuple(corner_at[place] for place in map(tuple, xy.tolist()))
    underside = (bottom[0], *bottom[:0:-1])
    if value <= 0.0:
        return Patch(xy, np.zeros(len(xy)), tuple(range(len(xy))), (bottom, underside), (0, 0))
    nodes, paths, crossings = _cut(xy, side, loops)
    drop = half - np.abs(np.append(side, np.zeros(len(nodes) - len(xy))))
    height = np.where(drop > RELATIVE_TOLERANCE * half, drop, 0.0) * (value / half if is_height else value)
    top = [len(nodes) + i if height[i] > 0.0 else i for i in range(len(nodes))]
    crossings.sort(key=lambda node: float(nodes[node, 0] * along[0] + nodes[node, 1] * along[1]))
    ridge = [pair for pair in zip(crossings[::2], crossings[1::2], strict=True) if pair[0] != pair[1]]
    arcs = [arc for path in paths for arc in pairwise(path)]
    is_right = [any(node < len(xy) and side[node] < 0.0 for node in arc) for arc in arcs]
    left = [arc for arc, right in zip(arcs, is_right, strict=True) if not right]
    right = [arc for arc, right in zip(arcs, is_right, strict=True) if right]
    # Seen along the ridge, the part to its left has the ridge in forward direction on its border.
    slopes = fill(nodes, trace([*left, *ridge])) + fill(nodes, trace([*right, *((b, a) for a, b in ridge)]))
    faces: list[Loop] = [tuple(top[node] for node in face) for face in slopes]
    faces += [wall for wall in (_wall(path, top) for path in paths) if len(wall) > 2]
    faces.append(underside)
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
