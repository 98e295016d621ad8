"""Watertight solids of models, for printing: all shapes of a model united, without hollows inside."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from manifold3d import Error, Manifold, Mesh64, OpType
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, connected
from grammarlab.errors import UsageError
from grammarlab.geometry.meshes.triangulate import triangulate
from grammarlab.scene import Scene

_THICKNESS = 0.2
"""Thickness in metres of shapes that enclose nothing: 2 mm at a scale of 1:100, which printers can make."""
_MARGIN = 2.5e-4
"""Metres by which shapes are larger on all sides, so that those that touch along an edge overlap: where an edge has
four triangles, a file without indices is not watertight."""
_FARTHEST = 4.0
"""Largest distance that a corner moves, in margins: the tip of a needle would move without bound."""
_SHORTEST = 1e-5
"""Metres below which edges are removed."""
_SMOOTH = float(np.cos(np.radians(30.0)))
"""Least cosine between normals of neighbours that become thick as one: they would cross behind sharper folds."""
_GAP = 5e-5
"""Metres between surfaces that touched along an edge: less than a printer can make."""
_MOST_ROUNDS = 8
"""Largest number of times that surfaces draw back."""
_MOST_SHAPES = 10_000
"""Largest number of shapes, and of pieces of different shapes, that are united: their time grows faster than they."""


@dataclass(frozen=True, slots=True)
class Solid:
    """The surface of one model as a closed mesh, y up, metres from the origin of the model."""

    points: Floats
    """[P, 3] points that are stored as different ones."""
    triangles: Ints
    """[T, 3] rows of `points`, counter-clockwise from outside; each edge has two triangles."""
    material: NDArray[np.int32]
    """[T] index into the materials of the scene."""


@dataclass(frozen=True, slots=True)
class _Shape:
    """Connected triangles, in the unit cube of their mesh, or in metres."""

    points: Floats
    triangles: Ints
    rim: Ints
    """[R, 2] directed edges without a triangle at their other side."""
    thickness: float = _THICKNESS
    """Metres that it becomes thick if it is open."""


def solid_of(scene: Scene) -> Solid:
    """The solid of a scene of one model: empty if it has no shape with an area.

    Shapes that enclose a volume are solid. Others, as walls without thickness, become `_THICKNESS` thick, inwards.
    Hollows that are closed on all sides are filled.

    Raises:
        UsageError: If it has more than `_MOST_SHAPES` shapes, or pieces of different shapes.
    """
    _check_number("shapes", len(scene))
    first = Manifold.reserve_ids(max(len(scene), 1))
    whole = Manifold.batch_boolean(list(_solids(scene, first)), OpType.Add)
    filled = [part for part in whole.decompose() if part.volume() > 0.0]
    surface = Manifold.batch_boolean(filled, OpType.Add).simplify(_SHORTEST).to_mesh64()
    triangles = np.asarray(surface.tri_verts, dtype=np.int64).reshape(-1, 3)
    points = np.asarray(surface.vert_properties, dtype=np.float64).reshape(-1, surface.vert_properties.shape[1])
    counts = np.diff(np.asarray(surface.run_index, dtype=np.int64)) // 3
    shape = np.repeat(np.asarray(surface.run_original_id, dtype=np.int64) - first, counts)
    used = np.unique(triangles)
    rows = np.searchsorted(used, triangles)
    return _welded(apart(points[used, :3], rows), rows, scene.material[shape])


def apart(points: Floats, triangles: Ints) -> Floats:
    """Points of which no two that are stored as one make an edge of more than two triangles.

    Surfaces that only touch along an edge are two surfaces here, but not in files without indices, nor to programs that
    join equal points. They draw back from such edges, by `_GAP`.

    Args:
        points: [P, 3] points.
        triangles: [T, 3] rows of points, each edge with two triangles.
    """
    for _ in range(_MOST_ROUNDS):
        proper, places = distinct_corners(stored(points), triangles)
        _, edge, counts = np.unique(np.sort(_edges(places), axis=1), axis=0, return_inverse=True, return_counts=True)
        touching = np.unique(_edges(triangles[proper])[counts[edge.ravel()] > 2])
        if not len(touching):
            break
        normal, direction = _normals(points, triangles), np.zeros_like(points)
        for column in range(3):
            np.add.at(direction, triangles[:, column], normal)
        length = np.linalg.norm(direction[touching], axis=1, keepdims=True)
        points = points.copy()
        points[touching] -= _GAP * direction[touching] / np.where(length > 0.0, length, 1.0)
    return points


def _welded(points: Floats, triangles: Ints, material: NDArray[np.int32]) -> Solid:
    """A solid whose points are stored as different ones, without triangles that then have no area."""
    rounded = stored(points)
    proper, places = distinct_corners(rounded, triangles)
    used, rows = np.unique(places, return_inverse=True)
    return Solid(np.unique(rounded, axis=0)[used].astype(np.float64), rows.reshape(-1, 3), material[proper])


def stored(points: Floats) -> NDArray[np.float32]:
    """Points as files keep them and programs read them: with 32 bits, and in micrometres where these are finer.

    Near 0, numbers of 32 bits differ by less than programs need to tell points from each other.
    """
    return np.round(points, 6).astype(np.float32)


def distinct_corners(points: NDArray[np.floating], triangles: Ints) -> tuple[Ints, Ints]:
    """Rows [t] of the triangles [T, 3] whose corners are different points, and [t, 3] numbers of these points."""
    _, place = np.unique(points, axis=0, return_inverse=True)
    places = place.ravel()[triangles]
    proper = np.flatnonzero((places != np.roll(places, 1, axis=1)).all(axis=1))
    return proper, places[proper]


def _check_number(what: str, num: int) -> None:
    if num > _MOST_SHAPES:
        raise UsageError(
            f"a model has {num:,} {what} and at most {_MOST_SHAPES:,} are united to a solid; "
            "choose another format, or a model of less detail"
        )


def _solids(scene: Scene, first_id: int) -> Iterator[Manifold]:
    """The solids of all shapes with a volume; triangles have the id ``first_id + k`` of a shape k of their material."""
    # Shapes that differ in their place only are one solid.
    sizes = (size.tobytes() for size in scene.size)
    keys = list(zip(scene.mesh.tolist(), sizes, scene.frame.tolist(), scene.material.tolist(), strict=True))
    rows = {key: row for row, key in reversed(list(enumerate(keys)))}
    pieces = _different_pieces(scene, sorted(rows.values()))
    solids: dict[int, Manifold] = {}
    for key, position in zip(keys, scene.position.tolist(), strict=True):
        row = rows[key]
        if row not in solids:
            frame = scene.frames[scene.frame[row]]
            found = (_placed(piece, frame, first_id + row) for piece in pieces[row])
            solids[row] = Manifold.batch_boolean([solid for solid in found if solid is not None], OpType.Add)
        if not solids[row].is_empty():
            yield solids[row].translate(position)


def _different_pieces(scene: Scene, rows: Sequence[int]) -> dict[int, list[_Shape]]:
    """The pieces of the shapes in some rows, in metres; they are counted before the first ones are united."""
    parts: dict[int, list[_Shape]] = {}
    pieces: dict[int, list[_Shape]] = {}
    num = 0
    for row in rows:
        mesh = int(scene.mesh[row])
        if mesh not in parts:
            parts[mesh] = _shapes(scene, mesh)
        pieces[row] = [piece for part in parts[mesh] for piece in _pieces(part, scene.size[row])]
        num += len(pieces[row])
        _check_number("pieces of meshes, between sharp folds,", num)
    return pieces


def _placed(shape: _Shape, frame: Floats, number: int) -> Manifold | None:
    """A shape in metres as a solid that counts from its place; None if it has no volume."""
    points, triangles = shape.points @ frame.T, shape.triangles
    if len(shape.rim):
        points, triangles = _thick(points, triangles, shape.rim, shape.thickness)
    return _solid(_larger(points, triangles), triangles, number)


def _shapes(scene: Scene, index: int) -> list[_Shape]:
    """The parts of a mesh that are not connected by faces: they may overlap, and touch along edges and at points."""
    mesh = scene.meshes.take(np.array([index]))
    triangles, _ = triangulate(mesh)
    points = np.unique(mesh.points, axis=0)
    _, triangles = distinct_corners(mesh.points, triangles)
    return [_shape(points[rows], corners) for rows, corners in _parts(triangles, _joints(triangles))]


def _pieces(part: _Shape, size: Floats) -> list[_Shape]:
    """A part of a mesh in metres; an open one is divided at sharp folds, behind which it would cross itself."""
    if not len(part.rim):
        return [replace(part, points=part.points * np.where(size > 0.0, size, _THICKNESS))]
    points = part.points * size
    normal, joints = _normals(points, part.triangles), _joints(part.triangles)
    first, second = normal[joints // 3].swapaxes(0, 1)
    is_smooth = (first * second).sum(axis=1) > _SMOOTH
    if is_smooth.all():
        return [replace(part, points=points)]
    # What is folded in little room keeps to it.
    thickness = min([_THICKNESS, *size[size > 0.0]])
    pieces = _parts(part.triangles, joints[is_smooth])
    return [replace(_shape(points[rows], corners), thickness=thickness) for rows, corners in pieces]


def _shape(points: Floats, triangles: Ints) -> _Shape:
    edges = _edges(triangles)
    there, back = edges @ (len(points), 1), edges[:, ::-1] @ (len(points), 1)
    return _Shape(points, triangles, edges[~np.isin(there, back)])


def _edges(triangles: Ints) -> Ints:
    """[3 T, 2] directed edges."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


