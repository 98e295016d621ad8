"""Meshes from files: OBJ and glTF, read by trimesh, fitted to the unit cube.

A file may come from a stranger: it and the files it refers to are read only from inside the asset folder, and its size
is bounded before and after it is expanded.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from grammarlab.assets.gltf_guard import check_gltf
from grammarlab.assets.obj import plain_faces
from grammarlab.assets.paths import meanings
from grammarlab.errors import AssetError, MissingAssetError
from grammarlab.geometry.meshes.mesh import Meshes

FORMATS = (".obj", ".glb", ".gltf")
MAX_BYTES = 64 * 2**20
"""Largest size of an asset file in bytes."""
MAX_FACES = 2_000_000
"""Largest number of triangles of one asset."""


@dataclass(frozen=True, slots=True)
class Asset:
    """One mesh from a file."""

    meshes: Meshes
    """One mesh of triangles in the unit cube."""
    low: NDArray[np.float64]
    """[3] low corner of its bounding box in the file, in the file's units."""
    size: NDArray[np.float64]
    """[3] the extent of its bounding box."""


class AssetFolder:
    """A folder of assets; each file is read once.

    Args:
        root: the folder; nothing outside it is read.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self._loaded: dict[str, Asset] = {}

    def load(self, path: str) -> Asset:
        """The mesh in a file; see `load_asset`."""
        if path not in self._loaded:
            self._loaded[path] = load_asset(path, self.root)
        return self._loaded[path]


def load_asset(path: str, root: Path) -> Asset:
    """Mesh of a file, with all its groups.

    Args:
        path: path of the file, relative to the folder.
        root: the asset folder; nothing outside it is read, links included.

    Raises:
        MissingAssetError: If the folder has no such file.
        AssetError: If it lies outside, is too large, or has no mesh.
    """
    file = find_asset(path, root)
    if file.suffix.lower() not in FORMATS:
        raise AssetError(f'the asset "{path}" is not a readable mesh; expected {", ".join(FORMATS)}')
    points, triangles = _read(file, path, root)
    low, high = points.min(axis=0), points.max(axis=0)
    size = high - low
    unit = (points - low) * np.divide(1.0, size, out=np.zeros(3), where=size > 0.0)
    ends = np.array([0, len(triangles)]), np.array([0, len(unit)])
    tags = np.zeros(len(triangles), np.int8)
    offsets = np.arange(0, triangles.size + 1, 3, dtype=np.int64)
    return Asset(Meshes(unit, triangles.ravel(), offsets, *ends, tags), low, size)


def find_asset(path: str, root: Path) -> Path:
    """Path of an asset.

    Raises:
        MissingAssetError: If the folder has no such file.
        AssetError: If it lies outside, or is too large.
    """
    folder = root.resolve()
    for meaning in meanings(path):
        file, size = _look_up(folder, meaning, path)
        if size is not None:
            break
    else:
        raise MissingAssetError(f'there is no asset "{path}" in the asset folder {root}')
    if size > MAX_BYTES:
        raise AssetError(f'the asset "{path}" has {size} bytes, more than the {MAX_BYTES} that are read')
    return file


def _look_up(folder: Path, meaning: str, path: str) -> tuple[Path, int | None]:
    """Path of a file inside a folder and its size in bytes; None if there is no such file."""
    try:
        file = (folder / meaning).resolve()
        inside = file.is_relative_to(folder)
        size = file.stat().st_size if inside and file.is_file() else None
    except (OSError, ValueError) as error:
        raise AssetError(f'the asset "{path}" cannot be looked up: {error}') from error
    if not inside:
        raise AssetError(f'the asset "{path}" lies outside the asset folder')
    return file, size


class _AssetFiles:
    """Resolver for trimesh of the files that an asset refers to.

    Args:
        folder: folder of the asset, relative to the root.
        root: the asset folder.
    """

    def __init__(self, folder: Path, root: Path) -> None:
        self._folder, self._root = folder, root
        self._left = MAX_BYTES

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

    def get(self, name: str) -> bytes:
        """Content of a file, by its path relative to the folder of the asset."""
        content = find_asset(str(self._folder / unquote(name.strip())), self._root).read_bytes()
        self._left -= len(content)
        if self._left < 0:
            raise AssetError(f"its files have more than the {MAX_BYTES} bytes that are read")
        return content


def _read(file: Path, name: str, root: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Points [P, 3] and triangles [T, 3] of all groups of a file."""
    import trimesh  # noqa: PLC0415  # takes longer to import than most grammars to derive

    kind = file.suffix.lower()
    content = file.read_bytes()
    if kind != ".obj":
        check_gltf(content, name, 3 * MAX_FACES)
    neighbours: Any = _AssetFiles(file.parent.relative_to(root.resolve()), root)
    try:
        mesh: Any = trimesh.load(
            io.BytesIO(plain_faces(content) if kind == ".obj" else content),
            file_type=kind[1:],
            resolver=neighbours,
            force="mesh",
            process=False,
            skip_materials=True,
        )
        points = np.asarray(mesh.vertices, dtype=np.float64)
        triangles = np.asarray(mesh.faces, dtype=np.int64)
    except Exception as error:  # trimesh's readers raise any exception for broken files
        raise AssetError(f'the asset "{name}" cannot be read: {error}') from error
    if len(triangles) == 0 or len(points) == 0:
        raise AssetError(f'the asset "{name}" has no faces')
    if len(triangles) > MAX_FACES:
        raise AssetError(f'the asset "{name}" has {len(triangles)} triangles, more than the {MAX_FACES} that are read')
    if not np.isfinite(points).all():
        raise AssetError(f'the asset "{name}" has points that are not finite numbers')
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise AssetError(f'the asset "{name}" has faces with corners that do not exist')
    return points, triangles
