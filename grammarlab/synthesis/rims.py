"""Open edges without the points that cutting has put on them: an opening has as many as in the example."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

import numpy as np
from mapbox_earcut import triangulate_float64

from grammarlab.arrays import Floats, Ints
from grammarlab.synthesis.mesh.surface import Surface, edge_table, without_empty
from grammarlab.synthesis.mesh.views import Plane

_MAX_POINTS = 5_000
"""Points; where more are found, all stay."""
_MIN_HEIGHT_RATIO = 1e-5
"""Height of a triangle, and depth of what is flat, as parts of the longest side."""


def smoothed(surface: Surface, planes: Sequence[Plane], tolerance: float) -> Surface:
    """The surface without points of seams on straight open edges, where the faces about them are flat.

    Args:
        surface: welded.
        planes: planes of the seams.
        tolerance: metres between a plane and a point on it, and between an edge and a point on it.
    """
    rims = _rims(surface)
    seam = np.zeros(len(surface.points), dtype=bool)
    for plane in planes:
        seam |= np.abs(surface.points[:, plane.axis] - plane.position) <= tolerance
    points = [point for point in rims if seam[point]]
    if not points or len(points) > _MAX_POINTS:
        return surface
    near = np.flatnonzero(
        np.isin(surface.triangles, [*points, *(end for point in points for end in rims[point])]).any(1)
    )
    fans: dict[int, set[int]] = defaultdict(set)
    triangles = surface.triangles.copy()
    for row in near.tolist():
        for point in triangles[row].tolist():
            fans[point].add(row)
    moved = True
    while moved:
        moved = False
        for point in list(points):
            before, after = rims[point]
            if not _straight(surface.points[[before, point, after]], tolerance):
                continue
            if _refilled(surface.points, triangles, fans, point, before, after):
                for neighbour, opposite in ((before, after), (after, before)):
                    if neighbour in rims:
                        rims[neighbour] = _with(rims[neighbour], point, opposite)
                points.remove(point)
                moved = True
    return without_empty(Surface(surface.points, triangles, surface.material))


def _rims(surface: Surface) -> dict[int, tuple[int, int]]:
    """Points with two open edges, and the other ends of these."""
    edges, count, _ = edge_table(surface.triangles, len(surface.points))
    ends: dict[int, list[int]] = defaultdict(list)
    for first, second in edges[count == 1].tolist():
        ends[first].append(second)
        ends[second].append(first)
    return {point: (others[0], others[1]) for point, others in ends.items() if len(others) == 2}


def _with(ends: tuple[int, int], old: int, new: int) -> tuple[int, int]:
    """The ends of a point's edges after one of them has moved."""
    return (new if ends[0] == old else ends[0], new if ends[1] == old else ends[1])


def _straight(points: Floats, tolerance: float) -> bool:
    """Whether the second of three points [3, 3] lies between the others."""
    along, offset = points[2] - points[0], points[1] - points[0]
    part = float(offset @ along) / max(float(along @ along), 1e-12)
    return 0.0 < part < 1.0 and float(np.linalg.norm(offset - part * along)) <= tolerance


def _refilled(points: Floats, triangles: Ints, fans: dict[int, set[int]], point: int, before: int, after: int) -> bool:
    """Fill the fan of a point without it; False, and nothing is changed, where the fan is not flat and simple."""
    rows = sorted(fans[point])
    following = {}
    for corners in triangles[rows].tolist():
        index = corners.index(point)
        following[corners[index - 2]] = corners[index - 1]
    start, end = (before, after) if before in following else (after, before)
    ring = [start]
    while ring[-1] != end and ring[-1] in following and len(ring) <= len(rows):
        ring.append(following[ring[-1]])
    normals = _normals(points[triangles[rows]])
    total = normals.sum(axis=0)
    longest = float(np.ptp(points[ring], axis=0).max())
    size = float(np.linalg.norm(total))
    if ring[-1] != end or len(ring) != len(rows) + 1 or size <= _MIN_HEIGHT_RATIO * longest**2:
        return False
    if (np.abs((points[ring] - points[point]) @ (total / size)) > _MIN_HEIGHT_RATIO * longest).any():
        return False
    filling = next(
        (candidate for candidate in _fillings(points, np.array(ring), total) if _sound(points[candidate], total)), None
    )
    if filling is None or len(filling) != len(rows) - 1:
        return False
    for row in rows:
        for corner in triangles[row].tolist():
            fans[corner].discard(row)
    triangles[rows[0]] = start
    triangles[rows[1:]] = filling
    for row in rows[1:]:
        for corner in triangles[row].tolist():
            fans[corner].add(row)
    return True


def _fillings(points: Floats, ring: Ints, normal: Floats) -> Iterator[Ints]:
    """Triangles [K, 3] that fill a flat ring: from its start, from its end, or cut off one after the other."""
    for end, rest in ((ring[0], ring[1:]), (ring[-1], ring[:-1])):
        yield np.stack([np.full(len(rest) - 1, end), rest[:-1], rest[1:]], axis=1)
    flat = points[ring][:, np.delete(np.arange(3), np.abs(normal).argmax())]
    cut = triangulate_float64(flat, np.array([len(ring)], dtype=np.uint32)).astype(np.int64).reshape(-1, 3)
    triangles = ring[cut]
    yield np.where((_normals(points[triangles]) @ normal < 0.0)[:, None], triangles[:, ::-1], triangles)


def _sound(corners: Floats, normal: Floats) -> bool:
    """Whether triangles [K, 3, 3] face one way, and none is nearly empty."""
    normals = _normals(corners)
    longest = np.ptp(corners, axis=1).max(axis=1, initial=0.0)
    return bool(((normals @ normal > 0.0) & (np.linalg.norm(normals, axis=1) > _MIN_HEIGHT_RATIO * longest**2)).all())


def _normals(corners: Floats) -> Floats:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
