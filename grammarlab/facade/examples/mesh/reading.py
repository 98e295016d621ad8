"""Meshes of buildings from files: OBJ, PLY, GLB, glTF and OFF, read by trimesh.

A file may come from a stranger: its size is checked before it is read, and its decoded content before it is used.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.assets.gltf_guard import check_gltf
from grammarlab.assets.meshes import find_asset
from grammarlab.assets.obj import plain_faces
from grammarlab.errors import AssetError, FacadeError
from grammarlab.facade.examples.mesh.solids import united
from grammarlab.facade.examples.mesh.surface import Surface, turns, welded, without_slivers

FORMATS = (".obj", ".ply", ".glb", ".gltf", ".off")
MOST_BYTES = 256 * 2**20
MOST_TRIANGLES = 2_000_000
"""Largest number of triangles: simplify larger meshes first."""
_LARGEST, _SMALLEST = 5_000.0, 0.01
"""Least and largest length of the longest side of a building, metres."""
_SAME = 1e-6
"""Largest distance of equal points, as a fraction of the longest side."""
_GREY = (0.7, 0.7, 0.68, 1.0)


@dataclass(frozen=True, slots=True)
class ExampleMesh:
    """A building from a file, near the origin."""

    surface: Surface
    origin: np.ndarray
    """[3] offset subtracted from the coordinates of the file: national coordinates are too large for a model."""
    colors: tuple[tuple[float, float, float, float], ...]
    """Red, green, blue and opacity of each material, 0 to 1."""
    has_materials: bool
    """Whether the file defines materials."""
    num_read: int
    """Number of triangles in the file."""


def read_mesh(path: Path, unit: float = 1.0) -> ExampleMesh:
    """The triangles of a file, with coinciding points merged.

    Args:
        path: the file.
        unit: length of a unit of its coordinates, metres.

    Raises:
        FacadeError: If the file is of another kind, broken, too large, or its size is not that of a building.
    """
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise FacadeError(f"{path.name}: expected a mesh as {', '.join(FORMATS)}, found {kind or 'no suffix'}.")
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise FacadeError(f"{path.name} has {size:,} bytes; at most {MOST_BYTES:,} are read. Simplify the mesh first.")
    groups = _groups(path, kind)
    points = np.concatenate([each[0] for each in groups]) * unit
    num = sum(len(each[1]) for each in groups)
    if not num:
        raise FacadeError(f"{path.name} holds no faces.")
    if num > MOST_TRIANGLES:
        raise FacadeError(f"{path.name} has {num:,} triangles; at most {MOST_TRIANGLES:,} are read. Simplify it first.")
    if not np.isfinite(points).all():
        raise FacadeError(f"{path.name} has points that are not finite numbers.")
    colors = list(dict.fromkeys(each[2] or _GREY for each in groups))
    firsts = np.cumsum([0, *(len(each[0]) for each in groups)])
    triangles = np.concatenate([each[1] + first for each, first in zip(groups, firsts, strict=False)])
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise FacadeError(f"{path.name} has faces with corners that do not exist.")
    material = np.concatenate([np.full(len(each[1]), colors.index(each[2] or _GREY)) for each in groups])
    used = points[triangles.ravel()]
    low, high = used.min(axis=0), used.max(axis=0)
    extent = float((high - low).max())
    if not _SMALLEST <= extent <= _LARGEST:
        raise FacadeError(
            f"{path.name} is {extent:g} m large; expected {_SMALLEST:g} to {_LARGEST:,.0f} m. "
            "If its coordinates are not in metres, give their unit (--unit)."
        )
    origin = np.round((low + high) / 2.0)
    tolerance = _SAME * extent
    surface = welded(Surface(points - origin, triangles, material), tolerance)
    surface = without_slivers(_once(united(surface, tolerance)), tolerance)
    if not len(surface):
        raise FacadeError(f"{path.name}: all of its triangles are empty.")
    return ExampleMesh(surface, origin, tuple(colors), any(each[2] for each in groups), num)


def _once(surface: Surface) -> Surface:
    """The surface without triangles that are there twice in one direction; in both, if all have a side for each."""
    sets, group = np.unique(np.sort(surface.triangles, axis=1), axis=0, return_inverse=True)
    key = 2 * group.ravel() + turns(surface.triangles)
    kinds, first = np.unique(key, return_index=True)
    if len(kinds) == 2 * len(sets):
        first = np.minimum(first[::2], first[1::2])
    which = np.zeros(len(surface), dtype=bool)
    which[first] = True
    return surface.part(which)


def _groups(path: Path, kind: str) -> list[tuple[Any, Any, tuple[float, float, float, float] | None]]:
    """Points, triangles and color of each group of a file."""
    import trimesh  # noqa: PLC0415  # takes longer to import than most commands take

    content = path.read_bytes()
    try:
        if kind in {".glb", ".gltf"}:
            check_gltf(content, path.name, 3 * MOST_TRIANGLES)
        elif kind == ".obj":
            content = plain_faces(content)
        neighbours: Any = _Neighbours(path.parent)
        loaded: Any = trimesh.load_scene(io.BytesIO(content), file_type=kind[1:], resolver=neighbours, process=False)
        found = []
        for mesh in loaded.dump():
            if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
                points = np.asarray(mesh.vertices, dtype=np.float64)
                found.append((points, np.asarray(mesh.faces, dtype=np.int64), _color(mesh)))
    except (AssetError, Exception) as error:  # trimesh's readers raise any exception for a broken file
        raise FacadeError(f"{path.name} cannot be read: {error or type(error).__name__}") from error
    if not found:
        raise FacadeError(f"{path.name} holds no faces.")
    return found


class _Neighbours:
    """Resolver for trimesh of the files that a mesh refers to: only those in its own folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

    def get(self, name: str) -> bytes:
        """The content of a file given by its path from the folder of the mesh."""
        return find_asset(name.strip(), self._folder).read_bytes()


def _color(mesh: Any) -> tuple[float, float, float, float] | None:
    """Main color of a group; None if the file has none."""
    visual = mesh.visual
    if not getattr(visual, "defined", False) or visual.kind != "texture":
        return None
    red, green, blue, opacity = (float(each) / 255.0 for each in np.asarray(visual.material.main_color)[:4])
    return round(red, 4), round(green, 4), round(blue, 4), round(opacity, 4)
