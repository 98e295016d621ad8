"""``insertAlongUV``: an asset repeated and bent along the texture coordinates of a shape."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import BoundCall, Operation
from grammarlab.derivation.calls.texture_transfer import without_maps
from grammarlab.derivation.functions.shape_measures import alike_meshes
from grammarlab.derivation.functions.shape_textures import uv_set_of
from grammarlab.derivation.operations.insertion import asset_mesh, painted
from grammarlab.derivation.state.corner_maps import coordinates_of, own_maps
from grammarlab.derivation.state.mesh_table import replaced, upright
from grammarlab.derivation.state.shapes import Ids, Shapes
from grammarlab.derivation.state.texture_maps import WORLD
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.uv_bending import bent, num_tiles, patches

_WORDS = frozenset({"scope.y", "vertex.normal", "alignPosition", "keepPosition"})
MOST_FACES = 500_000
"""Largest number of faces that one operation may make before they are cut: a budget."""


def insert_along_uv(call: BoundCall) -> Shapes:
    """``insertAlongUV(set, path, height, scope.y|vertex.normal, alignPosition|keepPosition)``.

    The asset's x follows u and its z runs against v, once in each unit; its height becomes that in metres. Faces of
    more than four corners, or without coordinates, are left out; a shape of such faces alone does not change.
    """
    if len(call.values) != 3:
        raise call.error("insertAlongUV expects a uv set, the path of a mesh and a height in metres")
    uv_set = uv_set_of(call.values[0].value, call.name, call.location)
    text = call.text(call.values[1])
    if isinstance(text, str):
        return _inserted(call, uv_set, text)
    shapes = call.shapes
    columns = {name: getattr(shapes, name).copy() for name in ("mesh", "size", "position", "material")}
    for code in np.unique(text).tolist():
        rows = np.flatnonzero(text == code)
        part = _inserted(call.rows(rows), uv_set, call.workspace.strings[code])
        for name, column in columns.items():
            column[rows] = getattr(part, name)
    return without_maps(shapes._replace(**columns), call.workspace)


def _inserted(call: BoundCall, uv_set: int, path: str) -> Shapes:
    """Shapes with one asset along their coordinates."""
    workspace = call.workspace
    shapes = upright(call.shapes, workspace.meshes, workspace.frames)
    mesh, size, low = asset_mesh(call, path)
    unit = workspace.meshes.take(np.array([mesh]))
    if "keepPosition" in call.words and size[1] > 0.0:
        unit = unit.with_points(unit.points + np.array([0.0, low[1] / size[1], 0.0]))
    if unit.data is not None:
        unit = unit.with_data(unit.data.without_normals())
    heights = call.column(call.values[2])
    ids = own_maps(shapes, uv_set, workspace)
    rows, source = _local_maps(shapes, ids, call)
    meshes, first, number = alike_meshes(shapes, workspace, rows.reshape(-1, 8), source, heights)
    surface = patches(meshes, _coordinates(meshes, rows[first], source[first]), "vertex.normal" in call.words)
    made = num_tiles(surface).sum() * max(unit.num_faces, 1)
    if made > MOST_FACES:
        hint = "scale the texture coordinates so that the mesh is repeated less often"
        raise call.error(f"insertAlongUV would make {made:,.0f} faces: expected at most {MOST_FACES:,}", hint)
    results = bent(unit, surface, heights[first][surface.owner], len(meshes))
    is_mapped = np.bincount(surface.owner, minlength=len(meshes)) > 0
    chosen = np.flatnonzero(is_mapped[number])
    if len(chosen) == 0:
        return shapes
    inserted = painted(call, shapes.take(chosen), path)
    after = replaced(inserted, results, number[chosen], workspace.meshes, workspace.frames)
    columns = {name: getattr(shapes, name).copy() for name in ("mesh", "size", "position", "material")}
    for name, column in columns.items():
        column[chosen] = getattr(after, name)
    return without_maps(shapes._replace(**columns), workspace)


def _local_maps(shapes: Shapes, ids: Ids, call: BoundCall) -> tuple[Floats, NDArray[np.int8]]:
    """[N, 2, 4] maps to u and v from points in scope axes, or from corners of meshes; and their sources [N]."""
    workspace = call.workspace
    rows, source = np.full((shapes.num, 2, 4), np.nan), np.full(shapes.num, WORLD, np.int8)
    known = np.flatnonzero(ids >= 0)
    if len(known) == 0:
        return rows, source
    maps = workspace.texture_maps.take(ids[known]).copy()
    source[known] = workspace.texture_maps.source(ids[known])
    of_world = source[known] == WORLD
    for axis in range(2):
        gradient = maps[of_world, axis, :3]
        place = shapes.take(known[of_world])
        maps[of_world, axis, 3] += np.einsum("ni,ni->n", gradient, place.position)
        maps[of_world, axis, :3] = workspace.frames.to_local(place.frame, gradient)
    rows[known] = maps
    return rows, source


def _coordinates(meshes: Meshes, rows: Floats, source: NDArray[np.int8]) -> Floats:
    """[C, 2] u and v at the corners of meshes [M] by maps [M, 2, 4]."""
    mesh = meshes.mesh_of_corner()
    points = meshes.points[meshes.corner_points()]
    if (source != WORLD).any():
        own = (source != WORLD)[mesh]
        points = np.where(own[:, None], 0.0, points)
        points[own, :2] = coordinates_of(meshes, source)[own]
    return np.einsum("cij,cj->ci", rows[mesh][:, :, :3], points) + rows[mesh][:, :, 3]


OPERATIONS: dict[str, Operation] = {"insertAlongUV": Operation(insert_along_uv, _WORDS, (3, 5))}
