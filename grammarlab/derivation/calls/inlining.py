"""Shapes derived at once and merged into one: ``inline``, ``union``, ``subtract`` and ``intersect``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import rows_of_groups
from grammarlab.derivation.calls.texture_transfer import with_pivot
from grammarlab.derivation.state.face_tags import face_sets
from grammarlab.derivation.state.mesh_table import normalized, right_handed, scaled, upright
from grammarlab.derivation.state.shapes import EMPTY, Shapes, concatenate, join_values, take_value
from grammarlab.derivation.state.tag_table import matches
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.errors import BudgetError, Location
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.mesh import NUM_ROLES, Meshes, SourcedMesh

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
    around all of them; their faces keep their materials and tags.

    Args:
        shapes: the shapes.
        leaves: from `derived_at_once`.
        strategy: ``append``, ``unify`` or ``recompose``.
        workspace: workspace of the derivation.
        location: place of the operation.
    """
    leaves_of = rows_of_groups(np.asarray(leaves.state[row_name(workspace)]).astype(np.int64), shapes.num)
    counts = np.array([len(chosen) for chosen in leaves_of], np.int64)
    first = np.cumsum(counts) - counts
    meshes, material = [], shapes.material.copy()
    for row, chosen in enumerate(leaves_of):
        group = local_meshes_of(shapes, row, leaves, chosen, workspace) if len(chosen) > 1 else []
        result, own = _unified(group, strategy, workspace, location), leaves.material[chosen].tolist()
        whole = result.mesh
        if group:
            material[row], whole = with_sources(result, group, own, own[0], workspace)
        meshes.append(whole)
    result = with_meshes(shapes, meshes, workspace)._replace(material=material)
    single = np.flatnonzero(counts == 1)
    return _with_leaves(result, leaves, single, first[single], workspace)


def with_attributes(shapes: Shapes, leaves: Shapes, workspace: Workspace) -> Shapes:
    """Shapes [N] of which those with a single leaf have the rule attributes of that leaf.

    Args:
        shapes: the shapes.
        leaves: from `derived_at_once`.
        workspace: workspace of the derivation.
    """
    rows = np.asarray(leaves.state[row_name(workspace)]).astype(np.int64)
    counts = np.bincount(rows, minlength=shapes.num)
    single, others = np.flatnonzero(counts[rows] == 1), np.flatnonzero(counts != 1)
    order = np.argsort(np.concatenate([rows[single], others]))
    state = dict(shapes.state)
    for name in workspace.attributes.keys() & state.keys():
        values = [take_value(leaves.state[name], single), take_value(state[name], others)]
        state[name] = take_value(join_values(values, [len(single), len(others)], workspace.strings), order)
    return shapes._replace(state=state)


def combined_shapes(
    shapes: Shapes,
    leaves: Shapes,
    operation: Literal["union", "subtract", "intersect"],
    is_swapped: bool,
    workspace: Workspace,
    location: Location,
) -> Shapes:
    """Shapes [N] with the geometry of a boolean operation on them and their leaves; faces keep materials and tags.

    Where one is not closed, ``union`` puts all together and the others keep the target, with a warning.

    Args:
        shapes: the shapes, operand A.
        leaves: from `derived_at_once`, operand B.
        operation: the operation.
        is_swapped: whether B is the target.
        workspace: workspace of the derivation.
        location: place of the operation.
    """
    from grammarlab.geometry.meshes.booleans import combined  # noqa: PLC0415

    leaves_of = rows_of_groups(np.asarray(leaves.state[row_name(workspace)]).astype(np.int64), shapes.num)
    own = scaled(workspace.meshes.take(shapes.mesh), shapes.size)
    meshes, material = [], shapes.material.copy()
    for row, chosen in enumerate(leaves_of):
        target = [own.take(np.array([row]))] if own.mesh_faces[row + 1] > own.mesh_faces[row] else []
        tool, of_tool = local_meshes_of(shapes, row, leaves, chosen, workspace), leaves.material[chosen].tolist()
        groups = [*tool, *target] if is_swapped else [*target, *tool]
        used = [*of_tool, *material[[row] * len(target)]] if is_swapped else [*material[[row] * len(target)], *of_tool]
        result = combined(groups, len(tool) if is_swapped else len(target), operation)
        if result is None:
            message = f"{operation} expects closed geometry; what is not closed stays as it is"
            workspace.recorder.add_warning(message, location)
            stays = groups if operation == "union" else groups[: len(tool) if is_swapped else len(target)]
            result = appended(stays)
        first = int(used[0]) if used else int(material[row])
        material[row], mesh = with_sources(result, groups, used, first, workspace)
        is_tool = result.source < len(tool) if is_swapped else result.source >= len(target)
        meshes.append(_with_operands(mesh, is_tool, workspace))
    return with_meshes(shapes, meshes, workspace)._replace(material=material)


