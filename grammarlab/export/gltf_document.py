"""Unfinished glTF 2.0 document: its JSON lists and its binary buffer."""

from __future__ import annotations

import json
import shutil
import struct
from typing import IO, Any

import numpy as np

from grammarlab.errors import UsageError
from grammarlab.export.model_files import Output

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
COMPONENTS = {np.dtype(np.float32): 5126, np.dtype(np.uint32): 5125, np.dtype(np.uint16): 5123}
MAGIC, VERSION, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
MOST_BYTES = 2**32 - 1
"""Largest size of a GLB in bytes, since its length has 32 bits."""
ENTRIES_AT_ONCE = 512

_encode = json.JSONEncoder(separators=(",", ":"), allow_nan=False).encode


class GltfDocument:
    """Collects the parts of one file; `pack` writes the GLB (glTF 2.0 specification, section 4).

    Added parts are converted to bytes at once and stored outside memory if they are large, since a file has its lengths
    before its content.

    Args:
        output: the file.
    """

    def __init__(self, output: Output) -> None:
        self._output = output
        self._lists: dict[str, _Entries] = {}
        self._buffer = output.part()
        self._used: set[str] = set()
        self._required: set[str] = set()
        self._root: dict[str, dict[str, Any]] = {}
        self._alignment = 4

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        """Append to the list `kind` (``nodes``, ``materials``, …) and return the index of the entry."""
        if kind not in self._lists:
            self._lists[kind] = _Entries(self._output.part())
        return self._lists[kind].add(entry)

    def require(self, extension: str) -> None:
        """Declare an extension that readers must support."""
        self._used.add(extension)
        self._required.add(extension)

    def use(self, extension: str, root: dict[str, Any] | None = None) -> None:
        """Declare an extension that readers may ignore, with its object at the root of the document."""
        self._used.add(extension)
        if root is not None:
            self._root[extension] = root

    def add_bytes(self, content: bytes, alignment: int = 4, **properties: int) -> int:
        """Append to the buffer; returns the index of the buffer view with further properties.

        Args:
            content: the bytes.
            alignment: 4 or 8; the view starts at a multiple of it in the file.
            properties: further properties of the view.

        Raises:
            UsageError: If the file would have more than `MOST_BYTES`.
        """
        self._alignment = max(self._alignment, alignment)
        self._buffer.write(b"\0" * (-self._buffer.tell() % alignment))
        view = {"buffer": 0, "byteOffset": self._buffer.tell(), "byteLength": len(content), **properties}
        self._buffer.write(content)
        self._buffer.write(b"\0" * (-len(content) % 4))
        _require_size(self._buffer.tell())
        return self.add("bufferViews", view)

    def add_array(self, values: np.ndarray, target: int | None = None) -> int:
        """Append an array to the buffer; the index of the buffer view."""
        properties = {} if target is None else {"target": target}
        if target == ARRAY_BUFFER:
            properties["byteStride"] = values.itemsize * values.shape[1]
        return self.add_bytes(np.ascontiguousarray(values).tobytes(), **properties)

    def add_accessor(
        self,
        view: int,
        values: np.ndarray,
        first: int,
        bounds: tuple[np.ndarray, np.ndarray] | None = None,
        *,
        normalized: bool = False,
    ) -> int:
        """Describe rows of an array that lies in a buffer view; the index of the accessor.

        Args:
            view: the buffer view that holds the whole array.
            values: the rows, [N] or [N, 2..4].
            first: index of the first row in the view.
            bounds: smallest and largest value of each column, if glTF requires them.
            normalized: whether integers stand for shares of their largest one.
        """
        width = 1 if values.ndim == 1 else values.shape[1]
        accessor: dict[str, Any] = {
            "bufferView": view,
            "byteOffset": first * width * values.itemsize,
            "componentType": COMPONENTS[values.dtype],
            "count": len(values),
            "type": "SCALAR" if width == 1 else f"VEC{width}",
        }
        if normalized:
            accessor["normalized"] = True
        if bounds is not None:
            accessor["min"], accessor["max"] = bounds[0].tolist(), bounds[1].tolist()
        return self.add("accessors", accessor)

    def pack(self, root_nodes: list[int], generator: str) -> None:
        """Write the GLB whose scene shows these nodes.

        Raises:
            UsageError: If it would have more than `MOST_BYTES`.
        """
        head: dict[str, Any] = {"asset": {"version": "2.0", "generator": generator}, "scene": 0}
        head["scenes"] = [{"nodes": root_nodes} if root_nodes else {}]
        if self._used:
            head["extensionsUsed"] = sorted(self._used)
        if self._required:
            head["extensionsRequired"] = sorted(self._required)
        if self._root:
            head["extensions"] = dict(sorted(self._root.items()))
        num_bytes = self._buffer.tell()
        ends = [f',"buffers":{_encode([{"byteLength": num_bytes}])}' if num_bytes else "", "}"]
        names = [f',"{kind}":[' for kind in self._lists]
        text_length = len(_encode(head)) - 1 + sum(map(len, names + ends))
        lists = [entries.finished() for entries in self._lists.values()]
        text_length += sum(entries.tell() + 1 for entries in lists)
        # The buffer starts after a head of 20 bytes, the text, and a head of 8 bytes.
        padding = (-text_length - 28) % self._alignment
        length = 12 + 8 + text_length + padding + (8 + num_bytes if num_bytes else 0)
        _require_size(length)

        stream = self._output.stream
        stream.write(struct.pack("<IIIII", MAGIC, VERSION, length, text_length + padding, JSON_CHUNK))
        stream.write(_encode(head)[:-1].encode())
        for name, entries in zip(names, lists, strict=True):
            stream.write(name.encode())
            _append(entries, stream)
            stream.write(b"]")
        stream.write("".join(ends).encode() + b" " * padding)
        if num_bytes:
            stream.write(struct.pack("<II", num_bytes, BINARY_CHUNK))
            _append(self._buffer, stream)


def index_type(num_vertices: int) -> type[np.unsignedinteger]:
    """The narrowest type of indices of vertices; glTF reserves the largest number of a type."""
    return np.uint16 if num_vertices < 2**16 - 1 else np.uint32


class _Entries:
    """One list of the JSON, of which at most `ENTRIES_AT_ONCE` are kept as objects, since text needs less memory.

    Args:
        part: an empty stream.
    """

    def __init__(self, part: IO[bytes]) -> None:
        self._part = part
        self._waiting: list[dict[str, Any]] = []
        self._num_written = 0

    def add(self, entry: dict[str, Any]) -> int:
        """Append an entry, which must not change afterwards; returns its index."""
        self._waiting.append(entry)
        index = self._num_written + len(self._waiting) - 1
        if len(self._waiting) == ENTRIES_AT_ONCE:
            self._write()
        return index

    def finished(self) -> IO[bytes]:
        """The stream, with the text of all entries between the brackets of the list."""
        if self._waiting:
            self._write()
        return self._part

    def _write(self) -> None:
        text = _encode(self._waiting)[1:-1].encode()
        self._part.write(b"," + text if self._num_written else text)
        self._num_written += len(self._waiting)
        self._waiting = []


def _append(part: IO[bytes], stream: IO[bytes]) -> None:
    part.seek(0)
    shutil.copyfileobj(part, stream, 1 << 20)


def _require_size(length: int) -> None:
    if length > MOST_BYTES:
        raise UsageError(
            f"the file would have {length} bytes or more and a GLB holds at most {MOST_BYTES}; "
            "write fewer models into one file, or share their meshes"
        )
