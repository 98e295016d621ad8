"""Meshes of any format as parts: points, triangles and colors."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from grammarlab.assets.gltf.reading import read_gltf
from grammarlab.assets.obj import read_obj
from grammarlab.assets.parts import MeshPart, Neighbours
from grammarlab.errors import AssetError

FORMATS = (".obj", ".ply", ".glb", ".gltf", ".off", ".stl")


def read_parts(content: bytes, suffix: str, neighbours: Neighbours, most_triangles: int) -> list[MeshPart]:
    """Parts of a mesh in a file; those without triangles are points of a scan.

    Args:
        content: the whole file.
        suffix: its suffix, one of `FORMATS`.
        neighbours: files that it refers to.
        most_triangles: largest number of triangles.

    Raises:
        AssetError: If it is broken or too large, without the name of the file.
    """
    if suffix in {".glb", ".gltf"}:
        parts = read_gltf(content, neighbours, 3 * most_triangles)
    elif suffix == ".obj":
        parts = read_obj(content, neighbours)
    else:
        parts = _read_others(content, suffix)
    num_triangles = sum(len(part.triangles) for part in parts)
    if num_triangles > most_triangles:
        raise AssetError(f"it has {num_triangles:,} triangles; at most {most_triangles:,} are read: simplify it first")
    return parts


def without_neighbours(name: str) -> bytes:
    """Refuse to read a file that a mesh refers to.

    Raises:
        AssetError: Always.
    """
    raise AssetError(f"it refers to the file {name[:100]!r}; expected a file that is complete alone, such as GLB")


def _read_others(content: bytes, suffix: str) -> list[MeshPart]:
    """Parts of a PLY, OFF or STL file, read by trimesh."""
    import trimesh  # noqa: PLC0415  # takes longer to import than most commands take

    try:
        with np.errstate(all="ignore"), _quiet(logging.getLogger("trimesh")):
            # From memory, so that no other file is opened: only the geometry of this one counts.
            loaded: Any = trimesh.load_scene(io.BytesIO(content), file_type=suffix[1:], process=False)
            geometries = loaded.dump()
    except Exception as error:  # trimesh's readers raise any exception for a broken file
        raise AssetError(f"it is not a valid {suffix[1:].upper()} file: {error or type(error).__name__}") from error
    return [_part(geometry) for geometry in geometries if hasattr(geometry, "vertices")]


@contextmanager
def _quiet(logger: logging.Logger) -> Iterator[None]:
    """Keeps warnings of a library, with their tracebacks, from the terminal; handlers of a user's program get them."""
    handler = logging.NullHandler()
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)


def _part(geometry: Any) -> MeshPart:
    points = np.asarray(geometry.vertices, dtype=np.float64).reshape(-1, np.shape(geometry.vertices)[-1])
    triangles = np.asarray(getattr(geometry, "faces", ()), dtype=np.int64).reshape(-1, 3)
    return MeshPart.of_triangles(points, triangles) if len(triangles) else MeshPart(points, triangles)
