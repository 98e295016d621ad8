"""GLB files that keep each mesh once and refer to it from many places."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts, row_of_value
from grammarlab.export.glb import GENERATOR, model_meshes
from grammarlab.export.gltf_document import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, GltfDocument
from grammarlab.export.gltf_materials import GltfMaterials
from grammarlab.scene import Scene, triangles
from grammarlab.scene.instances import chosen
from grammarlab.scene.shading import ShadedMeshes, shade
from grammarlab.scene.triangles import CREASE_ANGLE

INSTANCING = "EXT_mesh_gpu_instancing"
THINNEST = 1e-6
"""Smallest scale of a node in metres: at zero, readers cannot work out normals."""


@dataclass(frozen=True, slots=True)
class Placements:
    """Translation, rotation and scale of I instances, as glTF nodes hold them."""

    translation: NDArray[np.float32]
    """[I, 3] metres."""
    rotation: NDArray[np.float32]
    """[I, 4] unit quaternions x, y, z, w."""
    scale: NDArray[np.float32]
    """[I, 3] > 0."""


def reused_glb(
    scene: Scene, names: list[str], offsets: NDArray[np.float64], assets: Path | None = None, instancing: bool = False
) -> bytes:
    """A file with one mesh for each combination of mesh and material in use.

    Textured shapes share nothing: their texture coordinates differ with the size and the place of each shape. Those of
    one model are merged into one mesh.

    Args:
        scene: the models.
        names: [num_models] names of the nodes above each model.
        offsets: [num_models, 3] where each model stands, in metres.
        assets: folder of the textures; None leaves them out.
        instancing: write all places of a mesh as one node with ``EXT_mesh_gpu_instancing``, which the file then
            requires; otherwise write a node for each.

    Raises:
        AssetError: a texture is unusable.
    """
    document = GltfDocument()
    materials = GltfMaterials(document, scene.materials, assets)
    textured = np.zeros(len(scene.materials), dtype=bool)
    for material in np.unique(scene.material).tolist():
        textured[material] = materials.index(material)[1]
    merged = triangles(chosen(scene, textured[scene.material]))
    merged_meshes = model_meshes(document, merged, [f"{name}_textured" for name in names], materials)
    scene = chosen(scene, ~textured[scene.material])

    used, mesh = np.unique(scene.mesh, return_inverse=True)
    shaded = shade(scene.meshes.take(used), CREASE_ANGLE)
    solid = np.diff(shaded.mesh_triangles)[mesh] > 0
    mesh_of_pair = _ReusedMeshes(document, shaded, materials)
    placements = _placements(scene, shaded, mesh)
    if instancing and solid.any():
        document.require(INSTANCING)
    roots = []
    ends = np.searchsorted(scene.model, np.arange(scene.num_models + 1))
    for model, name in enumerate(names):
        rows = np.arange(ends[model], ends[model + 1])
        rows = rows[solid[rows]]
        children = [document.add("nodes", {"mesh": merged_meshes[model]})] if model in merged_meshes else []
        for pair, places in _by_pair(mesh, scene.material, rows):
            index = mesh_of_pair.index(*pair)
            add = _instanced_node if instancing else _nodes
            children += add(document, index, placements, places)
        node: dict[str, Any] = {"name": name}
        if children:
            node["children"] = children
        if offsets[model].any():
            node["translation"] = offsets[model].tolist()
        roots.append(document.add("nodes", node))
    return document.pack(roots, GENERATOR)


def _by_pair(
    mesh: NDArray[np.integer], material: NDArray[np.integer], rows: NDArray[np.int64]
) -> Iterator[tuple[tuple[int, int], NDArray[np.int64]]]:
    """The rows of each combination of mesh and material."""
    pairs, pair_of_row = np.unique(np.stack([mesh[rows], material[rows]], axis=1), axis=0, return_inverse=True)
    rows = rows[np.argsort(pair_of_row.ravel(), kind="stable")]
    ends = offsets_from_counts(np.bincount(pair_of_row.ravel(), minlength=len(pairs))).tolist()
    for index, (mesh_index, material_index) in enumerate(pairs.tolist()):
        yield (mesh_index, material_index), rows[ends[index] : ends[index + 1]]


def _placements(scene: Scene, shaded: ShadedMeshes, mesh: NDArray[np.integer]) -> Placements:
    # Imported here since the usual files do without it.
    from scipy.spatial.transform import Rotation  # noqa: PLC0415

    extends = np.zeros((len(shaded.mesh_triangles) - 1, 3), dtype=bool)
    np.logical_or.at(extends, row_of_value(np.diff(shaded.mesh_vertices)), shaded.points != 0)
    # A mesh that lies in the plane 0 of an axis is the same at any size along it.
    scale = np.where(~extends[mesh] & (scene.size < THINNEST), 1.0, np.maximum(scene.size, THINNEST))
    quaternion = Rotation.from_matrix(scene.frames).as_quat() if len(scene.frames) else np.zeros((0, 4))
    turned = quaternion.astype(np.float32)[scene.frame]
    return Placements(scene.position.astype(np.float32), turned, scale.astype(np.float32))


def _nodes(document: GltfDocument, mesh: int, placements: Placements, places: NDArray[np.int64]) -> list[int]:
    columns = (placements.translation, placements.rotation, placements.scale)
    rows = zip(*(column[places].tolist() for column in columns), strict=True)
    return [
        document.add("nodes", {"mesh": mesh, "translation": translation, "rotation": rotation, "scale": scale})
        for translation, rotation, scale in rows
    ]


def _instanced_node(document: GltfDocument, mesh: int, placements: Placements, places: NDArray[np.int64]) -> list[int]:
    attributes = {}
    columns = {"TRANSLATION": placements.translation, "ROTATION": placements.rotation, "SCALE": placements.scale}
    for name, values in columns.items():
        chosen = values[places]
        attributes[name] = document.add_accessor(document.add_array(chosen), chosen, 0)
    return [document.add("nodes", {"mesh": mesh, "extensions": {INSTANCING: {"attributes": attributes}}})]


class _ReusedMeshes:
    """The meshes of one document, each geometry written when it is first asked for."""

    def __init__(self, document: GltfDocument, shaded: ShadedMeshes, materials: GltfMaterials) -> None:
        self._document = document
        self._shaded = shaded
        self._materials = materials
        self._written: dict[tuple[int, int], int] = {}
        self._geometry: dict[int, dict[str, Any]] = {}

    def index(self, mesh: int, material: int) -> int:
        """The index in the document of a mesh in a material."""
        if (mesh, material) not in self._written:
            material_index, _ = self._materials.index(material)
            if mesh not in self._geometry:
                self._geometry[mesh] = self._write(mesh)
            primitive = {**self._geometry[mesh], "material": material_index}
            entry = {"name": f"mesh_{mesh}_{material}", "primitives": [primitive]}
            self._written[mesh, material] = self._document.add("meshes", entry)
        return self._written[mesh, material]

    def _write(self, mesh: int) -> dict[str, Any]:
        shaded = self._shaded
        vertices = slice(*shaded.mesh_vertices[mesh : mesh + 2])
        corners = shaded.triangles[slice(*shaded.mesh_triangles[mesh : mesh + 2])]
        points, normals = shaded.points[vertices].astype(np.float32), shaded.normals[vertices].astype(np.float32)
        attributes = {
            "POSITION": self._accessor(points, ARRAY_BUFFER, (points.min(axis=0), points.max(axis=0))),
            "NORMAL": self._accessor(normals, ARRAY_BUFFER),
        }
        indices = corners.astype(np.uint16 if len(points) < 2**16 - 1 else np.uint32).ravel()
        return {"attributes": attributes, "indices": self._accessor(indices, ELEMENT_ARRAY_BUFFER)}

    def _accessor(self, values: np.ndarray, target: int, bounds: tuple[np.ndarray, np.ndarray] | None = None) -> int:
        return self._document.add_accessor(self._document.add_array(values, target), values, 0, bounds)
