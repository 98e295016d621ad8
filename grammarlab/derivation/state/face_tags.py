"""Tags of the faces of shapes: each face of a mesh has the number of a set of tags, in the `TagTable` of a derivation.

Only grammars that use tags have any: otherwise `Workspace.tags` is None, and nothing here does anything.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.state.shapes import Shapes
from grammarlab.derivation.state.tag_table import Names, TagTable, matches
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.geometry.meshes.edges import edges
from grammarlab.geometry.meshes.mesh import NUM_ROLES, Meshes


def face_sets(meshes: Meshes) -> NDArray[np.integer]:
    """[F] the number of the set of tags of each face."""
    return meshes.tags // NUM_ROLES


def sets_of_shapes(shapes: Shapes, workspace: Workspace, table: TagTable) -> NDArray[np.int32]:
    """[N] the number of the set of all tags of the faces of each shape."""
    meshes, inverse = _different(shapes, workspace)
    return table.united(face_sets(meshes), meshes.mesh_of_face(), len(meshes))[inverse]


def sets_of_components(meshes: Meshes, table: TagTable, kind: str, part: str = "") -> NDArray[np.int32]:
    """[K] numbers of the sets of tags of components; what is tagged also tags its edges and corners.

    Args:
        meshes: M meshes.
        table: the sets.
        kind: ``f``, ``e``, ``v``, ``fe`` or ``fv``; the components are in the order of `geometry.components`.
        part: with ``e`` or ``v``, all tags of the edges or corners of the components.
    """
    face, own = meshes.face_of_corner(), face_sets(meshes).astype(np.int32)
    if kind in ("fe", "fv"):
        return own[face[np.flatnonzero(edges(meshes).edge_of_corner >= 0)] if kind == "fe" else face]
    if kind == "f" and not part:
        return own
    points, here = meshes.corner_points(), np.arange(len(face))
    found = edges(meshes)
    if kind == "v" or part == "v":
        sets, place = table.united(own[face], points, len(meshes.points)), points
    else:
        here = np.flatnonzero(found.edge_of_corner >= 0)
        place = found.edge_of_corner[here]
        sets = table.united(own[face[here]], place, len(found))
    if kind == "f":
        return table.united(sets[place], face[here], meshes.num_faces)
    if kind == "v":
        return sets[np.unique(points)]
    ends = np.concatenate((found.start, found.end))
    return sets if part != "v" else table.united(sets[ends], np.tile(np.arange(len(found)), 2), len(found))


def with_changed_tags(shapes: Shapes, workspace: Workspace, change: Callable[[Names], Iterable[str]]) -> Shapes:
    """Shapes with a change of the tags of each of their faces."""
    if workspace.tags is None:
        return shapes
    meshes, inverse = _different(shapes, workspace)
    tags = meshes.roles + NUM_ROLES * workspace.tags.changed(face_sets(meshes), change)
    return shapes._replace(mesh=workspace.meshes.add(replace(meshes, tags=tags.astype(np.int32)))[inverse])


def inherited(parts: Shapes, sources: Shapes, rows: NDArray[np.integer], workspace: Workspace) -> Shapes:
    """Parts [K] of shapes whose faces also have the tags that all faces of their shape have.

    Args:
        parts: the parts.
        sources: [N] the shapes.
        rows: [K] the shape of each part.
        workspace: workspace of the derivation.
    """
    table = workspace.tags
    if table is None or parts.num == 0:
        return parts
    common = _common(sources, workspace, table)[rows]
    for number in np.unique(common[common > 0]).tolist():
        chosen, more = np.flatnonzero(common == number), table[number]
        tagged = with_changed_tags(parts.take(chosen), workspace, lambda names, more=more: (*names, *more))
        mesh = parts.mesh.copy()
        mesh[chosen] = tagged.mesh
        parts = parts._replace(mesh=mesh)
    return parts


def with_automatic_tags(
    shapes: Shapes,
    workspace: Workspace,
    base: str,
    kinds: Callable[[Meshes], NDArray[np.integer]],
    names: Mapping[int, str],
) -> Shapes:
    """Shapes whose faces have the tags that an operation gives, and none that it gave before.

    Args:
        shapes: the result of the operation.
        workspace: workspace of the derivation.
        base: first subtag of all its tags.
        kinds: makes of meshes in the unit cubes of their scopes the kind [F] of each face.
        names: the rest of the tag of each kind; other kinds have none.
    """
    table = workspace.tags
    if table is None:
        return shapes
    meshes, inverse = _different(shapes, workspace)
    kind = kinds(meshes)
    sets = table.changed(face_sets(meshes), lambda tags: [tag for tag in tags if not matches(base, tag)])
    for number, name in names.items():
        chosen = kind == number
        added = f"{base}.{name}"
        sets[chosen] = table.changed(sets[chosen], lambda tags, added=added: (*tags, added))
    tagged = replace(meshes, tags=(NUM_ROLES * sets).astype(np.int32))
    return shapes._replace(mesh=workspace.meshes.add(tagged)[inverse])


def _different(shapes: Shapes, workspace: Workspace) -> tuple[Meshes, NDArray[np.intp]]:
    """The different meshes of shapes, and the number [N] of that of each shape."""
    ids, inverse = np.unique(shapes.mesh, return_inverse=True)
    return workspace.meshes.take(ids), inverse


def _common(shapes: Shapes, workspace: Workspace, table: TagTable) -> NDArray[np.int32]:
    """[N] the number of the set of the tags that all faces of a shape have."""
    meshes, inverse = _different(shapes, workspace)
    sets = face_sets(meshes)
    result = np.zeros(len(meshes), np.int32)
    for mesh in range(len(meshes)):
        own = np.unique(sets[meshes.mesh_faces[mesh] : meshes.mesh_faces[mesh + 1]]).tolist()
        if own:
            result[mesh] = table.id(set(table[own[0]]).intersection(*[table[number] for number in own[1:]]))
    return result[inverse]
