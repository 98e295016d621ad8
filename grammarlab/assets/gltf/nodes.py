"""Nodes of the scene of a glTF file, with their transforms (glTF 2.0, sections 3.5.2 and 3.5.3)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from grammarlab.assets.gltf.accessors import Accessors
from grammarlab.assets.gltf.document import GltfDocument
from grammarlab.assets.parts import Floats
from grammarlab.errors import AssetError

INSTANCING = "EXT_mesh_gpu_instancing"
_VISIBILITY = "KHR_node_visibility"
_IDENTITY = np.eye(4)


def world_matrices(document: GltfDocument) -> dict[int, Floats]:
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


def instance_matrices(node: dict[str, Any], world: Floats, accessors: Accessors) -> Floats:
    """[I, 4, 4] matrices to the world of the instances of the mesh of a node; one without instancing."""
    attributes = _instance_attributes(node)
    if attributes is None:
        return world[None]
    num = num_instances(node, accessors)
    parts = {
        "TRANSLATION": np.zeros((num, 3)),
        "ROTATION": np.tile([0.0, 0, 0, 1], (num, 1)),
        "SCALE": np.ones((num, 3)),
    }
    for name, default in parts.items():
        if name in attributes:
            parts[name] = accessors.floats(attributes[name], default.shape[1])
    return world @ placed(parts["TRANSLATION"], parts["ROTATION"], parts["SCALE"])


def num_instances(node: dict[str, Any], accessors: Accessors) -> int:
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


def placed(translation: Floats, rotation: Floats, scale: Floats) -> Floats:
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


def _instance_attributes(node: dict[str, Any]) -> dict[str, Any] | None:
    """Accessors of the transforms of instances, by name; None without instancing."""
    extension = node.get("extensions", {}).get(INSTANCING)
    return None if extension is None else extension.get("attributes", {})


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


def _matrix(node: dict[str, Any]) -> Floats | None:
    """[4, 4] matrix of a node to its parent; None for the identity."""
    if "matrix" in node:
        return _numbers(node["matrix"], 16).reshape(4, 4).T
    if not node.keys() & {"translation", "rotation", "scale"}:
        return None
    translation = _numbers(node.get("translation", [0, 0, 0]), 3)
    rotation = _numbers(node.get("rotation", [0, 0, 0, 1]), 4)
    return placed(translation[None], rotation[None], _numbers(node.get("scale", [1, 1, 1]), 3)[None])[0]


def _times(parent: Floats, matrix: Floats | None) -> Floats:
    return parent if matrix is None else parent @ matrix


def _numbers(values: object, count: int) -> Floats:
    array = np.array(values, dtype=np.float64)
    if array.shape != (count,):
        raise ValueError(f"the transform of a node has {array.size} numbers instead of {count}")
    if not np.isfinite(array).all():
        raise AssetError("it has transforms of nodes that are not finite numbers")
    return array
