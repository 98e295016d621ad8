"""A glTF 2.0 document in the making: its JSON lists and its one binary buffer."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from grammarlab.errors import UsageError

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
COMPONENTS = {"float32": 5126, "uint32": 5125, "uint16": 5123}
MAGIC, VERSION, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
MOST_BYTES = 2**32 - 1
"""A GLB states its length in 32 bits."""


class GltfDocument:
    """Collects the parts of one file; `pack` gives the bytes of a GLB (glTF 2.0 specification, section 4)."""

    def __init__(self) -> None:
        self._lists: dict[str, list[dict[str, Any]]] = {}
        self._chunks: list[bytes] = []
        self._num_bytes = 0
        self._extensions: set[str] = set()

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        """Append to the list `kind` (``nodes``, ``materials``, …) and return the index of the entry."""
        entries = self._lists.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def require(self, extension: str) -> None:
        """Declare that a reader must know an extension to show this file."""
        self._extensions.add(extension)

    def add_bytes(self, content: bytes) -> int:
        """Append to the buffer, aligned to 4 bytes; the index of the buffer view."""
        view: dict[str, Any] = {"buffer": 0, "byteOffset": self._num_bytes, "byteLength": len(content)}
        padding = -len(content) % 4
        self._chunks += [content, b"\0" * padding]
        self._num_bytes += len(content) + padding
        return self.add("bufferViews", view)

    def add_array(self, values: np.ndarray, target: int | None = None) -> int:
        """Append an array to the buffer; the index of the buffer view."""
        view = self.add_bytes(np.ascontiguousarray(values).tobytes())
        if target is not None:
            self._lists["bufferViews"][view]["target"] = target
        if target == ARRAY_BUFFER:
            self._lists["bufferViews"][view]["byteStride"] = values.itemsize * values.shape[1]
        return view

    def add_accessor(
        self, view: int, values: np.ndarray, first: int, bounds: tuple[np.ndarray, np.ndarray] | None = None
    ) -> int:
        """Describe rows of an array that lies in a buffer view; the index of the accessor.

        Args:
            view: the buffer view that holds the whole array.
            values: the rows, [N] or [N, 2..4].
            first: which row of the array in the view is the first.
            bounds: smallest and largest value of each column, where glTF asks for them.
        """
        width = 1 if values.ndim == 1 else values.shape[1]
        accessor: dict[str, Any] = {
            "bufferView": view,
            "byteOffset": first * width * values.itemsize,
            "componentType": COMPONENTS[values.dtype.name],
            "count": len(values),
            "type": "SCALAR" if width == 1 else f"VEC{width}",
        }
        if bounds is not None:
            accessor["min"], accessor["max"] = bounds[0].tolist(), bounds[1].tolist()
        return self.add("accessors", accessor)

    def pack(self, root_nodes: list[int], generator: str) -> bytes:
        """The bytes of the GLB whose scene shows these nodes.

        Raises:
            UsageError: they would be more than `MOST_BYTES`.
        """
        document: dict[str, Any] = {"asset": {"version": "2.0", "generator": generator}, "scene": 0}
        document["scenes"] = [{"nodes": root_nodes} if root_nodes else {}]
        if self._extensions:
            document["extensionsUsed"] = document["extensionsRequired"] = sorted(self._extensions)
        document.update(self._lists)
        if self._num_bytes:
            document["buffers"] = [{"byteLength": self._num_bytes}]
        text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + (8 + self._num_bytes if self._num_bytes else 0)
        if length > MOST_BYTES:
            raise UsageError(
                f"the file would have {length} bytes and a GLB holds at most {MOST_BYTES}; "
                "write fewer models into one file, or share their meshes"
            )
        parts = [struct.pack("<IIIII", MAGIC, VERSION, length, len(text), JSON_CHUNK), text]
        if self._num_bytes:
            parts += [struct.pack("<II", self._num_bytes, BINARY_CHUNK), *self._chunks]
        return b"".join(parts)
