"""GLB files: glTF 2.0 with its buffer inside, y up, metres, right-handed.

A model is one mesh, or many nodes that refer to meshes which the file stores once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from hashlib import blake2b
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts
from grammarlab.asset_roots import AssetRoot
from grammarlab.derivation.materials import Materials
from grammarlab.export.gltf_document import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, GltfDocument, index_type
from grammarlab.export.gltf_materials import GltfMaterials
from grammarlab.export.instance_placements import Placements, placements_of
from grammarlab.export.model_files import GENERATOR, AbstractWriter, Output
from grammarlab.export.names import ShapeNames, groups_by_name, model_values, shape_names
from grammarlab.scene import Scene, TriangleBatch
from grammarlab.scene.instances import chosen
from grammarlab.scene.shading import ShadedMeshes, shaded_meshes
from grammarlab.scene.triangles import CREASE_ANGLE, downwards, texture_coordinates

Content: TypeAlias = Callable[[Scene, TriangleBatch, str], dict[str, Any]]
"""Function that adds a named model to a document and returns the properties of its node."""
_INSTANCING = "EXT_mesh_gpu_instancing"


@final
class GlbWriter(AbstractWriter):
    """A file with one node per model, below a common node if the origin of the file is not the world's.

    Args:
        document: the file.
        content: writer of models.
        origin: [3] origin of the file in the world, in metres; JSON stores it in 64 bits, unlike the buffer.
        in_world: whether the common node moves the models to their place in the world; otherwise its extras name it.
    """

    def __init__(
        self, document: GltfDocument, content: Content, origin: NDArray[np.float64], *, in_world: bool = True
    ) -> None:
        self._in_world = in_world
        self._document = document
        self._content = content
        self._origin = origin
        self._roots: list[int] = []

    def add(self, scene: Scene, batch: TriangleBatch, name: str, offset: NDArray[np.float64]) -> None:
        """See `AbstractWriter.add`."""
        node: dict[str, Any] = {"name": name, **self._content(scene, batch, name)}
        if offset.any():
            node["translation"] = offset.tolist()
        if values := model_values(scene):
            node["extras"] = values
        self._roots.append(self._document.add("nodes", node))

    def finish(self) -> tuple[Path, ...]:
        """See `AbstractWriter.finish`.

        Raises:
            UsageError: If the file would be too large.
        """
        if self._origin.any():
            place = self._origin.tolist()
            node: dict[str, Any] = {"name": "origin", "children": self._roots}
            node |= {"translation": place} if self._in_world else {"extras": {"origin": place}}
            self._roots = [self._document.add("nodes", node)]
        self._document.pack(self._roots, GENERATOR)
        return ()


@final
@dataclass(frozen=True, slots=True)
class MergedContent:
    """Models as one mesh for each symbol, with a primitive for each of its materials; one mesh without symbols."""

    document: GltfDocument
    materials: GltfMaterials

    def __call__(self, scene: Scene, batch: TriangleBatch, name: str) -> dict[str, Any]:
        """Add one model; the properties of its node."""
        names = shape_names(scene)
        if names is None:
            return _merged_content(self.document, self.materials, batch, name)
        return _children(self.document, _named_nodes(self.document, self.materials, batch, names))


@final
class ReusedContent:
    """Models as nodes that refer to one mesh for each combination of mesh and material in the file.

    Textured shapes whose texture coordinates depend on their size and place do not share meshes. Those of one model are
    merged into one mesh.

    Args:
        document: the file.
        materials: materials of the document.
        instancing: write all places of a mesh as one node with ``EXT_mesh_gpu_instancing``, which the file then
            requires; otherwise write a node for each.
    """

    def __init__(self, document: GltfDocument, materials: GltfMaterials, *, instancing: bool) -> None:
        self._document = document
        self._materials = materials
        self._instancing = instancing
        self._meshes = _ReusedMeshes(document, materials)

    def __call__(self, scene: Scene, batch: TriangleBatch, name: str) -> dict[str, Any]:
        """Add one model; the properties of its node.

        Raises:
            AssetError: If a texture is unusable.
        """
        textured = np.zeros(len(scene.materials), dtype=bool)
        for material in batch.group_material.tolist():
            textured[material] = self._materials.index(scene.materials, material)[1] and scene.surface is None
        merged = batch.of_groups(np.flatnonzero(textured[batch.group_material]))
        names = shape_names(scene)
        if names is None:
            content = _merged_content(self._document, self._materials, merged, f"{name}_textured")
            children = [self._document.add("nodes", content)] if content else []
        else:
            children = _named_nodes(self._document, self._materials, merged, names)
        scene = chosen(scene, ~textured[scene.material])

        used, mesh = np.unique(scene.mesh, return_inverse=True)
        shaded = shaded_meshes(scene, used, CREASE_ANGLE)
        placements = placements_of(scene, shaded, mesh)
        rows = np.flatnonzero(np.diff(shaded.mesh_triangles)[mesh] > 0)
        symbol = np.zeros(len(scene), np.int32) if scene.labels is None else scene.labels.symbol
        for (index, material, kind), instance_rows in _by_kind(mesh, scene.material, symbol, rows):
            label = (
                None if names is None else (names.name(kind, scene.materials, material), names.extras(kind, material))
            )
            number = self._meshes.index(shaded, index, scene.materials, material, "" if label is None else label[0])
            described = {} if label is None else {"name": label[0], "extras": label[1]}
            children += (
                self._instanced({"mesh": number, **described}, placements, instance_rows)
                if self._instancing
                else self._nodes({"mesh": number, **described}, placements, instance_rows)
            )
        return {"children": children} if children else {}

    def _nodes(self, node: dict[str, Any], placements: Placements, instance_rows: NDArray[np.int64]) -> list[int]:
        columns = (placements.translation, placements.rotation, placements.scale)
        rows = zip(*(_short(column[instance_rows]) for column in columns), strict=True)
        return [
            self._document.add("nodes", {**node, "translation": translation, "rotation": rotation, "scale": scale})
            for translation, rotation, scale in rows
        ]

    def _instanced(self, node: dict[str, Any], placements: Placements, instance_rows: NDArray[np.int64]) -> list[int]:
        document = self._document
        document.require(_INSTANCING)
        attributes = {}
        columns = {"TRANSLATION": placements.translation, "ROTATION": placements.rotation, "SCALE": placements.scale}
        for name, values in columns.items():
            chosen = values[instance_rows]
            attributes[name] = document.add_accessor(document.add_array(chosen), chosen, 0)
        return [document.add("nodes", {**node, "extensions": {_INSTANCING: {"attributes": attributes}}})]


def merged_glb(batch: TriangleBatch, name: str, assets: AssetRoot | None = None) -> bytes:
    """A file of one model relative to its own origin.

    Args:
        batch: the model.
        name: name of its node.
        assets: folder of the textures; None leaves them out.

    Raises:
        AssetError: If a texture is unusable.
    """
    batch = batch.by_material()
    with ExitStack() as parts:
        stream = BytesIO()
        document = GltfDocument(Output(stream, None, parts))
        node = {"name": name, **_merged_content(document, GltfMaterials(document, assets), batch, name)}
        document.pack([document.add("nodes", node)], GENERATOR)
        return stream.getvalue()


def _merged_content(
    document: GltfDocument, materials: GltfMaterials, batch: TriangleBatch, name: str
) -> dict[str, Any]:
    """Properties of the node of a model: a mesh with one primitive for each material; none for no triangles."""
    primitives = _primitives(document, materials, batch)
    return {"mesh": document.add("meshes", {"name": name, "primitives": primitives})} if primitives else {}


def _named_nodes(
    document: GltfDocument, materials: GltfMaterials, batch: TriangleBatch, names: ShapeNames
) -> list[int]:
    """Nodes of a model, one for each of its symbols and materials, which share ranges of the buffer."""
    primitives = _primitives(document, materials, batch)
    nodes = []
    for symbol, material, group in groups_by_name(batch, names):
        name = names.name(symbol, batch.materials, material)
        mesh = document.add("meshes", {"name": name, "primitives": [primitives[group]]})
        nodes.append(document.add("nodes", {"name": name, "mesh": mesh, "extras": names.extras(symbol, material)}))
    return nodes


def _children(document: GltfDocument, nodes: list[int]) -> dict[str, Any]:
    return {"children": nodes} if nodes else {}


def _primitives(document: GltfDocument, materials: GltfMaterials, batch: TriangleBatch) -> list[dict[str, Any]]:
    """[G] a primitive for each group of a model."""
    written = [materials.index(batch.materials, material) for material in batch.group_material.tolist()]
    textured = np.array([needs_coordinates for _, needs_coordinates in written], dtype=bool)
    separate = textured & (batch.coordinates is None)
    rest = np.flatnonzero(~separate)
    shared = iter(_shared_primitives(document, batch.of_groups(rest) if separate.any() else batch, textured[rest]))
    return [
        {**(_textured_primitive(document, batch, group) if separate[group] else next(shared)), "material": index}
        for group, (index, _) in enumerate(written)
    ]


def _shared_primitives(
    document: GltfDocument, batch: TriangleBatch, textured: NDArray[np.bool_]
) -> list[dict[str, Any]]:
    """[G] one primitive per group; all groups share three or four ranges of the buffer.

    Args:
        document: the file.
        batch: the triangles.
        textured: [G] whether a group needs the texture coordinates of its vertices.
    """
    if len(batch.group_model) == 0:
        return []
    low = np.minimum.reduceat(batch.vertices, batch.group_vertices[:-1], axis=0)
    high = np.maximum.reduceat(batch.vertices, batch.group_vertices[:-1], axis=0)
    indices = _group_indices(batch)
    positions_view = document.add_array(batch.vertices, ARRAY_BUFFER)
    normals_view = document.add_array(batch.normals, ARRAY_BUFFER)
    coordinates = downwards(batch.coordinates) if batch.coordinates is not None and textured.any() else None
    coordinates_view = None if coordinates is None else document.add_array(coordinates, ARRAY_BUFFER)
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
        if coordinates is not None and coordinates_view is not None and textured[group]:
            attributes["TEXCOORD_0"] = document.add_accessor(coordinates_view, coordinates[start:end], start)
        start, end = index_ends[group : group + 2]
        accessor = document.add_accessor(indices_view, indices[start:end], start)
        primitives.append({"attributes": attributes, "indices": accessor})
    return primitives


def _group_indices(batch: TriangleBatch) -> NDArray[np.unsignedinteger]:
    """[3 T] vertices counted from the first of their own group, in the narrowest type that holds them."""
    starts = np.repeat(batch.group_vertices[:-1], np.diff(batch.group_triangles)).astype(np.uint32)
    largest = int(np.diff(batch.group_vertices).max())
    return (batch.triangles - starts[:, None]).astype(index_type(largest)).ravel()


def _add_array(
    document: GltfDocument, values: np.ndarray, target: int, bounds: tuple[np.ndarray, np.ndarray] | None = None
) -> int:
    """Index of an accessor of all rows of an array that the document stores."""
    return document.add_accessor(document.add_array(values, target), values, 0, bounds)


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
        attributes[name] = _add_array(document, values, ARRAY_BUFFER, bounds)
    return {"attributes": attributes}


class _ReusedMeshes:
    """Meshes of one document, each written when it is first used; equal ones are written once."""

    def __init__(self, document: GltfDocument, materials: GltfMaterials) -> None:
        self._document = document
        self._materials = materials
        self._written: dict[tuple[int, int, str], int] = {}
        self._geometry: dict[bytes, tuple[int, dict[str, Any]]] = {}

    def index(self, shaded: ShadedMeshes, mesh: int, table: Materials, material: int, name: str) -> int:
        """Index in the document of a mesh with a material of a table, under a name; empty for a number."""
        material_index, textured = self._materials.index(table, material)
        number, geometry = self._geometry_of(shaded, mesh, textured=textured)
        key = number, material_index, name
        if key not in self._written:
            entry = {
                "name": name or f"mesh_{number}_{material_index}",
                "primitives": [{**geometry, "material": material_index}],
            }
            self._written[key] = self._document.add("meshes", entry)
        return self._written[key]

    def _geometry_of(self, shaded: ShadedMeshes, mesh: int, *, textured: bool) -> tuple[int, dict[str, Any]]:
        """The number of a geometry, and the properties of its primitives."""
        vertices = slice(*shaded.mesh_vertices[mesh : mesh + 2])
        corners = shaded.triangles[slice(*shaded.mesh_triangles[mesh : mesh + 2])]
        points, normals = (column[vertices].astype(np.float32) + 0 for column in (shaded.points, shaded.normals))
        coordinates = None
        if textured and shaded.coordinates is not None:
            coordinates = downwards(shaded.coordinates[vertices])
        parts = [part for part in (points, normals, corners, coordinates) if part is not None]
        key = blake2b(b"".join(part.tobytes() for part in parts), digest_size=16).digest()
        if key not in self._geometry:
            attributes = {
                "POSITION": _add_array(self._document, points, ARRAY_BUFFER, (points.min(axis=0), points.max(axis=0))),
                "NORMAL": _add_array(self._document, normals, ARRAY_BUFFER),
            }
            if coordinates is not None:
                attributes["TEXCOORD_0"] = _add_array(self._document, coordinates, ARRAY_BUFFER)
            indices = corners.astype(index_type(len(points))).ravel()
            accessor = _add_array(self._document, indices, ELEMENT_ARRAY_BUFFER)
            self._geometry[key] = len(self._geometry), {"attributes": attributes, "indices": accessor}
        return self._geometry[key]


def _short(values: NDArray[np.float32]) -> list[list[float]]:
    """Rows of 32-bit numbers with as few digits as tell them apart, since JSON is text."""
    return values.astype(np.str_).astype(np.float64).tolist()


def _by_kind(
    mesh: NDArray[np.integer], material: NDArray[np.integer], symbol: NDArray[np.integer], rows: NDArray[np.int64]
) -> Iterator[tuple[tuple[int, int, int], NDArray[np.int64]]]:
    """Rows of each combination of mesh, material and symbol, in the order of their first occurrence."""
    columns = np.stack([mesh[rows], material[rows], symbol[rows]], axis=1)
    kinds, first, kind_of_row = np.unique(columns, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(first)
    rank[order] = np.arange(len(first))
    kind_of_row = rank[kind_of_row.ravel()]
    rows = rows[np.argsort(kind_of_row, kind="stable")]
    ends = offsets_from_counts(np.bincount(kind_of_row, minlength=len(first))).tolist()
    for (index, kind, number), (start, end) in zip(kinds[order].tolist(), pairwise(ends), strict=True):
        yield (index, kind, number), rows[start:end]
