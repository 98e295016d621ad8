"""Triangles and points of the scene of a glTF file, in the coordinates of the world.

Nodes have transforms (glTF 2.0, sections 3.5.2 and 3.5.3); morph targets and skins (3.7.3) have the pose of the file.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.assets.gltf_data import Accessors, GltfDocument, UnreadableError, parse_document
from grammarlab.assets.gltf_surface import corner_values, material_of
from grammarlab.assets.mesh_parts import Indices, MeshPart, Neighbours
from grammarlab.errors import AssetError

_INSTANCING = "EXT_mesh_gpu_instancing"
_VISIBILITY = "KHR_node_visibility"
_IDENTITY = np.eye(4)
_POINTS, _LINES, _TRIANGLES, _STRIP, _FAN = 0, (1, 2, 3), 4, 5, 6
_DRACO = "KHR_draco_mesh_compression"
_POINTS_AT_ONCE = 1 << 16
"""Number of points whose matrices are in memory at the same time."""
_INVALID = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError, RecursionError, struct.error)
"""Errors of values of another type or shape than in a valid file."""
_ROWS_PER_CORNER = 6
"""Number of decoded rows per corner of triangles: a position, an index, a normal and some texture coordinates, if no
two triangles share points."""
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
    skins: dict[int, _Skin] = field(default_factory=dict)

    def parts(self) -> Iterator[MeshPart]:
        worlds = _world_matrices(self.document)
        placements: dict[_Key, list[Floats]] = {}
        for index, world in worlds.items():
            node = self.document.entry("nodes", index)
            if "mesh" in node:
                self._count(node)
                key = self._key(node)
                matrices = _instance_matrices(node, world, self.accessors)
                placements.setdefault(key, []).append(matrices if key[2] is None else np.eye(4)[None])
        for (mesh, weights, skin), matrices in placements.items():
            if skin is not None and skin not in self.skins:
                self.skins[skin] = _skin_of(self.document, skin, worlds, self.accessors)
            for primitive in self._primitives(mesh):
                yield from self._part(primitive, weights, skin, np.concatenate(matrices))

    def _primitives(self, mesh: object) -> list[dict[str, Any]]:
        """The primitives of a mesh that have positions."""
        return [
            primitive
            for primitive in self.document.entry("meshes", mesh)["primitives"]
            if "POSITION" in primitive["attributes"]
        ]

    def _count(self, node: dict[str, Any]) -> None:
        """Refuse a scene that becomes too large with this node.

        Raises:
            AssetError: If it does.
        """
        key = node["mesh"], "skin" in node
        if key not in self.corners:
            self.corners[key] = sum(
                self._cost(primitive, skinned=key[1]) for primitive in self._primitives(node["mesh"])
            )
        self.num_corners += _num_instances(node, self.accessors) * max(self.corners[key], 1)
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
        pose = None if skin is None else self.skins[skin]
        mode, points = primitive.get("mode", _TRIANGLES), _positions(primitive, weights, pose, self.accessors)
        rows = np.arange(len(points))
        if "indices" in primitive:
            rows = self.accessors.integers(primitive["indices"])[:, 0]
        triangles = _triangles_of(mode, rows)
        if len(triangles):
            # Before the instances, since a few corners may be among very many points.
            part, used = MeshPart.of_triangles(points, triangles), np.unique(triangles)
            normals, coordinates = corner_values(primitive, len(points), self.document, self.accessors)
            moved, corners = _instanced(part.points, part.triangles, matrices)
            corner = corners.ravel()
            instance, point = np.divmod(corner, len(part.points))
            is_posed = skin is not None or "targets" in primitive
            yield MeshPart.of_faces(
                moved,
                corner,
                np.full(len(corners), 3),
                material_of(primitive, self.document),
                None if normals is None or is_posed else _turned(normals[used[point]], matrices[instance]),
                tuple(values[used[point]] for values in coordinates),
            )
        elif mode == _POINTS:
            yield MeshPart.of_points(_instanced(points[rows], triangles, matrices)[0])


@dataclass(frozen=True, slots=True)
class _Skin:
    """A skin in the pose of the scene."""

    matrices: Floats
    """[J, 4, 4] from the mesh to the world, for each joint."""


def _world_matrices(document: GltfDocument) -> dict[int, Floats]:
    """[4, 4] matrix to the world of each visible node of the scene, by its index.

    The scene is the default one, or the first; a file without scenes shows all of its nodes.

    Raises:
        ValueError: If a reference is invalid, a node has two parents, or nodes form a cycle.
    """
    worlds: dict[int, Floats] = {}
    rest = [(index, _IDENTITY) for index in _roots(document)]
    while rest:
        index, parent = rest.pop()
        node = document.entry("nodes", index)
        if index in worlds:
            raise ValueError(f"nodes {index} has two parents, or is part of a cycle")
        worlds[index] = world = _times(parent, _matrix(node))
        rest.extend((child, world) for child in reversed(node.get("children", [])) if _is_visible(document, child))
    return worlds


def _roots(document: GltfDocument) -> Iterator[int]:
    if document.json.get("scenes"):
        roots = document.entry("scenes", document.json.get("scene", 0)).get("nodes", [])
    else:
        nodes = document.json.get("nodes", [])
        children = {child for node in nodes for child in node.get("children", [])}
        roots = [index for index in range(len(nodes)) if index not in children]
    return (index for index in reversed(roots) if _is_visible(document, index))


def _is_visible(document: GltfDocument, index: int) -> bool:
    return document.entry("nodes", index).get("extensions", {}).get(_VISIBILITY, {}).get("visible", True) is not False


def _times(parent: Floats, matrix: Floats | None) -> Floats:
    return parent if matrix is None else parent @ matrix


def _matrix(node: dict[str, Any]) -> Floats | None:
    """[4, 4] matrix of a node to its parent; None for the identity."""
    if "matrix" in node:
        return _numbers(node["matrix"], 16).reshape(4, 4).T
    if not node.keys() & {"translation", "rotation", "scale"}:
        return None
    translation = _numbers(node.get("translation", [0, 0, 0]), 3)
    rotation = _numbers(node.get("rotation", [0, 0, 0, 1]), 4)
    return _placement_matrices(translation[None], rotation[None], _numbers(node.get("scale", [1, 1, 1]), 3)[None])[0]


def _numbers(values: object, count: int) -> Floats:
    array = np.array(values, dtype=np.float64)
    if array.shape != (count,):
        raise ValueError(f"the transform of a node has {array.size} numbers instead of {count}")
    if not np.isfinite(array).all():
        raise AssetError("it has transforms of nodes that are not finite numbers")
    return array


def _placement_matrices(translation: Floats, rotation: Floats, scale: Floats) -> Floats:
    """[I, 4, 4] matrices from translations [I, 3], quaternions x, y, z, w [I, 4], and scales [I, 3].

    Raises:
        ValueError: If a quaternion is zero.
    """
    length = np.linalg.norm(rotation, axis=1, keepdims=True)
    if not (length > 0.0).all():
        raise ValueError("a rotation is not a quaternion of length 1")
    x, y, z, w = (rotation / length).T
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrices = np.tile(_IDENTITY, (len(translation), 1, 1))
    matrices[:, :3, :3] = np.moveaxis(turn, 2, 0) * scale[:, None, :]
    matrices[:, :3, 3] = translation
    return matrices


def _instance_matrices(node: dict[str, Any], world: Floats, accessors: Accessors) -> Floats:
    """[I, 4, 4] matrices to the world of the instances of the mesh of a node; one without instancing."""
    attributes = _instance_attributes(node)
    if attributes is None:
        return world[None]
    num = _num_instances(node, accessors)
    parts = {
        "TRANSLATION": np.zeros((num, 3)),
        "ROTATION": np.tile([0.0, 0, 0, 1], (num, 1)),
        "SCALE": np.ones((num, 3)),
    }
    for name, default in parts.items():
        if name in attributes:
            parts[name] = accessors.floats(attributes[name], default.shape[1])
    return world @ _placement_matrices(parts["TRANSLATION"], parts["ROTATION"], parts["SCALE"])


def _instance_attributes(node: dict[str, Any]) -> dict[str, Any] | None:
    """Accessors of the transforms of instances, by name; None without instancing."""
    extension = node.get("extensions", {}).get(_INSTANCING)
    return None if extension is None else extension.get("attributes", {})


def _num_instances(node: dict[str, Any], accessors: Accessors) -> int:
    """Number of instances of the mesh of a node.

    Raises:
        ValueError: If the attributes of the instances have different lengths.
    """
    attributes = _instance_attributes(node)
    if attributes is None:
        return 1
    counts = {accessors.count(index) for index in attributes.values()}
    if len(counts) > 1:
        raise ValueError(f"the attributes of instances have {' and '.join(map(str, sorted(counts)))} rows")
    return counts.pop() if counts else 1


def _skin_of(document: GltfDocument, index: object, worlds: dict[int, Floats], accessors: Accessors) -> _Skin:
    """The skin of a node in the pose of the scene.

    Args:
        document: the file.
        index: the skin.
        worlds: matrices of nodes to the world.
        accessors: the values of the file.

    Raises:
        ValueError: If a joint is not a node of the scene.
    """
    skin = document.entry("skins", index)
    joints = skin["joints"]
    if not set(joints) <= worlds.keys():
        raise ValueError(f"skins {index!r} has joints that are not in the scene")
    matrices = np.array([worlds[joint] for joint in joints]).reshape(-1, 4, 4)
    if "inverseBindMatrices" in skin:
        inverse = accessors.floats(skin["inverseBindMatrices"], 16).reshape(-1, 4, 4).transpose(0, 2, 1)
        if len(inverse) < len(joints):
            raise ValueError(f"skins {index!r} has {len(inverse)} matrices for {len(joints)} joints")
        matrices = matrices @ inverse[: len(joints)]
    return _Skin(matrices)


def _triangles_of(mode: object, rows: Indices) -> Indices:
    """[T, 3] corners of the triangles of a primitive with corners [N]; none for points and lines.

    >>> _triangles_of(_STRIP, np.arange(4)).tolist(), _triangles_of(_FAN, np.arange(4)).tolist()
    ([[0, 1, 2], [1, 3, 2]], [[1, 2, 0], [2, 3, 0]])
    """
    if mode == _POINTS or mode in _LINES:
        return np.zeros((0, 3), np.int64)
    if mode == _TRIANGLES:
        return rows[: len(rows) // 3 * 3].reshape(-1, 3)
    first = np.arange(max(len(rows) - 2, 0))
    if mode == _STRIP:
        triangles = rows[np.stack([first, first + 1 + first % 2, first + 2 - first % 2], axis=1)]
        a, b, c = triangles.T
        return triangles[(a != b) & (b != c) & (c != a)]  # strips are joined by empty triangles
    if mode == _FAN:
        return rows[np.stack([first + 1, first + 2, np.zeros_like(first)], axis=1)]
    raise ValueError(f"a primitive has the mode {mode!r}, expected 0 to 6")


def _instanced(points: Floats, triangles: Indices, matrices: Floats) -> tuple[Floats, Indices]:
    """Points [I P, 3] and triangles [I T, 3] at I places; those of mirrored ones keep their outside."""
    moved = points @ matrices[:, :3, :3].transpose(0, 2, 1) + matrices[:, None, :3, 3]
    shifted = triangles + len(points) * np.arange(len(matrices))[:, None, None]
    mirrored = np.linalg.det(matrices[:, :3, :3]) < 0.0
    shifted[mirrored] = shifted[mirrored][:, :, ::-1]
    return moved.reshape(-1, 3), shifted.reshape(-1, 3)


def _turned(normals: Floats, matrices: Floats) -> Floats:
    """Normals [C, 3] on surfaces that are moved by matrices [C, 4, 4], of any length."""
    x, y, z = np.moveaxis(matrices[:, :3, :3], 2, 0)
    cofactors = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], axis=2)
    cofactors *= np.where(np.linalg.det(matrices[:, :3, :3]) < 0.0, -1.0, 1.0)[:, None, None]
    return np.einsum("cij,cj->ci", cofactors, normals)


def _positions(primitive: dict[str, Any], weights: Sequence[float], skin: _Skin | None, accessors: Accessors) -> Floats:
    """[P, 3] points of a primitive.

    Args:
        primitive: a primitive with positions.
        weights: weights of its morph targets.
        skin: the skin of the mesh; None if it has none.
        accessors: the values of the file.

    Raises:
        UnreadableError: If they are only there in compressed form.
    """
    attributes = primitive["attributes"]
    if _DRACO in primitive.get("extensions", {}) and accessors.is_empty(attributes["POSITION"]):
        raise UnreadableError(_DRACO)
    points = accessors.floats(attributes["POSITION"], 3)
    for weight, target in zip(weights, primitive.get("targets", []), strict=False):
        if weight and "POSITION" in target:
            moved = accessors.floats(target["POSITION"], 3)
            if len(moved) != len(points):
                raise ValueError(f"a morph target has {len(moved)} points instead of {len(points)}")
            points = points + float(weight) * moved
    return points if skin is None else _skinned(points, attributes, skin, accessors)


def _skinned(points: Floats, attributes: dict[str, Any], skin: _Skin, accessors: Accessors) -> Floats:
    """[P, 3] weighted means of the places of points by their joints (glTF 2.0, section 3.7.3)."""
    joints, weights = [], []
    for number in count():
        if f"JOINTS_{number}" not in attributes:
            break
        joints.append(accessors.integers(attributes[f"JOINTS_{number}"], 4))
        weights.append(accessors.floats(attributes[f"WEIGHTS_{number}"], 4))
    if not joints:
        raise ValueError("a mesh with a skin has no joints")
    joint, weight = np.concatenate(joints, axis=1), np.concatenate(weights, axis=1)
    if len(joint) != len(points) or len(weight) != len(points) or (joint.size and joint.max() >= len(skin.matrices)):
        raise ValueError("the joints of a mesh do not belong to its points or its skin")
    result = np.zeros_like(points)
    for start in range(0, len(points), _POINTS_AT_ONCE):
        rows = slice(start, start + _POINTS_AT_ONCE)
        for column in range(joint.shape[1]):
            matrices = skin.matrices[joint[rows, column]]
            moved = np.einsum("pij,pj->pi", matrices[:, :3, :3], points[rows]) + matrices[:, :3, 3]
            result[rows] += weight[rows, column, None] * moved
    return result
