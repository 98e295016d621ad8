"""Solids that touch or overlap as one: a building of slabs becomes one closed surface without faces inside it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from manifold3d import Error, Manifold, Mesh64, OpType
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from grammarlab.arrays import Floats, Ints
from grammarlab.synthesis.mesh.surface import Surface, joined, welded, without_folds, without_slivers

_MAX_TRIANGLES = 300_000
"""Triangles; larger meshes of many solids stay as they are, since uniting them takes too long."""
_MIN_VOLUME_RATIO = 1e-9
"""Volume of a solid, in cubes of its longest side; less is a sheet with two sides."""
_MAX_SOLIDS = 10_000
"""Largest number of solids of a union."""
_MAX_PAIRS = 5_000_000
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
    if not 0 < len(surface) <= _MAX_TRIANGLES:
        return surface
    bodies = _bodies(surface)
    if bodies is None or bodies.number < 2:
        return surface
    volume, longest = _volumes(bodies), _longest(bodies)
    flat = np.abs(volume) <= _MIN_VOLUME_RATIO * longest**3
    inside_out = volume[~flat] < 0.0
    if not len(inside_out) or inside_out.any() != inside_out.all():
        return surface
    rows = ~flat[bodies.body]
    solids = _solids(bodies, surface.material, np.flatnonzero(~flat), inside_out=bool(inside_out[0]))
    if any(solid.status() != Error.NoError for solid in solids) or _too_tangled(solids):
        return surface
    outside = surface_of(Manifold.batch_boolean(solids, OpType.Add))
    if inside_out[0]:
        outside = replace(outside, triangles=outside.triangles[:, ::-1])
    outside = without_folds(without_slivers(welded(outside, tolerance), tolerance))
    return welded(joined([outside, surface.part(~rows)]), tolerance) if flat.any() else outside


def solid_of(surface: Surface) -> Manifold | None:
    """A closed surface as a solid, with its materials as numbers of faces; None if it is open or too large."""
    bodies = _bodies(surface) if 0 < len(surface) <= _MAX_TRIANGLES else None
    if bodies is None:
        return None
    inside_out = _volumes(bodies).sum() < 0.0
    corners = bodies.triangles[:, ::-1] if inside_out else bodies.triangles
    solid = Manifold(
        Mesh64(
            bodies.points,
            np.ascontiguousarray(corners, dtype=np.uint64),
            face_id=surface.material.astype(np.uint64),
        )
    )
    return solid if solid.status() == Error.NoError and not solid.is_empty() else None


def surface_of(solid: Manifold) -> Surface:
    """The surface of a solid; materials are the numbers of its faces."""
    mesh = solid.to_mesh64()
    return Surface(
        np.array(mesh.vert_properties, dtype=np.float64).reshape(-1, 3),
        np.asarray(mesh.tri_verts).astype(np.int64).reshape(-1, 3),
        np.asarray(mesh.face_id).astype(np.int64),
    )


def _solids(bodies: _Bodies, material: Ints, chosen: Ints, *, inside_out: bool) -> list[Manifold]:
    """Some of the bodies as solids, with the materials [T] of their triangles as numbers of faces."""
    point_body = np.empty(len(bodies.points), dtype=np.int64)
    point_body[bodies.triangles] = bodies.body[:, None]
    ends = [
        np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=bodies.number))])
        for owner in (point_body, bodies.body)
    ]
    order, rows = (np.argsort(owner, kind="stable") for owner in (point_body, bodies.body))
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    triangles = (rank[bodies.triangles] - ends[0][bodies.body, None])[rows].astype(np.uint64)
    if inside_out:
        triangles = np.ascontiguousarray(triangles[:, ::-1])
    points, faces = bodies.points[order], material[rows].astype(np.uint64)
    solids = []
    for k in chosen.tolist():
        part = slice(ends[1][k], ends[1][k + 1])
        solids.append(Manifold(Mesh64(points[ends[0][k] : ends[0][k + 1]], triangles[part], face_id=faces[part])))
    return solids


def _too_tangled(solids: list[Manifold]) -> bool:
    if len(solids) > _MAX_SOLIDS:
        return True
    boxes = np.array([solid.bounding_box() for solid in solids])
    low, high = boxes[:, :3], boxes[:, 3:]
    counts = np.array([solid.num_tri() for solid in solids], dtype=np.float64)
    pairs = 0.0
    for number, count in enumerate(counts[:-1], 1):
        meets = ((low[number:] <= high[number - 1]) & (low[number - 1] <= high[number:])).all(axis=1)
        pairs += count * counts[number:][meets].sum()
    return bool(pairs > _MAX_PAIRS)


def _volumes(bodies: _Bodies) -> Floats:
    """[B] volume of each body; below 0 if it is inside out."""
    first = np.zeros(bodies.number, dtype=np.int64)
    first[bodies.body[::-1]] = bodies.triangles[::-1, 0]
    a, b, c = (bodies.points[column] - bodies.points[first[bodies.body]] for column in bodies.triangles.T)
    return np.bincount(bodies.body, np.einsum("ij,ij->i", a, np.cross(b, c)), bodies.number) / 6.0


def _longest(bodies: _Bodies) -> Floats:
    """[B] longest side of the box of each body, metres."""
    low, high = np.full((bodies.number, 3), np.inf), np.full((bodies.number, 3), -np.inf)
    for column in bodies.triangles.T:
        np.minimum.at(low, bodies.body, bodies.points[column])
        np.maximum.at(high, bodies.body, bodies.points[column])
    return (high - low).max(axis=1)


def _bodies(surface: Surface) -> _Bodies | None:
    """The surface in bodies; None where it is open.

    Where solids touch, an edge has more than two triangles. Those that run along it are paired with those that run
    against it in the order of the file: files list one solid after the other.
    """
    triangles, number = surface.triangles, len(surface.points)
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    key = np.minimum(start, end) * number + np.maximum(start, end)
    along, against = (np.flatnonzero(side) for side in (start < end, start > end))
    along, against = (side[np.argsort(key[side], kind="stable")] for side in (along, against))
    if not np.array_equal(key[along], key[against]):
        return None
    count, body = _components(len(triangles), along // 3, against // 3)
    after = np.arange(triangles.size).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    first, second = np.concatenate([along, after[along]]), np.concatenate([after[against], against])
    num_points, point = _components(triangles.size, first, second)
    points = np.empty((num_points, 3))
    points[point] = surface.points[start]
    return _Bodies(points, point.reshape(-1, 3), body, count)


def _components(size: int, first: Ints, second: Ints) -> tuple[int, Ints]:
    """Number of connected components of a graph of `size` nodes, and [size] the component of each node."""
    graph = coo_matrix((np.ones(len(first)), (first, second)), shape=(size, size))
    count, group = connected_components(graph, directed=False)
    return int(count), group.astype(np.int64)
