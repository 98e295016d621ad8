"""GLB files: glTF 2.0 with its buffer inside, y up, metres, right-handed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.export.gltf_document import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, GltfDocument
from grammarlab.export.gltf_materials import GltfMaterials
from grammarlab.scene import TriangleBatch
from grammarlab.scene.texture_coordinates import texture_coordinates

GENERATOR = "grammarlab"


def merged_glb(
    batch: TriangleBatch, names: list[str], offsets: NDArray[np.float64], assets: Path | None = None
) -> bytes:
    """A file with one node a model and one primitive a material.

    Args:
        batch: the models.
        names: [num_models] names of the nodes.
        offsets: [num_models, 3] where each model stands, in metres.
        assets: folder of the textures; None leaves them out.

    Raises:
        AssetError: a texture is unusable.
    """
    document = GltfDocument()
    meshes = model_meshes(document, batch, names, GltfMaterials(document, batch.materials, assets))
    roots = []
    for model, name in enumerate(names):
        node: dict[str, Any] = {"name": name}
        if model in meshes:
            node["mesh"] = meshes[model]
        if offsets[model].any():
            node["translation"] = offsets[model].tolist()
        roots.append(document.add("nodes", node))
    return document.pack(roots, GENERATOR)


def model_meshes(
    document: GltfDocument, batch: TriangleBatch, names: list[str], materials: GltfMaterials
) -> dict[int, int]:
    """The mesh in the document of each model that has triangles, with one primitive a material."""
    written = [materials.index(material) for material in batch.group_material.tolist()]
    plain = np.array([not textured for _, textured in written], dtype=bool)
    shared = iter(_shared_primitives(document, batch if plain.all() else batch.of_groups(np.flatnonzero(plain))))
    primitives = [
        {**(_textured_primitive(document, batch, group) if textured else next(shared)), "material": index}
        for group, (index, textured) in enumerate(written)
    ]
    ends = batch.model_groups.tolist()
    return {
        model: document.add("meshes", {"name": name, "primitives": primitives[ends[model] : ends[model + 1]]})
        for model, name in enumerate(names)
        if ends[model] < ends[model + 1]
    }


def _shared_primitives(document: GltfDocument, batch: TriangleBatch) -> list[dict[str, Any]]:
    """[G] one primitive a group; all groups share three stretches of the buffer."""
    if len(batch.group_model) == 0:
        return []
    low = np.minimum.reduceat(batch.vertices, batch.group_vertices[:-1], axis=0)
    high = np.maximum.reduceat(batch.vertices, batch.group_vertices[:-1], axis=0)
    indices = group_indices(batch)
    positions_view = document.add_array(batch.vertices, ARRAY_BUFFER)
    normals_view = document.add_array(batch.normals, ARRAY_BUFFER)
    indices_view = document.add_array(indices, ELEMENT_ARRAY_BUFFER)
    primitives = []
    vertex_ends, index_ends = batch.group_vertices.tolist(), (3 * batch.group_triangles).tolist()
    for group in range(len(batch.group_model)):
        start, end = vertex_ends[group : group + 2]
        bounds = low[group], high[group]
        attributes = {
            "POSITION": document.add_accessor(positions_view, batch.vertices[start:end], start, bounds),
            "NORMAL": document.add_accessor(normals_view, batch.normals[start:end], start),
        }
        start, end = index_ends[group : group + 2]
        accessor = document.add_accessor(indices_view, indices[start:end], start)
        primitives.append({"attributes": attributes, "indices": accessor})
    return primitives


def group_indices(batch: TriangleBatch) -> NDArray[np.unsignedinteger]:
    """[3 T] vertices counted from the first of their own group, in the narrowest type that holds them."""
    starts = np.repeat(batch.group_vertices[:-1], np.diff(batch.group_triangles)).astype(np.uint32)
    largest = int(np.diff(batch.group_vertices).max())
    dtype = np.uint16 if largest < 2**16 - 1 else np.uint32
    return (batch.triangles - starts[:, None]).astype(dtype).ravel()


def _textured_primitive(document: GltfDocument, batch: TriangleBatch, group: int) -> dict[str, Any]:
    """A primitive whose triangles share no vertices, so that each can have its own texture coordinates."""
    triangles = slice(*batch.group_triangles[group : group + 2])
    rows = batch.triangles[triangles]
    columns = {
        "POSITION": batch.vertices[rows].reshape(-1, 3),
        "NORMAL": batch.normals[rows].reshape(-1, 3),
        "TEXCOORD_0": texture_coordinates(batch, triangles).reshape(-1, 2),
    }
    attributes = {}
    for name, values in columns.items():
        bounds = (values.min(axis=0), values.max(axis=0)) if name == "POSITION" else None
        attributes[name] = document.add_accessor(document.add_array(values, ARRAY_BUFFER), values, 0, bounds)
    return {"attributes": attributes}
