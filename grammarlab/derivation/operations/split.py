"""``split``: a shape cut into slabs along one of its scope's axes, or between values of a texture coordinate."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby, repeat

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, distinct_rows, narrow
from grammarlab.derivation.calls.calls import Argument, BlockOperation, BoundCall, BoundPart, Head
from grammarlab.derivation.functions.shape_measures import local_meshes
from grammarlab.derivation.functions.shape_textures import SPACES, UV_AXES, Range, range_of, uv_set_of
from grammarlab.derivation.split_sizes import (
    TOLERANCE,
    Element,
    SplitPieces,
    SplitRepeat,
    SplitRow,
    SplitSize,
    divide,
    in_a_row,
)
from grammarlab.derivation.state.box_orders import kinds
from grammarlab.derivation.state.corner_maps import own_maps, without_face_maps
from grammarlab.derivation.state.lineage import PART
from grammarlab.derivation.state.mesh_table import add_faces, normalized, scaled, upright
from grammarlab.derivation.state.shapes import BOX, FACE, FOOTPRINT, Ids, Shapes, take_value
from grammarlab.geometry.meshes.vectors import cross, dot, norm, unit

Rows = NDArray[np.int64]

_INDICES = frozenset({"split.index", "split.total"})
_STRAIGHT = 1e-12
"""Largest component of a unit vector along other axes for which it counts as an axis."""
_LIES_ALONG = {BOX: (0, 1, 2), FOOTPRINT: (0, 2), FACE: (0, 1)}
"""Axes along which a box or rectangle extends."""
AXES = {"x": 0, "y": 1, "z": 2}
_WORDS = frozenset({*AXES, "adjust", "noAdjust", *UV_AXES, *SPACES})


def split(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
    """``split(x|y|z, adjust|noAdjust) { size : ... | ... }*``: slabs of the given sizes.

    Boxes and rectangles stay boxes and rectangles; other geometry is clipped, cuts through closed meshes are closed,
    and with ``adjust`` (the default) the scope of a part is fitted to its geometry.
    """
    words = call.words
    if words and words[0] in UV_AXES:
        return _split_between_values(call, heads)
    axis = AXES.get(words[0] if words else "")
    if axis is None:
        raise call.error("split expects x, y, z, u or v first", "for example split(x) { 2 : A | ~1 : B }")
    call = whole_turned(call if "noAdjust" in call.words else _flattened(call, axis), axis)
    shapes = call.shapes
    length = shapes.size[:, axis]
    elements = elements_of(call, heads, length)
    along = call.workspace.frames.axis(shapes.frame, axis)
    clipped = _needs_clipping(shapes.mesh, axis)
    general = clipped if clipped.any() else None
    row = in_a_row(length, elements)
    if row is None:
        pieces = pieces_of(call, length, elements)
    elif general is None and not _asked_indices(call) and not any(call.bare) and row.is_full:
        return _slabs(call, axis, row, along)
    else:
        pieces = row.pieces()
    return _cut(call, axis, pieces, along, general)


def _flattened(call: BoundCall, axis: int) -> BoundCall:
    """The call on rectangles in scopes without height over them, except along the axis of the cuts."""
    shapes = call.shapes
    size = shapes.size
    for kind, across in ((FOOTPRINT, 1), (FACE, 2)):
        if across == axis:
            continue
        rises = (shapes.mesh == kind) & (size[:, across] != 0.0)
        if rises.any():
            size = size.copy()
            size[rises, across] = 0.0
    return call if size is shapes.size else call._replace(shapes=shapes.resized(size))


def whole_turned(call: BoundCall, axis: int) -> BoundCall:
    """The call on shapes to cut across an axis: without coordinates of whole faces, and in upright scopes for y."""
    shapes = without_face_maps(call.shapes, call.workspace)
    if axis == 1:
        shapes = upright(shapes, call.workspace.meshes, call.workspace.frames)
    return call._replace(shapes=shapes)


def cut_in_slabs(call: BoundCall, axis: int, pieces: Sequence[SplitPieces]) -> list[BoundPart]:
    """Slabs of shapes across an axis of their scopes, for pieces along it: one part for each size."""
    along = call.workspace.frames.axis(call.shapes.frame, axis)
    clipped = _needs_clipping(call.shapes.mesh, axis)
    return _cut(call, axis, pieces, along, clipped if clipped.any() else None)


def _cut(
    call: BoundCall, axis: int, pieces: Sequence[SplitPieces], along: Floats, general: NDArray[np.bool_] | None
) -> list[BoundPart]:
    index_names = _asked_indices(call)
    numbers = _numbered(pieces, call.shapes, is_wanted=bool(index_names) or PART in call.shapes.state)
    parts = [
        call.shapes.bare_parts(piece.row) if is_bare else _part(call, axis, piece, along, general)
        for piece, is_bare in zip(pieces, call.bare or repeat(False), strict=False)
    ]
    if index_names:
        parts = _indexed(parts, pieces, numbers, call.shapes.num, index_names)
    return [BoundPart(part, number) for part, number in zip(parts, numbers, strict=True)]


BLOCKS: dict[str, BlockOperation] = {"split": BlockOperation(split, _WORDS, (1, 3))}


def _split_between_values(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
    """``split(u|v, uvSpace|unitSpace, set) { size : ... | ... }*``: parts from the smallest value to the largest.

    Sizes are differences of the coordinate, or with ``unitSpace`` metres on the surface. Boxes and rectangles that are
    cut across an axis of their scopes keep their type; other geometry is clipped at planes, and the scope of a
    part is fitted to its geometry.
    """
    words = call.words
    if len(words) != 2 or words[1] not in SPACES or len(call.values) != 1:
        raise call.error(
            f"split({words[0]}, ...) expects uvSpace or unitSpace, then a uv set",
            f"for example split({words[0]}, unitSpace, 0) {{ 2 : A | ~1 : B }}",
        )
    uv_set = uv_set_of(call.values[0].value, call.name, call.location)
    has_map = own_maps(call.shapes, uv_set, call.workspace) >= 0
    if not has_map.all():
        call.warn(
            f"split({words[0]}, ...) came to a shape without texture coordinates in set {uv_set}; it has no parts",
            "setupProjection and projectUV create them",
        )
        rows = np.flatnonzero(has_map)
        call = call.rows(rows)
        heads = tuple([head._replace(argument=_at_rows(head.argument, rows)) for head in heads])
        if len(rows) == 0:
            return [BoundPart(call.shapes, rows) for _ in heads]
    coordinate = range_of(call.shapes, uv_set, UV_AXES.index(words[0]), call.workspace)
    unit_length = coordinate.metres if words[1] == "unitSpace" else np.ones(call.shapes.num)
    length = coordinate.extent * unit_length
    elements = elements_of(call, heads, length)
    pieces = pieces_of(call, length, elements)
    index_names = _asked_indices(call)
    numbers = _numbered(pieces, call.shapes, is_wanted=bool(index_names) or PART in call.shapes.state)
    parts = [_texture_part(call, coordinate, unit_length, piece) for piece in pieces]
    if index_names:
        parts = _indexed(parts, pieces, numbers, call.shapes.num, index_names)
    return [BoundPart(part, number) for part, number in zip(parts, numbers, strict=True)]


def _at_rows(argument: Argument, rows: Rows) -> Argument:
    return argument._replace(value=take_value(argument.value, rows))


def elements_of(call: BoundCall, heads: Sequence[Head], length: Floats) -> list[Element]:
    """Sizes of a split of lengths [N], grouped by repeated group."""
    elements: list[Element] = []
    group = -1
    for head in heads:
        argument = head.argument
        number = call.number(argument)
        size = SplitSize(number * length if argument.relative else number, argument.floating)
        if head.group < 0:
            elements.append(size)
        elif head.group == group and isinstance(elements[-1], SplitRepeat):
            elements[-1] = SplitRepeat((*elements[-1].sizes, size))
        else:
            elements.append(SplitRepeat((size,)))
        group = head.group
    return elements


def pieces_of(call: BoundCall, length: Floats, elements: Sequence[Element]) -> list[SplitPieces]:
    """Pieces of lengths of the shapes.

    Raises:
        BudgetError: If they are too many.
    """
    return divide(length, elements, lambda count: call.workspace.expanded(count, call.shapes.num, call.location))


def _asked_indices(call: BoundCall) -> frozenset[str]:
    """Those of ``split.index`` and ``split.total`` that are read of its parts."""
    return call.workspace.state_names & _INDICES if call.has_index else frozenset()


def _numbered(pieces: Sequence[SplitPieces], shapes: Shapes, is_wanted: bool) -> list[NDArray[np.int64]]:
    """Index of each piece along its shape, from 0; only if it is wanted or a part draws."""
    counts = [len(piece.row) for piece in pieces]
    if shapes.key is None and not is_wanted:
        return [np.zeros(count, np.int64) for count in counts]
    if all(piece.is_one_each for piece in pieces):
        return [np.full(count, index) for index, count in enumerate(counts)]
    return numbers_along(pieces, shapes.num)


def numbers_along(pieces: Sequence[SplitPieces], num_shapes: int) -> list[NDArray[np.int64]]:
    """Index of each piece along its shape, from 0."""
    groups = [list(group) for _, group in groupby(pieces, key=lambda piece: piece.element)]
    if all(map(_is_regular, groups)):
        return _counted(groups, num_shapes)
    row = np.concatenate([piece.row for piece in pieces])
    order = along_shapes(pieces, row)
    per_row = np.bincount(row, minlength=num_shapes)
    number = np.empty(len(row), np.int64)
    number[order] = np.arange(len(row)) - np.repeat(np.cumsum(per_row) - per_row, per_row)
    return np.split(number, np.cumsum([len(piece.row) for piece in pieces])[:-1])


def _is_regular(group: Sequence[SplitPieces]) -> bool:
    """Whether the sizes of a repeated group take turns in every shape; pieces without extent have no order."""
    same_rows = all(piece.row is group[0].row for piece in group)
    return same_rows and all(piece.extent.min(initial=1.0) > 0.0 for piece in group)


def _counted(groups: Sequence[Sequence[SplitPieces]], num_shapes: int) -> list[NDArray[np.int64]]:
    """Index of each piece along its shape, from the numbers of pieces before it."""
    numbers: list[NDArray[np.int64]] = []
    before = np.zeros(num_shapes, np.int64)
    for group in groups:
        row, turns = group[0].row, len(group)
        per_shape = np.bincount(row, minlength=num_shapes)
        first = (before - turns * (np.cumsum(per_shape) - per_shape)).take(row)
        first += np.arange(0, turns * len(row), turns)
        numbers += [first + turn for turn in range(turns)]
        before += turns * per_shape
    return numbers


def along_shapes(pieces: Sequence[SplitPieces], row: Rows) -> Rows:
    """Order [K] of all pieces, by shape and then along it, from their shapes [K]."""
    start = np.concatenate([piece.start for piece in pieces])
    order = _alternating(pieces)
    order = order.take(np.argsort(narrow(row.take(order)), kind="stable"))
    ordered, shape = start[order], row[order]
    if ((ordered[1:] > ordered[:-1]) | (shape[1:] != shape[:-1])).all():
        return order
    return np.lexsort((start, row))


def _alternating(pieces: Sequence[SplitPieces]) -> Rows:
    """Order [K] in which the parts of a repeated group take turns, which is that along a shape unless some are missing.

    Sorting by two columns would take five times as long.
    """
    orders, first = [], 0
    for _, group in groupby(pieces, key=lambda piece: id(piece.row)):
        counts = [len(piece.row) for piece in group]
        last = first + sum(counts)
        orders.append(np.arange(first, last).reshape(len(counts), counts[0]).T.ravel())
        first = last
    return np.concatenate(orders)


def _texture_part(call: BoundCall, coordinate: Range, unit_length: Floats, piece: SplitPieces) -> Shapes:
    """The shapes [K] of one size of a split of shapes [N].

    Args:
        call: the split.
        coordinate: the texture coordinate on the shapes [N].
        unit_length: [N] length of one unit of the coordinate in the unit of the sizes.
        piece: the parts that the size makes.
    """
    rows = piece.row
    shapes = call.shapes.take(rows)
    if len(rows) == 0:
        return shapes
    steepness = norm(coordinate.gradient[rows])
    direction = unit(coordinate.gradient[rows])
    ends = np.stack([piece.start, piece.start + piece.extent]) / unit_length[rows]
    # From values of the coordinate to metres from the scope's origin along its gradient.
    low, high = (coordinate.low[rows] + ends - coordinate.start[rows]) / steepness
    axis, is_simple = _scope_axes(shapes.mesh, direction)
    position, size, mesh = shapes.position.copy(), shapes.size.copy(), shapes.mesh.copy()
    simple = np.flatnonzero(is_simple)
    if len(simple):
        forwards = direction[simple, axis[simple]] > 0.0
        start = np.where(forwards, low[simple], -high[simple])
        offset = np.zeros((len(simple), 3))
        offset[np.arange(len(simple)), axis[simple]] = start
        position[simple] += call.workspace.frames.to_world(shapes.frame[simple], offset)
        size[simple, axis[simple]] = high[simple] - low[simple]
        mesh[simple] = _cut_across(call, shapes.take(simple), axis[simple], start, high[simple] - low[simple])
    other = np.flatnonzero(~is_simple)
    if len(other):
        cut = _between(call, shapes.take(other), direction[other], low[other], high[other])
        position[other], size[other], mesh[other] = cut
    return shapes.rescoped(position, size, shapes.frame, mesh)


def _cut_across(call: BoundCall, shapes: Shapes, axis: Rows, start: Floats, extent: Floats) -> Ids:
    """[N] meshes of parts of boxes and rectangles, each cut across an axis of its own."""
    mesh = shapes.mesh.copy()
    for across in range(3):
        rows = np.flatnonzero(axis == across)
        if len(rows):
            length = shapes.size[rows, across]
            mesh[rows] = _ordered(call, across, mesh[rows], length, start[rows], extent[rows])
    return mesh


def _scope_axes(mesh: Ids, direction: Floats) -> tuple[Rows, NDArray[np.bool_]]:
    """Scope axis [K] nearest to a direction [K, 3], and whether shapes of these meshes extend exactly along it."""
    axis = np.abs(direction).argmax(axis=1)
    components = np.abs(direction)
    components[np.arange(len(axis)), axis] = 0.0
    extends = np.zeros((FACE + 2, 3), dtype=bool)
    for kind, axes in _LIES_ALONG.items():
        extends[kind, list(axes)] = True
    return axis, (components.max(axis=1) < _STRAIGHT) & extends[np.minimum(kinds(mesh), FACE + 1), axis]


def _between(
    call: BoundCall, shapes: Shapes, direction: Floats, low: Floats, high: Floats
) -> tuple[Floats, Floats, Ids]:
    """Positions, sizes and meshes of shapes [K] clipped between planes across a direction [K, 3].

    Args:
        call: the split.
        shapes: [K] the shapes to clip.
        direction: [K, 3] unit vectors in scope axes.
        low: [K] metres from the scopes' origins to the first plane.
        high: [K] metres to the second one.
    """
    workspace = call.workspace
    whole = local_meshes(shapes, workspace)
    axes = _axes_with_first(direction)
    turned = whole.with_points(_turned(whole.points, axes[whole.mesh_of_point()]))
    from grammarlab.geometry.meshes.clip import slabs  # noqa: PLC0415  # boxes and rectangles need no cuts

    cut = slabs(turned, np.arange(shapes.num), 0, low, high)
    back = _turned(cut.points, axes.swapaxes(1, 2)[cut.mesh_of_point()])
    meshes, corner, size = normalized(cut.with_points(back))
    position = shapes.position + workspace.frames.to_world(shapes.frame, corner)
    return position, size, add_faces(workspace.meshes, meshes)


def _axes_with_first(direction: Floats) -> Floats:
    """[K, 3, 3] three axes at right angles, as rows, of which the first has the direction [K, 3]."""
    least = np.eye(3)[np.abs(direction).argmin(axis=1)]
    second = unit(cross(direction, least))
    return np.stack([direction, second, cross(direction, second)], axis=1)


def _turned(points: Floats, axes: Floats) -> Floats:
    """[P, 3] the places of points along axes [P, 3, 3]."""
    return np.stack([dot(axes[:, row], points) for row in range(3)], axis=1)


def _indexed(
    parts: Sequence[Shapes],
    pieces: Sequence[SplitPieces],
    numbers: Sequence[NDArray[np.int64]],
    num_shapes: int,
    names: frozenset[str],
) -> list[Shapes]:
    """Parts with their index and total, if the grammar reads them."""
    totals = np.bincount(np.concatenate([piece.row for piece in pieces]), minlength=num_shapes)
    result = []
    for part, piece, number in zip(parts, pieces, numbers, strict=True):
        values = {"split.index": number.astype(np.float64), "split.total": totals[piece.row].astype(np.float64)}
        result.append(part._replace(state={**part.state, **{name: values[name] for name in names}}))
    return result


def _needs_clipping(mesh: Ids, axis: int) -> NDArray[np.bool_]:
    """Whether shapes need clipping: all except boxes and rectangles cut across an axis."""
    if axis == 0:
        return mesh > FACE
    return (mesh > FACE) | (mesh == (FOOTPRINT if axis == 1 else FACE))


def _slabs(call: BoundCall, axis: int, row: SplitRow, along: Floats) -> list[BoundPart]:
    """All parts at once of a split in which every shape has one piece of each size and none needs clipping."""
    shapes = call.shapes
    frame = shapes.frame
    meshes = [
        _ordered(call, axis, shapes.mesh, shapes.size[:, axis], s, e)
        for s, e in zip(row.start, row.extent, strict=True)
    ]
    position = shapes.position + along * row.start[:, :, None]
    size = shapes.size[None].repeat(len(position), axis=0)
    size[:, :, axis] = row.extent
    number = np.arange(len(position))[:, None].repeat(len(frame), axis=1)
    columns = zip(position, size, meshes, number, strict=True)
    return [BoundPart(shapes.rescoped(p, s, frame, mesh), n) for p, s, mesh, n in columns]


def _ordered(call: BoundCall, axis: int, mesh: Ids, length: Floats, start: Floats, extent: Floats) -> Ids:
    """[N] meshes of parts of boxes and rectangles of given lengths along an axis, with the faces of boxes in order."""
    if len(mesh) == 0 or mesh.min() > BOX:
        return mesh
    return call.workspace.meshes.boxes.cut(mesh, axis, start > TOLERANCE, start + extent < length - TOLERANCE)


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
    mesh = _ordered(call, axis, mesh, size[:, axis], piece.start, piece.extent)
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
    return shapes.parts(rows, position, size, frame, mesh)


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
    from grammarlab.geometry.meshes.clip import slabs  # noqa: PLC0415  # boxes and rectangles need no cuts

    rows, start, length = piece.row[general], piece.start[general], piece.extent[general]
    whole = call.shapes.mesh[rows], call.shapes.size[rows]
    first, number = distinct_rows(*whole, start, length)
    wholes, source = distinct_rows(*(column[first] for column in whole))
    meshes = scaled(call.workspace.meshes.take(whole[0][first][wholes]), whole[1][first][wholes])
    start = start[first]
    unit, low, extent = normalized(slabs(meshes, source, axis, start, start + length[first]))
    position, size, mesh = position.copy(), size.copy(), mesh.copy()
    low[:, axis] -= start
    if "noAdjust" in call.words:
        box = size[general[first]]
        counts = np.diff(unit.mesh_points)
        shift, scale = low / np.where(box > 0.0, box, 1.0), extent / np.where(box > 0.0, box, 1.0)
        points = unit.points * np.repeat(scale, counts, axis=0) + np.repeat(shift, counts, axis=0)
        mesh[general] = call.workspace.meshes.add(unit.with_points(points))[number]
    else:
        mesh[general] = call.workspace.meshes.add(unit)[number]
        position[general] += call.workspace.frames.to_world(frame[general], low[number])
        size[general] = extent[number]
    return position, size, mesh
