"""Caps: faces on the planes where different units meet, where only one of them has material.

The open edges of one seam plane, and pieces of the lines where it crosses others, form closed walks; each part of the
plane is covered as often as they wind around it. On a line, given ends can be joined in only one way, so the edges that
two planes add to their common line cancel, and a closed surface stays closed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import mapbox_earcut
import numpy as np
import shapely
from scipy.spatial import KDTree

from grammarlab.arrays import Floats, Ints
from grammarlab.synthesis.mesh.surface import Surface, without_empty
from grammarlab.synthesis.mesh.views import Plane
from grammarlab.synthesis.stitching import seam_edges

_MAX_EDGES = 200_000
"""Largest number of open edges of one plane."""


class _Walk(NamedTuple):
    """Directed segments of a plane."""

    start: Floats
    """[S, 2] starts."""
    end: Floats
    """[S, 2] ends."""
    times: Ints
    """[S] multiplicity of each."""


def capped(surface: Surface, planes: Sequence[Plane], tolerance: float) -> Surface:
    """The surface with faces over open seams.

    Args:
        surface: welded, without T-junctions.
        planes: planes of the seams.
        tolerance: largest distance of a point on a plane, metres.
    """
    positions = {axis: np.unique([plane.position for plane in planes if plane.axis == axis]) for axis in range(3)}
    edges, times = seam_edges(surface, planes, tolerance)
    points, faces, materials = surface.points, [surface.triangles], [surface.material]
    point_material = np.zeros(len(points), dtype=np.int64)
    point_material[surface.triangles.ravel()] = np.repeat(surface.material, 3)
    for plane in planes:
        on = (np.abs(points[:, plane.axis] - plane.position) <= tolerance)[edges].all(axis=1)
        if not on.any() or on.sum() > _MAX_EDGES:
            continue
        axes = [(plane.axis + 1) % 3, (plane.axis + 2) % 3]
        walk = _closed(points[:, axes], edges[on], times[on], [positions[axis] for axis in axes], tolerance)
        flat, rows = _faces(walk)
        if not len(rows):
            continue
        points, indices, nearest = _placed(points, np.unique(edges), plane, flat, tolerance)
        triangles = indices[rows]
        point_material = np.append(point_material, np.zeros(len(points) - len(point_material), dtype=np.int64))
        faces.append(triangles)
        materials.append(point_material[nearest[rows[:, 0]]])
        edges, times = _open(edges, times, triangles, len(points))
    return without_empty(Surface(points, np.concatenate(faces), np.concatenate(materials)))


def _open(edges: Ints, times: Ints, triangles: Ints, num_points: int) -> tuple[Ints, Ints]:
    """Open edges and their multiplicities after triangles are added."""
    start = np.concatenate([edges[:, 0], triangles.ravel()])
    end = np.concatenate([edges[:, 1], np.roll(triangles, -1, axis=1).ravel()])
    count = np.concatenate([times, np.ones(triangles.size, dtype=np.int64)])
    key = np.minimum(start, end) * num_points + np.maximum(start, end)
    unique, inverse = np.unique(key, return_inverse=True)
    net = np.rint(np.bincount(inverse.ravel(), weights=np.where(start < end, count, -count))).astype(np.int64)
    is_open = net != 0
    edge = np.stack([unique // num_points, unique % num_points], axis=1)[is_open]
    return np.where(net[is_open, None] > 0, edge, edge[:, ::-1]), np.abs(net[is_open])


def _closed(points: Floats, edges: Ints, times: Ints, lines: Sequence[Floats], tolerance: float) -> _Walk:
    """Open edges of a plane, with pieces of lines between their loose ends where these balance."""
    start, end, count = [points[edges[:, 0]]], [points[edges[:, 1]]], [times]
    loose = np.zeros(len(points), dtype=np.int64)
    np.add.at(loose, edges[:, 1], times)
    np.subtract.at(loose, edges[:, 0], times)
    for axis in (0, 1):
        ends = np.flatnonzero(loose)
        for position in lines[axis] if len(ends) else ():
            on = ends[np.abs(points[ends, axis] - position) <= tolerance]
            on = on[loose[on] != 0]
            if len(on) < 2 or loose[on].sum() != 0:
                continue
            on = on[np.argsort(points[on, 1 - axis], kind="stable")]
            # The sum of loose ends before a piece is the flow along it.
            flow = np.cumsum(loose[on])[:-1]
            first, last = np.where(flow > 0, on[:-1], on[1:]), np.where(flow > 0, on[1:], on[:-1])
            used = flow != 0
            start.append(points[first[used]])
            end.append(points[last[used]])
            count.append(np.abs(flow[used]))
            loose[on] = 0
    return _Walk(np.concatenate(start), np.concatenate(end), np.concatenate(count))


def _faces(walk: _Walk) -> tuple[Floats, Ints]:
    """Corners [K, 2] and triangles [F, 3] that cover the inside of a walk, in the opposite direction."""
    noded = shapely.unary_union(shapely.linestrings(np.stack([walk.start, walk.end], axis=1)))
    corners, rows = [np.zeros((0, 2))], [np.zeros((0, 3), dtype=np.int64)]
    first = 0
    for face in shapely.get_parts(shapely.polygonize(shapely.get_parts(noded))):
        turns = _winding(shapely.get_coordinates(face.representative_point())[0], walk)
        if turns == 0:
            continue
        rings = [shapely.get_coordinates(ring)[:-1] for ring in (face.exterior, *face.interiors)]
        flat = np.concatenate(rings)
        ends = np.cumsum([len(ring) for ring in rings]).astype(np.uint32)
        cut = mapbox_earcut.triangulate_float64(flat, ends).reshape(-1, 3).astype(np.int64)
        corner = flat[cut]
        ab, ac = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        anticlockwise = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0] > 0.0
        cut = np.where((anticlockwise == (turns < 0))[:, None], cut, cut[:, ::-1])
        corners.append(flat)
        rows += [cut + first] * abs(turns)
        first += len(flat)
    return np.concatenate(corners), np.concatenate(rows)


def _winding(point: Floats, walk: _Walk) -> int:
    """Winding number of directed segments around a point, anticlockwise."""
    (x, y), a, b = point, walk.start, walk.end
    rising, falling = (a[:, 1] <= y) & (b[:, 1] > y), (b[:, 1] <= y) & (a[:, 1] > y)
    side = (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (x - a[:, 0]) * (b[:, 1] - a[:, 1])
    return int((walk.times * (rising & (side > 0.0))).sum() - (walk.times * (falling & (side < 0.0))).sum())


def _placed(points: Floats, existing: Ints, plane: Plane, flat: Floats, tolerance: float) -> tuple[Floats, Ints, Ints]:
    """Points [Q, 3] with new ones of a plane, the row [K] of each corner, and the nearest known row [K]."""
    corners = np.empty((len(flat), 3))
    corners[:, plane.axis] = plane.position
    corners[:, [(plane.axis + 1) % 3, (plane.axis + 2) % 3]] = flat
    distance, nearest = KDTree(points[existing]).query(corners)
    new = distance > tolerance
    indices = np.where(new, len(points) + np.cumsum(new) - 1, existing[nearest])
    return np.concatenate([points, corners[new]]), indices, existing[nearest]
