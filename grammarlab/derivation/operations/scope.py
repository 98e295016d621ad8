"""Operations that move, scale and rotate the scope with its geometry."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import Argument, BoundCall, Operation, OperationFunction
from grammarlab.derivation.calls.texture_transfer import carried, initial_maps, pivot_position, with_pivot
from grammarlab.derivation.frames import euler
from grammarlab.derivation.state.mesh_table import mirrored
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.derivation.state.texture_maps import map_name
from grammarlab.derivation.state.trim_planes import NONE, TRIM

_SMALLEST = -1e-9
"""Largest size in metres that counts as zero, since it comes from rounding."""

_CENTER_AXES = frozenset({"x", "y", "z", "xy", "xz", "yz", "xyz"})
_SYSTEMS = frozenset({"abs", "rel", "scope", "pivot", "object", "world"})
_PIVOTS = frozenset({"scopeOrigin", "scopeCenter"})


def t(call: BoundCall) -> Shapes:
    """``t(x, y, z)``: move along the scope's axes by metres, or ``'`` shares of its size."""
    return call.shapes._replace(position=moved(call, call.arguments))


def moved(call: BoundCall, lengths: tuple[Argument, ...]) -> Floats:
    """Positions [N, 3] moved along the scope's axes."""
    position = call.shapes.position
    for axis, argument in enumerate(lengths):
        length = call.length(argument, axis)
        if isinstance(length, np.ndarray):
            position = position + call.workspace.frames.axis(call.shapes.frame, axis) * length[:, None]
        elif length != 0.0:
            position = position + call.workspace.frames.axis(call.shapes.frame, axis) * length
    return position


def s(call: BoundCall) -> Shapes:
    """``s(x, y, z)``: set the size of the scope; the geometry is scaled with it.

    A negative size mirrors the shape along that axis, and its faces then point inwards. The scope has a positive size
    afterwards and begins at its other end; only a shape below a negative extrusion keeps its negative height.
    """
    size, turns = call.shapes.size.copy(), False
    for axis, argument in enumerate(call.arguments):
        value = argument.value
        if not (argument.relative and type(value) is float and 0.0 <= value < math.inf):
            size[:, axis] = length = call.length(argument, axis)
            turns = turns or (length.min() if isinstance(length, np.ndarray) else length) < 0.0
        elif value != 1.0:
            size[:, axis] *= value
    return _turned(call, size) if turns else _resized(call, size)


def _resized(call: BoundCall, size: Floats) -> Shapes:
    return carried(call.shapes, call.shapes.resized(size), call.workspace)


def _turned(call: BoundCall, size: Floats) -> Shapes:
    """Shapes of new sizes [N, 3], some negative, mirrored where only the new size is negative."""
    sunk = call.shapes.size < 0.0
    size = np.where((size < 0.0) & (size > _SMALLEST) & ~sunk, 0.0, size)
    return mirrored(_resized(call, size), (size < 0.0) & ~sunk, call.workspace.meshes, call.workspace.frames)


def center(call: BoundCall) -> Shapes:
    """``center(axes)``: centre the scope, along these axes, in the shape at the beginning of the sequence."""
    shapes, origin = call.shapes, call.origin
    # Each shape by itself, whatever the others of a batch are: the two ways differ in the last bit.
    stays = (shapes.frame == origin.frame) & (shapes.position == origin.position).all(axis=1)
    position = _centered(call) if stays.any() else shapes.position
    if not stays.all():
        position = np.where(stays[:, None], position, _centered_anywhere(call))
    return shapes._replace(position=position)


def _centered(call: BoundCall) -> Floats:
    """Positions [N, 3] of shapes that were scaled, but not moved or rotated, since the sequence began."""
    position = call.shapes.position
    for axis, name in enumerate("xyz"):
        if name in str(call.arguments[0].value):
            margin = 0.5 * (call.origin.size[:, axis] - call.shapes.size[:, axis])
            position = position + call.workspace.frames.axis(call.shapes.frame, axis) * margin[:, None]
    return position


def _centered_anywhere(call: BoundCall) -> Floats:
    """Positions [N, 3] of shapes that may have been moved or rotated since the sequence began."""
    frames, shapes, origin = call.workspace.frames, call.shapes, call.origin
    target = origin.position + frames.to_world(origin.frame, 0.5 * origin.size)
    current = shapes.position + frames.to_world(shapes.frame, 0.5 * shapes.size)
    offset = frames.to_local(shapes.frame, target - current)
    chosen = np.array([axis in str(call.arguments[0].value) for axis in "xyz"])
    return shapes.position + frames.to_world(shapes.frame, offset * chosen)


