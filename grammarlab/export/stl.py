"""Binary STL files of watertight solids, z up."""

from __future__ import annotations

import shutil
import struct
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray

from grammarlab.export.model_files import AbstractWriter, Output
from grammarlab.export.printable_solids import apart, distinct_corners, solid_of, stored, z_up
from grammarlab.scene import Scene, TriangleBatch

_FACE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_HEAD = 80
"""Bytes of the head, which is text."""


@final
class StlWriter(AbstractWriter):
    """All models as triangles in metres; the head gives the origin of the file.

    Args:
        output: the file.
        origin: [3] origin of the file in the world, in metres, y up.
    """

    def __init__(self, output: Output, origin: NDArray[np.float64]) -> None:
        self._stream = output.stream
        self._faces = output.part()
        self._origin = origin

    def add(self, scene: Scene, batch: TriangleBatch, name: str, offset: NDArray[np.float64]) -> None:
        """See `AbstractWriter.add`."""
        solid = solid_of(scene)
        points = stored(z_up(apart(solid.points + offset, solid.triangles)))
        # Points that are stored as one make triangles without an area, beside which programs find holes.
        corners = points[solid.triangles[distinct_corners(points, solid.triangles)[0]]]
        turn = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(turn, axis=1, keepdims=True)
        faces = np.zeros(len(corners), _FACE)
        faces["normal"] = turn / np.where(length > 0.0, length, 1.0)  # ty: ignore[invalid-assignment]
        faces["corners"] = corners  # ty: ignore[invalid-assignment]
        self._faces.write(faces.tobytes())

    def finish(self) -> tuple[Path, ...]:
        """See `AbstractWriter.finish`."""
        x, y, z = z_up(self._origin[None])[0].tolist()
        head = "grammarlab: metres, z up" + (f", origin {x!r} {y!r} {z!r}" if self._origin.any() else "")
        self._stream.write(head.encode()[:_HEAD].ljust(_HEAD))
        self._stream.write(struct.pack("<I", self._faces.tell() // _FACE.itemsize))
        self._faces.seek(0)
        shutil.copyfileobj(self._faces, self._stream, 1 << 20)
        return ()
