"""Maps of shapes whose meshes have texture coordinates at their corners, and leaves with these maps applied."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, distinct_rows, index_in_row, take_rows
from grammarlab.derivation.forest import Leaves
from grammarlab.derivation.state.shapes import Ids, Shapes
from grammarlab.derivation.state.texture_maps import DELETED, FACES, NONE, WORLD, map_ids, with_maps
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.geometry.components import extract_faces
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.mesh import Meshes

_IDENTITY = np.eye(4)[:2]
_SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def own_maps(shapes: Shapes, uv_set: int, workspace: Workspace) -> Ids:
    """[N] maps of one uv set that the grammar uses; those of the corners of the mesh where a shape has no map."""
    ids = map_ids(shapes, uv_set)
    if not workspace.meshes.has_data:
        return ids
    rows = np.flatnonzero(ids == NONE)
    rows = rows[workspace.meshes.has_coordinates(shapes.mesh[rows], uv_set)]
    if len(rows) == 0:
        return ids
    maps = np.broadcast_to(_IDENTITY, (len(rows), 2, 4))
    source = np.full(len(rows), uv_set, dtype=np.int8)
    ids = ids.copy()
    ids[rows] = workspace.texture_maps.add(maps, np.zeros(len(rows), dtype=bool), source)
    return ids


def with_face_maps(shapes: Shapes, workspace: Workspace) -> Shapes:
    """Boxes or rectangles [N] on each of whose faces an image is once, if the grammar uses the first uv set."""
    if 0 not in workspace.uv_sets or not shapes.num:
        return shapes
    source = np.full(1, FACES, dtype=np.int8)
    ids = workspace.texture_maps.add(_IDENTITY[None], np.zeros(1, dtype=bool), source)
    return with_maps(shapes, 0, ids.repeat(shapes.num))


def without_face_maps(shapes: Shapes, workspace: Workspace) -> Shapes:
    """The same shapes without coordinates where these belong to whole faces, which are about to be cut."""
    if not workspace.texture_maps.has_faces:
        return shapes
    ids = map_ids(shapes, 0)
    rows = np.flatnonzero(ids >= 0)
    rows = rows[workspace.texture_maps.source(ids[rows]) == FACES]
    if len(rows) == 0:
        return shapes
    ids = ids.copy()
    ids[rows] = NONE
    return with_maps(shapes, 0, ids)


def coordinates_of(meshes: Meshes, source: NDArray[np.int8]) -> Floats:
    """[C, 2] coordinates of the corners of meshes [M] from their sources [M], sets of the corners or `FACES`."""
    of_corner = source[meshes.mesh_of_corner()]
    coordinates = np.full((len(of_corner), 2), np.nan)
    for uv_set in np.unique(source[source >= 0]).tolist():
        chosen = of_corner == uv_set
        if meshes.data is not None:
            coordinates[chosen] = meshes.data.coordinates(uv_set)[chosen]
    counts = np.diff(meshes.face_offsets)
    on_faces = np.flatnonzero((of_corner == FACES) & (counts == 4).repeat(counts))
    coordinates[on_faces] = _SQUARE[index_in_row(counts)[on_faces]]
    return coordinates


def finished(leaves: Leaves, workspace: Workspace) -> Leaves:
    """Leaves in which every mesh has one material, and the coordinates that rules gave its corners.

    A leaf of several materials becomes one for each of them. What is left in `Leaves.texture_map` are maps from the
    world and negative ids.
    """
    if not workspace.has_corner_maps:
        return leaves
    if workspace.materials.has_palettes:
        leaves = _of_one_material(leaves, workspace)
    return _mapped(leaves, workspace)


def _of_one_material(leaves: Leaves, workspace: Workspace) -> Leaves:
    """Leaves with palettes, divided by the materials of their faces."""
    pairs, inverse = np.unique(np.stack([leaves.mesh, leaves.material], axis=1), axis=0, return_inverse=True)
    meshes, materials, counts = [], [], []
    for mesh, material in pairs.tolist():
        members = workspace.materials.members(material)
        parts = [(mesh, members[0])] if len(members) == 1 else _parts_of(mesh, members, workspace)
        counts.append(len(parts))
        meshes += [part for part, _ in parts]
        materials += [member for _, member in parts]
    where, offsets = take_rows(np.cumsum([0, *counts]), inverse.ravel())
    rows = np.repeat(np.arange(len(leaves)), np.diff(offsets))
    columns = {name: getattr(leaves, name)[rows] for name in ("node", "position", "size", "frame", "texture_map")}
    mesh = np.array(meshes, dtype=np.int32)[where]
    return Leaves(mesh=mesh, material=np.array(materials, dtype=np.int32)[where], **columns)


def _parts_of(mesh: int, members: tuple[int, ...], workspace: Workspace) -> list[tuple[int, int]]:
    """Ids of the faces of each material of a mesh, and the materials, in the order of the members."""
    whole = workspace.meshes.take(np.array([mesh]))
    slots = np.zeros(whole.num_faces, np.int32) if whole.data is None else whole.data.slots
    material = np.array(members, dtype=np.int32)[slots]
    different = [member for member in dict.fromkeys(members) if (material == member).any()]
    if len(different) == 1:
        return [(mesh, different[0])]
    faces = [np.flatnonzero(material == member) for member in different]
    parts = extract_faces(whole, np.concatenate(faces), np.array([len(of_member) for of_member in faces]))
    return list(zip(workspace.meshes.add(parts).tolist(), different, strict=True))


def _mapped(leaves: Leaves, workspace: Workspace) -> Leaves:
    """Leaves whose meshes have the coordinates that maps of the coordinates of corners make."""
    ids, table = leaves.texture_map, workspace.texture_maps
    rows = np.flatnonzero(ids != NONE)
    is_map = ids[rows] != DELETED
    source = np.full(len(rows), WORLD, dtype=np.int8)
    source[is_map] = table.source(ids[rows[is_map]])
    changed = np.flatnonzero((source != WORLD) | ~is_map)
    if len(changed) == 0:
        return leaves
    rows, source, is_map = rows[changed], source[changed], is_map[changed]
    maps = np.full((len(rows), 2, 4), np.nan)
    maps[is_map] = table.take(ids[rows[is_map]])
    first, number = distinct_rows(leaves.mesh[rows], source, maps)
    mesh, texture_map = leaves.mesh.copy(), leaves.texture_map.copy()
    mesh[rows] = _with_coordinates(leaves.mesh[rows[first]], source[first], maps[first], workspace)[number]
    texture_map[rows] = NONE
    return replace(leaves, mesh=mesh, texture_map=texture_map)


def _with_coordinates(ids: Ids, source: NDArray[np.int8], maps: Floats, workspace: Workspace) -> Ids:
    """Ids [N] of meshes with maps [N, 2, 4] of the coordinates of their corners in the sets `source` [N]."""
    meshes = workspace.meshes.take(ids)
    old = coordinates_of(meshes, source)
    data = CornerData.of_sets([old], meshes.num_faces) if meshes.data is None else meshes.data
    rows = maps[meshes.mesh_of_corner()]
    new = rows[:, :, 0] * old[:, :1] + rows[:, :, 1] * old[:, 1:] + rows[:, :, 3]
    return workspace.meshes.add(meshes.with_data(data.with_coordinates(0, new)))
