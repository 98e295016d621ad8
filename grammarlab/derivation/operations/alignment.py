"""Operations that change the axes of the scope but not the geometry, or mirror the geometry."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, distinct, distinct_rows
from grammarlab.derivation.calls.calls import Argument, BoundCall, Operation, OperationFunction
from grammarlab.derivation.calls.texture_transfer import carried, with_pivot
from grammarlab.derivation.frames import cube_indices, euler
from grammarlab.derivation.functions.shape_measures import alike_meshes, local_meshes
from grammarlab.derivation.state.box_orders import is_box
from grammarlab.derivation.state.mesh_table import add_faces, different_ids, normalized
from grammarlab.derivation.state.shapes import BOX, EMPTY, FACE, Shapes, as_column
from grammarlab.geometry.meshes.measure import corner_edges, face_areas, face_normals
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.ragged import next_in_row
from grammarlab.language.syntax.keywords import KEYWORDS

Rows = NDArray[np.int64]

_TOLERANCE = 1e-9
"""Largest component of the difference of axes that count as equal."""
_AXES_WORDS = frozenset(
    {"x", "y", "z", *(f"{system}.{axes}" for system in ("world", "object") for axes in ("x", "y", "z", "xyz"))}
)
_GEOMETRY_WORDS = frozenset({"yUp", "zUp", "any", "auto", "largest", "longest", "world.lowest"})
_PIVOT_WORDS = frozenset({"xyz", "yzx", "zxy"})
_PIVOT_CORNERS = np.array(
    [
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
        [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
        [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
        [[0, 0, 1], [0, -1, 0], [1, 0, 0]],
        [[-1, 0, 0], [0, -1, 0], [0, 0, 1]],
        [[0, 0, -1], [0, -1, 0], [-1, 0, 0]],
        [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
    ],
    dtype=np.float64,
)
"""[8, 3, 3] rows are the x, y and z axis that ``setPivot(xyz, corner)`` gives, in the old axes."""
_PIVOT_ORDER = {"xyz": [0, 1, 2], "yzx": [2, 0, 1], "zxy": [1, 2, 0]}


def reframed(call: BoundCall, turn: Floats) -> Shapes:
    """Shapes with scopes rotated by [N, 3, 3] in their own axes and fitted to the unchanged geometry."""
    shapes, frames, table = call.shapes, call.workspace.frames, call.workspace.meshes
    frame = frames.rotated(shapes.frame, turn)
    cubes = cube_indices(turn)
    if is_box(shapes.mesh).all() and (cubes >= 0).all():
        inverse = np.swapaxes(turn, 1, 2)
        extent = np.einsum("nij,nj->ni", inverse, shapes.size)
        position = shapes.position + frames.to_world(frame, np.minimum(extent, 0.0))
        mesh = table.boxes.turned(shapes.mesh, cubes)
        return shapes._replace(position=position, size=np.abs(extent), frame=frame, mesh=mesh)
    meshes, first, number = alike_meshes(shapes, call.workspace, turn)
    turn = turn[first]
    points = np.einsum("pji,pj->pi", turn[meshes.mesh_of_point()], meshes.points)
    turned = meshes.with_points(points, turn=turn.swapaxes(1, 2))
    unit, low, size = normalized(turned)
    mesh = np.where(shapes.mesh == EMPTY, np.int32(EMPTY), add_faces(table, unit)[number])
    position = shapes.position + frames.to_world(frame, low[number])
    return shapes._replace(position=position, size=size[number], frame=frame, mesh=mesh.astype(np.int32))


def repivoted(call: BoundCall, turn: Floats) -> Shapes:
    """Shapes from `reframed` with the pivot at the origin of the new scope."""
    shapes = reframed(call, turn)
    return with_pivot(shapes, shapes.position, shapes.frame, call.workspace)


def where(call: BoundCall, chosen: NDArray[np.bool_], apply: OperationFunction) -> Shapes:
    """Shapes of which only the chosen ones [N] are changed, by an operation on scopes and geometry."""
    rows = np.flatnonzero(chosen)
    if len(rows) == 0:
        return call.shapes
    changed = apply(call.rows(rows))
    fields = ("position", "size", "frame", "pivot", "mesh")
    merged = {name: getattr(call.shapes, name).copy() for name in fields}
    for name, column in merged.items():
        column[rows] = getattr(changed, name)
    state = dict(call.shapes.state)
    for name, value in changed.state.items():
        if value is not call.shapes.state.get(name):
            column = as_column(call.shapes.state[name], call.shapes.num, call.workspace.strings).copy()
            column[rows] = value
            state[name] = column
    return call.shapes._replace(**merged, state=state)


def rotate_scope(call: BoundCall) -> Shapes:
    """``rotateScope(x, y, z)``: turn the scope's axes by degrees, about the pivot's axes."""
    frames, shapes = call.workspace.frames, call.shapes
    x, y, z = (call.number(argument) for argument in call.arguments)
    inverse = np.swapaxes(frames.rotations(shapes.frame), 1, 2)
    return reframed(call, inverse @ frames.rotations(frames.rotated_about(shapes.frame, shapes.pivot, euler(x, y, z))))


def align_to_axes(call: BoundCall) -> Shapes:
    """``alignScopeToAxes(y)``: one axis along the world's, the next one as near as possible to its old direction.

    Without an argument all axes are the world's. With ``object.y`` the axes are those of the initial shape.
    """
    system, _, word = call.words[0].rpartition(".") if call.words else ("", "", "xyz")
    frames, shapes = call.workspace.frames, call.shapes
    rotations = frames.rotations(shapes.frame)
    if system == "object":
        initial = frames.rotations(call.workspace.roots.frame[shapes.model])
        rotations = np.swapaxes(initial, 1, 2) @ rotations
    if word == "xyz":
        return repivoted(call, np.swapaxes(rotations, 1, 2))
    axis = "xyz".index(word)
    fixed = np.broadcast_to(np.eye(3)[axis], (shapes.num, 3))
    if np.abs(rotations[:, :, axis] - fixed).max() < _TOLERANCE:
        return with_pivot(shapes, shapes.position, shapes.frame, call.workspace)
    neighbour = 0 if axis != 0 else 2
    target = _axes(fixed, axis, rotations[:, :, neighbour], neighbour, rotations[:, :, 2 - neighbour])
    return repivoted(call, np.swapaxes(rotations, 1, 2) @ target)


def _axes(fixed: Floats, axis: int, near: Floats, neighbour: int, fallback: Floats) -> Floats:
    """[N, 3, 3] right-handed axes, one given, another one as near as possible to a direction.

    Where that direction is along the given axis, the third axis is as near as possible to `fallback`.
    """
    flat = near - fixed * np.einsum("ni,ni->n", near, fixed)[:, None]
    is_cyclic = (neighbour + 1) % 3 == axis
    other = np.cross(fixed, fallback) if is_cyclic else np.cross(fallback, fixed)
    flat = np.where(np.linalg.norm(flat, axis=1, keepdims=True) > 1e-6, flat, other)
    spare = np.cross(fixed, np.roll(fixed, 1, axis=1))
    flat = np.where(np.linalg.norm(flat, axis=1, keepdims=True) > 1e-6, flat, spare)
    flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    axes = np.empty((len(fixed), 3, 3))
    axes[:, :, axis], axes[:, :, neighbour] = fixed, flat
    last = 3 - axis - neighbour
    axes[:, :, last] = np.cross(axes[:, :, (last + 1) % 3], axes[:, :, (last + 2) % 3])
    return axes


def align_to_geometry(call: BoundCall) -> Shapes:
    """``alignScopeToGeometry(yUp|zUp, face, edge)``: one axis along a face's normal, x along an edge.

    The face is an index, ``largest``, ``world.lowest`` or ``any``; the edge an index, ``longest``, ``world.lowest``
    or ``any``.
    """
    if not call.words or call.words[0] not in ("yUp", "zUp") or len(call.arguments) < 2:
        raise call.error("alignScopeToGeometry expects yUp or zUp, then a face, then an edge")
    meshes = local_meshes(call.shapes, call.workspace)
    if (np.diff(meshes.mesh_faces) == 0).any():
        return where(call, np.diff(meshes.mesh_faces) > 0, align_to_geometry)
    which_edge = call.arguments[2] if len(call.arguments) > 2 else Argument("auto", keyword=True)
    corner = _chosen_corner(call, meshes, call.arguments[1], which_edge)
    normal = face_normals(meshes)[meshes.face_of_corner()[corner]]
    normal = np.where(normal.any(axis=1, keepdims=True), normal, [0.0, 1.0, 0.0])
    along = corner_edges(meshes)[corner]
    up = 1 if call.words[0] == "yUp" else 2
    return repivoted(call, _axes(normal, up, along, 0, np.roll(normal, 1, axis=1)))


def _chosen_corner(call: BoundCall, meshes: Meshes, face: Argument, edge: Argument) -> Rows:
    """[N] first corner of the edge that a shape is aligned to."""
    mesh, of_corner = meshes.mesh_of_face(), meshes.face_of_corner()
    height = _world_heights(call, meshes)[meshes.corner_points()]
    lengths = np.linalg.norm(corner_edges(meshes), axis=1)
    if face.keyword and face.value in ("any", "auto"):
        is_candidate = np.ones(meshes.num_faces, dtype=bool)
    else:
        is_candidate = np.zeros(meshes.num_faces, dtype=bool)
        is_candidate[_chosen_face(call, meshes, face, height)] = True
    candidates = np.flatnonzero(is_candidate[of_corner])
    owner = mesh[of_corner[candidates]]
    if edge.keyword and edge.value == "longest":
        cost = -np.round(lengths[candidates], 9)
    elif edge.keyword and edge.value in ("world.lowest", "auto"):
        is_free = face.keyword and face.value in ("any", "auto")
        chosen = _lowest_edges if is_free else _mean_heights
        cost = chosen(meshes, candidates, owner, height)
    elif edge.keyword:
        cost = np.zeros(len(candidates))
    else:
        return _nth(candidates, owner, call.column(edge), len(meshes))
    return candidates[_first_of_smallest(cost, owner, len(meshes))]


def _mean_heights(meshes: Meshes, candidates: Rows, owner: Rows, height: Floats) -> Floats:
    """[K] mean heights of edges, for the edges of one face."""
    return np.round(0.5 * (height + height[next_in_row(meshes.face_offsets)])[candidates], 9)


def _lowest_edges(meshes: Meshes, candidates: Rows, owner: Rows, height: Floats) -> Floats:
    """[K] ranks of edges, for those of all faces: those with the lowest corner first, the least steep, the longest."""
    lengths = np.linalg.norm(corner_edges(meshes), axis=1)
    ends = np.stack((height, height[next_in_row(meshes.face_offsets)]))[:, candidates]
    low = np.round(ends.min(axis=0), 9)
    steepness = np.round(np.abs(ends[1] - ends[0]) / np.maximum(lengths[candidates], 1e-12), 9)
    order = np.lexsort((-np.round(lengths[candidates], 9), steepness, low, owner))
    rank = np.empty(len(candidates))
    rank[order] = np.arange(len(candidates))
    return rank


def _chosen_face(call: BoundCall, meshes: Meshes, face: Argument, height: Floats) -> Rows:
    mesh = meshes.mesh_of_face()
    if face.keyword and face.value == "largest":
        return _first_of_smallest(-np.round(face_areas(meshes), 9), mesh, len(meshes))
    if face.keyword:
        up = call.workspace.frames.rotations(call.shapes.frame)[:, 1, :]
        steep = -np.abs(np.einsum("fi,fi->f", face_normals(meshes), up[mesh]))
        low = np.minimum.reduceat(height, meshes.face_offsets[:-1])
        order = np.lexsort((np.round(steep, 9), np.round(low, 9), mesh))
        return order[np.searchsorted(mesh, np.arange(len(meshes)))]
    return _nth(np.arange(meshes.num_faces), mesh, call.column(face), len(meshes))


def _first_of_smallest(cost: Floats, owner: Rows, count: int) -> Rows:
    """First row with the smallest cost, for each owner; owners ascend."""
    order = np.lexsort((cost, owner))
    return order[np.searchsorted(owner, np.arange(count))]


def _nth(rows: Rows, owner: Rows, index: Floats, count: int) -> Rows:
    """Row of each owner with a number, modulo its number of rows."""
    first = np.searchsorted(owner, np.arange(count))
    numbers = np.bincount(owner, minlength=count)
    return rows[first + np.rint(index).astype(np.int64) % numbers]


def _world_heights(call: BoundCall, meshes: Meshes) -> Floats:
    up = call.workspace.frames.rotations(call.shapes.frame)[:, 1, :]
    return np.einsum("pj,pj->p", up[meshes.mesh_of_point()], meshes.points)


def align_to_box(call: BoundCall) -> Shapes:
    """``alignScopeToGeometryBBox(xz)``: turn the scope in a plane of its axes to the least box around it.

    Of all turns up to 45 degrees, the smallest is taken that gives the rectangle of least area in that plane.
    """
    first, second = ("xyz".index(letter) for letter in call.words[0])
    meshes = local_meshes(call.shapes, call.workspace)
    angles = np.zeros(call.shapes.num)
    for row in range(call.shapes.num):
        points = meshes.points[meshes.mesh_points[row] : meshes.mesh_points[row + 1]][:, [first, second]]
        angles[row] = _least_turn(points)
    turn = np.broadcast_to(np.eye(3), (call.shapes.num, 3, 3)).copy()
    turn[:, first, first] = turn[:, second, second] = np.cos(angles)
    turn[:, second, first], turn[:, first, second] = np.sin(angles), -np.sin(angles)
    return repivoted(call, turn)


def _least_turn(points: Floats) -> float:
    """Angle from -pi/4 to pi/4 of the rectangle of least area around points [P, 2]."""
    from shapely import MultiPoint, Polygon  # noqa: PLC0415  # few grammars need it

    hull = MultiPoint(points).convex_hull if len(points) else None
    if not isinstance(hull, Polygon):
        return 0.0
    corners = np.asarray(hull.exterior.coords)
    along = np.diff(corners, axis=0)
    candidates = np.append(0.0, np.arctan2(along[:, 1], along[:, 0]))
    candidates = (candidates + np.pi / 4.0) % (np.pi / 2.0) - np.pi / 4.0
    cos, sin = np.cos(candidates)[:, None], np.sin(candidates)[:, None]
    x, y = corners.T
    area = np.ptp(cos * x + sin * y, axis=1) * np.ptp(cos * y - sin * x, axis=1)
    least = candidates[area <= area.min() * (1.0 + _TOLERANCE)]
    return float(least[np.abs(least).argmin()])


def set_pivot(call: BoundCall) -> Shapes:
    """``setPivot(xyz|yzx|zxy, corner)``: the scope's origin at another corner, its axes along the edges there."""
    if not call.words or len(call.values) != 1:
        raise call.error("setPivot expects xyz, yzx or zxy, then a corner from 0 to 7")
    corner = np.rint(call.column(call.values[0])).astype(np.int64) % 8
    rows = _PIVOT_CORNERS[corner][:, _PIVOT_ORDER[call.words[0]], :]
    return repivoted(call, np.swapaxes(rows, 1, 2).copy())


