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

from grammarlab.arrays import Floats, Ints, connected, rows_of_groups
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
_SHEET_GAP_M = 0.25
"""Least distance of a backdrop from the rest, metres: what is nearer, such as frames of windows, is on a wall."""
_LEVEL = 0.9
"""Least cosine of the angle between the normal of a ground plane and the up axis; terrain may be inclined a little."""
_MOST_SHEETS = 6
"""Largest number of sheets that are compared with all points, the largest ones: one per side of a box around them."""
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


def without_sheets(mesh: ExampleMesh, up: Floats) -> tuple[ExampleMesh, tuple[str, ...]]:
    """A building without ground planes and backdrops, and a note about each.

    Such a sheet is flat, touches nothing, has all else on one side of it, and reaches beyond all of that on all sides,
    over at least twice its area. A ground plane is level and below all else; a backdrop is at a distance from all else,
    since a sheet that other parts lie on is a wall.

    Args:
        mesh: the building.
        up: [3] up axis, of length 1, in the coordinates of the mesh.
    """
    surface = mesh.surface
    corners = surface.triangles
    of_point = connected(len(surface.points), corners[:, :2].ravel(), corners[:, 1:].ravel())
    pieces = _flat_pieces(surface.points, of_point)
    sheets = _sheets(pieces, surface.points[~np.isin(of_point, list(pieces))], up)
    if sheets:
        # Walls may be flat pieces as well: a blank one is a sheet beside windows, but not beside the other walls.
        others = surface.points[~np.isin(of_point, list(sheets))]
        sheets = _sheets({piece: pieces[piece] for piece in sheets}, others, up)
    if not sheets:
        return mesh, ()
    is_sheet = np.isin(of_point[corners[:, 0]], list(sheets))
    notes = [
        f"a flat sheet of {length:.3g} x {width:.3g} m, such as a ground plane, is left out"
        for length, width in sheets.values()
    ]
    return replace(mesh, surface=surface.part(~is_sheet), patches=mesh.patches[:, ~is_sheet]), tuple(notes)


@dataclass(frozen=True, eq=False, slots=True)
class _FlatPiece:
    """A connected flat part of a surface."""

    rows: Ints
    """[P] its points."""
    axes: Floats
    """[3, 3] its axes, the normal last."""
    seen: Floats
    """[P, 3] its points along its axes, metres."""


def _flat_pieces(points: Floats, of_point: Ints) -> dict[int, _FlatPiece]:
    """The large flat pieces by number, the largest first, from the points and the number of the piece of each."""
    num = int(of_point.max()) + 1
    low, high = np.full((num, 3), np.inf), np.full((num, 3), -np.inf)
    np.minimum.at(low, of_point, points)
    np.maximum.at(high, of_point, points)
    extent = np.linalg.norm(high - low, axis=1)
    is_large = extent >= _SHEET_EXTENT * float(np.linalg.norm(np.ptp(points, axis=0)))
    rows = rows_of_groups(of_point, num) if is_large.any() else []
    pieces = {}
    for piece in sorted(np.flatnonzero(is_large).tolist(), key=lambda piece: -extent[piece]):
        axes = _flat_axes(points[rows[piece]])
        if axes is not None:
            pieces[piece] = _FlatPiece(rows[piece], axes, points[rows[piece]] @ axes.T)
    return pieces


def _flat_axes(points: Floats) -> Floats | None:
    """[3, 3] axes of a flat piece, the normal last; None for points [P, 3] that are not flat."""
    if len(points) < 3:
        return None
    _, spread, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    flat = _FLAT * float(spread[0])
    return axes if spread[2] <= flat < spread[1] else None


def _sheets(pieces: dict[int, _FlatPiece], rest: Floats, up: Floats) -> dict[int, tuple[float, float]]:
    """Length and width, metres, of those flat pieces that are ground planes or backdrops of the rest [Q, 3]."""
    if not len(rest) or not pieces:
        return {}
    # Few points say of most pieces that they do not reach beyond the rest.
    extremes = rest[np.concatenate([rest.argmin(axis=0), rest.argmax(axis=0)])]
    candidates = [number for number, piece in pieces.items() if _is_beyond(piece, extremes @ piece.axes.T, up)]
    sheets = {}
    for number in candidates[:_MOST_SHEETS]:
        piece = pieces[number]
        other = rest @ piece.axes.T
        if _is_beyond(piece, other, up) and (size := _size_around(piece.seen[:, :2], other[:, :2])) is not None:
            sheets[number] = size
    return sheets


def _is_beyond(piece: _FlatPiece, other: Floats, up: Floats) -> bool:
    """Whether other points [Q, 3], along its axes, are on the side, at the distance and in the bounds of a sheet."""
    seen = piece.seen
    before, behind = float(other[:, 2].min() - seen[:, 2].max()), float(seen[:, 2].min() - other[:, 2].max())
    flat = _FLAT * float(np.ptp(seen, axis=0).max())
    rise = float(piece.axes[2] @ up)
    if abs(rise) >= _LEVEL:
        gap, least = before if rise > 0.0 else behind, -flat
    else:
        gap, least = max(before, behind), max(flat, _SHEET_GAP_M)
    if gap < least:
        return False
    low, high = other[:, :2].min(axis=0), other[:, :2].max(axis=0)
    return bool((seen[:, :2].min(axis=0) <= low).all() and (high <= seen[:, :2].max(axis=0)).all())


def _size_around(sheet: Floats, rest: Floats) -> tuple[float, float] | None:
    """Length and width of a sheet [P, 2] that contains the rest [Q, 2] and has at least twice its area, or None."""
    area, rest_area = (shapely.convex_hull(shapely.MultiPoint(points)) for points in (sheet, rest))
    if area.area < _SHEET_RATIO * rest_area.area or not area.contains(rest_area):
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
