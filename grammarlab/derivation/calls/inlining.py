"""Shapes derived at once and merged into one: ``inline``, ``union``, ``subtract`` and ``intersect``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls.texture_transfer import with_pivot
from grammarlab.derivation.state.mesh_table import normalized, right_handed, scaled, upright
from grammarlab.derivation.state.shapes import EMPTY, Shapes, concatenate
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.errors import BudgetError, Location
from grammarlab.geometry.meshes.mesh import Meshes

if TYPE_CHECKING:  # imported by the first boolean operation, since few grammars have any
    from grammarlab.geometry.meshes.booleans import Operation

_MOST_LEVELS = 20
"""Largest depth of inlined rules in inlined rules."""


def derived_at_once(
    run: Callable[[Shapes, Workspace], None], shapes: Shapes, workspace: Workspace, location: Location
) -> Shapes:
    """Leaves [K] of shapes [N], ordered by shape; `Shapes.state` has the row of each under `row_name`.

    Args:
        run: applies operations to shapes.
        shapes: the shapes.
        workspace: workspace of the derivation, whose pending shapes wait meanwhile.
        location: place of the operation.

    Raises:
        BudgetError: If it is inside of itself too often.
    """
    if workspace.inline_depth >= _MOST_LEVELS:
        hint = "a recursive rule needs a case that ends it"
        raise BudgetError(f"inlined rules contain each other more than {_MOST_LEVELS} times", location, hint)
    name = row_name(workspace)
    marked = shapes._replace(state={**shapes.state, name: np.arange(shapes.num, dtype=np.float64)})
    waiting, workspace.pending = workspace.pending, [[] for _ in workspace.pending]
    workspace.inline_depth += 1

    def derive() -> None:
        run(marked, workspace)
        workspace.finish()

    try:
        chunks = workspace.recorder.leaves_apart(derive)
    finally:
        workspace.inline_depth -= 1
        workspace.pending = waiting
    plain = [chunk._replace(locals=(), key=None) for chunk in chunks]
    if not plain:
        return marked.take(np.zeros(0, np.int64))
    leaves = concatenate(plain, workspace.strings)
    meshes, frames = workspace.meshes, workspace.frames
    leaves = right_handed(upright(leaves, meshes, frames), meshes, frames)
    visible = np.flatnonzero(leaves.mesh != EMPTY)
    rows = np.asarray(leaves.state[name])[visible]
    return leaves.take(visible[np.argsort(rows, kind="stable")])


def row_name(workspace: Workspace) -> str:
    """Entry of `Shapes.state` with the row of the shape that is being inlined."""
    return f"inlined.{workspace.inline_depth}"


def merged(shapes: Shapes, leaves: Shapes, strategy: str, workspace: Workspace, location: Location) -> Shapes:
    """Shapes [N] with the geometry of their leaves.

    A single leaf is taken as it is, with its scope and material. Several leaves get the axes of the shape and a scope
    around all of them; their material is that of the shape, unless all have the same.

    Args:
        shapes: the shapes.
        leaves: from `derived_at_once`.
        strategy: ``append``, ``unify`` or ``recompose``; the last is the first here.
        workspace: workspace of the derivation.
        location: place of the operation.
    """
    rows = np.asarray(leaves.state[row_name(workspace)]).astype(np.int64)
    counts = np.bincount(rows, minlength=shapes.num)
    first = np.cumsum(counts) - counts
    groups = [_local(shapes, leaves, rows, row, workspace) if counts[row] > 1 else [] for row in range(shapes.num)]
    meshes = [_unified(group, strategy, workspace, location) for group in groups]
    result = _with_meshes(shapes, meshes, workspace)
    single = np.flatnonzero(counts == 1)
    result = _with_leaves(result, leaves, single, first[single], workspace)
    material = result.material.copy()
    for row in np.flatnonzero(counts > 1).tolist():
        own = leaves.material[first[row] : first[row] + counts[row]]
        if (own == own[0]).all():
            material[row] = own[0]
    return result._replace(material=material)


def combined_shapes(
    shapes: Shapes,
    first: Shapes,
    second: Shapes,
    operation: Literal["union", "subtract", "intersect"],
    workspace: Workspace,
    location: Location,
) -> Shapes:
    """Shapes [N] with the geometry of a boolean operation on their leaves of two bodies.

    Where a leaf is not closed, ``union`` puts the leaves together and the others keep the first ones, with a warning.
    """
    from grammarlab.geometry.meshes.booleans import combined  # noqa: PLC0415

    name = row_name(workspace)
    rows = [np.asarray(part.state[name]).astype(np.int64) for part in (first, second)]
    meshes = []
    for row in range(shapes.num):
        left = _local(shapes, first, rows[0], row, workspace)
        right = _local(shapes, second, rows[1], row, workspace)
        mesh = combined(left, right, cast("Operation", operation))
        if mesh is None:
            message = f"{operation} expects closed geometry; what is not closed stays as it is"
            workspace.recorder.add_warning(message, location)
            mesh = Meshes.united([*left, *right] if operation == "union" else left)
        meshes.append(mesh)
    return _with_meshes(shapes, meshes, workspace)


def _local(shapes: Shapes, leaves: Shapes, rows: NDArray[np.int64], row: int, workspace: Workspace) -> list[Meshes]:
    """Meshes of the leaves of one shape, in metres along its axes from its origin."""
    chosen = np.flatnonzero(rows == row)
    frames = workspace.frames
    own = leaves.take(chosen)
    parts = scaled(workspace.meshes.take(own.mesh), own.size)
    turn = np.swapaxes(frames.rotations(shapes.frame[row : row + 1]), 1, 2) @ frames.rotations(own.frame)
    offset = frames.to_local(np.repeat(shapes.frame[row], len(chosen)), own.position - shapes.position[row])
    owner = parts.mesh_of_point()
    points = np.einsum("pij,pj->pi", turn[owner], parts.points) + offset[owner]
    placed = parts.with_points(points, turn=turn)
    return [placed.take(np.array([index])) for index in range(len(chosen))]


def _unified(group: Sequence[Meshes], strategy: str, workspace: Workspace, location: Location) -> Meshes:
    if strategy == "unify" and group:
        from grammarlab.geometry.meshes.booleans import polygons_of, united  # noqa: PLC0415

        solid = united(group)
        if solid is not None:
            return polygons_of(solid)
        workspace.recorder.add_warning("inline(unify) expects closed geometry; it is appended", location)
    return Meshes.united(group)


def _with_meshes(shapes: Shapes, meshes: Sequence[Meshes], workspace: Workspace) -> Shapes:
    """Shapes with other geometry [N] in their axes, in metres from their origins."""
    if not meshes:
        return shapes
    unit, low, size = normalized(Meshes.concatenate(list(meshes)))
    position = shapes.position + workspace.frames.to_world(shapes.frame, low)
    return shapes._replace(position=position, size=size, mesh=workspace.meshes.add(unit))


def _with_leaves(
    shapes: Shapes, leaves: Shapes, rows: NDArray[np.int64], which: NDArray[np.int64], workspace: Workspace
) -> Shapes:
    """Shapes of which those at rows are a single leaf."""
    if len(rows) == 0:
        return shapes
    columns = {}
    for name in ("position", "size", "frame", "mesh", "material", "pivot"):
        column = getattr(shapes, name).copy()
        column[rows] = getattr(leaves, name)[which]
        columns[name] = column
    result = shapes._replace(**columns)
    return with_pivot(result, result.position, result.pivot, workspace) if len(rows) == shapes.num else result
