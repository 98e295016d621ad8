"""GLB files: glTF 2.0 with its buffer inside, y up, metres, right-handed."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from grammarlab.export.files import Output
from grammarlab.export.gltf_document import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, GltfDocument
from grammarlab.export.gltf_materials import GltfMaterials
from grammarlab.export.writer import GENERATOR, AbstractWriter
from grammarlab.scene import Scene, TriangleBatch
from grammarlab.scene.texture_coordinates import texture_coordinates

Content: TypeAlias = Callable[[Scene, TriangleBatch, str], dict[str, Any]]
"""Function that adds a named model to a document and returns the properties of its node."""


@final
class GlbWriter(AbstractWriter):
    """A file with one node per model, below a common node if the origin of the file is not the world's.

    Args:
        document: the file.
        content: writer of models.
        origin: [3] origin of the file in the world, in metres; JSON stores it in 64 bits, unlike the buffer.
    """

    def __init__(self, document: GltfDocument, content: Content, origin: NDArray[np.float64]) -> None:
        self._document = document
        self._content = content
        self._origin = origin
        self._roots: list[int] = []

    def add(self, scene: Scene, batch: TriangleBatch, name: str, offset: NDArray[np.float64]) -> None:
        """See `AbstractWriter.add`."""
        node: dict[str, Any] = {"name": name, **self._content(scene, batch, name)}
        if offset.any():
            node["translation"] = offset.tolist()
        self._roots.append(self._document.add("nodes", node))

    def finish(self) -> tuple[Path, ...]:
        """See `AbstractWriter.finish`.

        Raises:
            UsageError: If the file would be too large.
        """
        if self._origin.any():
            node = {"name": "origin", "translation": self._origin.tolist(), "children": self._roots}
            self._roots = [self._document.add("nodes", node)]
        self._document.pack(self._roots, GENERATOR)
        return ()


def merged_glb(batch: TriangleBatch, name: str, assets: Path | None = None) -> bytes:
    """A file of one model relative to its own origin.

    Args:
        batch: the model.
        name: name of its node.
        assets: folder of the textures; None leaves them out.

    Raises:
        AssetError: If a texture is unusable.
    """
    with ExitStack() as parts:
        stream = BytesIO()
        document = GltfDocument(Output(stream, None, parts))
        node = {"name": name, **merged_content(document, GltfMaterials(document, assets), batch, name)}
        document.pack([document.add("nodes", node)], GENERATOR)
        return stream.getvalue()


@final
@dataclass(frozen=True, slots=True)
class MergedContent:
    """Models as one mesh each, with one primitive for each material."""

    document: GltfDocument
    materials: GltfMaterials

    def __call__(self, scene: Scene, batch: TriangleBatch, name: str) -> dict[str, Any]:
        """Add one model; the properties of its node."""
        return merged_content(self.document, self.materials, batch, name)


def merged_content(document: GltfDocument, materials: GltfMaterials, batch: TriangleBatch, name: str) -> dict[str, Any]:
    """One mesh with one primitive for each material of a model; None for a model without triangles."""
    written = [materials.index(batch.materials, material) for material in batch.group_material.tolist()]
    plain = np.array([not textured for _, textured in written], dtype=bool)
    shared = iter(_shared_primitives(document, batch if plain.all() else batch.of_groups(np.flatnonzero(plain))))
    primitives = [
        {**(_textured_primitive(document, batch, group) if textured else next(shared)), "material": index}
        for group, (index, textured) in enumerate(written)
    ]
    return {"mesh": document.add("meshes", {"name": name, "primitives": primitives})} if primitives else {}


def _shared_primitives(document: GltfDocument, batch: TriangleBatch) -> list[dict[str, Any]]:
    """[G] one primitive per group; all groups share three ranges of the buffer."""
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