def mirror(call: BoundCall) -> Shapes:
    """``mirror(x, y, z)``: mirror the geometry within its scope along the axes that are true."""
    flips = [_flag(call, argument) for argument in call.arguments]
    turned = carried(_seen_from_other_ends(call, np.array(flips)), call.shapes, call.workspace)
    return _mirrored(call._replace(shapes=turned), flips)


def _seen_from_other_ends(call: BoundCall, flips: NDArray[np.bool_]) -> Shapes:
    """The same shapes in scopes with some axes reversed."""
    size = call.shapes.size
    offset = call.workspace.frames.to_world(call.shapes.frame, np.where(flips, size, 0.0))
    return call.shapes._replace(position=call.shapes.position + offset, size=np.where(flips, -size, size))


def mirror_scope(call: BoundCall) -> Shapes:
    """``mirrorScope(x, y, z)``: reverse axes of the scope, which then begin at its other end; the geometry stays.

    A scope with one or three reversed axes is left-handed until a derivation ends (`MeshTable.right_handed`).
    """
    columns = [np.broadcast_to(np.asarray(_truths(call, argument)), call.shapes.num) for argument in call.arguments]
    codes = sum(column.astype(np.int64) << axis for axis, column in enumerate(columns))
    for code in distinct(np.asarray(codes), 8).tolist():
        if code:
            reversed_axes = [bool(code >> axis & 1) for axis in range(3)]
            shapes = where(call, codes == code, lambda part, axes=reversed_axes: _reversed_scope(part, axes))
            call = call._replace(shapes=shapes)
    return call.shapes


