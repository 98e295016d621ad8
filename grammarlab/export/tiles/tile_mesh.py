"""Merged shapes of a tile: triangles with the colours and the models of their vertices, drawn at once."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, take_rows
from grammarlab.assets.srgb import linear_from_srgb
from grammarlab.derivation.materials import Materials
from grammarlab.export.gltf_document import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, GltfDocument, index_type
from grammarlab.export.gltf_materials import GltfMaterials
from grammarlab.export.tiles.tile_metadata import FEATURE_IDS, feature_ids
from grammarlab.export.tiles.tile_part import TilePart, by_first_use, row_numbers
from grammarlab.scene import TriangleBatch
from grammarlab.scene.triangles import downwards, texture_coordinates

MESH_FEATURES = "EXT_mesh_features"
_LARGEST = 2**16 - 1
"""Integer that stands for 1.0 in a colour; 8 bits show steps in the dark, as colours of vertices are linear."""
_STEPS = (10.0, 4.0, 2.0, 1.0)
"""Steps of opacity, roughness, metal and light of merged materials, each combination of which is a draw."""
MAX_MERGED = 40
"""Number of combinations above which steps are coarser."""


def merged_materials(table: Materials) -> Materials:
    """Materials of merged shapes: white if without texture, and with few different numbers.

    >>> from grammarlab.derivation.materials import CHANNELS
    >>> row = np.array(list(CHANNELS.values()))
    >>> merged_materials(Materials(np.stack([row, row * 0.99]), ("", ""))).channels.round(1).tolist()[1]
    [1.0, 1.0, 1.0, 1.0, 0.0, 0.8, 0.0, 0.0, 0.0]
    """
    plain = np.array([texture == "" for texture in table.textures], dtype=bool)
    channels = table.channels.copy()
    for steps in _STEPS:
        channels[plain] = np.rint(table.channels[plain] * steps) / steps
        channels[plain, :3] = 1.0
        if len(np.unique(channels[plain], axis=0)) <= MAX_MERGED:
            break
    return replace(table, channels=channels)


def num_materials(table: Materials) -> int:
    """Number of different materials in a table."""
    return len({(row.tobytes(), name) for row, name in zip(table.channels, table.textures, strict=True)})


def add_mesh(document: GltfDocument, materials: GltfMaterials, batch: TriangleBatch, offset: Floats) -> TilePart:
    """Add the triangles of B models as one mesh, with a primitive for each material.

    Materials without texture whose other numbers are about equal share a primitive, with colours of its vertices.

    Args:
        document: the document.
        materials: materials of the document.
        batch: the triangles.
        offset: [B, 3] origin of each model in the tile.

    Raises:
        AssetError: If a texture is unusable.
    """
    if not len(batch.triangles):
        return TilePart((), 0, 0)
    document.use(MESH_FEATURES)
    table = merged_materials(batch.materials)
    entries = [materials.index(table, material) for material in batch.group_material.tolist()]
    index = np.array([entry for entry, _ in entries])
    textured = np.array([needs_coordinates for _, needs_coordinates in entries])
    primitives = []
    for material in sorted(set(index.tolist())):
        groups = np.flatnonzero(index == material)
        primitives.append(_primitive(document, batch, groups, offset, textured=bool(textured[groups[0]])))
        primitives[-1]["material"] = material
    node = document.add("nodes", {"mesh": document.add("meshes", {"primitives": primitives})})
    return TilePart((node,), len(primitives), len(batch.triangles))


def _primitive(
    document: GltfDocument, batch: TriangleBatch, groups: Ints, offset: Floats, *, textured: bool
) -> dict[str, Any]:
    """A primitive of the triangles of groups [K] of a batch."""
    vertex, ends = take_rows(batch.group_vertices, groups)
    triangle, triangle_ends = take_rows(batch.group_triangles, groups)
    counts = np.diff(ends)
    moves = np.repeat(ends[:-1] - batch.group_vertices[groups], np.diff(triangle_ends))
    corners = batch.triangles[triangle].astype(np.int64) + moves[:, None]
    rows = np.arange(len(vertex))
    coordinates = None
    if textured and batch.coordinates is not None:
        coordinates = downwards(batch.coordinates[vertex])
    elif textured:
        # Each triangle has its own texture coordinates.
        coordinates = np.concatenate(
            [texture_coordinates(batch, slice(*batch.group_triangles[group : group + 2])) for group in groups.tolist()]
        ).reshape(-1, 2)
        keys = np.column_stack((corners.ravel(), coordinates.view(np.int32).astype(np.int64)))
        first, number = by_first_use(row_numbers(keys))
        rows, coordinates, corners = corners.ravel()[first], coordinates[first], number.reshape(-1, 3)
    model, material = batch.group_model[groups].repeat(counts)[rows], batch.group_material[groups].repeat(counts)[rows]
    columns: dict[str, NDArray[Any]] = {
        "POSITION": (batch.vertices[vertex[rows]] + offset[model]).astype(np.float32),
        "NORMAL": batch.normals[vertex[rows]],
    }
    if coordinates is not None:
        columns["TEXCOORD_0"] = coordinates
    else:
        columns["COLOR_0"] = _vertex_colors(batch)[material]
    columns[FEATURE_IDS] = model.astype(np.float32)
    attributes = {name: _accessor(document, name, values) for name, values in columns.items()}
    indices = corners.astype(index_type(len(rows))).ravel()
    view = document.add_array(indices, ELEMENT_ARRAY_BUFFER)
    return {
        "attributes": attributes,
        "indices": document.add_accessor(view, indices, 0),
        "extensions": {MESH_FEATURES: feature_ids(columns[FEATURE_IDS], attribute=0)},
    }


def _accessor(document: GltfDocument, name: str, values: NDArray[Any]) -> int:
    bounds = (values.min(axis=0), values.max(axis=0)) if name == "POSITION" else None
    rows = values.reshape(len(values), -1)
    view = document.add_array(rows, ARRAY_BUFFER)
    return document.add_accessor(view, values, 0, bounds, normalized=name == "COLOR_0")


def _vertex_colors(batch: TriangleBatch) -> NDArray[np.uint16]:
    """[K, 4] linear colours of the materials of a batch; opacity is that of the material."""
    colors = np.full((len(batch.materials), 4), _LARGEST, dtype=np.uint16)
    colors[:, :3] = np.rint(_LARGEST * linear_from_srgb(batch.materials.color))
    return colors
