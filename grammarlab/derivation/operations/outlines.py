"""Operations on the outlines of faces: ``offset``, ``setback``, inner rectangles, building shapes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts, take_rows
from grammarlab.derivation.calls.calls import Argument, BlockOperation, BoundCall, BoundPart, Head, Operation, selected
from grammarlab.derivation.functions.shape_measures import AlikeMeshes, alike_meshes, local_meshes, oriented
from grammarlab.derivation.functions.street_sides import (
    OLDER_SELECTORS,
    EdgeMoves,
    by_streets,
    line_sides,
    outline_lines,
    picked_by,
    with_moved_edges,
)
from grammarlab.derivation.operations.comp import edges_of_faces
from grammarlab.derivation.state.array_table import is_table
from grammarlab.derivation.state.face_tags import inherited
from grammarlab.derivation.state.mesh_table import add_faces, normalized, replaced
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.geometry.components import extract_faces
from grammarlab.geometry.meshes.edges import edges as edge_table
from grammarlab.geometry.meshes.edges import in_rings
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.planar import regroup
from grammarlab.geometry.selectors import ORIENTATIONS

if TYPE_CHECKING:  # imported by the first operation that needs them, since few grammars have any
    from grammarlab.geometry.outlines.setback import Setback

Rows = NDArray[np.int64]

_FEWEST_WITH_HOLE = 8
"""Corners of a triangle with a triangular hole, joined by a bridge that is passed in both directions."""
_KEEP = frozenset({"all", "inside", "border"})
_PARTS = frozenset({"shape", "remainder"})
_WINGS = {
    "shapeL": ("front", "left"),
    "shapeO": ("front", "right", "back", "left"),
    "shapeU": ("front", "right", "left"),
}
"""Sides along which each operation makes wings, in the order of its arguments."""
EDGES = frozenset({*ORIENTATIONS, *OLDER_SELECTORS, "all", "remainder"})


def offset(call: BoundCall) -> Shapes:
    """``offset(distance, all|inside|border)``: every face replaced by its offset polygons, the ring, or both."""
    from grammarlab.geometry.outlines import offset as outlines  # noqa: PLC0415

    keep = cast("Literal['all', 'inside', 'border']", call.words[0] if call.words else "all")
    distance = call.column(call.values[0])
    before = alike_meshes(call.shapes, call.workspace, distance)
    meshes = outlines.offset(before.meshes, distance[before.first], keep)

    def moves(whole: Meshes) -> EdgeMoves:
        return EdgeMoves(whole, -distance[whole.mesh_of_corner()])

    return _replaced(call, before, meshes, moves)


def setback(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
    """``setback(distance) { selector : ... | remainder : ... }``: strips along edges cut off.

    An array has a distance for each edge of each face, in order; edges beyond its end stay.
    Selectors use the outward normals of the edges; a number is the index of an edge modulo the number of edges; a
    condition is evaluated on each edge.
    """
    meshes = local_meshes(call.shapes, call.workspace)
    mesh = meshes.mesh_of_face()[meshes.face_of_corner()]
    return strips_of(
        call, heads, meshes, edge_groups(call, heads, meshes), edge_values(call, call.values[0], meshes, mesh)
    )


def edge_groups(call: BoundCall, heads: tuple[Head, ...], meshes: Meshes) -> Rows:
    """[C] index of the part that selects the edge that leaves each corner; -1 for the edges that no part selects."""
    from grammarlab.geometry.outlines import setback as strips  # noqa: PLC0415

    outward = strips.edge_normals(meshes)
    mesh = meshes.mesh_of_face()[meshes.face_of_corner()]
    groups = np.full(len(meshes.corners), strips.REMAINDER, dtype=np.int64)
    for index, head in enumerate(heads):
        if head.argument.value != "remainder":
            chosen = _edges(call, head, meshes, outward, mesh)
            groups[chosen & (groups == strips.REMAINDER)] = index
    return groups


def strips_of(
    call: BoundCall, heads: tuple[Head, ...], meshes: Meshes, groups: Rows, distances: NDArray[np.float64]
) -> list[BoundPart]:
    """The strips and the remainders of a setback as parts.

    Args:
        call: the operation, on shapes [N].
        heads: selectors of edges, or ``remainder``.
        meshes: [N] the geometry of the shapes.
        groups: [C] from `edge_groups`.
        distances: [C] metres.
    """
    from grammarlab.geometry.outlines import setback as strips  # noqa: PLC0415

    result = strips.setback(meshes, distances, groups)
    part_groups = [strips.REMAINDER if head.argument.value == "remainder" else i for i, head in enumerate(heads)]
    moved = EdgeMoves(meshes, np.where(groups == strips.REMAINDER, 0.0, distances))
    return parts_of(call, result, heads, part_groups, moved)


def inner_rectangle(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
    """``innerRectangle(scope|edge) { shape : ... | remainder : ... }``: the largest rectangle inside each face."""
    from grammarlab.geometry.outlines import inner_rectangle as rectangles  # noqa: PLC0415
    from grammarlab.geometry.outlines.setback import REMAINDER  # noqa: PLC0415

    alignment = cast("Literal['scope', 'edge']", call.words[0] if call.words else "scope")
    meshes = local_meshes(call.shapes, call.workspace)
    result = rectangles.inner_rectangle(meshes, alignment)
    part_groups = [REMAINDER if head.argument.value == "remainder" else rectangles.RECTANGLE for head in heads]
    return parts_of(call, result, heads, part_groups, EdgeMoves(meshes, np.zeros(len(meshes.corners)), True))


def inner_rect(call: BoundCall) -> Shapes:
    """``innerRect()``: every face replaced by the largest rectangle inside it."""
    from grammarlab.geometry.outlines import inner_rectangle as rectangles  # noqa: PLC0415

    before = alike_meshes(call.shapes, call.workspace)

    def moves(whole: Meshes) -> EdgeMoves:
        return EdgeMoves(whole, np.zeros(len(whole.corners)), by_direction=True)

    return _replaced(call, before, rectangles.inner_rect(before.meshes), moves)


def rectify(call: BoundCall) -> Shapes:
    """``rectify(angle)``: edges that deviate from an axis of the scope by less than an angle made parallel to it."""
    from grammarlab.geometry.outlines.rectify import rectified  # noqa: PLC0415

    angle = np.clip(call.column(call.values[0]), 0.0, 45.0)
    before = alike_meshes(call.shapes, call.workspace, angle)

    def moves(whole: Meshes) -> EdgeMoves:
        return EdgeMoves(whole, np.zeros(len(whole.corners)), by_direction=True)

    return _replaced(call, before, rectified(before.meshes, angle[before.first]), moves)


def _edges(call: BoundCall, head: Head, meshes: Meshes, outward: NDArray[np.float64], mesh: Rows) -> NDArray[np.bool_]:
    """[C] whether the head of a part selects each edge."""

    def picked(selector: str) -> NDArray[np.bool_]:
        if selector == "all":
            return np.ones(len(outward), dtype=bool)
        return picked_by(
            selector,
            lambda name: _oriented_edges(call, name, meshes, outward, mesh),
            mesh,
            call.shapes,
            call.workspace,
        )

    if head.condition is not None:
        # Bridges between an outline and its hole cannot be selected.
        corners, _ = in_rings(meshes, edge_table(meshes).edge_of_corner)
        parts, number = edges_of_faces(call)
        flags = np.zeros(len(outward), dtype=bool)
        flags[corners] = selected(call, head.condition, parts, number, lambda word: picked(word)[corners])
        return flags
    if head.argument.keyword:
        return picked(str(head.argument.value))
    face = meshes.face_of_corner()
    number = _edge_numbers(meshes, meshes.face_offsets[:-1])
    counts = np.bincount(face[number >= 0], minlength=meshes.num_faces)[face]
    index = np.rint(call.column(head.argument)).astype(np.int64)[mesh]
    return number == index % np.maximum(counts, 1)


def _edge_numbers(meshes: Meshes, starts: Rows) -> Rows:
    """[C] number of the edge that leaves each corner, from 0 at each of these corners [K]; -1 for bridges to holes.

    The edges of a face count from its first corner on, those of its holes last.
    """
    table = edge_table(meshes)
    corners, _ = in_rings(meshes, table.edge_of_corner)
    number = np.full(len(meshes.corners), -1, dtype=np.int64)
    group = np.searchsorted(starts, corners, side="right")
    number[corners] = np.arange(len(corners)) - np.searchsorted(group, group)
    return number


def edges_towards(call: BoundCall, selectors: Sequence[str], meshes: Meshes) -> NDArray[np.bool_]:
    """[C] whether the edge that leaves each corner looks where one of these selectors says."""
    from grammarlab.geometry.outlines import setback as strips  # noqa: PLC0415

    outward, mesh = strips.edge_normals(meshes), meshes.mesh_of_face()[meshes.face_of_corner()]
    return np.logical_or.reduce([_oriented_edges(call, name, meshes, outward, mesh) for name in selectors])


def _oriented_edges(
    call: BoundCall, selector: str, meshes: Meshes, outward: NDArray[np.float64], mesh: Rows
) -> NDArray[np.bool_]:
    """[C] whether the outward normal of an edge, or the street along it, is what a selector names."""
    shapes, workspace = call.shapes, call.workspace
    flags = oriented(selector, outward, mesh, shapes, workspace)
    return by_streets(
        selector, lambda: line_sides(outline_lines(meshes), shapes, workspace), flags, mesh, shapes, workspace
    )


def edge_values(
    call: BoundCall, argument: Argument, meshes: Meshes, mesh: Rows, default: float = 0.0
) -> NDArray[np.float64]:
    """[C] number for the edge that leaves each corner: one for all edges of a shape, or those of an array in order.

    Args:
        call: the operation, on shapes [N].
        argument: a number, or an array with a number for each edge of each face.
        meshes: [N] the geometry of the shapes.
        mesh: [C] mesh of each corner.
        default: number of edges beyond the end of an array, and of bridges to holes.

    Raises:
        DerivationError: If it is an array of something else.
    """
    value = argument.value
    if not is_table(value):
        return call.column(argument)[mesh]
    position = _edge_numbers(meshes, np.searchsorted(mesh, np.arange(len(meshes))))
    table, distances = np.asarray(value)[mesh], np.full(len(mesh), default)
    for number in np.unique(table).tolist():
        array = call.workspace.tables[number]
        if array.kind != "float":
            raise call.error(f"{call.name} expected numbers, found an array of the type {array.kind}")
        has_distance = (position >= 0) & (table == number) & (position < len(array.cells))
        distances[has_distance] = np.array(array.cells, dtype=np.float64)[position[has_distance]]
    return distances


def _wings(name: Literal["shapeL", "shapeO", "shapeU"]) -> BlockOperation:
    """An outline with wings along some sides and a remainder."""

    def divide(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
        from grammarlab.geometry.outlines import setback as strips  # noqa: PLC0415

        depths = dict(zip(_WINGS[name], [call.column(argument) for argument in call.values], strict=True))
        meshes = local_meshes(call.shapes, call.workspace)
        distances = strips.wing_depths(meshes, depths)
        result = strips.setback(meshes, distances, np.zeros(len(distances), dtype=np.int64))
        part_groups = [strips.REMAINDER if head.argument.value == "remainder" else 0 for head in heads]
        return parts_of(call, result, heads, part_groups, EdgeMoves(meshes, distances, has_wings=True))

    count = len(_WINGS[name])
    return BlockOperation(divide, frozenset(), (count, count), _PARTS)


def _replaced(call: BoundCall, before: AlikeMeshes, meshes: Meshes, moves: Callable[[Meshes], EdgeMoves]) -> Shapes:
    """The shapes [N] with other geometry.

    Args:
        call: the operation.
        before: their geometry.
        meshes: [K] the new geometry of each of the old ones, in the axes of the shapes.
        moves: how edges of geometry [N] moved.
    """
    shapes, workspace, number = call.shapes, call.workspace, before.number
    result = replaced(shapes, meshes, number, workspace.meshes, workspace.frames)
    rows = np.arange(shapes.num)
    result = inherited(result, shapes, rows, workspace)
    if workspace.streets is None:
        return result
    moved = moves(before.meshes.take(number))
    return with_moved_edges(result, meshes.take(number), rows, shapes, moved, workspace)


def parts_of(
    call: BoundCall, result: Setback, heads: Sequence[Head], part_groups: Sequence[int], moved: EdgeMoves
) -> list[BoundPart]:
    """The pieces of each group as shapes: one per piece, or one of all pieces of a shape."""
    owner = result.meshes.mesh_of_face()
    parts = []
    for head, group in zip(heads, part_groups, strict=True):
        faces = np.flatnonzero(result.group == group)
        counts = np.ones(len(faces), dtype=np.int64)
        row = owner[faces]
        if head.joined and len(faces):
            row, counts = np.unique(row, return_counts=True)
        first = np.cumsum(counts) - counts
        number = (faces - result.meshes.mesh_faces[:-1][owner[faces]])[first] if len(faces) else faces
        parts.append(BoundPart(_pieces(call, result.meshes, faces, counts, row, moved), number))
    return parts


def _pieces(call: BoundCall, meshes: Meshes, faces: Rows, counts: Rows, row: Rows, moved: EdgeMoves) -> Shapes:
    """Shapes made of faces, in the axes of the shapes they come from."""
    shapes, frames = call.shapes, call.workspace.frames
    local = _separated(meshes, faces, counts)
    unit, low, size = normalized(local)
    frame = shapes.frame[row]
    position = shapes.position[row] + frames.to_world(frame, low)
    parts = shapes.parts(row, position, size, frame, add_faces(call.workspace.meshes, unit))
    parts = inherited(parts, shapes, row, call.workspace)
    return with_moved_edges(parts, local, row, shapes, moved, call.workspace)


def _separated(meshes: Meshes, faces: Rows, counts: Rows) -> Meshes:
    """Meshes with given numbers of these faces. Faces do not share points, but a face may pass the same point twice."""
    corners, offsets = take_rows(meshes.face_offsets, faces)
    sizes = np.diff(offsets)
    if sizes.max(initial=0) < _FEWEST_WITH_HOLE:
        return Meshes.from_polygons(meshes.points[meshes.corner_points()[corners]], sizes, counts)
    single = extract_faces(meshes, faces, np.ones(len(faces), dtype=np.int64))
    return regroup(_in_order_of_corners(single), offsets_from_counts(counts))


def _in_order_of_corners(meshes: Meshes) -> Meshes:
    """Meshes of one face each whose points are numbered as its corners pass them first, as in `Meshes.from_polygons`.

    So the points of a face do not depend on the other faces of a batch.
    """
    used, first, point = np.unique(meshes.corner_points(), return_index=True, return_inverse=True)
    order = np.argsort(first)
    number = np.empty(len(used), dtype=np.int64)
    number[order] = np.arange(len(used))
    corners = number[point] - meshes.mesh_points[:-1].repeat(np.diff(meshes.face_offsets))
    return replace(meshes, points=meshes.points[used[order]], corners=corners)


OPERATIONS: dict[str, Operation] = {
    "innerRect": Operation(inner_rect),
    "offset": Operation(offset, _KEEP, (1, 2)),
    "rectify": Operation(rectify, num_arguments=(1, 1)),
}

BLOCKS: dict[str, BlockOperation] = {
    "innerRectangle": BlockOperation(inner_rectangle, frozenset({"scope", "edge"}), (1, 1), _PARTS),
    "setback": BlockOperation(setback, frozenset(), (1, 2), EDGES),
    "setbackPerEdge": BlockOperation(setback, frozenset(), (1, 2), EDGES),
    "shapeL": _wings("shapeL"),
    "shapeO": _wings("shapeO"),
    "shapeU": _wings("shapeU"),
}
