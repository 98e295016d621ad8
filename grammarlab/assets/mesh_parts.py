"""Parts of a mesh from a file, in the coordinates of the file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, offsets_from_counts, row_lengths, row_of_value
from grammarlab.errors import AssetError
from grammarlab.geometry.meshes.corner_data import CornerData, join_data
from grammarlab.geometry.meshes.measure import DEGENERATE, face_normals, is_convex
from grammarlab.geometry.meshes.mesh import Meshes, Soup
from grammarlab.geometry.meshes.ragged import all_rows, next_in_row, sum_rows
from grammarlab.geometry.meshes.triangulate import triangulate
from grammarlab.geometry.meshes.vectors import cross, dot, norm

Indices: TypeAlias = NDArray[np.int64]
Color: TypeAlias = tuple[float, float, float, float]
"""Red, green, blue and opacity, 0 to 1."""
Neighbours: TypeAlias = Callable[[str], bytes]
"""Function from a name in a file to the content of the file with this name; it raises AssetError."""

FARTHEST = 1e12
"""Largest coordinate that is read, in the units of the file: squares and cubes of larger ones lose their digits."""
MOST_MATERIALS = 1_000
"""Largest number of different materials of one file: each costs a pass over the faces, and a look for its image."""
MOST_WORK = 10**9
"""Bound on the sum of squared numbers of corners of concave faces, to which the time of ear clipping is proportional
at worst."""


@dataclass(frozen=True, slots=True)
class PartMaterial:
    """Material of a part, in the units of its file: colors are sRGB in OBJ, linear light in glTF."""

    color: Color
    texture: str = ""
    """Image in the words of the file: a path, or ``#image3`` for an image inside a glTF file; empty for none."""
    metallic: float = 0.0
    roughness: float = 0.8
    emissive: tuple[float, float, float] = (0.0, 0.0, 0.0)
    is_cut_out: bool = False
    """Whether transparent parts of the image are holes."""


