"""``split``: a shape cut into slabs along one of its scope's axes, or between values of a texture coordinate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls.calls import BlockOperation, BoundCall, BoundPart, Head
from grammarlab.derivation.functions.shapes.geometry import local_meshes
from grammarlab.derivation.functions.shapes.texture_coordinates import SPACES, UV_AXES
from grammarlab.derivation.operations.splitting.parts import asked_indices, elements_of, indexed, numbered
from grammarlab.derivation.operations.splitting.textures import split_between_values
from grammarlab.derivation.state.meshes import normalized, upright
from grammarlab.derivation.state.shapes import FACE, FOOTPRINT, Floats, Ids, Shapes
from grammarlab.derivation.values.splitting import SplitPieces, SplitRow, count_pieces, divide, in_a_row
from grammarlab.geometry.cuts.clip import slabs

_AXES = {"x": 0, "y": 1, "z": 2}
_WORDS = frozenset({*_AXES, "adjust", "noAdjust", *UV_AXES, *SPACES})


def split(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
    """``split(x|y|z, adjust|noAdjust) { size : ... | ... }*``: slabs of the given sizes, see `splitting`.

    Boxes and rectangles stay boxes and rectangles; other geometry is clipped, cuts through closed meshes are closed,
    and with ``adjust`` (the default) the scope of a part is fitted to its geometry.
    """
    words = call.words
    if words and words[0] in UV_AXES:
        return split_between_values(call, heads)
    axis = _AXES.get(words[0] if words else "")
    if axis is None:
        raise call.error("split expects x, y, z, u or v first", "for example split(x) { 2 : A | ~1 : B }")
    shapes = upright(call.shapes, call.workspace.meshes, call.workspace.frames) if axis == 1 else call.shapes
    if shapes is not call.shapes:
        call = call._replace(shapes=shapes)
    length = shapes.size[:, axis]
    elements = elements_of(call, heads, length)
    along = call.workspace.frames.axis(shapes.frame, axis)
    clipped = _needs_clipping(shapes.mesh, axis)
    general = clipped if clipped.any() else None
    asked = asked_indices(call.workspace)
    row = in_a_row(length, elements)
    if row is None:
        call.workspace.expanded(count_pieces(length, elements), shapes.num, call.location)
        pieces = divide(length, elements)
    elif general is None and not asked and row.is_full:
        return _slabs(shapes, axis, row, along)
    else:
        pieces = row.pieces()
    numbers = numbered(pieces, shapes, is_wanted=bool(asked))
    made = [_part(call, axis, piece, along, general) for piece in pieces]
    if asked:
        made = indexed(made, pieces, numbers, shapes.num, asked)
    return [BoundPart(part, number) for part, number in zip(made, numbers, strict=True)]


def _slabs(shapes: Shapes, axis: int, row: SplitRow, along: Floats) -> list[BoundPart]:
    """All parts at once of a split in which every shape has one piece of each size and none needs clipping."""
    frame, mesh = shapes.frame, shapes.mesh
    position = shapes.position + along * row.start[:, :, None]
    size = shapes.size[None].repeat(len(position), axis=0)
    size[:, :, axis] = row.extent
    number = np.arange(len(position))[:, None].repeat(len(frame), axis=1)
    return [BoundPart(shapes.rescoped(p, s, frame, mesh), n) for p, s, n in zip(position, size, number, strict=True)]


def _part(call: BoundCall, axis: int, piece: SplitPieces, along: Floats, general: NDArray[np.bool_] | None) -> Shapes:
    """The shapes of one size of the split.

    Args:
        call: the split, of shapes [N].
        axis: along which it cuts.
        piece: the pieces of the size.
        along: [N, 3] direction of that axis in the world.
        general: [N] whether shapes need clipping; None if none does.
    """
    shapes, rows = call.shapes, piece.row
    everyone = piece.is_one_each
    frame = shapes.frame if everyone else shapes.frame.take(rows)
    mesh = shapes.mesh if everyone else shapes.mesh.take(rows)
    size = shapes.size.copy() if everyone else shapes.size.take(rows, axis=0)
    size[:, axis] = piece.extent
    if everyone:
        position = shapes.position + along * piece.start[:, None]
    else:
        position = shapes.position.take(rows, axis=0) + along.take(rows, axis=0) * piece.start[:, None]
    if general is not None:
        chosen = np.flatnonzero(general[rows])
        position, size, mesh = _clipped(call, axis, piece, chosen, position, size, mesh, frame)
    if everyone:
        return shapes.rescoped(position, size, frame, mesh)
    return shapes.place(rows, position, size, frame, mesh)


def _needs_clipping(mesh: Ids, axis: int) -> NDArray[np.bool_]:
    """Whether shapes need clipping: all except boxes and rectangles cut across an axis."""
    if axis == 0:
        return mesh > FACE
    return (mesh > FACE) | (mesh == (FOOTPRINT if axis == 1 else FACE))


def _clipped(
    call: BoundCall,
    axis: int,
    piece: SplitPieces,
    general: NDArray[np.int64],
    position: Floats,
    size: Floats,
    mesh: Ids,
    frame: Ids,
) -> tuple[Floats, Floats, Ids]:
    """Positions, sizes and meshes, with the pieces ``general`` replaced by their clipped geometry."""
    if len(general) == 0:
        return position, size, mesh
    sources, source = np.unique(piece.row[general], return_inverse=True)
    start = piece.start[general]
    whole = local_meshes(call.shapes.take(sources), call.workspace)
    cut = slabs(whole, source, axis, start, start + piece.extent[general])
    unit, low, extent = normalized(cut)
    position, size, mesh = position.copy(), size.copy(), mesh.copy()
    low[:, axis] -= start
    if "noAdjust" in call.words:
        box = size[general]
        counts = np.diff(unit.mesh_points)
        shift, scale = low / np.where(box > 0.0, box, 1.0), extent / np.where(box > 0.0, box, 1.0)
        points = unit.points * np.repeat(scale, counts, axis=0) + np.repeat(shift, counts, axis=0)
        mesh[general] = call.workspace.meshes.add(unit.with_points(points))
    else:
        mesh[general] = call.workspace.meshes.add(unit)
        position[general] += call.workspace.frames.to_world(frame[general], low)
        size[general] = extent
    return position, size, mesh


BLOCKS: dict[str, BlockOperation] = {"split": BlockOperation(split, _WORDS, (1, 3))}
