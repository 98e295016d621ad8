"""The triangles that the scene of a glTF file shows."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grammarlab.assets.gltf.accessors import Accessors
from grammarlab.assets.gltf.document import GltfDocument, parse_document
from grammarlab.assets.gltf.nodes import instance_matrices, num_instances, world_matrices
from grammarlab.assets.gltf.shapes import POINTS, Skin, positions, skin_of, triangles_of
from grammarlab.assets.parts import Color, Floats, Indices, MeshPart, Neighbours, color_of
from grammarlab.errors import AssetError

_INVALID = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError, RecursionError, struct.error)
"""Errors of values of another type or shape than in a valid file."""
_ROWS_PER_CORNER = 2
"""Number of decoded rows per corner of triangles: a position and an index, if no two triangles share points."""
_WHITE = (1.0, 1.0, 1.0, 1.0)

_Key = tuple[int, tuple[float, ...], int | None]
"""A mesh, the weights of its morph targets, and its skin."""


def read_gltf(content: bytes, neighbours: Neighbours, most_corners: int) -> list[MeshPart]:
    """Parts of the scene of a glTF or GLB file, one for each primitive, with all of its instances.

    Morph targets and skins are in the pose of the file. Lines are left out; points are parts without triangles.

    Args:
        content: the whole file.
        neighbours: files that it refers to.
        most_corners: largest number of corners of all triangles of the scene.

    Raises:
        AssetError: If it is invalid or too large, or requires an extension that is not read.
    """
    try:
        document = parse_document(content, neighbours)
        scene = _Scene(document, Accessors(document, _ROWS_PER_CORNER * most_corners), most_corners)
        with np.errstate(all="ignore"):  # values that are not finite are refused
            return list(scene.parts())
    except _INVALID as error:
        raise AssetError(f"it is not a valid glTF file: {error or type(error).__name__}") from error


@dataclass(slots=True)
class _Scene:
    document: GltfDocument
    accessors: Accessors
    most_corners: int
    num_corners: int = 0
    """Number of corners of triangles so far, with those of instances; at least 1 for each primitive."""
    corners: dict[tuple[int, bool], int] = field(default_factory=dict)
    """Number of corners of each mesh, and of points that a skin or a morph target moves."""
    skins: dict[int, Skin] = field(default_factory=dict)

    def parts(self) -> Iterator[MeshPart]:
        worlds = world_matrices(self.document)
        places: dict[_Key, list[Floats]] = {}
        for index, world in worlds.items():
            node = self.document.entry("nodes", index)
            if "mesh" in node:
                self._count(node)
                key = self._key(node)
                matrices = instance_matrices(node, world, self.accessors)
                places.setdefault(key, []).append(matrices if key[2] is None else np.eye(4)[None])
        for (mesh, weights, skin), matrices in places.items():
            if skin is not None and skin not in self.skins:
                self.skins[skin] = skin_of(self.document, skin, worlds, self.accessors)
            for primitive in self._primitives(mesh):
                yield from self._part(primitive, weights, skin, np.concatenate(matrices))

    def _primitives(self, mesh: object) -> list[dict[str, Any]]:
        """The primitives of a mesh that have positions."""
        return [each for each in self.document.entry("meshes", mesh)["primitives"] if "POSITION" in each["attributes"]]

    def _count(self, node: dict[str, Any]) -> None:
        """Refuse a scene that becomes too large with this node.

        Raises:
            AssetError: If it does.
        """
        key = node["mesh"], "skin" in node
        if key not in self.corners:
            self.corners[key] = sum(self._cost(each, skinned=key[1]) for each in self._primitives(node["mesh"]))
        self.num_corners += num_instances(node, self.accessors) * max(self.corners[key], 1)
        if self.num_corners > self.most_corners:
            raise AssetError(
                f"it expands to {self.num_corners:,} corners of triangles or more, with all of its instances; "
                f"at most {self.most_corners:,} are read"
            )

    def _cost(self, primitive: dict[str, Any], *, skinned: bool) -> int:
        num_points = self.accessors.count(primitive["attributes"]["POSITION"])
        num_corners = self.accessors.count(primitive["indices"]) if "indices" in primitive else num_points
        return max(num_corners, 1) + (num_points if skinned or "targets" in primitive else 0)

    def _key(self, node: dict[str, Any]) -> _Key:
        weights = node.get("weights", self.document.entry("meshes", node["mesh"]).get("weights", []))
        return node["mesh"], tuple(weights), node.get("skin")

    def _part(
        self, primitive: dict[str, Any], weights: tuple[float, ...], skin: int | None, matrices: Floats
    ) -> Iterator[MeshPart]:
        """A primitive at all of its places [I, 4, 4]."""
        mode, points = primitive.get("mode", 4), self._positions(primitive, weights, skin)
        rows = np.arange(len(points))
        if "indices" in primitive:
            rows = self.accessors.integers(primitive["indices"])[:, 0]
        triangles = triangles_of(mode, rows)
        if len(triangles):
            part = MeshPart.of_triangles(points, triangles)
            yield MeshPart(*_instanced(part.points, part.triangles, matrices), self._color(primitive))
        elif mode == POINTS:
            yield MeshPart(*_instanced(points[rows], triangles, matrices))

    def _positions(self, primitive: dict[str, Any], weights: tuple[float, ...], skin: int | None) -> Floats:
        return positions(primitive, weights, None if skin is None else self.skins[skin], self.accessors)

    def _color(self, primitive: dict[str, Any]) -> Color | None:
        if "material" not in primitive:
            return None
        material = self.document.entry("materials", primitive["material"])
        metal = material.get("pbrMetallicRoughness", {}).get("baseColorFactor")
        gloss = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness", {}).get("diffuseFactor")
        return color_of(_WHITE if metal is None and gloss is None else metal or gloss)


def _instanced(points: Floats, triangles: Indices, matrices: Floats) -> tuple[Floats, Indices]:
    """Points [I P, 3] and triangles [I T, 3] at I places; those of mirrored ones keep their outside."""
    moved = points @ matrices[:, :3, :3].transpose(0, 2, 1) + matrices[:, None, :3, 3]
    shifted = triangles + len(points) * np.arange(len(matrices))[:, None, None]
    mirrored = np.linalg.det(matrices[:, :3, :3]) < 0.0
    shifted[mirrored] = shifted[mirrored][:, :, ::-1]
    return moved.reshape(-1, 3), shifted.reshape(-1, 3)
