"""Values of accessors: interleaved, sparse, normalised, or zeros (glTF 2.0, sections 3.6.2 and 5.1)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.assets.gltf.document import GltfDocument, whole
from grammarlab.assets.parts import Floats, Indices
from grammarlab.errors import AssetError

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


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
        return whole(count, "the count of an accessor")

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
        num_replaced = whole(sparse["count"], "the count of a sparse accessor")
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
        first = start + whole(reference.get("byteOffset", 0), "byteOffset")
        size = component.itemsize * width
        step = size if stride is None else whole(stride, "byteStride")
        if step < size:
            raise ValueError(f"byteStride is {step}, expected at least {size}")
        if count == 0:
            return np.zeros((0, width), component)
        if first + step * (count - 1) + size > end:
            raise ValueError(f"an accessor of {count} rows of {step} bytes does not fit into its buffer view")
        return np.ndarray((count, width), component, content, first, (step, component.itemsize))
