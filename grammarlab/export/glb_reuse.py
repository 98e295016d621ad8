"""GLB files that store each mesh once and refer to it from many nodes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import blake2b
from itertools import pairwise
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts, row_of_value
from grammarlab.derivation.values.materials import Materials
from grammarlab.export.glb import merged_content
from grammarlab.export.gltf_document import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, GltfDocument
from grammarlab.export.gltf_materials import GltfMaterials
from grammarlab.scene import Scene, TriangleBatch
from grammarlab.scene.instances import chosen
from grammarlab.scene.shading import ShadedMeshes, shade
from grammarlab.scene.triangles import CREASE_ANGLE

INSTANCING = "EXT_mesh_gpu_instancing"
THINNEST = 1e-6
"""Smallest scale of a node in metres, since readers cannot compute normals at zero."""


@dataclass(frozen=True, slots=True)
class Placements:
    """Translation, rotation and scale of I instances, as in glTF nodes."""

    translation: NDArray[np.float32]
    """[I, 3] metres."""
    rotation: NDArray[np.float32]
    """[I, 4] unit quaternions x, y, z, w."""
    scale: NDArray[np.float32]
    """[I, 3] > 0."""


@final
class ReusedContent:
    """Models as nodes that refer to one mesh for each combination of mesh and material in the file.

    Textured shapes do not share meshes: their texture coordinates depend on the size and the place of each shape. Those
    of one model are merged into one mesh.

    Args:
        document: the file.
        materials: its materials.
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
            textured[material] = self._materials.index(scene.materials, material)[1]
        merged = batch.of_groups(np.flatnonzero(textured[batch.group_material]))
        content = merged_content(self._document, self._materials, merged, f"{name}_textured")
        children = [self._document.add("nodes", content)] if content else []
        scene = chosen(scene, ~textured[scene.material])

        used, mesh = np.unique(scene.mesh, return_inverse=True)
        shaded = shade(scene.meshes.take(used), CREASE_ANGLE)
        placements = _placements(scene, shaded, mesh)
        rows = np.flatnonzero(np.diff(shaded.mesh_triangles)[mesh] > 0)
        for pair, places in _by_pair(mesh, scene.material, rows):
            index = self._meshes.index(shaded, pair[0], scene.materials, pair[1])
            children += (
                self._instanced(index, placements, places)
                if self._instancing
                else self._nodes(index, placements, places)
            )
        return {"children": children} if children else {}

    def _nodes(self, mesh: int, placements: Placements, places: NDArray[np.int64]) -> list[int]:
        columns = (placements.translation, placements.rotation, placements.scale)
        rows = zip(*(column[places].tolist() for column in columns), strict=True)
        return [
            self._document.add(
                "nodes", {"mesh": mesh, "translation": translation, "rotation": rotation, "scale": scale}
            )
            for translation, rotation, scale in rows
        ]

    def _instanced(self, mesh: int, placements: Placements, places: NDArray[np.int64]) -> list[int]:
        document = self._document
        document.require(INSTANCING)
        attributes = {}
        columns = {"TRANSLATION": placements.translation, "ROTATION": placements.rotation, "SCALE": placements.scale}
        for name, values in columns.items():
            chosen = values[places]
            attributes[name] = document.add_accessor(document.add_array(chosen), chosen, 0)
        return [document.add("nodes", {"mesh": mesh, "extensions": {INSTANCING: {"attributes": attributes}}})]


def _by_pair(
    mesh: NDArray[np.integer], material: NDArray[np.integer], rows: NDArray[np.int64]
) -> Iterator[tuple[tuple[int, int], NDArray[np.int64]]]:
    """Rows of each combination of mesh and material, in the order of their first occurrence."""
    _, first, pair_of_row = np.unique(
        np.stack([mesh[rows], material[rows]], axis=1), axis=0, return_index=True, return_inverse=True
    )
    place = np.empty_like(first)
    place[np.argsort(first)] = np.arange(len(first))
    pair_of_row = place[pair_of_row.ravel()]
    rows = rows[np.argsort(pair_of_row, kind="stable")]
    ends = offsets_from_counts(np.bincount(pair_of_row, minlength=len(first))).tolist()
    for start, end in pairwise(ends):
        yield (int(mesh[rows[start]]), int(material[rows[start]])), rows[start:end]


def _placements(scene: Scene, shaded: ShadedMeshes, mesh: NDArray[np.integer]) -> Placements:
    # Imported here, since most files do not need it.
    from scipy.spatial.transform import Rotation  # noqa: PLC0415

    extends = np.zeros((len(shaded.mesh_triangles) - 1, 3), dtype=bool)
    np.logical_or.at(extends, row_of_value(np.diff(shaded.mesh_vertices)), shaded.points != 0)
    # A mesh in the plane 0 of an axis is the same at any size along it.
    scale = np.where(~extends[mesh] & (scene.size < THINNEST), 1.0, np.maximum(scene.size, THINNEST))
    used, frame = np.unique(scene.frame, return_inverse=True)
    quaternion = Rotation.from_matrix(scene.frames[used]).as_quat() if len(used) else np.zeros((0, 4))
    turned = quaternion.astype(np.float32)[frame]
    return Placements(scene.position.astype(np.float32), turned, scale.astype(np.float32))


class _ReusedMeshes:
    """Meshes of one document, each written when it is first used; equal ones are written once."""

    def __init__(self, document: GltfDocument, materials: GltfMaterials) -> None:
        self._document = document
        self._materials = materials
        self._written: dict[tuple[int, int], int] = {}
        self._geometry: dict[bytes, tuple[int, dict[str, Any]]] = {}

    def index(self, shaded: ShadedMeshes, mesh: int, table: Materials, material: int) -> int:
        """Index in the document of a mesh with a material of a table."""
        material_index, _ = self._materials.index(table, material)
        number, geometry = self._geometry_of(shaded, mesh)
        if (number, material_index) not in self._written:
            entry = {
                "name": f"mesh_{number}_{material_index}",
                "primitives": [{**geometry, "material": material_index}],
            }
            self._written[number, material_index] = self._document.add("meshes", entry)
        return self._written[number, material_index]

    def _geometry_of(self, shaded: ShadedMeshes, mesh: int) -> tuple[int, dict[str, Any]]:
        """The number of a geometry, and the properties of its primitives."""
        vertices = slice(*shaded.mesh_vertices[mesh : mesh + 2])
        corners = shaded.triangles[slice(*shaded.mesh_triangles[mesh : mesh + 2])]
        points, normals = (column[vertices].astype(np.float32) + 0 for column in (shaded.points, shaded.normals))
        key = blake2b(b"".join(part.tobytes() for part in (points, normals, corners)), digest_size=16).digest()
        if key not in self._geometry:
            attributes = {
                "POSITION": self._accessor(points, ARRAY_BUFFER, (points.min(axis=0), points.max(axis=0))),
                "NORMAL": self._accessor(normals, ARRAY_BUFFER),
            }
            indices = corners.astype(np.uint16 if len(points) < 2**16 - 1 else np.uint32).ravel()
            accessor = self._accessor(indices, ELEMENT_ARRAY_BUFFER)
            self._geometry[key] = len(self._geometry), {"attributes": attributes, "indices": accessor}
        return self._geometry[key]

    def _accessor(self, values: np.ndarray, target: int, bounds: tuple[np.ndarray, np.ndarray] | None = None) -> int:
        return self._document.add_accessor(self._document.add_array(values, target), values, 0, bounds)
