"""Watertight solids of models, for printing: all shapes of a model united, without hollows inside."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from manifold3d import Error, Manifold, Mesh64, OpType
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
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
_MOST_SHAPES = 10_000
"""Largest number of shapes that are united: their time grows faster than their number."""


@dataclass(frozen=True, slots=True)
class Solid:
    """The surface of one model as a closed mesh, y up, metres from the origin of the model."""

    points: Floats
    """[P, 3] different points."""
    triangles: Ints
    """[T, 3] rows of `points`, counter-clockwise from outside; each edge has two triangles."""
    material: NDArray[np.int32]
    """[T] index into the materials of the scene."""


@dataclass(frozen=True, slots=True)
class _Shape:
    """A mesh in the unit cube as triangles."""

    points: Floats
    triangles: Ints
    rim: Ints
    """[R, 2] directed edges without a triangle at their other side."""


def solid_of(scene: Scene) -> Solid:
    """The solid of a scene of one model: empty if it has no shape with an area.

    Shapes that enclose a volume are solid. Others, as walls without thickness, become `_THICKNESS` thick, inwards.
    Hollows that are closed on all sides are filled.

    Raises:
        UsageError: If it has more than `_MOST_SHAPES` shapes.
    """
    if len(scene) > _MOST_SHAPES:
        raise UsageError(
            f"a model has {len(scene):,} shapes and at most {_MOST_SHAPES:,} are united to a solid; "
            "choose another format, or a model of less detail"
        )
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
    return Solid(points[used, :3], rows, scene.material[shape] if len(shape) else np.zeros(0, np.int32))


def _solids(scene: Scene, first_id: int) -> Iterator[Manifold]:
    """The solids of all shapes with a volume; the triangles of instance k have the id ``first_id + k``."""
    used, mesh = np.unique(scene.mesh, return_inverse=True)
    shapes = [_shape(scene, index) for index in used.tolist()]
    for row, (index, frame) in enumerate(zip(mesh.tolist(), scene.frame.tolist(), strict=True)):
        shape, size = shapes[index], scene.size[row]
        is_closed = not len(shape.rim)
        if is_closed:
            size = np.where(size > 0.0, size, _THICKNESS)
        points = scene.position[row] + (shape.points * size) @ scene.frames[frame].T
        triangles = shape.triangles
        if not is_closed:
            points, triangles = _thick(points, triangles, shape.rim)
        solid = _solid(_larger(points, triangles), triangles, first_id + row)
        if solid is not None:
            yield solid


def _shape(scene: Scene, index: int) -> _Shape:
    mesh = scene.meshes.take(np.array([index]))
    triangles, _ = triangulate(mesh)
    points, point = np.unique(mesh.points, axis=0, return_inverse=True)
    triangles = point.ravel()[triangles]
    is_proper = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    triangles = triangles[is_proper]
    edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    there, back = edges @ (len(points), 1), edges[:, ::-1] @ (len(points), 1)
    return _Shape(points, triangles, edges[~np.isin(there, back)])


def _thick(points: Floats, triangles: Ints, rim: Ints) -> tuple[Floats, Ints]:
    """An open surface with a second one behind it, and walls along its rim."""
    corner = points[triangles]
    normal = np.zeros_like(points)
    turn = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    for column in range(3):
        np.add.at(normal, triangles[:, column], turn)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    behind = points - _THICKNESS * normal / np.where(length > 0.0, length, 1.0)
    num = len(points)
    start, end = rim.T
    walls = np.concatenate([np.stack([end, start, start + num], 1), np.stack([end, start + num, end + num], 1)])
    return np.concatenate([points, behind]), np.concatenate([triangles, triangles[:, ::-1] + num, walls])


def _larger(points: Floats, triangles: Ints) -> Floats:
    """Points of a closed mesh whose faces have moved outwards by the margin, as far as three faces can at a corner."""
    corner = points[triangles]
    turn = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(turn, axis=1, keepdims=True)
    normal = turn / np.where(length > 0.0, length, 1.0)
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
