"""Operations on texture coordinates: projections, and changes of existing coordinates."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import Argument, BoundCall, Operation
from grammarlab.derivation.functions.shape_textures import Range, range_of, uv_set_of
from grammarlab.derivation.state.corner_maps import own_maps
from grammarlab.derivation.state.shapes import Ids, Shapes, number_column
from grammarlab.derivation.state.texture_maps import DELETED, projection_name, with_maps
from grammarlab.language.syntax.keywords import KEYWORDS

Change: TypeAlias = Callable[[BoundCall, Shapes, tuple[Floats, ...], Floats], Floats]
"""New maps [N, 2, 4] from the operation, shapes [N], its numbers [N] and their maps [N, 2, 4]."""


def setup_projection(call: BoundCall) -> Shapes:
    """``setupProjection(set, axes, width, height, uOffset, vOffset, uwFactor)``: the projection for ``projectUV``.

    u is the position along the first axis, less the offset, plus `uwFactor` times the position along the third axis, in
    textures of this width; v is that along the second axis, in textures of this height: the lower left corner of the
    image is at the offsets. Positions count from the origin of the current scope, or of the world. ``'x`` is a share of
    the scope's size along the axis, and ``~x`` is adjusted so that a whole number fills it. A negative size mirrors the
    image, and a size of 0 makes the coordinate 0.
    """
    uv_set = _uv_set(call, 0)
    if len(call.words) != 1 or call.words[0] not in KEYWORDS["projection"]:
        example = "for example setupProjection(0, scope.xy, 2, 1)"
        raise call.error("setupProjection expects a uv set, axes, a width and a height", example)
    system, _, letters = call.words[0].partition(".")
    axes = ["xyz".index(letter) for letter in letters]
    shapes, numbers = call.shapes, call.values[1:]
    rotations = call.workspace.frames.rotations(shapes.frame if system == "scope" else np.zeros_like(shapes.frame))
    origin = shapes.position if system == "scope" else -call.workspace.origins[shapes.model]
    gradients = [rotations[:, :, axis] for axis in axes]
    if len(numbers) > 4:
        gradients[0] = gradients[0] + rotations[:, :, 3 - sum(axes)] * call.column(numbers[4])[:, None]
    maps = np.empty((shapes.num, 2, 4))
    for row, (axis, gradient) in enumerate(zip(axes, gradients, strict=True)):
        share = _reciprocal(_tile(call, numbers[row], np.abs(shapes.size[:, axis])))
        offset = call.length(numbers[2 + row], axis) if len(numbers) > 2 + row else 0.0
        maps[:, row, :3] = gradient * share[:, None]
        # Subtracted from 0, since a coordinate without an offset is 0, not -0.
        maps[:, row, 3] = (0.0 - (offset + np.einsum("ni,ni->n", gradient, origin))) * share
    ids = call.workspace.texture_maps.add(maps, np.zeros(shapes.num, dtype=bool))
    return shapes._replace(state={**shapes.state, projection_name(uv_set): ids})


def project(call: BoundCall) -> Shapes:
    """``projectUV(set)``: coordinates from the projection of ``setupProjection``, or from that of the initial shape."""
    uv_set = _uv_set(call, 0)
    projection: Ids = np.asarray(call.shapes.state[projection_name(uv_set)])
    return with_maps(call.shapes, uv_set, projection)


def delete(call: BoundCall) -> Shapes:
    """``deleteUV(set)``: remove the coordinates."""
    return with_maps(call.shapes, _uv_set(call, 0), np.full(call.shapes.num, DELETED, dtype=np.int32))


def copy(call: BoundCall) -> Shapes:
    """``copyUV(from, to)``: the coordinates of one set for another."""
    ids = own_maps(call.shapes, _uv_set(call, 0), call.workspace).copy()
    rows = np.flatnonzero(ids >= 0)
    ids[rows] = _new_ids(call, call.workspace.texture_maps.take(ids[rows]), ids[rows])
    return with_maps(call.shapes, _uv_set(call, 1), ids)


def _uv_set(call: BoundCall, index: int) -> int:
    argument = call.arguments[index]
    return uv_set_of(argument.value, call.name, call.location)


def _new_ids(call: BoundCall, maps: Floats, old: Ids) -> Ids:
    """Ids [N] of maps [N, 2, 4] that an operation made of old ones [N]."""
    table = call.workspace.texture_maps
    return table.add(maps, np.zeros(len(maps), dtype=bool), table.source(old))


def _tile(call: BoundCall, argument: Argument, length: Floats) -> Floats:
    """[N] size of one texture: absolute, a share of a length [N], or adjusted so that a whole number fits."""
    size = number_column(call.number(argument), len(length))
    if argument.relative:
        return size * length
    if argument.floating:
        count = np.maximum(np.rint(length * np.abs(_reciprocal(size))), 1.0)
        return np.sign(size) * length / count
    return size


def _reciprocal(size: Floats) -> Floats:
    return np.where(size == 0.0, 0.0, 1.0 / np.where(size == 0.0, 1.0, size))


def _changing(change: Change, num_arguments: int, keywords: frozenset[str] = frozenset()) -> Operation:
    """An operation that makes new maps for shapes with maps in the set of its first argument."""

    def apply(call: BoundCall) -> Shapes:
        uv_set = _uv_set(call, 0)
        numbers = tuple(call.column(argument) for argument in call.values[1:])
        ids = own_maps(call.shapes, uv_set, call.workspace).copy()
        rows = np.flatnonzero(ids >= 0)
        if len(rows) == 0:
            return call.shapes
        maps = call.workspace.texture_maps.take(ids[rows])
        chosen = tuple(number[rows] for number in numbers)
        ids[rows] = _new_ids(call, change(call, call.shapes.take(rows), chosen, maps), ids[rows])
        return with_maps(call.shapes, uv_set, ids)

    return Operation(apply, keywords, (num_arguments, num_arguments))


def _translated(call: BoundCall, shapes: Shapes, numbers: tuple[Floats, ...], maps: Floats) -> Floats:
    """``translateUV(set, u, v)``, in older files ``offsetUV``: added to all coordinates."""
    maps[:, :, 3] += np.stack(numbers, axis=1)
    return maps


def _scaled(call: BoundCall, shapes: Shapes, numbers: tuple[Floats, ...], maps: Floats) -> Floats:
    """``scaleUV(set, u, v)``: factors of all coordinates."""
    return maps * np.stack(numbers, axis=1)[:, :, None]


def _rotated(call: BoundCall, shapes: Shapes, numbers: tuple[Floats, ...], maps: Floats) -> Floats:
    """``rotateUV(set, degrees)``: the coordinates rotated about u = v = 0, from u towards v."""
    angle = np.radians(numbers[0])[:, None]
    u, v = maps[:, 0], maps[:, 1]
    return np.stack([np.cos(angle) * u - np.sin(angle) * v, np.sin(angle) * u + np.cos(angle) * v], axis=1)


def _tiled(call: BoundCall, shapes: Shapes, numbers: tuple[Floats, ...], maps: Floats) -> Floats:
    """``tileUV(set, width, height)``: from 0 on, with a texture of this size in metres on the surface.

    ``'x`` is a share of the surface, and ``~x`` is adjusted so that a whole number fills it. A negative size mirrors
    the image, and a size of 0 leaves its axis unchanged.
    """
    for axis, (argument, size) in enumerate(zip(call.values[1:], numbers, strict=True)):
        coordinate = _range(call, shapes, axis)
        tile = _tile(call, argument._replace(value=size), coordinate.extent * coordinate.metres)
        factor = np.where(tile == 0.0, 1.0, coordinate.metres * _reciprocal(tile))
        maps[:, axis, 3] -= np.where(tile == 0.0, 0.0, coordinate.low)
        maps[:, axis] *= factor[:, None]
    return maps


def _normalized(call: BoundCall, shapes: Shapes, numbers: tuple[Floats, ...], maps: Floats) -> Floats:
    """``normalizeUV(set, uv|uvUniform|u|v, type)``: moved and scaled to 0..1, ``uvUniform`` with one factor for both.

    Faces are never normalized separately: a shape has one map.
    """
    mode = call.words[0] if call.words else ""
    ranges = [_range(call, shapes, axis) for axis in range(2)]
    largest = np.maximum(ranges[0].extent, ranges[1].extent)
    for axis, coordinate in enumerate(ranges):
        if mode in ("uv", "uvUniform", "uv"[axis]):
            extent = largest if mode == "uvUniform" else coordinate.extent
            maps[:, axis, 3] -= coordinate.low
            maps[:, axis] *= np.where(extent > 0.0, _reciprocal(extent), 1.0)[:, None]
    return maps


def _range(call: BoundCall, shapes: Shapes, axis: int) -> Range:
    return range_of(shapes, _uv_set(call, 0), axis, call.workspace)


OPERATIONS: dict[str, Operation] = {
    "copyUV": Operation(copy, num_arguments=(2, 2)),
    "deleteUV": Operation(delete, num_arguments=(1, 1)),
    "normalizeUV": _changing(_normalized, 3, KEYWORDS["uv_mode"] | KEYWORDS["uv_faces"]),
    "offsetUV": _changing(_translated, 3),
    "projectUV": Operation(project, num_arguments=(1, 1)),
    "rotateUV": _changing(_rotated, 2),
    "scaleUV": _changing(_scaled, 3),
    "setupProjection": Operation(setup_projection, KEYWORDS["projection"], (4, 7)),
    "tileUV": _changing(_tiled, 3),
    "translateUV": _changing(_translated, 3),
}
