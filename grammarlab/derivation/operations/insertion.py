"""Operations that replace the geometry by a primitive or an asset, fitted to the scope."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from grammarlab.arrays import Floats, Ints, distinct, distinct_rows
from grammarlab.derivation.calls.calls import BoundCall, Operation, OperationFunction
from grammarlab.derivation.calls.texture_transfer import without_maps
from grammarlab.derivation.functions.shape_materials import (
    ASSET_MATERIAL,
    asset_channels,
    asset_materials,
    cut_out_images,
    with_asset_materials,
)
from grammarlab.derivation.state.corner_maps import with_face_maps
from grammarlab.derivation.state.mesh_table import mirrored, upright
from grammarlab.derivation.state.shapes import BOX, FOOTPRINT, Ids, Shapes
from grammarlab.derivation.state.trim_planes import trim
from grammarlab.geometry.meshes import primitives
from grammarlab.geometry.meshes.mesh import Meshes

_INSERT_WORDS = frozenset(
    {"yUp", "zUp", "alignSizeAndPosition", "keepSizeAndPosition", "keepSizeAlignPosition"}
    | {"numericalCleanup", "noCleanup"}
)
_STAND_UP = np.array([[[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]])
"""[1, 3, 3] rotation by -90 degrees about x."""
_MOST_SIDES = 512
_WITHOUT_IMAGES = ":notex"


def i(call: BoundCall) -> Shapes:
    """``i(path, yUp|zUp, mode, cleanup)``: a mesh from the asset folder or a built-in one, mapped onto the scope.

    With ``keepSizeAndPosition`` the mesh keeps its size and position. With ``keepSizeAlignPosition`` it keeps its size
    and is centred on the scope's floor. Meshes are never cleaned up, so that mode has no effect.

    Dimensions of the scope that are 0 follow the mesh: one such dimension takes the mean scale of the two others, two
    take the scale of the third, and if all three are 0 the mesh keeps its own size.

    An asset that the folder lacks becomes a unit box, so that derived shapes keep place and size (`Forest` names it).
    So does one that cannot be read, and an unknown built-in mesh. A path outside the folder is an error.
    """
    call = _bare(call)
    text = call.text(call.values[0])
    if isinstance(text, str):
        return _inserted(call, call.shapes, text)
    shapes = call.shapes
    mesh, size, position, material = (
        shapes.mesh.copy(),
        shapes.size.copy(),
        shapes.position.copy(),
        shapes.material.copy(),
    )
    of_asset = asset_materials(shapes).copy() if ASSET_MATERIAL in shapes.state else None
    for string in distinct(text, len(call.workspace.strings)).tolist():
        rows = np.flatnonzero(text == string)
        part = _inserted(call, shapes.take(rows), call.workspace.strings[string])
        mesh[rows], size[rows], position[rows], material[rows] = part.mesh, part.size, part.position, part.material
        if of_asset is not None:
            of_asset[rows] = asset_materials(part)
    inserted = shapes._replace(mesh=mesh, size=size, position=position, material=material)
    return inserted if of_asset is None else with_asset_materials(inserted, of_asset)


def _bare(call: BoundCall) -> BoundCall:
    """The call on scopes of positive height, without the texture coordinates of the replaced geometry."""
    shapes = upright(call.shapes, call.workspace.meshes, call.workspace.frames)
    bare = without_maps(shapes, call.workspace)
    if ASSET_MATERIAL in bare.state:
        bare = with_asset_materials(bare, np.zeros(bare.num, np.int32))
    return call._replace(shapes=bare)


def _inserted(call: BoundCall, shapes: Shapes, path: str) -> Shapes:
    mesh, asset_size, low = asset_mesh(call, path)
    shapes = painted(call, shapes, path)
    if mesh == BOX and path.startswith("builtin:"):
        shapes = with_face_maps(shapes, call.workspace)
    if "zUp" in call.words:
        mesh, asset_size, low = _stood_up(call, mesh, asset_size, low)
    if "keepSizeAlignPosition" in call.words:
        ids, sizes = np.full(shapes.num, mesh, dtype=np.int32), np.broadcast_to(asset_size, (shapes.num, 3))
        return _standing(call._replace(shapes=shapes), ids, sizes, np.array([0.5, 0.0, 0.5]))
    if "keepSizeAndPosition" in call.words:
        shapes = shapes._replace(size=np.zeros_like(shapes.size))
    return fitted(shapes, mesh, asset_size, low, call)


def asset_mesh(call: BoundCall, path: str) -> tuple[int, Floats, Floats]:
    """A mesh in the unit cube, and its size [3] and low corner [3] in its file."""
    table = call.workspace.meshes
    name = path.removesuffix(_WITHOUT_IMAGES)
    if name in ("builtin:cube", "builtin:box"):
        return BOX, np.ones(3), np.zeros(3)
    if name in primitives.BUILTIN_ASSETS:
        size = primitives.natural_size(name.removeprefix("builtin:"))
        return table.named(name, partial(primitives.builtin_asset, name)), size, np.zeros(3)
    if path.startswith("builtin:"):
        valid_names = ", ".join(primitives.BUILTIN_ASSETS)
        call.warn(f'unknown built-in mesh "{path}"; a box stands in its place', f"expected one of {valid_names}")
        return BOX, np.ones(3), np.zeros(3)
    asset = call.workspace.asset(name, call.location)
    if asset is None:
        return BOX, np.ones(3), np.zeros(3)
    return table.named(name, lambda: asset.meshes), asset.size, asset.low


def painted(call: BoundCall, shapes: Shapes, path: str) -> Shapes:
    """Shapes with the materials of an asset; ``:notex`` after its path leaves its images out."""
    name = path.removesuffix(_WITHOUT_IMAGES)
    asset = None if name.startswith("builtin:") else call.workspace.asset(name, call.location)
    if asset is None or asset.materials == (None,):
        return shapes
    materials = [
        None if material is None else asset_channels(material, has_image=name == path) for material in asset.materials
    ]
    table = call.workspace.materials
    table.cut_out |= cut_out_images(asset.materials)
    of_asset = table.inserted(np.zeros(shapes.num, np.int32), materials) if ASSET_MATERIAL in shapes.state else None
    painted = shapes._replace(material=table.inserted(shapes.material, materials))
    return painted if of_asset is None else with_asset_materials(painted, of_asset)


def _stood_up(call: BoundCall, mesh: int, asset_size: Floats, low: Floats) -> tuple[int, Floats, Floats]:
    """A mesh with up axis z, rotated by -90 degrees about x so that y is up."""
    size, corner = asset_size[[0, 2, 1]], np.array([low[0], low[2], -low[1] - asset_size[1]])
    if mesh == BOX:
        return mesh, size, corner
    table = call.workspace.meshes

    def stood_up() -> Meshes:
        unit = table.take(np.array([mesh]))
        x, y, z = unit.points.T
        flipped = np.where(asset_size[1] > 0.0, 1.0 - y, 0.0)
        return unit.with_points(np.stack((x, z, flipped), axis=1), turn=_STAND_UP)

    return table.named(f"zUp:{mesh}", stood_up), size, corner


def fitted(shapes: Shapes, mesh: int, asset_size: Floats, low: Floats, call: BoundCall) -> Shapes:
    """Shapes with one mesh of the unit cube.

    Its own size [3] or [N, 3] and low corner [3] replace dimensions that are 0.
    """
    shapes = shapes._replace(mesh=np.full(shapes.num, mesh, dtype=np.int32))
    flat = shapes.size <= 0.0
    if not flat.any():
        return shapes
    size, missing = shapes.size.copy(), flat.sum(axis=1)
    scales = np.where(flat | (asset_size <= 0.0), 0.0, shapes.size / np.where(asset_size > 0.0, asset_size, 1.0))
    scale = np.where(missing == 3, 1.0, scales.sum(axis=1) / np.maximum(3 - missing, 1))
    size[flat] = (scale[:, None] * asset_size)[flat]
    offset = np.where((missing >= 2)[:, None] & flat, scale[:, None] * low, 0.0)
    position = shapes.position + call.workspace.frames.to_world(shapes.frame, offset)
    return shapes._replace(size=size, position=position)


def trim_shapes(call: BoundCall) -> Shapes:
    """``trim()``: shapes without what lies beyond their trim planes."""
    return trim(call.shapes, call.workspace.trim_planes, call.workspace.meshes, call.workspace.frames)


def _trimming(apply: OperationFunction) -> OperationFunction:
    """An operation whose new geometry is trimmed."""
    return lambda call: trim_shapes(call._replace(shapes=apply(call)))


def _primitive(name: str, num_counts: int, num_dimensions: int) -> Operation:
    """``primitiveX(counts, dimensions)``: fitted to the scope, or with dimensions around the axis of the scope.

    A radius is that of the circle through all corners, so most scopes are smaller than the circle.
    Negative dimensions mirror it, like negative sizes in ``s``; the reference does not define them.
    """

    def apply(call: BoundCall) -> Shapes:
        call = _bare(call)
        numbers = [call.number(argument) for argument in call.arguments]
        dimensions = numbers[num_counts:] if len(numbers) > num_counts else []
        if dimensions and len(dimensions) != num_dimensions:
            raise call.error(f"{call.name} expects all of its {num_dimensions} dimensions or none")
        mesh = _mesh(call, name, numbers[:num_counts])
        if name in ("cube", "quad"):
            call = call._replace(shapes=with_face_maps(call.shapes, call.workspace))
        natural = _of_counts(call, partial(primitives.natural_size, name), numbers[:num_counts])
        if not dimensions:
            return fitted(call.shapes, 0, natural, np.zeros(3), call)._replace(mesh=mesh)
        axis = _of_counts(call, partial(primitives.axis_place, name), numbers[:num_counts])
        return _standing(call, mesh, natural * _extent(name, dimensions, call.shapes.num), axis)

    return Operation(_trimming(apply), num_arguments=(0, num_counts + num_dimensions))


def _mesh(call: BoundCall, name: str, counts: list[float | Floats]) -> Ids:
    """[N] mesh of a primitive with given numbers of sides and divisions."""
    if name in ("cube", "quad"):
        return np.full(call.shapes.num, BOX if name == "cube" else FOOTPRINT, dtype=np.int32)
    if not counts:
        return np.full(call.shapes.num, _named(call, name, ()), dtype=np.int32)
    table, number = _different_counts(call, counts)
    if table.min() < 3 or table.max() > _MOST_SIDES:
        raise call.error(f"{call.name} expects 3 to {_MOST_SIDES} sides, found {table.min():g} to {table.max():g}")
    ids = [_named(call, name, tuple(int(count) for count in row)) for row in table]
    return np.array(ids, dtype=np.int32).take(number)


def _of_counts(call: BoundCall, measure: Callable[..., Floats], counts: list[float | Floats]) -> Floats:
    """[N, 3] what a measure gives for numbers of sides and divisions; [3] without any."""
    if not counts:
        return measure()
    table, number = _different_counts(call, counts)
    return np.array([measure(*(int(count) for count in row)) for row in table]).take(number, axis=0)


def _different_counts(call: BoundCall, counts: list[float | Floats]) -> tuple[Floats, Ints]:
    """Different rows [K, C] of numbers of sides and divisions, in ascending order, and the row [N] of each shape."""
    columns = [np.broadcast_to(np.rint(count), call.shapes.num) for count in counts]
    first, number = distinct_rows(*columns)
    table, order = np.unique(np.stack(columns, axis=1).take(first, axis=0), axis=0, return_inverse=True)
    return table, order.ravel().take(number)


def _named(call: BoundCall, name: str, counts: tuple[int, ...]) -> int:
    full = ":".join(["primitive", name, *map(str, counts)])
    return call.workspace.meshes.named(full, partial(_MAKERS[name], *counts))


def _extent(name: str, dimensions: list[float | Floats], count: int) -> Floats:
    """[N, 3] size of the block or of the circle around a primitive, from its dimensions."""
    first, *rest = dimensions
    if name in ("cube", "quad"):
        width, height, depth = (first, *rest) if name == "cube" else (first, 0.0, rest[0])
        sides = (width, height, depth)
    else:
        diameter = 2.0 * first
        height = diameter if name == "sphere" else 0.0 if name == "disk" else rest[0]
        sides = (diameter, height, diameter)
    return np.stack([np.broadcast_to(side, count).astype(np.float64) for side in sides], axis=1)


def _standing(call: BoundCall, mesh: Ids, size: Floats, axis: Floats) -> Shapes:
    """Shapes with new geometry on the middle of the scope's floor, mirrored along axes of negative size.

    Args:
        call: the operation.
        mesh: [N] the geometry.
        size: [N, 3] its size in metres.
        axis: [3] or [N, 3] the point that is in the middle, as shares of the size.
    """
    shapes = call.shapes
    offset = (0.5 * shapes.size - axis * size) * [1.0, 0.0, 1.0]
    position = shapes.position + call.workspace.frames.to_world(shapes.frame, offset)
    standing = shapes._replace(mesh=mesh, size=size, position=position)
    return mirrored(standing, size < 0.0, call.workspace.meshes, call.workspace.frames)


_MAKERS = {
    "cone": primitives.cone,
    "cylinder": primitives.cylinder,
    "disk": primitives.disk,
    "sphere": primitives.sphere,
}

OPERATIONS: dict[str, Operation] = {
    "i": Operation(_trimming(i), _INSERT_WORDS, (1, 4)),
    "primitiveCone": _primitive("cone", 1, 2),
    "primitiveCube": _primitive("cube", 0, 3),
    "primitiveCylinder": _primitive("cylinder", 1, 2),
    "primitiveDisk": _primitive("disk", 1, 1),
    "primitiveQuad": _primitive("quad", 0, 2),
    "primitiveSphere": _primitive("sphere", 2, 1),
    "trim": Operation(trim_shapes),
}
