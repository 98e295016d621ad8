"""Meshes of buildings from OBJ, PLY, GLB, glTF and OFF files, and surfaces as GLB files.

A file may come from a stranger: its size is checked before it is read, and its decoded content before it is used.
Written files have one primitive per material over shared points, so that closed surfaces are read as closed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from grammarlab.arrays import Floats, Ints
from grammarlab.assets.mesh_files import NeighbourFiles, read_parts
from grammarlab.assets.mesh_parts import MeshPart, joined
from grammarlab.errors import AssetError, FacadeError
from grammarlab.facade.values import read_bounded
from grammarlab.files import write_bytes
from grammarlab.synthesis.mesh.file_faces import patches_of
from grammarlab.synthesis.mesh.solids import united
from grammarlab.synthesis.mesh.surface import Color, Surface, turns, welded, without_slivers

FORMATS = (".obj", ".ply", ".glb", ".gltf", ".off")
"""Suffixes of files of meshes."""
_MOST_BYTES = 256 * 2**20
"""Largest size of a file, bytes."""
_MOST_TRIANGLES = 2_000_000
"""Largest number of triangles: simplify larger meshes first."""
_MAX_SIZE_M, _MIN_SIZE_M = 5_000.0, 0.01
"""Least and largest length of the longest side of a building, metres."""
_TOLERANCE = 1e-6
"""Largest distance of equal points, as a fraction of the longest side."""
_FLAT = 1e-4
"""Largest thickness of a flat piece, as a fraction of its length."""
_SHEET_RATIO = 2.0
"""Least area of a ground plane or backdrop, as a multiple of that of the rest; roofs that jut out have less."""
_SHEET_EXTENT = 0.5
"""Least diagonal of such a sheet, as a fraction of that of all: it is larger than the rest."""
_GREY = (0.7, 0.7, 0.68, 1.0)
"""Color of parts without a material."""


@dataclass(frozen=True, slots=True)
class ExampleMesh:
    """A building from a file, near the origin."""

    surface: Surface
    origin: np.ndarray
    """[3] offset subtracted from the coordinates of the file: national coordinates are too large for a model."""
    colors: tuple[Color, ...]
    """Color of each material."""
    has_materials: bool
    """Whether the file defines materials."""
    num_read: int
    """Number of triangles in the file."""
    patches: Ints
    """[2, T] number of the patch of each triangle (`grammarlab.synthesis.mesh.file_faces`): by the points of the file
    and by merged points."""


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
    parts = _parts(path, kind)
    points, triangles = joined(parts)
    points *= unit
    num = len(triangles)
    colors = list(dict.fromkeys(part.color or _GREY for part in parts))
    material = np.concatenate([np.full(len(part.triangles), colors.index(part.color or _GREY)) for part in parts])
    patch = patches_of(points, triangles, material)
    used = points[triangles.ravel()]
    low, high = used.min(axis=0), used.max(axis=0)
    extent = float((high - low).max())
    if not _MIN_SIZE_M <= extent <= _MAX_SIZE_M:
        raise FacadeError(
            f"{path.name} is {extent:g} m large; expected {_MIN_SIZE_M:g} to {_MAX_SIZE_M:,.0f} m. "
            "If its coordinates are not in metres, give their unit (`unit=`)."
        )
    origin = np.round((low + high) / 2.0)
    tolerance = _TOLERANCE * extent
    # Patches take the place of materials, so that they stay with their triangles through all of this.
    surface = welded(Surface(points - origin, triangles, patch), tolerance)
    surface = without_slivers(_once(united(surface, tolerance)), tolerance)
    if not len(surface):
        raise FacadeError(f"{path.name}: all of its triangles are empty.")
    of_patch = np.zeros(int(patch.max()) + 1, dtype=np.int64)
    of_patch[patch] = material
    patch, surface = surface.material, replace(surface, material=of_patch[surface.material])
    # Where walls are many polygons, those that meet in one plane are a patch as well.
    planes = patches_of(surface.points, surface.triangles, surface.material)
    has_materials = any(part.color for part in parts)
    return ExampleMesh(surface, origin, tuple(colors), has_materials, num, np.stack([patch, planes]))


def without_sheets(mesh: ExampleMesh) -> tuple[ExampleMesh, tuple[str, ...]]:
    """A building without ground planes and backdrops, and a note about each.

    Such a sheet is flat, touches nothing, has all else on one side of it, and reaches beyond all of that on all sides,
    over at least twice its area.
    """
    surface = mesh.surface
    num = len(surface.points)
    edges = surface.triangles[:, [0, 1, 1, 2]].reshape(-1, 2)
    links = csr_matrix((np.ones(len(edges), dtype=bool), edges.T), shape=(num, num))
    num_pieces, of_point = connected_components(links, directed=False)
    low, high = np.full((num_pieces, 3), np.inf), np.full((num_pieces, 3), -np.inf)
    np.minimum.at(low, of_point, surface.points)
    np.maximum.at(high, of_point, surface.points)
    extent = np.linalg.norm(high - low, axis=1)
    whole = float(np.linalg.norm(np.ptp(surface.points, axis=0)))
    of_triangle = of_point[surface.triangles[:, 0]]
    sheets = {}
    for piece in np.flatnonzero(extent >= _SHEET_EXTENT * whole).tolist():
        points = surface.part(of_triangle == piece).points
        if (axes := _flat_axes(points)) is not None:
            sheets[piece] = points, axes
    rest = surface.part(~np.isin(of_triangle, list(sheets))).points
    sizes = {piece: _sheet_size(points, axes, rest) for piece, (points, axes) in sheets.items()} if len(rest) else {}
    large = {piece: size for piece, size in sizes.items() if size is not None}
    is_sheet = np.isin(of_triangle, list(large))
    notes = [
        f"a flat sheet of {length:.3g} x {width:.3g} m, such as a ground plane, is left out"
        for length, width in large.values()
    ]
    if not notes:
        return mesh, ()
    return replace(mesh, surface=surface.part(~is_sheet), patches=mesh.patches[:, ~is_sheet]), tuple(notes)


def _flat_axes(points: Floats) -> Floats | None:
    """[3, 3] axes of a flat piece, the normal last; None for points [P, 3] that are not flat."""
    if len(points) < 3:
        return None
    _, spread, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    flat = _FLAT * float(spread[0])
    return axes if spread[2] <= flat < spread[1] else None


def _sheet_size(sheet: Floats, axes: Floats, rest: Floats) -> tuple[float, float] | None:
    """Length and width of a flat piece [P, 3] that is a ground plane or a backdrop of the rest [Q, 3], or None."""
    seen, other = sheet @ axes.T, rest @ axes.T
    flat = _FLAT * float(np.ptp(seen, axis=0).max())
    is_beside = other[:, 2].min() >= seen[:, 2].max() - flat or other[:, 2].max() <= seen[:, 2].min() + flat
    area, other_area = (shapely.convex_hull(shapely.MultiPoint(points[:, :2])) for points in (seen, other))
    if not is_beside or area.area < _SHEET_RATIO * other_area.area or not area.contains(other_area):
        return None
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(area))
    width, length = sorted(np.linalg.norm(np.diff(corners[:3], axis=0), axis=1).tolist())
    return length, width


def write_glb(surface: Surface, colors: Sequence[Color], path: Path) -> Path:
    """Write a surface, y up; without normals, so that points are not duplicated at edges.

    Args:
        surface: the surface.
        colors: colors of its materials.
        path: the file.
    """
    import trimesh  # noqa: PLC0415  # takes longer to import than most commands take
    from trimesh.visual import TextureVisuals  # noqa: PLC0415
    from trimesh.visual.material import PBRMaterial  # noqa: PLC0415

    scene: Any = trimesh.Scene()
    for number in np.unique(surface.material).tolist():
        part = surface.part(surface.material == number)
        material = PBRMaterial(
            name=f"material-{number}",
            baseColorFactor=[round(255 * channel) for channel in colors[number]],
            metallicFactor=0.0,
            roughnessFactor=0.8,
            doubleSided=True,
        )
        visual = TextureVisuals(material=material)
        mesh = trimesh.Trimesh(part.points, part.triangles, visual=visual, process=False)
        scene.add_geometry(mesh, geom_name=f"part-{number}", node_name=f"part-{number}")
    content = scene.export(file_type="glb")
    write_bytes(path, content)
    return path


def _parts(path: Path, kind: str) -> list[MeshPart]:
    """The parts of a file that have faces.

    Raises:
        FacadeError: If it is broken, too large, or has no faces.
    """
    try:
        neighbours = NeighbourFiles(Path(), path.parent, _MOST_BYTES)
        parts = read_parts(read_bounded(path, _MOST_BYTES), kind, neighbours, _MOST_TRIANGLES)
    except AssetError as error:
        raise FacadeError(f"{path.name} cannot be read: {error}") from error
    with_faces = [part for part in parts if len(part.counts)]
    if not with_faces:
        raise FacadeError(f"{path.name} holds no faces.")
    return with_faces


def _once(surface: Surface) -> Surface:
    """The surface without triangles that are there twice in one direction; in both, if all have a side for each."""
    sets, group = np.unique(np.sort(surface.triangles, axis=1), axis=0, return_inverse=True)
    key = 2 * group.ravel() + turns(surface.triangles)
    kinds, first = np.unique(key, return_index=True)
    if len(kinds) == 2 * len(sets):
        first = np.minimum(first[::2], first[1::2])
    is_first = np.zeros(len(surface), dtype=bool)
    is_first[first] = True
    return surface.part(is_first)
