"""``extrude``: prisms over faces."""

from __future__ import annotations

from typing import Any

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.calls.calls import BoundCall, Operation
from grammarlab.derivation.frames import cube_index
from grammarlab.derivation.functions.shape_measures import alike_meshes
from grammarlab.derivation.state.box_orders import PRISM, SUNK_PRISM
from grammarlab.derivation.state.face_tags import with_automatic_tags
from grammarlab.derivation.state.mesh_table import replaced, turned_over
from grammarlab.derivation.state.shapes import EMPTY, FACE, FOOTPRINT, Ids, Shapes
from grammarlab.geometry.meshes import extrude as solids
from grammarlab.geometry.meshes.measure import face_normals
from grammarlab.geometry.meshes.mesh import BOTTOM, INNER_WALL, OUTER_WALL, TOP, Meshes

_WORDS = frozenset(
    {"world.up", "world.up.flatTop", "world.x", "world.y", "world.z", "face.normal", "vertex.normal", "x", "y", "z"}
)
_ALONG = {"x": 0, "y": 1, "z": 2, "world.x": 0, "world.y": 1, "world.z": 2, "world.up": 1, "world.up.flatTop": 1}
_NORMALS = frozenset({"face.normal", "vertex.normal"})
_LYING = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""The scope of an extruded face in the face's axes: its y is the face's z, its z the face's -y."""
_LYING_CUBE = cube_index(_LYING)
_TAGS = {BOTTOM: "bottom", TOP: "top", OUTER_WALL: "side.outer", INNER_WALL: "side.inner"}
"""Tag of each role of faces."""


def extrude(call: BoundCall) -> Shapes:
    """``extrude(height)`` or ``extrude(direction, height)``: every face moved, with walls between.

    The scope's y axis then runs along the direction, and x stays as near as possible to its old direction. A negative
    height extrudes in the opposite direction and makes ``scope.sy`` negative; all faces point outwards.
    """
    if len(call.values) != 1:
        raise call.error("extrude expects one height, or a direction such as world.up and a height")
    heights = np.broadcast_to(call.length(call.values[0], 1), call.shapes.num)
    solid = _with_tags(call, _extruded(call, heights))
    below = (heights < 0.0) & (solid.mesh != EMPTY)
    return turned_over(solid, below, call.workspace.meshes, call.workspace.frames) if below.any() else solid


def _extruded(call: BoundCall, heights: Floats) -> Shapes:
    """The solids, in scopes of positive height."""
    direction = call.words[0] if call.words else "face.normal"
    shapes = call.shapes
    if direction == "face.normal" and call.workspace.tags is None:
        footprint, face = shapes.mesh == FOOTPRINT, shapes.mesh == FACE
        if footprint.all():
            return _raised(call, shapes, heights)
        if face.all():
            return _deepened(call, shapes, heights)
        if (footprint | face).any():
            return _one_by_one(call, heights, (footprint, face))
    return _general(call, shapes, heights, direction)


def _one_by_one(call: BoundCall, heights: Floats, kinds: tuple[np.ndarray, ...]) -> Shapes:
    """The operation on each kind of geometry separately, merged again."""
    rest = ~np.logical_or.reduce(kinds)
    rows = [np.flatnonzero(kind) for kind in (*kinds, rest)]
    parts = [_extruded(_narrowed(call, chosen), heights[chosen]) for chosen in rows if len(chosen)]
    back = np.argsort(np.concatenate(rows))
    fields = ("position", "size", "frame", "mesh")
    joined: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts])[back] for name in fields}
    return call.shapes._replace(**joined)


def _narrowed(call: BoundCall, rows: np.ndarray) -> BoundCall:
    arguments = tuple(a._replace(value=a.value[rows]) if isinstance(a.value, np.ndarray) else a for a in call.arguments)
    return call._replace(shapes=call.shapes.take(rows), arguments=arguments)


def _raised(call: BoundCall, shapes: Shapes, heights: Floats) -> Shapes:
    """Rectangles on the ground become boxes."""
    size = shapes.size.copy()
    size[:, 1] = np.abs(heights)
    down = np.minimum(heights, 0.0)
    position = shapes.position
    if down.any():
        position = position + call.workspace.frames.axis(shapes.frame, 1) * down[:, None]
    return shapes._replace(position=position, size=size, mesh=_prisms(heights))


