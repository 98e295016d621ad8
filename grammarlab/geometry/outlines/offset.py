"""CGA's ``offset``: polygons grown or shrunk by parallel edges with mitred corners, and the ring between."""

from __future__ import annotations

from typing import Literal

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.mesh import BORDER, INSIDE, Indices, Meshes
from grammarlab.geometry.meshes.planar import RELATIVE_TOLERANCE, lay_flat, rectangle_sizes, regroup
from grammarlab.geometry.outlines.patches import Patch, alike, fill, in_order, rings, stamp, stamp_patch
from grammarlab.geometry.outlines.straight_skeleton import Loop, sweep

Keep = Literal["all", "inside", "border"]

_RECTANGLE_FACES = ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7))
_RECTANGLE_TAGS = (BORDER, BORDER, BORDER, BORDER, INSIDE)


def offset(meshes: Meshes, distance: Floats | float, keep: Keep = "all") -> Meshes:
    """Every face replaced by its offset polygons, by the ring between, or by both.

    Ring faces come first, tagged `BORDER`, one for each edge in order, and begin with that edge. Offset polygons are
    tagged `INSIDE`; each begins at the part of the lowest edge that is left. Ring faces face the other way for positive
    distances, so that the signed areas of offset polygons and ring always add up to that of the face. A distance of 0
    (beside the size of the face) gives no ring. Where nothing is left inside, ``keep="inside"`` keeps the face itself,
    as CGA does; so does any offset of a face without area or with edges that cross.

    Args:
        meshes: M meshes.
        distance: [M] or one for all, in metres; negative shrinks, positive grows. Mitres have no limit.
        keep: which faces to keep.
    """
    polygons = lay_flat(meshes)
    requested = np.broadcast_to(np.asarray(distance, np.float64), len(meshes))[meshes.mesh_of_face()]
    distances = np.where(np.abs(requested) > RELATIVE_TOLERANCE * polygons.extents(), requested, 0.0)
    rectangular, sizes = rectangle_sizes(polygons)
    smallest = sizes.min(axis=1, initial=np.inf)
    simple = rectangular & (distances != 0.0) & (-2.0 * distances < smallest * (1.0 - RELATIVE_TOLERANCE))
    batches: list[Meshes] = []
    rows: list[Indices] = []
    fast = np.flatnonzero(simple)
    if len(fast):
        selected = [i for i, tag in enumerate(_RECTANGLE_TAGS) if _is_kept(tag, keep)]
        faces = [_RECTANGLE_FACES[i] for i in selected]
        xy = _rectangle_nodes(sizes[fast], distances[fast])
        tags = [_RECTANGLE_TAGS[i] for i in selected]
        batches.append(stamp(polygons, fast, xy, np.zeros(xy.shape[:2]), range(4), faces, tags))
        rows.append(fast)
    slow = np.flatnonzero(~simple)
    for members, corners, step in alike(polygons, slow, distances[slow].tolist()):
        batches.append(stamp_patch(polygons, members, _offset_patch(corners, step, keep)))
        rows.append(members)
    if not batches:
        return meshes
    return regroup(in_order(batches, rows), meshes.mesh_faces)


def _is_kept(tag: int, keep: Keep) -> bool:
    return keep == "all" or (tag == INSIDE) == (keep == "inside")


def _rectangle_nodes(sizes: Floats, distances: Floats) -> Floats:
    """[K, 8, 2] corners of rectangles, then of their offset polygons."""
    low = np.zeros_like(sizes)
    corners = [_corners(low, sizes), _corners(low - distances[:, None], sizes + distances[:, None])]
    return np.concatenate(corners, axis=1)


def _corners(low: Floats, high: Floats) -> Floats:
    """[K, 4, 2] corners of rectangles between opposite corners [K, 2], counter-clockwise."""
    x = np.stack([low[:, 0], high[:, 0], high[:, 0], low[:, 0]], axis=1)
    y = np.stack([low[:, 1], low[:, 1], high[:, 1], high[:, 1]], axis=1)
    return np.stack([x, y], axis=2)


def _offset_patch(xy: Floats, distance: float, keep: Keep) -> Patch:
    whole = Patch(xy, np.zeros(len(xy)), tuple(range(len(xy))), (tuple(range(len(xy))),), (INSIDE,))
    if distance == 0.0:
        return _selected_faces(whole, keep)
    grown = _shrunk(xy, -distance) if distance < 0.0 else _grown(xy, distance)
    if grown is None:
        return _selected_faces(whole, keep)
    if keep == "inside" and INSIDE not in grown.tags:
        return whole
    return _selected_faces(grown, keep)


def _selected_faces(patch: Patch, keep: Keep) -> Patch:
    pairs = [(face, tag) for face, tag in zip(patch.faces, patch.tags, strict=True) if _is_kept(tag, keep)]
    return Patch(patch.xy, patch.height, patch.corner, tuple(face for face, _ in pairs), tuple(tag for _, tag in pairs))


def _shrunk(xy: Floats, distance: float) -> Patch | None:
    loops = rings(xy)
    corners = [corner for ring in loops for corner in ring]
    result = sweep([xy[ring] for ring in loops], [1.0] * len(corners), distance)
    if result is None:
        return None
    inner = fill(result.xy, result.rest_from_first_edge(range(len(corners))))
    border = [face for faces in result.faces for face in faces]
    tags = (BORDER,) * len(border) + (INSIDE,) * len(inner)
    return Patch(result.xy, np.zeros(len(result.xy)), tuple(corners), (*border, *inner), tags)


def _grown(xy: Floats, distance: float) -> Patch | None:
    """Every ring swept to its other side: the outline grows, holes shrink."""
    nodes: list[Floats] = []
    loops: list[Loop] = []
    border: list[tuple[int, Loop]] = []
    moved: list[Floats] = []
    corners: list[int] = []
    originals = rings(xy)
    if not originals:
        return None
    first_new = sum(len(ring) for ring in originals)
    for ring in originals:
        backwards = [ring[0], *ring[:0:-1]]
        result = sweep([xy[backwards]], [1.0] * len(ring), distance)
        if result is None:
            return None
        shift = first_new - len(ring)
        node_index = [len(corners) + i if i < len(ring) else i + shift for i in range(len(result.xy))]
        # The edge that leaves a corner backwards is the one that arrives there.
        edges = backwards[1:] + backwards[:1]
        for edge, faces in zip(edges, result.faces, strict=True):
            border += [(edge, tuple(node_index[node] for node in (face[1], face[0], *face[:1:-1]))) for face in faces]
        for loop in result.rest_from_first_edge(edges):
            turned = (loop[1], loop[0], *loop[:1:-1])
            loops.append(tuple(node_index[node] for node in turned))
        corners += backwards
        nodes.append(result.xy[: len(ring)])
        moved.append(result.xy[len(ring) :])
        first_new += len(result.xy) - len(ring)
    points = np.concatenate([*nodes, *moved])
    inner = fill(points, loops)
    faces = (*(face for _, face in sorted(border)), *inner)
    tags = (BORDER,) * len(border) + (INSIDE,) * len(inner)
    return Patch(points, np.zeros(len(points)), tuple(corners), faces, tags)