def _joints(triangles: Ints) -> Ints:
    """[J, 2] rows of `_edges` that are one edge, of the two triangles that share it."""
    edges = np.sort(_edges(triangles), axis=1)
    number = edges @ (edges.max(initial=0) + 1, 1)
    order = np.argsort(number, kind="stable")
    _, counts = np.unique(number, return_counts=True)
    return order[np.repeat(counts == 2, counts)].reshape(-1, 2)


def _parts(triangles: Ints, joints: Ints) -> list[tuple[Ints, Ints]]:
    """Parts of a mesh whose triangles are connected by some edges that two triangles share.

    Parts that only touch have points of their own, so that they move apart when they grow.

    Args:
        triangles: [T, 3] rows of points.
        joints: [J, 2] rows of `_edges` that connect, as of `_joints`.

    Returns:
        For each part, [p] rows of its points, and [t, 3] its triangles as rows of these.
    """
    edges, start = _edges(triangles), np.arange(3 * len(triangles))
    end = np.roll(start.reshape(-1, 3), -1, axis=1).ravel()
    first, second = joints.T
    is_turned = edges[first, 0] != edges[second, 0]
    from_start, from_end = np.where(is_turned, (end[second], start[second]), (start[second], end[second]))
    point = connected(len(start), np.append(start[first], end[first]), np.append(from_start, from_end))
    place = np.empty(int(point.max(initial=-1)) + 1, dtype=np.int64)
    place[point] = triangles.ravel()
    corners = point.reshape(-1, 3)
    part = connected(len(place), corners[:, :2].ravel(), corners[:, 1:].ravel())[corners[:, 0]]
    order = np.argsort(part, kind="stable")
    return [
        (place[used], rows.reshape(-1, 3))
        for members in np.split(order, np.flatnonzero(np.diff(part[order])) + 1)
        if len(members)
        for used, rows in (np.unique(corners[members], return_inverse=True),)
    ]