def _with_operands(mesh: Meshes, is_tool: NDArray[np.bool_], workspace: Workspace) -> Meshes:
    """A mesh whose faces have the tag ``bool.A``, or ``bool.B`` where they come from the second operand."""
    table = workspace.tags
    if table is None:
        return mesh
    sets = face_sets(mesh).astype(np.int32)
    for chosen, operand in ((~is_tool, "bool.A"), (is_tool, "bool.B")):
        sets[chosen] = table.changed(
            sets[chosen], lambda tags, own=operand: [own, *(tag for tag in tags if not matches("bool", tag))]
        )
    return replace(mesh, tags=(mesh.roles + NUM_ROLES * sets).astype(np.int32))


def with_sources(
    result: SourcedMesh, groups: Sequence[Meshes], materials: Sequence[int], first: int, workspace: Workspace
) -> tuple[int, Meshes]:
    """The id of the materials of a result, and its mesh with the tags and materials of the faces it is made of.

    Args:
        result: a mesh and the faces of others that it is made of.
        groups: the other meshes.
        materials: their materials.
        first: the material that rules see.
        workspace: workspace of the derivation.
    """
    mesh, table = result.mesh, workspace.materials
    tags, ids = np.zeros(mesh.num_faces, np.int32), np.full(mesh.num_faces, first, np.int64)
    for number, (group, material) in enumerate(zip(groups, materials, strict=True)):
        chosen = np.flatnonzero(result.source == number)
        faces = result.face[chosen]
        tags[chosen] = group.tags[faces]
        slots = np.zeros(group.num_faces, np.int32) if group.data is None else group.data.slots
        ids[chosen] = np.array(table.members(material))[slots[faces]]
    members = list(dict.fromkeys([table.members(first)[0], *ids.tolist()]))
    slots = np.searchsorted(np.sort(members), ids)
    slots = np.argsort(members)[slots].astype(np.int32)
    data = mesh.data
    if len(members) > 1 or data is not None:
        values = np.full((len(mesh.corners), 3), np.nan) if data is None else data.values
        data = CornerData(values, slots)
    return table.palette(members), replace(mesh, tags=tags, data=data)


def local_meshes_of(
    shapes: Shapes, row: int, leaves: Shapes, chosen: NDArray[np.integer], workspace: Workspace
) -> list[Meshes]:
    """Meshes of the chosen leaves of one shape, in metres along its axes from its origin."""
    frames = workspace.frames
    own = leaves.take(chosen)
    parts = scaled(workspace.meshes.take(own.mesh), own.size)
    turn = np.swapaxes(frames.rotations(shapes.frame[row : row + 1]), 1, 2) @ frames.rotations(own.frame)
    offset = frames.to_local(np.repeat(shapes.frame[row], len(chosen)), own.position - shapes.position[row])
    owner = parts.mesh_of_point()
    points = np.einsum("pij,pj->pi", turn[owner], parts.points) + offset[owner]
    placed = parts.with_points(points, turn=turn)
    return [placed.take(np.array([index])) for index in range(len(chosen))]


def _unified(group: Sequence[Meshes], strategy: str, workspace: Workspace, location: Location) -> SourcedMesh:
    if strategy == "unify" and group:
        from grammarlab.geometry.meshes.booleans import united  # noqa: PLC0415

        result = united(group)
        if result is not None:
            return result
        workspace.recorder.add_warning("inline(unify) expects closed geometry; it is appended", location)
    whole = appended(group)
    if strategy == "recompose" and group:
        from grammarlab.geometry.meshes.reconnection import MOST_EDGES, reconnected  # noqa: PLC0415

        mesh = reconnected(whole.mesh)
        if mesh is not None:
            return whole._replace(mesh=mesh)
        message = f"inline(recompose) connects at most {MOST_EDGES:,} edges; more are appended"
        workspace.recorder.add_warning(message, location)
    return whole


def appended(group: Sequence[Meshes]) -> SourcedMesh:
    """All faces of meshes, with the mesh and the face that each comes from."""
    counts = [mesh.num_faces for mesh in group]
    return SourcedMesh(
        Meshes.united(group),
        np.repeat(np.arange(len(group)), counts),
        np.concatenate([np.arange(count) for count in counts]) if counts else np.zeros(0, np.int64),
    )


def with_meshes(shapes: Shapes, meshes: Sequence[Meshes], workspace: Workspace) -> Shapes:
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
