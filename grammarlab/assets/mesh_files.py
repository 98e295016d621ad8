"""Meshes of asset files in OBJ and glTF, fitted to the unit cube; parts of meshes in other formats.

A file may come from a stranger: it and the files it refers to are read only from inside the asset folder, and its size
is bounded before and after it is expanded.
"""

from __future__ import annotations

import io
import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from grammarlab.asset_roots import AssetRoot, Place, place_of, places
from grammarlab.assets.image_paths import INSIDE, image_beside
from grammarlab.assets.mesh_parts import (
    MeshPart,
    Neighbours,
    PartMaterial,
    as_one_mesh,
    require_few_materials,
    welded,
    without_flat_faces,
)
from grammarlab.assets.srgb import srgb_from_linear
from grammarlab.errors import AssetError, MissingAssetError, UnreadableAssetError
from grammarlab.files import read_bounded
from grammarlab.geometry.meshes.mesh import Meshes

_Loaded = TypeVar("_Loaded")

PART_FORMATS = (".obj", ".ply", ".glb", ".gltf", ".off", ".stl")
_ASSET_FORMATS = (".obj", ".glb", ".gltf")
MAX_BYTES = 64 * 2**20
"""Largest size of an asset file in bytes."""
MAX_FACES = 2_000_000
"""Largest number of triangles of one asset."""
_MOST_PARSED = 32 * 2**20
"""Largest number of bytes of parsed assets that are kept for the next derivation."""
_MOST_MATERIAL_BYTES = 2**20
"""Largest size in bytes of a file that rules read a material from."""
_SETTLED = 100_000_000
"""Nanoseconds after which a further change of a file gives it another time, on every usual disk."""


@dataclass(frozen=True, slots=True)
class Asset:
    """One mesh from a file."""

    meshes: Meshes
    """One mesh in the unit cube."""
    low: NDArray[np.float64]
    """[3] low corner of its bounding box in the file, in the file's units."""
    size: NDArray[np.float64]
    """[3] the extent of its bounding box."""
    materials: tuple[PartMaterial | None, ...] = (None,)
    """The materials of its faces, by `CornerData.slots`: colors are sRGB, textures paths of images as rules name them;
    None for faces without a material."""


Stamp: TypeAlias = "tuple[Path, int, int, int, int] | None"
"""Path, size, number on its disk, time of the last change of the content and of any change; None for no file."""


class _Parsed(NamedTuple):
    """An asset as its files have it, and the state of the files."""

    asset: Asset
    stamps: tuple[tuple[str, Stamp], ...]
    """Each file that was read or looked for, before it was."""

    @property
    def num_bytes(self) -> int:
        """Bytes of its arrays."""
        meshes = self.asset.meshes
        values = 0 if meshes.data is None else meshes.data.values.nbytes
        return meshes.points.nbytes + meshes.corners.nbytes + meshes.face_offsets.nbytes + values

    def is_current(self, root: AssetRoot) -> bool:
        """Whether none of its files has changed since."""
        return all(_stamp(name, root) == stamp for name, stamp in self.stamps)

    def is_settled(self) -> bool:
        """Whether its files last changed long enough ago that a further change would change their stamps."""
        now = time.time_ns()
        return all(stamp is None or now - max(stamp[3:]) > _SETTLED for _, stamp in self.stamps)


class _ParsedAssets:
    """The assets that were used last, up to a number of bytes, for as long as their files stay as they are.

    A derivation is the same with and without it. Each step is one operation on a dictionary, so threads may share it.
    """

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes = most_bytes
        self._entries: dict[tuple[str, AssetRoot], _Parsed] = {}

    def load(self, path: str, root: AssetRoot) -> Asset:
        """The asset as its files have it; see `load_asset`."""
        key = (path, root)
        parsed = self._entries.pop(key, None)
        if parsed is None or not parsed.is_current(root):
            parsed = _parse(path, root)
        if parsed.is_settled():
            self._entries[key] = parsed
            self._shrink()
        return parsed.asset

    def _shrink(self) -> None:
        entries = list(self._entries.items())
        excess = sum(parsed.num_bytes for _, parsed in entries) - self._most_bytes
        for key, parsed in entries:
            if excess <= 0:
                break
            self._entries.pop(key, None)
            excess -= parsed.num_bytes


_PARSED = _ParsedAssets(_MOST_PARSED)


class AssetFolder:
    """A folder of assets; each file is read once.

    Args:
        root: the folder; nothing outside it is read.
    """

    def __init__(self, root: AssetRoot) -> None:
        self.root = root
        self._loaded: dict[str, Asset | UnreadableAssetError] = {}
        self._materials: dict[str, PartMaterial | UnreadableAssetError | None] = {}

    def load(self, path: str) -> Asset:
        """The mesh in a file; see `load_asset`."""
        return _once(self._loaded, load_asset, path, self.root)

    def load_material(self, path: str) -> PartMaterial | None:
        """The first material in a file; see `load_material`."""
        return _once(self._materials, load_material, path, self.root)


