"""Parts of a shape edited in place: ``modify``, a ``comp`` whose leaves and untouched faces become the shape again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, rows_of_groups
from grammarlab.derivation.calls.calls import Argument, Head
from grammarlab.derivation.calls.inlining import appended, local_meshes_of, with_meshes, with_sources
from grammarlab.derivation.state.mesh_table import scaled
from grammarlab.derivation.state.shapes import Shapes, concatenate, number_column
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.geometry.meshes.mesh import Meshes

UNTOUCHED = Head(argument=Argument("all", keyword=True), joined=True)
"""Head of the part that no other part of the block selects."""
_NEAR = 1e-5
"""Metres within which points are one corner of the shape."""


class RowNames(NamedTuple):
    """Entries of `Shapes.state` of what is derived from the parts of shapes."""

    shape: str
    """Row of the shape."""
    component: str
    """Number of the selected part among all of them."""


def recomposed(
    shapes: Shapes, parts: Sequence[Shapes], leaves: Shapes, names: RowNames, kind: str, workspace: Workspace
) -> Shapes:
    """Shapes [N] of the leaves of their selected parts and of the rest, connected again.

    The only leaf of a part that has its geometry in the unit cube is the part moved, turned or scaled, and takes the
    corners that it shares with others along; where several move one corner, it comes to the mean place.

    Args:
        shapes: the shapes.
        parts: the selected parts of each head, and the parts that none selects, all faces of a shape as one.
        leaves: what was derived from the selected parts.
        names: entries of their state.
        kind: ``f`` for faces. If the parts are edges or corners, all faces stay.
        workspace: workspace of the derivation.
    """
    *selected, rest = parts
    components = concatenate(
        [part for part in selected if part.num] or [rest.take(np.zeros(0, np.int64))], workspace.strings
    )
    of_component, of_leaf, of_rest = (
        np.asarray(number_column(each.state[names.shape], each.num)).astype(np.int64)
        for each in (components, leaves, rest)
    )
    derived_from = np.asarray(number_column(leaves.state.get(names.component, 0.0), leaves.num)).astype(np.int64)
    num_leaves = np.bincount(derived_from, minlength=components.num)
    own = scaled(workspace.meshes.take(shapes.mesh), shapes.size)
    meshes, material = [], shapes.material.copy()
    groups = (rows_of_groups(of, shapes.num) for of in (of_component, of_leaf, of_rest))
    for row, (of_row, chosen, kept) in enumerate(zip(*groups, strict=True)):
        old = dict(zip(of_row.tolist(), local_meshes_of(shapes, row, components, of_row, workspace), strict=True))
        new = local_meshes_of(shapes, row, leaves, chosen, workspace)
        number = derived_from[chosen]
        is_moved = (leaves.mesh[chosen] == components.mesh[number]) & (num_leaves[number] == 1)
        before = [old[index] for index in number[is_moved].tolist()]
        corners = _Corners(before, [mesh for mesh, moved in zip(new, is_moved, strict=True) if moved])
        edited = [
            old[index] if moved else mesh for mesh, index, moved in zip(new, number.tolist(), is_moved, strict=True)
        ]
        used = leaves.material[chosen].tolist()
        if kind == "f":
            others = local_meshes_of(shapes, row, rest, kept, workspace)
        else:
            # Moved edges and corners are no faces.
            new_faces = np.flatnonzero(~is_moved).tolist()
            edited, used = [edited[index] for index in new_faces], [used[index] for index in new_faces]
            others = [own.take(np.array([row]))]
        first = int(shapes.material[row])
        group = [corners.after(mesh) for mesh in (*edited, *others)]
        result = appended(group)
        result = result._replace(mesh=_connected(result.mesh))
        material[row], mesh = with_sources(result, group, [*used, *[first] * len(others)], first, workspace)
        meshes.append(mesh)
    return with_meshes(shapes, meshes, workspace)._replace(material=material)


def _connected(mesh: Meshes) -> Meshes:
    from grammarlab.geometry.meshes.reconnection import reconnected  # noqa: PLC0415

    result = reconnected(mesh) if mesh.num_faces else None
    return mesh if result is None else result


class _Corners:
    """Where the corners of moved parts were, and where they are."""

    def __init__(self, old: Sequence[Meshes], new: Sequence[Meshes]) -> None:
        before = np.concatenate([mesh.points for mesh in old]) if old else np.zeros((0, 3))
        after = np.concatenate([mesh.points for mesh in new]) if new else np.zeros((0, 3))
        moved = np.abs(after - before).max(axis=1, initial=0.0) > _NEAR
        self._before, self._after = before[moved], after[moved]

    def after(self, mesh: Meshes) -> Meshes:
        """A mesh with its corners at their new places."""
        if not len(self._before):
            return mesh
        from scipy.spatial import KDTree  # noqa: PLC0415  # few grammars need it

        near = KDTree(self._before).query_ball_point(mesh.points, _NEAR)
        points: Floats = mesh.points.copy()
        for index, rows in enumerate(near):
            if rows:
                points[index] = self._after[sorted(rows)].mean(axis=0)
        return mesh.with_points(points)