def _deepened(call: BoundCall, shapes: Shapes, heights: Floats) -> Shapes:
    """Rectangles in a wall become boxes whose y axis points out of the wall."""
    frames = call.workspace.frames
    width, height = shapes.size[:, 0], shapes.size[:, 1]
    position = shapes.position + frames.axis(shapes.frame, 1) * height[:, None]
    down = np.minimum(heights, 0.0)
    if down.any():
        position = position + frames.axis(shapes.frame, 2) * down[:, None]
    size = np.stack([width, np.abs(heights), height], axis=1)
    return shapes._replace(
        position=position, size=size, frame=frames.turned(shapes.frame, _LYING_CUBE), mesh=_prisms(heights)
    )


def _prisms(heights: Floats) -> Ids:
    """[N] what rectangles of these heights become."""
    return np.select([heights > 0.0, heights < 0.0], [PRISM, SUNK_PRISM], FOOTPRINT).astype(np.int32)


def _general(call: BoundCall, shapes: Shapes, heights: Floats, direction: str) -> Shapes:
    """Any geometry: the solid is a mesh, and the scope is rotated so that y runs along the direction."""
    given = _given_directions(call, shapes, direction)
    columns = (heights,) if given is None else (heights, given)
    meshes, first, number = alike_meshes(shapes, call.workspace, *columns)
    edges = solids.are_edges(meshes)
    if edges.any() and not edges.all():
        return _one_by_one(call, heights, (edges[number],))
    heights = heights[first]
    along = first_normals(meshes) if given is None else given[first]
    roles = call.workspace.tags is not None
    if edges.any():
        # An edge moves along the normal of its face, or the mean one of its faces: its z axis.
        along = np.broadcast_to([0.0, 0.0, 1.0], along.shape) if direction in _NORMALS else along
        solid = solids.extrude_edges(meshes, along * heights[:, None])
    elif direction == "vertex.normal":
        solid = solids.extrude_along_vertex_normals(meshes, heights, roles)
    elif direction == "world.up.flatTop":
        solid = solids.extrude_to_level(meshes, heights, along, roles)
    else:
        solid = solids.extrude(meshes, heights, None if direction == "face.normal" else along, roles)
    return stood_up(call, solid, along, number)


def _with_tags(call: BoundCall, solid: Shapes) -> Shapes:
    """The solids with the automatic tags of `_TAGS`, such as ``extrude.side.outer``."""
    return with_automatic_tags(solid, call.workspace, "extrude", lambda meshes: meshes.roles, _TAGS)


def stood_up(call: BoundCall, solid: Meshes, along: Floats, number: Ints) -> Shapes:
    """Shapes with other geometry and a scope whose y axis runs along a direction.

    Args:
        call: the operation, on shapes [N].
        solid: [K] the different geometries in metres, in the axes of the old scopes and from their origins.
        along: [K, 3] unit vectors in the axes of the old scopes.
        number: [N] the geometry of each shape.
    """
    shapes, frames, table = call.shapes, call.workspace.frames, call.workspace.meshes
    rotation = _standing_on(along)
    points = np.einsum("pji,pj->pi", rotation[solid.mesh_of_point()], solid.points)
    turned = solid.with_points(points, turn=rotation.swapaxes(1, 2))
    standing = shapes._replace(frame=frames.rotated_alike(shapes.frame, rotation, number))
    return replaced(standing, turned, number, table, frames)


def _given_directions(call: BoundCall, shapes: Shapes, direction: str) -> Floats | None:
    """[N, 3] a direction as unit vectors in scope axes; None for those of the geometry."""
    if direction not in _ALONG:
        return None
    axis = np.broadcast_to(np.eye(3)[_ALONG[direction]], (shapes.num, 3))
    return call.workspace.frames.to_local(shapes.frame, axis) if direction.startswith("world") else axis


def first_normals(meshes: Meshes) -> Floats:
    """[M, 3] unit normals of the first faces of meshes; up if there is no face."""
    first = np.zeros((len(meshes), 3))
    filled = np.diff(meshes.mesh_faces) > 0
    first[filled] = face_normals(meshes)[meshes.mesh_faces[:-1][filled]]
    first[~first.any(axis=1)] = [0.0, 1.0, 0.0]
    return first


def _standing_on(y: Floats) -> Floats:
    """[N, 3, 3] rotations with a given y axis and an x axis as near as possible to the old one."""
    x: Floats = np.array([1.0, 0.0, 0.0]) - y * y[:, :1]
    length = np.linalg.norm(x, axis=1, keepdims=True)
    x = np.where(length > 1e-6, x / np.maximum(length, 1e-6), np.cross(y, [0.0, 0.0, 1.0]))
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, y, np.cross(x, y)], axis=2).astype(np.float64)


OPERATIONS: dict[str, Operation] = {"extrude": Operation(extrude, _WORDS, (1, 2))}