def _once(
    known: dict[str, _Loaded | UnreadableAssetError],
    load: Callable[[str, AssetRoot], _Loaded],
    path: str,
    root: AssetRoot,
) -> _Loaded:
    """What a file has, or why it cannot be read, from the first time it was asked for."""
    if path not in known:
        try:
            known[path] = load(path, root)
        except UnreadableAssetError as error:
            known[path] = error
    value = known[path]
    if isinstance(value, UnreadableAssetError):
        raise value
    return value


class NeighbourFiles:
    """Files that a mesh refers to, read only from inside a folder; together they have a bound.

    Args:
        folder: folder of the mesh, relative to the root.
        root: nothing outside this folder is read.
        most_bytes: largest size of all files together.
    """

    def __init__(self, folder: Path, root: Path, most_bytes: int) -> None:
        self._folder, self._root = folder, root
        self._rest = self._most = most_bytes
        self.stamps: list[tuple[str, Stamp]] = []
        """The files that were asked for, and the state of each before it was read."""

    def __call__(self, name: str) -> bytes:
        """Content of a file, by its path relative to the folder of the mesh.

        Raises:
            AssetError: If it is missing, lies outside, or the files have too many bytes.
        """
        path = str(self._folder / name.strip())
        self.stamps.append((path, _stamp(path, self._root)))
        content = _content(find_asset(path, self._root), name, self._rest)
        self._rest -= len(content)
        return content


def load_asset(path: str, root: AssetRoot) -> Asset:
    """Mesh of a file, with all its groups.

    Args:
        path: path of the file, relative to the folder.
        root: the asset folder; nothing outside it is read, links included.

    Raises:
        MissingAssetError: If the folder has no such file.
        UnreadableAssetError: If it is too large, has no mesh, or another format.
        AssetError: If it lies outside.
    """
    asset = _PARSED.load(path, root)
    if asset.materials == (None,):
        return asset
    folder, name = place_of(find_asset(path, root), root)
    materials = tuple(material and _placed(material, Path(name), folder) for material in asset.materials)
    return replace(asset, materials=materials)


def _parse(path: str, root: AssetRoot) -> _Parsed:
    """Mesh of a file with its materials as the file has them."""
    stamp = _stamp(path, root)
    file = find_asset(path, root)
    if file.suffix.lower() not in _ASSET_FORMATS:
        expected = ", ".join(_ASSET_FORMATS)
        raise UnreadableAssetError(
            f'the asset "{path}" is not a readable mesh; expected {expected}: export it as OBJ or GLB'
        )
    parts, neighbours = _read(file, path, root)
    mesh = without_flat_faces(as_one_mesh(parts))
    if file.suffix.lower() != ".obj":
        mesh = welded(mesh)
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    size = high - low
    scale = np.divide(1.0, size, out=np.zeros(3), where=size > 0.0)
    unit = mesh.with_points((mesh.points - low) * scale, stretch=np.where(size > 0.0, scale, 1.0)[None])
    asset = Asset(unit, low, size, tuple(dict.fromkeys(part.material for part in parts)))
    return _Parsed(asset, ((path, stamp), *neighbours.stamps))


def load_material(path: str, root: AssetRoot) -> PartMaterial | None:
    """The first material of an MTL file, placed as those of a mesh; None if it has none with a colour or an image.

    Raises:
        MissingAssetError: If the folder has no such file.
        UnreadableAssetError: If it is too large, or of another format.
        AssetError: If it lies outside.
    """
    from grammarlab.assets.mtl_reader import first_material  # noqa: PLC0415  # few rules read materials

    if Path(path).suffix.lower() != ".mtl":
        raise UnreadableAssetError(f'the material "{path}" is not readable; expected .mtl')
    file = find_asset(path, root)
    size = file.stat().st_size
    if size > _MOST_MATERIAL_BYTES:
        message = f'the material "{path}" has {size} bytes, more than the {_MOST_MATERIAL_BYTES} that are read'
        raise UnreadableAssetError(message)
    folder, name = place_of(file, root)
    first = first_material(_content(file, path, _MOST_MATERIAL_BYTES))
    return first and _placed(first, Path(name), folder)


def _stamp(path: str, root: AssetRoot) -> Stamp:
    """State of a file of the folder; None if there is none to read."""
    try:
        file = find_asset(path, root)
        state = file.stat()
    except (AssetError, OSError):
        return None
    return file, state.st_size, state.st_ino, state.st_mtime_ns, state.st_ctime_ns


