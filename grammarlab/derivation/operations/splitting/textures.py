"""``split`` in texture space: a shape cut at values of u or v."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls.calls import BoundCall, BoundPart, Head
from grammarlab.derivation.functions.shapes.geometry import local_meshes
from grammarlab.derivation.functions.shapes.texture_coordinates import SPACES, UV_AXES, Range, range_of, uv_set_of
from grammarlab.derivation.operations.splitting.parts import asked_indices, elements_of, indexed, numbered
from grammarlab.derivation.state.meshes import add_faces, normalized
from grammarlab.derivation.state.shapes import BOX, FACE, FOOTPRINT, Floats, Ids, Shapes
from grammarlab.derivation.state.texture_maps import map_ids
from grammarlab.derivation.values.splitting import SplitPieces, count_pieces, divide
from grammarlab.geometry.cuts.clip import slabs
from grammarlab.geometry.meshes.vectors import cross, dot, norm, unit

Rows = NDArray[np.int64]

_STRAIGHT = 1e-12
"""Largest component of a unit vector along other axes for which it counts as an axis."""

_LIES_ALONG = {BOX: (0, 1, 2), FOOTPRINT: (0, 2), FACE: (0, 1)}
"""Axes along which a box or rectangle extends."""


def split_between_values(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
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
    if (map_ids(call.shapes, uv_set) < 0).any():
        raise call.error(
            f"split({words[0]}, ...) came to a shape without texture coordinates in set {uv_set}",
            "setupProjection and projectUV create them",
        )
    found = range_of(call.shapes, uv_set, UV_AXES.index(words[0]), call.workspace)
    unit_length = found.metres if words[1] == "unitSpace" else np.ones(call.shapes.num)
    length = found.extent * unit_length
    elements = elements_of(call, heads, length)
    call.workspace.expanded(count_pieces(length, elements), call.shapes.num, call.location)
    pieces = divide(length, elements)
    asked = asked_indices(call.workspace)
    numbers = numbered(pieces, call.shapes, is_wanted=bool(asked))
    made = [_part(call, found, unit_length, piece) for piece in pieces]
    if asked:
        made = indexed(made, pieces, numbers, call.shapes.num, asked)
    return [BoundPart(part, number) for part, number in zip(made, numbers, strict=True)]


def _part(call: BoundCall, found: Range, unit_length: Floats, piece: SplitPieces) -> Shapes:
    """The shapes [K] of one size of a split of shapes [N].

    Args:
        call: the split.
        found: the coordinate on the shapes [N].
        unit_length: [N] length of one unit of the coordinate in the unit of the sizes.
        piece: what becomes of the size.
    """
    rows = piece.row
    shapes = call.shapes.take(rows)
    if len(rows) == 0:
        return shapes
    steepness = norm(found.gradient[rows])
    direction = unit(found.gradient[rows])
    ends = np.stack([piece.start, piece.start + piece.extent]) / unit_length[rows]
    # From values of the coordinate to metres from the scope's origin along its gradient.
    low, high = (found.low[rows] + ends - found.start[rows]) / steepness
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
    other = np.flatnonzero(~is_simple)
    if len(other):
        cut = _between(call, shapes.take(other), direction[other], low[other], high[other])
        position[other], size[other], mesh[other] = cut
    return shapes.rescoped(position, size, shapes.frame, mesh)


def _scope_axes(mesh: Ids, direction: Floats) -> tuple[Rows, NDArray[np.bool_]]:
    """Scope axis [K] nearest to a direction [K, 3], and whether shapes of these meshes extend exactly along it."""
    axis = np.abs(direction).argmax(axis=1)
    others = np.abs(direction)
    others[np.arange(len(axis)), axis] = 0.0
    extends = np.zeros((FACE + 2, 3), dtype=bool)
    for kind, axes in _LIES_ALONG.items():
        extends[kind, list(axes)] = True
    return axis, (others.max(axis=1) < _STRAIGHT) & extends[np.minimum(mesh, FACE + 1), axis]


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
