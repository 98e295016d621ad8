"""Points and triangles of primitives, in the coordinates of their mesh or, with a skin, of the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np

from grammarlab.assets.gltf.accessors import Accessors
from grammarlab.assets.gltf.document import GltfDocument, UnreadableError
from grammarlab.assets.parts import Floats, Indices

POINTS, LINES, TRIANGLES, STRIP, FAN = 0, (1, 2, 3), 4, 5, 6
_DRACO = "KHR_draco_mesh_compression"
_POINTS_AT_ONCE = 1 << 16
"""Number of points whose matrices are in memory at the same time."""


@dataclass(frozen=True, slots=True)
class Skin:
    """A skin in the pose of the scene."""

    matrices: Floats
    """[J, 4, 4] from the mesh to the world, for each joint."""


def triangles_of(mode: object, rows: Indices) -> Indices:
    """[T, 3] corners of the triangles of a primitive with corners [N]; none for points and lines.

    >>> triangles_of(STRIP, np.arange(4)).tolist(), triangles_of(FAN, np.arange(4)).tolist()
    ([[0, 1, 2], [1, 3, 2]], [[1, 2, 0], [2, 3, 0]])
    """
    if mode == POINTS or mode in LINES:
        return np.zeros((0, 3), np.int64)
    if mode == TRIANGLES:
        return rows[: len(rows) // 3 * 3].reshape(-1, 3)
    first = np.arange(max(len(rows) - 2, 0))
    if mode == STRIP:
        triangles = rows[np.stack([first, first + 1 + first % 2, first + 2 - first % 2], axis=1)]
        a, b, c = triangles.T
        return triangles[(a != b) & (b != c) & (c != a)]  # strips are joined by empty triangles
    if mode == FAN:
        return rows[np.stack([first + 1, first + 2, np.zeros_like(first)], axis=1)]
    raise ValueError(f"a primitive has the mode {mode!r}, expected 0 to 6")


def positions(primitive: dict[str, Any], weights: Sequence[float], skin: Skin | None, accessors: Accessors) -> Floats:
    """[P, 3] points of a primitive.

    Args:
        primitive: a primitive with positions.
        weights: weights of its morph targets.
        skin: its skin; None if it has none.
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


def skin_of(document: GltfDocument, index: object, worlds: dict[int, Floats], accessors: Accessors) -> Skin:
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
    return Skin(matrices)


def _skinned(points: Floats, attributes: dict[str, Any], skin: Skin, accessors: Accessors) -> Floats:
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