def _placed(material: PartMaterial, file: Path, root: Path) -> PartMaterial:
    """A material of a file with sRGB colors, and an image as rules name it.

    Args:
        material: the material, as the file has it.
        file: path of the file relative to the asset folder.
        root: the asset folder.
    """
    texture = material.texture
    if texture.startswith(INSIDE):
        texture = file.as_posix() + texture
    elif texture:
        texture = image_beside(texture, file.parent, root)
    if file.suffix.lower() in (".obj", ".mtl"):
        return replace(material, texture=texture)
    red, green, blue = srgb_from_linear(np.array(material.color[:3])).tolist()
    glow = srgb_from_linear(np.array(material.emissive)).tolist()
    return replace(
        material,
        texture=texture,
        color=(red, green, blue, material.color[3]),
        emissive=(glow[0], glow[1], glow[2]),
    )


def find_asset(path: str, root: AssetRoot) -> Path:
    """Path of an asset.

    Raises:
        MissingAssetError: If the folder has no such file.
        UnreadableAssetError: If it is too large.
        AssetError: If it lies outside.
    """
    for place in places(path, root):
        file, size = _look_up(place, path)
        if size is not None:
            break
    else:
        raise MissingAssetError(f'there is no asset "{path}" in the asset folder {root}')
    if size > MAX_BYTES:
        raise UnreadableAssetError(f'the asset "{path}" has {size} bytes, more than the {MAX_BYTES} that are read')
    return file


def read_parts(content: bytes, suffix: str, neighbours: Neighbours, most_triangles: int) -> list[MeshPart]:
    """Parts of a mesh in a file; those without triangles are points of a scan.

    Args:
        content: the whole file.
        suffix: suffix of the file, one of `PART_FORMATS`.
        neighbours: files that it refers to.
        most_triangles: largest number of triangles.

    Raises:
        AssetError: If it is broken or too large, without the name of the file.
    """
    if suffix in {".glb", ".gltf"}:
        from grammarlab.assets.gltf_scene import read_gltf  # noqa: PLC0415  # many runs read no mesh

        parts = read_gltf(content, neighbours, 3 * most_triangles)
    elif suffix == ".obj":
        from grammarlab.assets.obj_reader import read_obj  # noqa: PLC0415

        parts = read_obj(content, neighbours)
    else:
        parts = _read_others(content, suffix)
    num_triangles = sum(part.num_triangles for part in parts)
    if num_triangles > most_triangles:
        raise AssetError(f"it has {num_triangles:,} triangles; at most {most_triangles:,} are read: simplify it first")
    return parts


def without_neighbours(name: str) -> bytes:
    """Refuse to read a file that a mesh refers to.

    Raises:
        AssetError: Always.
    """
    raise AssetError(f"it refers to the file {name[:100]!r}; expected a file that is complete alone, such as GLB")


def _look_up(place: Place, path: str) -> tuple[Path, int | None]:
    """Path of a file inside the folder of a place and its size in bytes; None if there is no such file."""
    try:
        folder = place.folder.resolve()
        file = (folder / place.name).resolve()
        inside = file.is_relative_to(folder)
        size = file.stat().st_size if inside and file.is_file() else None
    except (OSError, ValueError, RuntimeError) as error:  # RuntimeError: a link to itself, before Python 3.13
        raise AssetError(f'the asset "{path}" cannot be looked up: {error}') from error
    if not inside:
        raise AssetError(f'the asset "{path}" lies outside the asset folder')
    return file, size


def _read(file: Path, name: str, root: AssetRoot) -> tuple[list[MeshPart], NeighbourFiles]:
    """The parts of a file that have faces, at least one, and the files that it refers to."""
    folder, relative = place_of(file, root)
    neighbours = NeighbourFiles(Path(relative).parent, folder, MAX_BYTES)
    content = _content(file, name, MAX_BYTES)
    try:
        parts = [part for part in read_parts(content, file.suffix.lower(), neighbours, MAX_FACES) if len(part.counts)]
        require_few_materials(len({part.material for part in parts}))
    except AssetError as error:
        raise UnreadableAssetError(f'the asset "{name}" cannot be read: {error}') from error
    if not parts:
        raise UnreadableAssetError(f'the asset "{name}" has no faces')
    return parts, neighbours


def _content(file: Path, name: str, most: int) -> bytes:
    """Content of a file.

    Raises:
        AssetError: If it cannot be read, or has too many bytes.
    """
    try:
        return read_bounded(file, most)
    except OSError as error:
        raise AssetError(f'the asset "{name}" cannot be read: {error.strerror or error}') from error


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
    return MeshPart.of_triangles(points, triangles) if len(triangles) else MeshPart.of_points(points)