def _truths(call: BoundCall, argument: Argument) -> bool | NDArray[np.bool_]:
    value = argument.value
    if isinstance(value, bool) or (isinstance(value, np.ndarray) and value.dtype.kind == "b"):
        return value  # type: ignore[return-value, ty:invalid-explicit-return]
    raise call.error(f"{call.name} expects true or false for each axis")


def _reversed_scope(call: BoundCall, flips: Sequence[bool]) -> Shapes:
    shapes, frames = call.shapes, call.workspace.frames
    offset = frames.to_world(shapes.frame, np.where(flips, shapes.size, 0.0))
    turned = _mirrored(call, flips)
    frame = frames.rotated(shapes.frame, np.diag(np.where(flips, -1.0, 1.0)))
    return turned._replace(position=shapes.position + offset, frame=frame)


def _mirrored(call: BoundCall, flips: Sequence[bool]) -> Shapes:
    """Shapes with other geometry in the same scopes."""
    shapes = call.shapes
    rows = np.flatnonzero(shapes.mesh > BOX)
    if not any(flips) or len(rows) == 0:
        return shapes
    extends = shapes.size[rows] != 0.0
    first, number = distinct_rows(shapes.mesh[rows], extends)
    meshes = call.workspace.meshes.take(shapes.mesh[rows[first]])
    points = meshes.points.copy()
    filled = extends[first][meshes.mesh_of_point()]
    for axis, flip in enumerate(flips):
        if flip:
            points[:, axis] = np.where(filled[:, axis], 1.0 - points[:, axis], points[:, axis])
    # Reversed faces get reversed normals, but a mirrored normal still points outwards.
    signs = np.where(flips, -1.0, 1.0) * (-1.0 if sum(flips) % 2 else 1.0)
    mirrored = meshes.with_points(points, stretch=np.broadcast_to(signs, (len(meshes), 3)))
    if sum(flips) % 2:
        mirrored = mirrored.reversed()
    mesh = shapes.mesh.copy()
    mesh[rows] = add_faces(call.workspace.meshes, mirrored)[number]
    return shapes._replace(mesh=mesh)


