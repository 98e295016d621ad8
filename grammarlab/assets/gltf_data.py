"""Content of glTF and GLB files: JSON, buffers, and values of accessors.

Accessors are interleaved, sparse, normalised, or zeros (glTF 2.0, sections 3.6.2 and 5.1).
"""

from __future__ import annotations

import base64
import json
import struct
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.assets.mesh_parts import Indices, Neighbours
from grammarlab.errors import AssetError

_GLB_MAGIC, _JSON_CHUNK, _BINARY_CHUNK = b"glTF", 0x4E4F534A, 0x004E4942
_GEOMETRIC = frozenset({"EXT_mesh_gpu_instancing", "KHR_mesh_quantization", "KHR_node_visibility"})
"""Extensions of the geometry that are read."""
_APPEARANCE = (
    "KHR_materials_",
    "KHR_techniques_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_xmp",
    "KHR_animation_",
    "EXT_materials_",
    "EXT_texture_",
    "EXT_lights_",
    "MSFT_texture_",
    "MSFT_packing_",
    "ADOBE_materials_",
)
"""Beginnings of the names of extensions that do not change the geometry."""
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class UnreadableError(AssetError):
    """A glTF file that requires an extension that is not read."""

    def __init__(self, extension: str) -> None:
        advice = " (Blender, or `gltf-transform cp`, removes compression)" if "compression" in extension else ""
        super().__init__(
            f"it needs the glTF extension {extension}, which is not read; export it without this extension{advice}"
        )


@dataclass(slots=True)
class GltfDocument:
    """The parsed file; its buffers are read when they are needed.

    References are checked, since a file may come from a stranger: Python would count negative ones from the end.
    """

    json: dict[str, Any]
    binary: bytes | None
    """The binary chunk of a GLB file."""
    neighbours: Neighbours
    """Files that it refers to."""
    _buffers: dict[object, bytes] = field(default_factory=dict)

    def entry(self, kind: str, index: object) -> dict[str, Any]:
        """An entry of a list of the document, such as ``nodes``.

        Raises:
            ValueError: If it does not exist.
        """
        entries = self.json.get(kind, [])
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(entries):
            raise ValueError(f"{kind} has no entry {index!r}")
        return entries[index]

    def view(self, index: object) -> tuple[bytes, int, int, int | None]:
        """Buffer of a buffer view, its first byte and the byte after its last, and its stride.

        Raises:
            ValueError: If it is not inside its buffer.
            AssetError: If it is compressed, or the file of its buffer cannot be read.
        """
        view = self.entry("bufferViews", index)
        compressed = sorted(name for name in view.get("extensions", {}) if name.endswith("_meshopt_compression"))
        number = view.get("buffer")
        if compressed and not self._has_content(number):
            raise UnreadableError(compressed[0])
        content = self._buffer(number)
        start = _whole(view.get("byteOffset", 0), "byteOffset")
        end = start + _whole(view["byteLength"], "byteLength")
        if end > len(content):
            raise ValueError(f"bufferViews {index!r} ends at byte {end} of a buffer of {len(content)} bytes")
        return content, start, end, view.get("byteStride")

    def image(self, index: object) -> bytes:
        """Content of an image that lies in the file itself, or in a file beside it.

        Raises:
            ValueError: If it does not exist.
            AssetError: If its file cannot be read.
        """
        image = self.entry("images", index)
        if "uri" in image:
            return self._content_of(image["uri"])
        content, start, end, _ = self.view(image.get("bufferView"))
        return content[start:end]

    def _has_content(self, number: object) -> bool:
        return "uri" in self.entry("buffers", number) or (number == 0 and self.binary is not None)

    def _buffer(self, number: object) -> bytes:
        buffer = self.entry("buffers", number)
        if number not in self._buffers:
            self._buffers[number] = self._content(number, buffer.get("uri"))
        content, length = self._buffers[number], _whole(buffer["byteLength"], "byteLength")
        if len(content) < length:
            raise ValueError(f"buffers {number!r} has {len(content)} bytes instead of {length}: the file is cut off")
        return content

    def _content(self, number: object, uri: str | None) -> bytes:
        if uri is None:
            if number != 0 or self.binary is None:
                raise ValueError(f"buffers {number!r} has no content")
            return self.binary
        return self._content_of(uri)

    def _content_of(self, uri: str) -> bytes:
        if not uri.startswith("data:"):
            return self.neighbours(unquote(uri))
        head, _, data = uri.partition(",")
        return base64.b64decode(unquote(data)) if head.endswith(";base64") else unquote_to_bytes(data)


