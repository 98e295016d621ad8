"""Solids that touch or overlap as one: a building of slabs becomes one closed surface without faces inside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from manifold3d import Error, Manifold, Mesh64, OpType
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from grammarlab.facade.examples.mesh.surface import (
    Floats,
    Ints,
    Surface,
    joined,
    welded,
    without_folds,
    without_slivers,
)

_MOST = 300_000
"""Triangles; larger meshes of many solids stay as they are, since uniting them takes too long."""
_LEAST = 1e-9
"""Volume of a solid, in cubes of its longest side; less is a sheet with two sides."""
_MOST_SOLIDS = 10_000
_MOST_PAIRS = 5_000_000
"""Pairs of triangles of different solids whose boxes meet: a limit on the size of the union."""


@dataclass(frozen=True, eq=False)
class _Bodies:
    """Closed surfaces that share no points."""

    points: Floats
    """[Q, 3] metres."""
    triangles: Ints
    """[T, 3] rows of `points`."""
    body: Ints
    """[T] number of the body of each triangle."""
    number: int


def united(surface: Surface, tolerance: float) -> Surface:
    """The outside of all solids of a surface together.

    Sheets that are seen from both sides stay beside them. A surface that is open, is one solid, has hollow or inverted
    solids, or has more than 300,000 triangles stays as it is; so do more than 10,000 solids, and solids with so many
    triangles near each other that the union could become very large.

    Args:
        surface: welded; triangles of one solid follow each other, as far as they share edges with others.
        tolerance: metres between points that are one.
    """
    if not 0 < len(surface) <= _MOST:
        return surface
    bodies = _bodies(surface)
    if bodies is None or bodies.number < 2:
        return surface
    solids, sheets, inside_out = [], [], set[bool]()
    order = np.argsort(bodies.body, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(bodies.body[order])) + 1):
        used, corners = np.unique(bodies.triangles[rows], return_inverse=True)
        corners = corners.reshape(-1, 3)
        points = bodies.points[used]
        volume = _volume(points, corners)
        if abs(volume) <= _LEAST * float(np.ptp(points, axis=0).max()) ** 3:
            sheets.append(surface.part(np.isin(np.arange(len(surface)), rows)))
            continue
        negative = volume < 0.0
        inside_out.add(negative)
        material = surface.material[rows].astype(np.uint64)
        turned = corners[:, ::-1] if negative else corners
        solids.append(Manifold(Mesh64(points, np.ascontiguousarray(turned, dtype=np.uint64), face_id=material)))
    if len(inside_out) != 1 or any(each.status() != Error.NoError for each in solids) or _too_tangled(solids):
        return surface
    mesh = Manifold.batch_boolean(solids, OpType.Add).to_mesh64()
    triangles = np.asarray(mesh.tri_verts).astype(np.int64).reshape(-1, 3)
    outside = Surface(
        np.array(mesh.vert_properties, dtype=np.float64)[:, :3],
        triangles[:, ::-1] if inside_out.pop() else triangles,
        np.asarray(mesh.face_id).astype(np.int64),
    )
    outside = without_folds(without_slivers(welded(outside, tolerance), tolerance))
    return welded(joined([outside, *sheets]), tolerance) if sheets else outside


def _too_tangled(solids: list[Manifold]) -> bool:
    if len(solids) > _MOST_SOLIDS:
        return True
    boxes = np.array([each.bounding_box() for each in solids])
    low, high = boxes[:, :3], boxes[:, 3:]
    counts = np.array([each.num_tri() for each in solids], dtype=np.float64)
    pairs = 0.0
    for number, count in enumerate(counts[:-1], 1):
        meets = ((low[number:] <= high[number - 1]) & (low[number - 1] <= high[number:])).all(axis=1)
        pairs += count * counts[number:][meets].sum()
    return bool(pairs > _MOST_PAIRS)


def _volume(points: Floats, triangles: Ints) -> float:
    a, b, c = (points[column] - points[0] for column in triangles.T)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)))


def _bodies(surface: Surface) -> _Bodies | None:
    """The surface in bodies; None where it is open.

    Where solids touch, an edge has more than two triangles. Those that run along it are paired with those that run
    against it in the order of the file: files list one solid after the other.
    """
    triangles, number = surface.triangles, len(surface.points)
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    key = np.minimum(start, end) * number + np.maximum(start, end)
    along, against = (np.flatnonzero(each) for each in (start < end, start > end))
    along, against = (each[np.argsort(key[each], kind="stable")] for each in (along, against))
    if not np.array_equal(key[along], key[against]):
        return None
    count, body = _components(len(triangles), along // 3, against // 3)
    after = np.arange(triangles.size).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    one, other = np.concatenate([along, after[along]]), np.concatenate([after[against], against])
    num_points, point = _components(triangles.size, one, other)
    points = np.empty((num_points, 3))
    points[point] = surface.points[start]
    return _Bodies(points, point.reshape(-1, 3), body, count)


def _components(size: int, one: Ints, other: Ints) -> tuple[int, Ints]:
    """How many groups pairs connect numbers below a size to, and [size] the group of each."""
    graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(size, size))
    count, group = connected_components(graph, directed=False)
    return int(count), group.astype(np.int64)