def _flag(call: BoundCall, argument: Argument) -> bool:
    if isinstance(argument.value, bool):
        return argument.value
    raise call.error(f"{call.name} expects true or false for each axis, the same for all shapes")


def reverse_normals(call: BoundCall) -> Shapes:
    """``reverseNormals()``: the same faces with reversed orientation."""
    table, mesh = call.workspace.meshes, call.shapes.mesh.copy()
    for kind in range(BOX, FACE + 1):
        turned = table.take(np.array([kind])).reversed
        mesh[call.shapes.mesh == kind] = table.named(f"reversed:{kind}", turned)
    rows = np.flatnonzero((call.shapes.mesh > FACE) | (call.shapes.mesh < 0))
    if len(rows):
        different, number = different_ids(mesh[rows])
        mesh[rows] = add_faces(table, table.take(different).reversed())[number]
    return call.shapes._replace(mesh=mesh)


OPERATIONS: dict[str, Operation] = {
    "alignScopeToAxes": Operation(align_to_axes, _AXES_WORDS, (0, 1)),
    "alignScopeToGeometry": Operation(align_to_geometry, _GEOMETRY_WORDS, (2, 3)),
    "alignScopeToGeometryBBox": Operation(align_to_box, KEYWORDS["axis_pair"], (1, 1)),
    "mirror": Operation(mirror, num_arguments=(3, 3)),
    "mirrorScope": Operation(mirror_scope, num_arguments=(3, 3)),
    "reverseNormals": Operation(reverse_normals),
    "rotateScope": Operation(rotate_scope, num_arguments=(3, 3)),
    "setPivot": Operation(set_pivot, _PIVOT_WORDS, (2, 2)),
}
