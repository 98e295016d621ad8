"""Texture coordinates and plans of initial shapes and of moved shapes, and the pivots that shapes move with.

A pivot is the coordinate system that a scope is placed in: ``scope.t`` and ``scope.r`` count from it. Its axes are a
column of every shape; its position is kept in `Shapes.state`, as the attributes ``pivot.p``, if the grammar reads it.
"""

from __future__ import annotations

from typing import cast

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.derivation.state.shapes import Ids, Shapes, Value, number_column
from grammarlab.derivation.state.texture_maps import NONE, Move, map_name, projection_name
from grammarlab.derivation.state.workspace import Workspace

PIVOT_POSITION = ("pivot.px", "pivot.py", "pivot.pz")
"""Metres along the axes of the initial shape, from its origin."""
_STREET = ((True, False), (False, False), (False, True))
"""For each set of initial shapes, whether it runs from 0 to 1, and whether u begins at the other end."""


def initial_maps(roots: Shapes, workspace: Workspace) -> dict[str, Value]:
    """Entries of `Shapes.state` of the initial shapes: the coordinates of a straight street, and a projection.

    u runs along the first edge, v from it across the shape: in set 0 from 0 to 1, in set 1 in metres, in set 2 in
    metres with u from the other end. The projection of all sets is in metres: v upwards, and u along the first edge
    plus the distance behind it, so that it runs on around the corner.
    """
    no_maps = np.full(roots.num, NONE, dtype=np.int32)
    state: dict[str, Value] = {}
    projection = no_maps
    if workspace.uv_sets and roots.num:
        projection = workspace.texture_maps.add(_around_the_corner(roots, workspace), np.zeros(roots.num, dtype=bool))
    for uv_set in workspace.uv_sets:
        state[projection_name(uv_set)] = projection
        state[map_name(uv_set)] = no_maps
        if uv_set < len(_STREET) and roots.num:
            state[map_name(uv_set)] = workspace.texture_maps.add(
                _street(roots, uv_set, workspace), np.ones(roots.num, dtype=bool)
            )
    return state


def carried(before: Shapes, after: Shapes, workspace: Workspace) -> Shapes:
    """Shapes that were moved, rotated or scaled with their scopes, with their previous coordinates and edges.

    Args:
        before: [N] the shapes before the move.
        after: [N] the shapes after it; points of the unit cubes of their scopes correspond.
        workspace: workspace of the derivation.
    """
    names = workspace.map_names
    if not names:
        return after
    move = Move.of(before, after)
    moved = {name: workspace.texture_maps.moved(cast("Ids", after.state[name]), move) for name in names}
    return after._replace(state={**after.state, **moved})


def without_maps(shapes: Shapes, workspace: Workspace) -> Shapes:
    """The same shapes without texture coordinates, and without a place in the plan of their lot."""
    names = workspace.map_names
    if not names:
        return shapes
    no_maps = np.full(shapes.num, NONE, dtype=np.int32)
    return shapes._replace(state={**shapes.state, **dict.fromkeys(names, no_maps)})


def pivot_position(shapes: Shapes, workspace: Workspace) -> Floats:
    """[N, 3] positions of the pivots, from the origin of positions; on an initial shape, its scope's origin."""
    roots = workspace.roots
    offset = np.stack([number_column(shapes.state.get(name, 0.0), shapes.num) for name in PIVOT_POSITION], axis=1)
    return roots.position[shapes.model] + workspace.frames.to_world(roots.frame[shapes.model], offset)


def with_pivot(shapes: Shapes, position: Floats, frame: Ids, workspace: Workspace) -> Shapes:
    """The same shapes with pivots at positions [N, 3], with the axes of frames [N]."""
    shapes = shapes._replace(pivot=frame)
    if PIVOT_POSITION[0] not in workspace.state_names:
        return shapes
    roots = workspace.roots
    offset = workspace.frames.to_local(roots.frame[shapes.model], position - roots.position[shapes.model])
    return shapes._replace(state={**shapes.state, **dict(zip(PIVOT_POSITION, offset.T.copy(), strict=True))})


def _street(roots: Shapes, uv_set: int, workspace: Workspace) -> Floats:
    """[N, 2, 4] the maps of one set of initial shapes."""
    is_unit, is_reversed = _STREET[uv_set]
    x, _, z = np.moveaxis(workspace.frames.rotations(roots.frame), 2, 0)
    width, depth = roots.size[:, 0], roots.size[:, 2]
    u, v = (-x, width) if is_reversed else (x, np.zeros_like(width)), (-z, depth)
    maps = np.empty((roots.num, 2, 4))
    for row, ((gradient, start), extent) in enumerate(zip((u, v), (width, depth), strict=True)):
        share = np.where(extent > 0.0, 1.0 / np.where(extent > 0.0, extent, 1.0), 0.0) if is_unit else 1.0
        maps[:, row, :3] = gradient * np.reshape(share, (-1, 1))
        maps[:, row, 3] = (start - np.einsum("ni,ni->n", gradient, roots.position)) * share
    return maps


def _around_the_corner(roots: Shapes, workspace: Workspace) -> Floats:
    """[N, 2, 4] the projection of initial shapes: (x - z, y) in their axes, from their first corner."""
    x, y, z = np.moveaxis(workspace.frames.rotations(roots.frame), 2, 0)
    first_of_mesh = workspace.meshes.take(roots.mesh)
    filled = np.flatnonzero(np.diff(first_of_mesh.mesh_points) > 0)
    corner = np.zeros((roots.num, 3))
    first = first_of_mesh.face_offsets[first_of_mesh.mesh_faces[filled]]
    corner[filled] = first_of_mesh.points[first_of_mesh.corner_points()[first]]
    position = roots.position + workspace.frames.to_world(roots.frame, corner * roots.size)
    gradients = np.stack([x - z, y], axis=1)
    start = -np.einsum("nai,ni->na", gradients, position)
    return np.concatenate([gradients, start[:, :, None]], axis=2)
