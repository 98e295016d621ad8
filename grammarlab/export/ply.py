"""Binary PLY files: positions, normals and colours at the vertices."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import row_of_value
from grammarlab.export.model_files import AbstractWriter, Output
from grammarlab.export.obj import origin_comments
from grammarlab.scene import Scene, TriangleBatch

FACE = np.dtype([("count", "u1"), ("corners", "<u4", 3)])
PROPERTY_TYPES = {"<f4": "float", "<f8": "double", "|u1": "uchar"}


@final
class PlyWriter(AbstractWriter):
    """All models as one mesh, with the sRGB colours of their materials, and texture coordinates if vertices have them.

    A comment gives the origin of the file, since the format has no transforms.

    Args:
        output: the file.
        origin: [3] origin of the file in the world, in metres.
        wide: whether positions need 64 bits, since models are far apart.
    """

    def __init__(self, output: Output, origin: NDArray[np.float64], *, wide: bool) -> None:
        self._stream = output.stream
        self._origin = origin
        self._vertices, self._faces = output.part(), output.part()
        self._num_vertices = 0
        self._wide = wide
        self._vertex = _vertex_type(wide=wide, coordinates=False)

    def add(self, scene: Scene, batch: TriangleBatch, name: str, offset: NDArray[np.float64]) -> None:
        """See `AbstractWriter.add`."""
        if self._num_vertices == 0:
            self._vertex = _vertex_type(wide=self._wide, coordinates=batch.coordinates is not None)
        vertices = np.empty(len(batch.vertices), self._vertex)
        positions = batch.vertices + offset
        material = batch.group_material[row_of_value(np.diff(batch.group_vertices))]
        colors = np.rint(np.clip(batch.materials.channels[:, :4], 0.0, 1.0) * 255).astype(np.uint8)[material]
        for index, axis in enumerate(("x", "y", "z")):
            vertices[axis] = positions[:, index]
            vertices["n" + axis] = batch.normals[:, index]
        for index, channel in enumerate(("red", "green", "blue", "alpha")):
            vertices[channel] = colors[:, index]
        if batch.coordinates is not None:
            vertices["s"], vertices["t"] = batch.coordinates.T
        faces = np.empty(len(batch.triangles), FACE)
        faces["count"] = 3  # ty: ignore[invalid-assignment]
        faces["corners"] = batch.triangles + np.uint32(self._num_vertices)  # ty: ignore[invalid-assignment]
        self._num_vertices += len(vertices)
        self._vertices.write(vertices.tobytes())
        self._faces.write(faces.tobytes())

    def finish(self) -> tuple[Path, ...]:
        """See `AbstractWriter.finish`."""
        header = ["ply", "format binary_little_endian 1.0", "comment grammarlab: metres, y up"]
        header += origin_comments("comment ", self._origin)
        header.append(f"element vertex {self._num_vertices}")
        header += [f"property {PROPERTY_TYPES[self._vertex[name].str]} {name}" for name in self._vertex.names or ()]
        header.append(f"element face {self._faces.tell() // FACE.itemsize}")
        header += ["property list uchar uint vertex_indices", "end_header"]
        self._stream.write(("\n".join(header) + "\n").encode())
        for part in (self._vertices, self._faces):
            part.seek(0)
            shutil.copyfileobj(part, self._stream, 1 << 20)
        return ()


def _vertex_type(*, wide: bool, coordinates: bool) -> np.dtype:
    """Layout of a vertex, with texture coordinates if the models of a file have them at their vertices."""
    return np.dtype(
        [(name, "<f8" if wide else "<f4") for name in ("x", "y", "z")]
        + [(name, "<f4") for name in ("nx", "ny", "nz")]
        + [(name, "u1") for name in ("red", "green", "blue", "alpha")]
        + [(name, "<f4") for name in ("s", "t") if coordinates]
    )