@dataclass(frozen=True, slots=True)
class MeshPart:
    """Faces of one material, or points without faces."""

    points: Floats
    """[P, 3] points; each is a corner of a face if there are faces."""
    corners: Indices
    """[C] rows of `points`: the corners of the faces, one face after the other; C is 0 for a scan."""
    counts: Indices
    """[F] number of corners of each face, at least 3."""
    material: PartMaterial | None = None
    """None if the file has none."""
    normals: Floats | None = None
    """[C, 3] normal of each corner, of any length; NaN or zero for none."""
    coordinates: tuple[Floats, ...] = ()
    """For each uv set, [C, 2] u and v (upwards) of each corner, NaN for none; the first is that of the texture."""

    def __post_init__(self) -> None:
        """Refuse points and faces that no program can use.

        Raises:
            AssetError: If a coordinate is not finite or too large, or a face has a corner that does not exist.
        """
        if self.points.ndim != 2 or self.points.shape[1] != 3:
            raise AssetError("it has points without three coordinates")
        if not np.isfinite(self.points).all():
            raise AssetError("it has points that are not finite numbers")
        if not (np.abs(self.points) <= FARTHEST).all():
            raise AssetError(f"it has coordinates larger than {FARTHEST:g}")
        if self.corners.size and not 0 <= self.corners.min() <= self.corners.max() < len(self.points):
            raise AssetError("it has faces with corners that do not exist")

    @classmethod
    def of_faces(
        cls,
        points: Floats,
        corners: Indices,
        counts: Indices,
        material: PartMaterial | None = None,
        normals: Floats | None = None,
        coordinates: tuple[Floats, ...] = (),
    ) -> MeshPart:
        """Faces with their own corners among points [P, 3] that other parts may use.

        Raises:
            AssetError: If a face has a corner that does not exist.
        """
        used, rows = np.unique(corners, return_inverse=True)
        if len(used) and not 0 <= used[0] <= used[-1] < len(points):
            raise AssetError(f"it has {len(points):,} points, and faces with corners that do not exist")
        return cls(points[used], rows.ravel().astype(np.int64), counts, material, normals, coordinates)

    @classmethod
    def of_triangles(cls, points: Floats, triangles: Indices) -> MeshPart:
        """Triangles [T, 3] with their own corners among points [P, 3] that other parts may use.

        Raises:
            AssetError: If a triangle has a corner that does not exist.
        """
        return cls.of_faces(points, triangles.ravel(), np.full(len(triangles), 3))

    @classmethod
    def of_points(cls, points: Floats) -> MeshPart:
        """Points [P, 3] without faces."""
        return cls(points, np.zeros(0, np.int64), np.zeros(0, np.int64))

    @property
    def color(self) -> Color | None:
        """Main color of its material; None if the file has none."""
        return None if self.material is None else self.material.color

    @property
    def num_triangles(self) -> int:
        """Number of triangles that cover the faces."""
        return len(self.corners) - 2 * len(self.counts)

    @property
    def triangles(self) -> Indices:
        """[T, 3] rows of `points`: triangles that cover the faces, computed anew each time.

        The second triangle of a quadrilateral begins with its third corner, as in common readers of OBJ.
        """
        if (self.counts == 3).all():
            return self.corners.reshape(-1, 3)
        meshes = self._unshared()
        triangles, face = triangulate(meshes)
        halves = np.flatnonzero((self.counts[face] == 4) & (np.append(-1, face[:-1]) == face))
        fans = halves[triangles[halves, 0] == meshes.face_offsets[face[halves]]]
        triangles[fans] = np.roll(triangles[fans], -1, axis=1)
        return self.corners[triangles]

    def require_simple(self) -> None:
        """Refuse concave faces of so many corners that they cannot be cut into triangles in reasonable time.

        Raises:
            AssetError: If there are such faces.
        """
        if (self.counts**2).sum() <= MOST_WORK:
            return
        concave = self.counts[~is_convex(self._unshared())]
        if (concave**2).sum() > MOST_WORK:
            raise AssetError(
                f"its concave faces have too many corners (up to {concave.max():,} each); triangulate it first"
            )

    def _unshared(self) -> Meshes:
        """Each face as a mesh, near the origin: products of national coordinates leave no digits for centimetres."""
        return Meshes.from_polygons((self.points - self.points.mean(axis=0))[self.corners], self.counts)


def require_few_materials(count: int) -> None:
    """Refuse a file with too many different materials.

    Raises:
        AssetError: If there are more than `MOST_MATERIALS`.
    """
    if count > MOST_MATERIALS:
        raise AssetError(f"it has {count:,} different materials; at most {MOST_MATERIALS:,} are read")


def joined(parts: Sequence[MeshPart]) -> tuple[Floats, Indices]:
    """The points [P, 3] of all parts one after the other, and their triangles [T, 3] as rows of these points.

    >>> corner = MeshPart.of_triangles(np.eye(3), np.array([[0, 1, 2]]))
    >>> joined([corner, corner])[1].tolist()
    [[0, 1, 2], [3, 4, 5]]
    """
    firsts = _firsts(parts)
    triangles = [part.triangles + first for part, first in zip(parts, firsts, strict=False)]
    return _all_points(parts), np.concatenate([np.zeros((0, 3), np.int64), *triangles])


def as_one_mesh(parts: Sequence[MeshPart]) -> Meshes:
    """The faces of all parts, as polygons of one mesh; its slots number the different materials of the parts."""
    points = _all_points(parts)
    corners = [part.corners + first for part, first in zip(parts, _firsts(parts), strict=False)]
    counts = np.concatenate([np.zeros(0, np.int64), *(part.counts for part in parts)])
    every_corner = np.concatenate([np.zeros(0, np.int64), *corners])
    slots = {material: number for number, material in enumerate(dict.fromkeys(part.material for part in parts))}
    data = join_data([(_data_of(part, slots[part.material]), len(part.corners), len(part.counts)) for part in parts])
    return Meshes(
        points=points,
        corners=every_corner,
        face_offsets=offsets_from_counts(counts),
        mesh_faces=np.array([0, len(counts)]),
        mesh_points=np.array([0, len(points)]),
        tags=np.zeros(len(counts), np.int8),
        data=data,
    )