class Accessors:
    """Decoded accessors of a document; each is decoded once.

    Accessors without content mean zeros, so a few bytes can declare terabytes.

    Args:
        document: the file.
        most_rows: largest number of decoded rows.
    """

    def __init__(self, document: GltfDocument, most_rows: int) -> None:
        self._document = document
        self._most_rows = most_rows
        self._num_rows = 0
        self._decoded: dict[object, NDArray[Any]] = {}
        self._floats: dict[object, Floats] = {}

    def count(self, index: object) -> int:
        """Number of rows of an accessor."""
        count = self._document.entry("accessors", index)["count"]
        return _whole(count, "the count of an accessor")

    def is_empty(self, index: object) -> bool:
        """Whether an accessor has no content, so that all of its values are zero."""
        accessor = self._document.entry("accessors", index)
        return "bufferView" not in accessor and "sparse" not in accessor

    def floats(self, index: object, width: int) -> Floats:
        """[N, width] values of an accessor; normalised integers are numbers from 0 or -1 to 1."""
        values = self._values(index, width)
        if index not in self._floats:
            floats = values.astype(np.float64)
            if values.dtype.kind != "f" and self._document.entry("accessors", index).get("normalized"):
                floats = np.maximum(floats / float(np.iinfo(values.dtype).max), -1.0)
            self._floats[index] = floats
        return self._floats[index]

    def integers(self, index: object, width: int = 1) -> Indices:
        """[N, width] values of an accessor of unsigned integers.

        Raises:
            ValueError: If it has another type.
        """
        values = self._values(index, width)
        if values.dtype.kind != "u":
            raise ValueError(f"accessors {index!r} has no unsigned integers")
        return values.astype(np.int64)

    def _values(self, index: object, width: int) -> NDArray[Any]:
        accessor = self._document.entry("accessors", index)
        if index not in self._decoded:
            self._num_rows += self.count(index)
            if self._num_rows > self._most_rows:
                raise AssetError(f"it has {self._num_rows:,} values or more; at most {self._most_rows:,} are read")
            self._decoded[index] = self._decode(accessor)
        values = self._decoded[index]
        if values.shape[1] != width:
            raise ValueError(f"accessors {index!r} has {values.shape[1]} columns instead of {width}")
        return values

    def _decode(self, accessor: dict[str, Any]) -> NDArray[Any]:
        count, width = accessor["count"], _WIDTHS[accessor["type"]]
        component = np.dtype(_COMPONENTS[accessor["componentType"]])
        if "bufferView" in accessor:
            values = self._rows(accessor, count, component, width)
        else:
            values = np.zeros((count, width), component)
        if "sparse" not in accessor:
            return values
        sparse = accessor["sparse"]
        num_replaced = _whole(sparse["count"], "the count of a sparse accessor")
        if num_replaced > count:
            raise ValueError(f"a sparse accessor replaces {num_replaced} of {count} rows")
        index_type = np.dtype(_COMPONENTS[sparse["indices"]["componentType"]])
        if index_type.kind != "u":
            raise ValueError("the rows of a sparse accessor are not unsigned integers")
        rows = self._rows(sparse["indices"], num_replaced, index_type, 1)[:, 0].astype(np.int64)
        if len(rows) and rows.max() >= count:
            raise ValueError(f"a sparse accessor replaces row {rows.max()} of {count}")
        values = values.copy()
        values[rows] = self._rows(sparse["values"], num_replaced, component, width)
        return values

    def _rows(self, reference: dict[str, Any], count: int, component: np.dtype[Any], width: int) -> NDArray[Any]:
        """Rows of a buffer view from an offset on."""
        content, start, end, stride = self._document.view(reference["bufferView"])
        first = start + _whole(reference.get("byteOffset", 0), "byteOffset")
        size = component.itemsize * width
        step = size if stride is None else _whole(stride, "byteStride")
        if step < size:
            raise ValueError(f"byteStride is {step}, expected at least {size}")
        if count == 0:
            return np.zeros((0, width), component)
        if first + step * (count - 1) + size > end:
            raise ValueError(f"an accessor of {count} rows of {step} bytes does not fit into its buffer view")
        return np.ndarray((count, width), component, content, first, (step, component.itemsize))


def parse_document(content: bytes, neighbours: Neighbours) -> GltfDocument:
    """The document of a glTF or GLB file.

    Args:
        content: the whole file.
        neighbours: files that it refers to.

    Raises:
        ValueError: If it is not a glTF 2.0 file.
        UnreadableError: If it requires an extension that is not read.
    """
    text, binary = _chunks(content) if content[:4] == _GLB_MAGIC else (content, None)
    document = json.loads(text)
    version = str(document.get("asset", {}).get("version", "2.0"))
    if not version.startswith("2."):
        raise ValueError(f"expected version 2.0 of glTF, found {version[:20]!r}; export it again as glTF 2.0")
    for name in document.get("extensionsRequired", []):
        if name not in _GEOMETRIC and not name.startswith(_APPEARANCE):
            raise UnreadableError(name[:100])
    return GltfDocument(document, binary, neighbours)


def _whole(value: object, name: str) -> int:
    """The value, if it is a whole number of at least 0."""
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise ValueError(f"{name} is {value!r}, expected a whole number")
    return value


def _chunks(content: bytes) -> tuple[bytes, bytes | None]:
    """JSON and binary chunk of a GLB file."""
    version, _, length, kind = struct.unpack_from("<IIII", content, 4)
    if version != 2:
        raise ValueError(f"expected version 2 of GLB, found {version}; export it again as glTF 2.0")
    if kind != _JSON_CHUNK:
        raise ValueError("its first chunk is not JSON")
    end = 20 + length
    if end > len(content):
        raise ValueError("it is cut off in its JSON")
    text, binary = content[20:end], None
    if end + 8 <= len(content):
        length, kind = struct.unpack_from("<II", content, end)
        binary = content[end + 8 : end + 8 + length] if kind == _BINARY_CHUNK else None
    return text, binary
