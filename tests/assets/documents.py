"""glTF documents for tests, built from arrays."""

from __future__ import annotations

import base64
import json
import struct
from typing import Any

import numpy as np

COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]], np.float32)
SQUARE_TRIANGLES = np.array([0, 1, 2, 2, 1, 3])
BOX = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
BOX_TRIANGLES = np.array(
    [
        [0, 1, 3, 0, 3, 2],
        [4, 6, 7, 4, 7, 5],
        [0, 4, 5, 0, 5, 1],
        [2, 3, 7, 2, 7, 6],
        [0, 2, 6, 0, 6, 4],
        [1, 5, 7, 1, 7, 3],
    ]
).ravel()
"""Corners of the twelve triangles of a box, counter-clockwise seen from outside."""


class Document:
    """A document whose buffer is inside."""

    def __init__(self) -> None:
        self.json: dict[str, Any] = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": []}
        self.buffer = b""

    def view(self, content: bytes, **properties: int) -> int:
        """Index of a new buffer view."""
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        view = {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(content), **properties}
        self.buffer += content
        self.json["bufferViews"].append(view)
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values: np.ndarray, *, padding: int = 0, **properties: Any) -> int:
        """Index of a new accessor; each row is followed by some bytes of padding."""
        rows = np.ascontiguousarray(values if values.ndim == 2 else values[:, None])
        content = b"".join(row.tobytes() + b"\xee" * padding for row in rows)
        stride = {"byteStride": rows.itemsize * rows.shape[1] + padding} if padding else {}
        return self.bare(rows, bufferView=self.view(content, **stride), **properties)

    def bare(self, rows: np.ndarray, **properties: Any) -> int:
        """Index of a new accessor with the type and length of some rows, but without their values."""
        entry = {"componentType": COMPONENTS[rows.dtype.str[1:]], "count": len(rows), "type": TYPES[rows.shape[1]]}
        self.json["accessors"].append({**entry, **properties})
        return len(self.json["accessors"]) - 1

    def mesh(self, points: np.ndarray, triangles: np.ndarray | None = None, **properties: Any) -> int:
        """Index of a new mesh with one primitive."""
        primitive: dict[str, Any] = {"attributes": {"POSITION": self.accessor(points)}, **properties}
        if triangles is not None:
            primitive["indices"] = self.accessor(triangles.astype(np.uint16))
        return self.add("meshes", {"primitives": [primitive]})

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        self.json.setdefault(kind, []).append(entry)
        return len(self.json[kind]) - 1

    def show(self, *roots: int) -> None:
        """Make these nodes the scene."""
        self.json["scene"] = self.add("scenes", {"nodes": list(roots)})

    def gltf(self) -> bytes:
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.buffer).decode()
        return json.dumps({**self.json, "buffers": [{"byteLength": len(self.buffer), "uri": uri}]}).encode()

    def glb(self) -> bytes:
        text = json.dumps({**self.json, "buffers": [{"byteLength": len(self.buffer)}]}).encode()
        text += b" " * (-len(text) % 4)
        binary = self.buffer + b"\0" * (-len(self.buffer) % 4)
        length = 28 + len(text) + len(binary)
        head = struct.pack("<4sIIII", b"glTF", 2, length, len(text), 0x4E4F534A)
        return head + text + struct.pack("<II", len(binary), 0x004E4942) + binary


def rich_document() -> Document:
    """A document with every kind of content that is read."""
    document = Document()
    box = document.mesh(BOX, BOX_TRIANGLES, material=0)
    strip = document.mesh(SQUARE, mode=5)
    transform = {"offset": [0.5, 0.25], "rotation": 0.5, "scale": [2.0, 4.0], "texCoord": 1}
    texture = {"index": 0, "extensions": {"KHR_texture_transform": transform}}
    color = {"baseColorFactor": [1.0, 0.5, 0.0, 1.0], "baseColorTexture": texture, "roughnessFactor": 0.25}
    document.add("materials", {"pbrMetallicRoughness": color, "emissiveFactor": [0.0, 0.5, 1.0]})
    document.add("textures", {"source": 0})
    document.add("images", {"bufferView": document.view(b"picture"), "mimeType": "image/png"})
    document.json["meshes"][box]["primitives"][0]["attributes"] |= {
        "NORMAL": document.accessor((2.0 * BOX - 1.0).astype(np.float32)),
        "TEXCOORD_0": document.accessor((65535 * BOX[:, :2]).astype(np.uint16), normalized=True),
        "TEXCOORD_1": document.accessor(BOX[:, 1:].astype(np.float32)),
    }
    rows, moved = document.view(np.array([3], np.uint16).tobytes()), document.view(np.ones(3, np.float32).tobytes())
    sparse = {"count": 1, "indices": {"bufferView": rows, "componentType": 5123}, "values": {"bufferView": moved}}
    fan = document.mesh(np.array([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]], np.int8), mode=6)
    document.json["accessors"][-1]["sparse"] = {
        **sparse,
        "values": {"bufferView": document.view(np.array([0, 5, 5], np.int8).tobytes())},
    }
    target = document.accessor(np.ones((4, 3), np.float32), sparse=sparse)
    morph = document.mesh(SQUARE, SQUARE_TRIANGLES, targets=[{"POSITION": target}])
    document.json["meshes"][morph]["weights"] = [0.5]
    joints = document.accessor(np.zeros((4, 4), np.uint8))
    weights = document.accessor(np.tile(np.array([255, 0, 0, 0], np.uint8), (4, 1)), normalized=True)
    skinned = document.mesh(SQUARE, SQUARE_TRIANGLES)
    document.json["meshes"][skinned]["primitives"][0]["attributes"] |= {"JOINTS_0": joints, "WEIGHTS_0": weights}
    document.add(
        "skins", {"joints": [1], "inverseBindMatrices": document.accessor(np.eye(4, dtype="f4").reshape(1, 16))}
    )
    places = {
        "TRANSLATION": document.accessor(np.arange(9, dtype=np.float32).reshape(3, 3)),
        "ROTATION": document.accessor(np.tile(np.array([0, 0, 0, 127], np.int8), (3, 1)), normalized=True),
    }
    document.add("nodes", {"children": [1, 2, 3], "scale": [2, 2, -2]})
    document.add("nodes", {"mesh": box, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": places}}})
    document.add("nodes", {"mesh": strip, "matrix": np.eye(4).ravel().tolist()})
    document.add("nodes", {"mesh": fan, "children": [4, 5], "rotation": [0, 0.6, 0, 0.8]})
    document.add("nodes", {"mesh": morph, "translation": [1, 2, 3]})
    document.add("nodes", {"mesh": skinned, "skin": 0})
    document.show(0)
    return document