def _data_of(part: MeshPart, slot: int) -> CornerData | None:
    """Values of the corners of a part and the number of its material; None if it has none and the first material."""
    if part.normals is None and not part.coordinates and slot == 0:
        return None
    normals = np.full((len(part.corners), 3), np.nan) if part.normals is None else part.normals
    length = np.sqrt((normals**2).sum(axis=1))
    known = (length > 0.0) & np.isfinite(length)
    normals = np.where(known[:, None], normals, np.nan) / np.where(known, length, 1.0)[:, None]
    values = np.concatenate([normals, *part.coordinates], axis=1)
    return CornerData(values, np.full(len(part.counts), slot, np.int32))


def _firsts(parts: Sequence[MeshPart]) -> list[int]:
    """Number of points before each part."""
    return np.cumsum([0, *(len(part.points) for part in parts)]).tolist()


def _all_points(parts: Sequence[MeshPart]) -> Floats:
    return np.concatenate([np.zeros((0, 3)), *(part.points for part in parts)])


def color_of(channels: object) -> Color | None:
    """A color from 3 or 4 numbers, in steps of 1/255 as images have; None for other values."""
    try:
        values = np.array(channels, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    if values.shape not in {(3,), (4,)} or not np.isfinite(values).all():
        return None
    red, green, blue, opacity = (np.round(np.round(255.0 * np.clip([*values, 1.0][:4], 0.0, 1.0)) / 255.0, 4)).tolist()
    return red, green, blue, opacity


def welded(mesh: Meshes) -> Meshes:
    """One mesh whose faces share points of equal position, without faces that then have a corner twice.

    Files that keep one normal for each point have several points at the edges of flat faces.
    """
    order = np.lexsort(mesh.points.T)
    is_new = np.append(True, (np.diff(mesh.points[order], axis=0) != 0.0).any(axis=1))
    first = np.empty(len(order), np.int64)
    first[order] = order[is_new][np.cumsum(is_new) - 1]
    used, corners = np.unique(first[mesh.corners], return_inverse=True)
    ends = np.array([0, len(used)])
    shared = Meshes(
        points=mesh.points[used],
        corners=corners,
        face_offsets=mesh.face_offsets,
        mesh_faces=mesh.mesh_faces,
        mesh_points=ends,
        tags=mesh.tags,
        data=mesh.data,
    )
    faces = Soup.of_faces(shared, np.arange(shared.num_faces))
    differs = sum_rows(faces.rows == faces.rows[next_in_row(faces.offsets)], faces.offsets) == 0
    if not differs.any():
        return mesh
    return faces.where(differs).meshes(shared.points, np.zeros(len(used), np.int64), 1)


def without_flat_faces(mesh: Meshes) -> Meshes:
    """One mesh without the faces whose corners lie on a line, as CityEngine reads it; the same if no others exist."""
    # A bow tie has no normal either, since its halves cancel.
    flat = np.flatnonzero(~face_normals(mesh).any(axis=1))
    flat = flat[_lie_on_lines(mesh.points, Soup.of_faces(mesh, flat))]
    if len(flat) in {0, mesh.num_faces}:
        return mesh
    faces = Soup.of_faces(mesh, np.delete(np.arange(mesh.num_faces), flat))
    return faces.meshes(mesh.points, np.zeros(len(mesh.points), np.int64), 1)


def _lie_on_lines(points: Floats, faces: Soup) -> NDArray[np.bool_]:
    """[F] whether all corners of a face lie on a line, up to `DEGENERATE` of their distance from the first one."""
    face = row_of_value(row_lengths(faces.offsets))
    offset = points[faces.rows] - points[faces.rows[faces.offsets[:-1]]][face]
    reach = dot(offset, offset)
    farthest = offset[np.lexsort((reach, face))[faces.offsets[1:] - 1]]
    aside = norm(cross(offset, farthest[face]))
    return all_rows(aside <= DEGENERATE * dot(farthest, farthest)[face], faces.offsets)