def _normals(points: Floats, triangles: Ints) -> Floats:
    """[T, 3] unit normals; zeros for triangles without an area."""
    corner = points[triangles]
    turn = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(turn, axis=1, keepdims=True)
    return turn / np.where(length > 0.0, length, 1.0)


def _thick(points: Floats, triangles: Ints, rim: Ints, thickness: float) -> tuple[Floats, Ints]:
    """An open surface with a second one behind it, and walls along its rim."""
    corner = points[triangles]
    normal = np.zeros_like(points)
    turn = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    for column in range(3):
        np.add.at(normal, triangles[:, column], turn)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    behind = points - thickness * normal / np.where(length > 0.0, length, 1.0)
    num = len(points)
    start, end = rim.T
    walls = np.concatenate([np.stack([end, start, start + num], 1), np.stack([end, start + num, end + num], 1)])
    return np.concatenate([points, behind]), np.concatenate([triangles, triangles[:, ::-1] + num, walls])


def _larger(points: Floats, triangles: Ints) -> Floats:
    """Points of a closed mesh whose faces have moved outwards by the margin, as far as three faces can at a corner."""
    normal = _normals(points, triangles)
    spread, direction = np.zeros((len(points), 3, 3)), np.zeros_like(points)
    for column in range(3):
        np.add.at(spread, triangles[:, column], normal[:, :, None] * normal[:, None, :])
        np.add.at(direction, triangles[:, column], normal)
    move = np.einsum("pij,pj->pi", np.linalg.pinv(spread, rcond=1e-3, hermitian=True), direction)
    reach = np.linalg.norm(move, axis=1, keepdims=True)
    return points + _MARGIN * move * np.minimum(1.0, _FARTHEST / np.maximum(reach, 1.0))


def _solid(points: Floats, triangles: Ints, number: int) -> Manifold | None:
    """A closed mesh as a solid whose triangles have this number; None if it has no volume, or crosses itself."""
    if len(triangles) < 4:
        return None
    surface = Mesh64(
        vert_properties=np.ascontiguousarray(points),
        tri_verts=triangles.astype(np.uint64),
        run_index=np.array([0, 3 * len(triangles)], dtype=np.uint64),
        run_original_id=np.array([number], dtype=np.uint32),
    )
    surface.merge()
    solid = Manifold(surface)
    if solid.status() != Error.NoError or solid.is_empty() or not solid.volume() > 0.0:
        return None
    return solid


def z_up(points: Floats) -> Floats:
    """Points [P, 3] with z upwards and y to the north, as programs for printing expect them."""
    return np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1) + 0.0
