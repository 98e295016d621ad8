"""A small reader of GLB files, written from the glTF 2.0 specification and apart from the writer."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

DTYPES = {5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
MESH_FORMATS = ("glb", "obj", "ply")
"""Formats that have the triangles of a scene as they are."""
INSTANCING = "EXT_mesh_gpu_instancing"


@dataclass(frozen=True)
class Glb:
    document: dict[str, Any]
    buffer: bytes

    def values(self, index: int) -> np.ndarray:
        """The rows of an accessor."""
        accessor = self.document["accessors"][index]
        view = self.document["bufferViews"][accessor["bufferView"]]
        dtype, width = np.dtype(DTYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]
        stride = view.get("byteStride", dtype.itemsize * width)
        first = view["byteOffset"] + accessor.get("byteOffset", 0)
        last = first + stride * (accessor["count"] - 1) + dtype.itemsize * width
        assert last <= view["byteOffset"] + view["byteLength"] <= len(self.buffer)
        return np.ndarray((accessor["count"], width), dtype, self.buffer, first, (stride, dtype.itemsize))

    def material(self, primitive: dict[str, Any]) -> dict[str, Any]:
        return self.document["materials"][primitive["material"]]


def read_glb(path: Path) -> Glb:
    content = path.read_bytes()
    magic, version, length = struct.unpack_from("<4sII", content)
    assert (magic, version, length) == (b"glTF", 2, len(content))
    num_text, kind = struct.unpack_from("<I4s", content, 12)
    assert kind == b"JSON"
    document = json.loads(content[20 : 20 + num_text])
    if 20 + num_text == length:
        return Glb(document, b"")
    num_binary, kind = struct.unpack_from("<I4s", content, 20 + num_text)
    assert kind == b"BIN\0"
    assert 28 + num_text + num_binary == length
    assert document["buffers"] == [{"byteLength": num_binary}]
    return Glb(document, content[28 + num_text :])


def matrices(translation: np.ndarray, rotation: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """[N, 4, 4] from translations, quaternions (x, y, z, w) and scales."""
    result = np.tile(np.eye(4), (len(translation), 1, 1))
    result[:, :3, :3] = Rotation.from_quat(rotation).as_matrix() * scale[:, None, :]
    result[:, :3, 3] = translation
    return result


def node_matrices(glb: Glb, node: dict[str, Any]) -> np.ndarray:
    """[N, 4, 4] the places of a node: one, or many with GPU instancing, each below the node's own."""
    own = matrices(
        np.array([node.get("translation", [0, 0, 0])], dtype=float),
        np.array([node.get("rotation", [0, 0, 0, 1])], dtype=float),
        np.array([node.get("scale", [1, 1, 1])], dtype=float),
    )
    extension = node.get("extensions", {}).get(INSTANCING)
    if extension is None:
        return own
    columns = {name: glb.values(index).astype(float) for name, index in extension["attributes"].items()}
    return own @ matrices(columns["TRANSLATION"], columns["ROTATION"], columns["SCALE"])


@dataclass(frozen=True)
class Surface:
    """T triangles in the world, in the order of the file."""

    corners: np.ndarray
    """[T, 3, 3]."""
    normals: np.ndarray
    """[T, 3, 3] at the corners."""
    coordinates: np.ndarray
    """[T, 3, 2] of textures; NaN where there are none."""
    materials: np.ndarray
    """[T] names."""


def world(glb: Glb) -> Surface:
    """Every triangle that the file's scene shows."""
    document = glb.document
    parts: list[Surface] = []

    def visit(index: int, parent: np.ndarray) -> None:
        node = document["nodes"][index]
        places = parent @ node_matrices(glb, node)
        if "mesh" in node:
            for primitive in document["meshes"][node["mesh"]]["primitives"]:
                parts.extend(placed(glb, primitive, place) for place in places)
        for child in node.get("children", []):
            visit(child, places[0])

    for root in document["scenes"][document["scene"]].get("nodes", []):
        visit(root, np.eye(4))
    return Surface(
        np.concatenate([part.corners for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.coordinates for part in parts]),
        np.concatenate([part.materials for part in parts]),
    )


def placed(glb: Glb, primitive: dict[str, Any], place: np.ndarray) -> Surface:
    """The triangles of a primitive at one place [4, 4]."""
    attributes = primitive["attributes"]
    points, normals = (glb.values(attributes[name]).astype(float) for name in ("POSITION", "NORMAL"))
    rows = glb.values(primitive["indices"]).ravel() if "indices" in primitive else np.arange(len(points))
    corners = (points @ place[:3, :3].T + place[:3, 3])[rows].reshape(-1, 3, 3)
    turned = (normals @ np.linalg.inv(place[:3, :3]))[rows].reshape(-1, 3, 3)
    turned /= np.linalg.norm(turned, axis=2, keepdims=True)
    coordinates = np.full((len(corners), 3, 2), np.nan)
    if "TEXCOORD_0" in attributes:
        coordinates = glb.values(attributes["TEXCOORD_0"]).astype(float)[rows].reshape(-1, 3, 2)
    return Surface(corners, turned, coordinates, np.repeat(glb.material(primitive)["name"], len(corners)))