def r(call: BoundCall) -> Shapes:
    """``r(x, y, z)``: rotate about the pivot's axes, around the scope's origin or, with ``scopeCenter``, its centre."""
    shapes, frames = call.shapes, call.workspace.frames
    frame = frames.rotated_about(shapes.frame, shapes.pivot, _turn(call))
    if "scopeCenter" in call.words:
        half = 0.5 * shapes.size
        position = shapes.position + frames.to_world(shapes.frame, half) - frames.to_world(frame, half)
        return shapes._replace(frame=frame, position=position)
    return shapes._replace(frame=frame)


def _turn(call: BoundCall) -> Floats:
    """Rotation from an operation's three angles in degrees: [3, 3], or [N, 3, 3] if they differ."""
    x, y, z = (call.number(argument) for argument in call.values)
    return euler(x, y, z)


def translate(call: BoundCall) -> Shapes:
    """``translate(rel|abs, scope|pivot|object|world, x, y, z)``: move along, or to a place in, a system of axes."""
    mode, system = _mode_and_system(call)
    lengths = np.stack([np.broadcast_to(call.length(a, i), call.shapes.num) for i, a in enumerate(call.values)], axis=1)
    shapes, frames = call.shapes, call.workspace.frames
    offset = frames.to_world(_axes(call, system), lengths)
    start = shapes.position if mode == "rel" else _origin(call, system)
    return shapes._replace(position=start + offset)


def rotate(call: BoundCall) -> Shapes:
    """``rotate(rel|abs, scope|pivot|object|world, x, y, z)``: turn about the origin of the scope."""
    mode, system = _mode_and_system(call)
    shapes, frames, turn = call.shapes, call.workspace.frames, _turn(call)
    axes = _axes(call, system)
    if mode == "abs":
        return shapes._replace(frame=frames.rotated(axes, turn))
    return shapes._replace(frame=frames.rotated_about(shapes.frame, axes, turn))


def _mode_and_system(call: BoundCall) -> tuple[str, str]:
    words = call.words
    if len(words) != 2 or len(call.values) != 3 or words[0] not in {"abs", "rel"} or words[1] in {"abs", "rel"}:
        raise call.error(
            f"{call.name} expects abs or rel, then scope, pivot, object or world, then three numbers",
            f"for example {call.name}(rel, world, 0, 1, 0)",
        )
    return words[0], words[1]


def _origin(call: BoundCall, system: str) -> Floats:
    """Origins [N, 3] of a coordinate system, relative to the origin of positions."""
    shapes = call.shapes
    if system == "world":
        return -call.workspace.origins[shapes.model]
    if system == "object":
        return call.workspace.roots.position[shapes.model]
    return shapes.position if system == "scope" else pivot_position(shapes, call.workspace)


def _axes(call: BoundCall, system: str) -> NDArray[np.int32]:
    """The frames [N] of a coordinate system."""
    shapes = call.shapes
    if system == "world":
        return np.zeros_like(shapes.frame)
    if system == "object":
        return call.workspace.roots.frame[shapes.model]
    return shapes.frame if system == "scope" else shapes.pivot


def _moving(apply: OperationFunction) -> OperationFunction:
    """An operation that moves or rotates shapes with their texture coordinates."""
    return lambda call: carried(call.shapes, apply(call), call.workspace)


def reset_geometry(call: BoundCall) -> Shapes:
    """``resetGeometry()``: geometry, scope, pivot and texture coordinates of the initial shape, without trim planes.

    Materials, attributes and projections stay.
    """
    shapes, workspace = call.shapes, call.workspace
    roots = workspace.roots.take(shapes.model)
    maps = {map_name(uv_set) for uv_set in workspace.uv_sets}
    state = {name: value for name, value in initial_maps(roots, workspace).items() if name in maps}
    if TRIM in shapes.state:
        state[TRIM] = NONE
    again = shapes._replace(
        mesh=roots.mesh,
        size=roots.size,
        position=roots.position,
        frame=roots.frame,
        state={**shapes.state, **state},
    )
    return with_pivot(again, roots.position, roots.frame, workspace)


OPERATIONS: dict[str, Operation] = {
    "center": Operation(_moving(center), _CENTER_AXES, (1, 1)),
    "r": Operation(_moving(r), _PIVOTS, (3, 4)),
    "resetGeometry": Operation(reset_geometry),
    "rotate": Operation(_moving(rotate), _SYSTEMS, (5, 5)),
    "s": Operation(s, num_arguments=(3, 3)),
    "scale": Operation(s, num_arguments=(3, 3)),
    "t": Operation(_moving(t), num_arguments=(3, 3)),
    "translate": Operation(_moving(translate), _SYSTEMS, (5, 5)),
}
