"""Instances of a tile: meshes that many shapes of all its buildings share, each drawn at once.

Every mesh and material that is used often enough becomes one node with ``EXT_mesh_gpu_instancing``, whose instances
have the ids of their models (``EXT_instance_features``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from hashlib import blake2b
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints, offsets_from_counts
from grammarlab.export.gltf_document import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, GltfDocument, index_type
from grammarlab.export.gltf_materials import GltfMaterials
from grammarlab.export.instance_placements import placements_of
from grammarlab.export.tiles.tile_mesh import merged_materials, num_materials
from grammarlab.export.tiles.tile_metadata import FEATURE_IDS, feature_ids
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.export.tiles.tile_part import TilePart, by_first_use, row_numbers
from grammarlab.scene.instances import Scene, chosen
from grammarlab.scene.shading import ShadedMeshes, shaded_meshes
from grammarlab.scene.triangles import CREASE_ANGLE, downwards

INSTANCING, INSTANCE_FEATURES = "EXT_mesh_gpu_instancing", "EXT_instance_features"
MIN_SAVED = 4096
"""Fewest bytes saved by instances that are worth a draw of their own; others are merged."""
MAX_DRAWS = 150
"""Most draws of a tile; meshes and materials that save the fewest bytes are merged."""
_SAME_REPEAT = 1e-5
"""Share of a repeat of a picture by which equal texture maps differ."""
_INSTANCE_BYTES, _VERTEX_BYTES, _TRIANGLE_BYTES = 48, 36, 6


@dataclass(frozen=True, slots=True)
class _Pairs:
    """Instances [I] by their combination of mesh and material."""

    shaded: ShadedMeshes
    """The different meshes, in the order of their first use."""
    mesh: Ints
    """[I] index into `shaded`."""
    pair: Ints
    """[I] number of the combination of mesh and material, in the order of their first use."""
    first: Ints
    """[P] the first instance of each combination."""


def add_instances(document: GltfDocument, materials: GltfMaterials, tile: TileModels) -> tuple[TilePart, Flags]:
    """Add the shapes whose meshes are used often.

    Returns:
        The part, and [I] the instances of the scene that it has not drawn.
    """
    scene = tile.scene
    pairs = _pairs(scene)
    most = max(0, MAX_DRAWS - num_materials(merged_materials(scene.materials)))
    worth = _worth(pairs, scene, most)
    rows = np.flatnonzero(worth[pairs.pair])
    if not len(rows):
        return TilePart((), 0, 0), np.ones(len(scene), dtype=bool)
    rows = rows[np.argsort(pairs.pair[rows], kind="stable")]
    first = pairs.first[worth]
    ends = offsets_from_counts(np.bincount(pairs.pair[rows])[np.flatnonzero(worth)])

    document.require(INSTANCING)
    document.use(INSTANCE_FEATURES)
    entries = [materials.index(scene.materials, material) for material in scene.material[first].tolist()]
    drawn = pairs.mesh[first]
    is_textured = np.zeros(len(pairs.shaded.mesh_vertices) - 1, dtype=bool)
    is_textured[drawn[[textured for _, textured in entries]]] = True
    primitives = _primitives(document, pairs.shaded, np.unique(drawn), is_textured)
    columns = _columns(document, tile, pairs, rows)
    nodes = []
    spans = pairwise(ends.tolist())
    for mesh, (material, _), (start, end) in zip(drawn.tolist(), entries, spans, strict=True):
        entry = {"primitives": [{**primitives[mesh], "material": material}]}
        attributes = {
            name: document.add_accessor(view, values[start:end], start) for name, (view, values) in columns.items()
        }
        features = feature_ids(columns[FEATURE_IDS][1][start:end], attribute=0)
        extensions = {INSTANCING: {"attributes": attributes}, INSTANCE_FEATURES: features}
        nodes.append(document.add("nodes", {"mesh": document.add("meshes", entry), "extensions": extensions}))
    num_triangles = int(np.diff(pairs.shaded.mesh_triangles)[pairs.mesh[rows]].sum())
    is_left = np.ones(len(scene), dtype=bool)
    is_left[rows] = False
    return TilePart(tuple(nodes), len(nodes), num_triangles), is_left


def _pairs(scene: Scene) -> _Pairs:
    """Meshes and materials by content: the tables of a scene may have equal rows."""
    first, number = by_first_use(scene.mesh)
    _, same = by_first_use(_numbers([_mesh_key(scene, mesh) for mesh in scene.mesh[first].tolist()]))
    projections, projection = _projections(scene)
    mesh_first, mesh = by_first_use(same[number] * (len(projections) + 1) + projection + 1)
    shaded = shaded_meshes(scene, scene.mesh[mesh_first], CREASE_ANGLE)
    if len(projections):
        shaded = replace(shaded, coordinates=_projected(shaded, projections, projection[mesh_first]))
    used, number = by_first_use(scene.material)
    table = scene.materials
    keys = [(table.channels[row].tobytes(), table.textures[row]) for row in scene.material[used].tolist()]
    material = _numbers(keys)[number]
    pair_first, pair = by_first_use(mesh * (int(material.max(initial=0)) + 1) + material)
    return _Pairs(shaded, mesh, pair, pair_first)


def _projections(scene: Scene) -> tuple[Floats, Ints]:
    """Texture maps from points of meshes instead of points of models: equal shapes at different places share one.

    Returns:
        [K, 2, 4] different maps, and [I] index of the map of each instance, -1 for instances without.
    """
    projection = np.full(len(scene), -1, dtype=np.int64)
    has_texture = np.array([texture != "" for texture in scene.materials.textures], dtype=bool)
    rows = np.flatnonzero(has_texture[scene.material] & (scene.texture_map >= 0))
    if scene.surface is not None or not len(rows):
        return np.zeros((0, 2, 4)), projection
    maps = scene.texture_maps[scene.texture_map[rows]]
    local = np.empty_like(maps)
    local[:, :, :3] = np.einsum("nij,njk->nik", maps[:, :, :3], scene.frames[scene.frame[rows]])
    local[:, :, :3] *= scene.size[rows][:, None]
    local[:, :, 3] = np.einsum("nij,nj->ni", maps[:, :, :3], scene.position[rows]) + maps[:, :, 3]
    # Pictures repeat, so whole repeats do not matter.
    local[:, :, 3] -= np.floor(local[:, :, 3] + _SAME_REPEAT)
    keys = np.rint(local.reshape(-1, 8) / _SAME_REPEAT).astype(np.int64)
    first, projection[rows] = by_first_use(row_numbers(keys))
    return local[first], projection


def _projected(shaded: ShadedMeshes, projections: Floats, projection: Ints) -> Floats:
    """[V, 2] u and v of the vertices of meshes [M] with maps [M], v upwards; zeros for meshes without."""
    coordinates = np.zeros((len(shaded.points), 2))
    mesh = np.repeat(projection, np.diff(shaded.mesh_vertices))
    rows = np.flatnonzero(mesh >= 0)
    maps = projections[mesh[rows]]
    coordinates[rows] = np.einsum("vij,vj->vi", maps[:, :, :3], shaded.points[rows]) + maps[:, :, 3]
    return coordinates


def _worth(pairs: _Pairs, scene: Scene, most: int) -> Flags:
    """[P] which combinations are drawn as instances: the best, up to a number."""
    uses = np.bincount(pairs.pair, minlength=len(pairs.first))
    num_vertices, num_triangles = (
        np.diff(ends)[pairs.mesh[pairs.first]] for ends in (pairs.shaded.mesh_vertices, pairs.shaded.mesh_triangles)
    )
    merged = _VERTEX_BYTES * num_vertices + _TRIANGLE_BYTES * num_triangles
    saved = uses * (merged - _INSTANCE_BYTES) - merged
    worth = saved >= MIN_SAVED
    if scene.surface is None:
        # Without a map, texture coordinates follow from the place of a shape.
        has_texture = np.array([texture != "" for texture in scene.materials.textures], dtype=bool)
        worth &= ~has_texture[scene.material[pairs.first]] | (scene.texture_map[pairs.first] >= 0)
    best = np.lexsort((-saved, ~worth))[most:]
    worth[best] = False
    return worth


def _primitives(
    document: GltfDocument, shaded: ShadedMeshes, meshes: Ints, is_textured: Flags
) -> dict[int, dict[str, Any]]:
    """Properties of the primitives of chosen meshes, which share ranges of the buffer."""
    primitives: dict[int, dict[str, Any]] = {}
    vertex_ends, triangle_ends = shaded.mesh_vertices.tolist(), shaded.mesh_triangles.tolist()
    points, normals = (column.astype(np.float32) + 0 for column in (shaded.points, shaded.normals))
    views = {"POSITION": (document.add_array(points, ARRAY_BUFFER), points)}
    views["NORMAL"] = (document.add_array(normals, ARRAY_BUFFER), normals)
    if shaded.coordinates is not None:
        coordinates = downwards(shaded.coordinates)
        views["TEXCOORD_0"] = (document.add_array(coordinates, ARRAY_BUFFER), coordinates)
    dtype = index_type(int(np.diff(shaded.mesh_vertices).max(initial=0)))
    indices = shaded.triangles.astype(dtype).ravel()
    index_view = document.add_array(indices, ELEMENT_ARRAY_BUFFER)
    for mesh in meshes.tolist():
        start, end = vertex_ends[mesh : mesh + 2]
        attributes = {}
        for name, (view, values) in views.items():
            rows = values[start:end]
            bounds = (rows.min(axis=0), rows.max(axis=0)) if name == "POSITION" else None
            if name != "TEXCOORD_0" or is_textured[mesh]:
                attributes[name] = document.add_accessor(view, rows, start, bounds)
        start, end = (3 * row for row in triangle_ends[mesh : mesh + 2])
        accessor = document.add_accessor(index_view, indices[start:end], start)
        primitives[mesh] = {"attributes": attributes, "indices": accessor}
    return primitives


def _columns(
    document: GltfDocument, tile: TileModels, pairs: _Pairs, rows: Ints
) -> dict[str, tuple[int, NDArray[np.float32]]]:
    """Attributes of the instances at these rows: their buffer view and their values."""
    scene = chosen(tile.scene, rows)
    placements = placements_of(scene, pairs.shaded, pairs.mesh[rows])
    translation = (scene.position + tile.offset[scene.model]).astype(np.float32)
    columns = {
        "TRANSLATION": translation,
        "ROTATION": placements.rotation,
        "SCALE": placements.scale,
        FEATURE_IDS: scene.model.astype(np.float32),
    }
    return {name: (document.add_array(values), values) for name, values in columns.items()}


def _mesh_key(scene: Scene, mesh: int) -> bytes:
    """Key of the content of a mesh."""
    meshes = scene.meshes
    faces = slice(*meshes.mesh_faces[mesh : mesh + 2])
    points = slice(*meshes.mesh_points[mesh : mesh + 2])
    ends = meshes.face_offsets[faces.start : faces.stop + 1]
    parts = [meshes.points[points], meshes.corners[ends[0] : ends[-1]], ends - ends[0]]
    if scene.surface is not None:
        parts += [scene.surface.normals[points], scene.surface.coordinates[points]]
    digest = blake2b(digest_size=16)
    for part in parts:
        digest.update(np.int64(part.size).tobytes() + np.ascontiguousarray(part).tobytes())
    return digest.digest()


def _numbers(keys: list[Any]) -> NDArray[np.int64]:
    """[n] number of each key among the different ones."""
    numbers: dict[Any, int] = {}
    return np.array([numbers.setdefault(key, len(numbers)) for key in keys], dtype=np.int64)
