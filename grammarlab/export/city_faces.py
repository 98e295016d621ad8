"""Faces of a scene as surfaces of CityJSON: level of detail 3."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints, row_of_value
from grammarlab.export.city_surfaces import (
    MILLIMETRES,
    CityGeometry,
    SurfaceKind,
    distinct_points,
    to_grid,
    with_ground,
)
from grammarlab.export.surface_labels import GROUND, ROOF, UNLABELLED, WALL, WINDOW, SurfaceLabels
from grammarlab.geometry.meshes.measure import corner_edges, face_areas, face_normals
from grammarlab.geometry.meshes.mesh import Meshes, Soup
from grammarlab.geometry.meshes.ragged import distinct_keys, max_rows, sum_rows
from grammarlab.geometry.meshes.triangulate import triangulate
from grammarlab.geometry.meshes.vectors import apply, dot, norm
from grammarlab.scene import Scene

_FLAT = 0.005
"""Largest distance in metres of corners from the plane of their face; validators allow 0.01."""
_NARROW = 0.001
"""Smallest width in metres of a face on a grid of millimetres."""
STEEP = math.cos(math.radians(75.0))
"""Smallest upward part of the normal of a roof: a slope of 75 degrees, so that a mansard is one."""
_BASE = 0.3
"""Largest height in metres of a face of the ground above the bottom of the building."""
_FLOOR_SHARE = 0.8
"""Smallest share of the outline that faces of the ground cover in a model with a floor; boxes of walls have bottoms."""
ROOF_HEIGHT = 2.0
"""Smallest height in metres of a roof above the bottom of the building."""
_FLAT_LYING = 0.95
"""Smallest vertical part of the normal of a face that lies flat."""
_LARGEST_SILL = 4.0
"""Largest area in square metres of a face of a window or door that lies flat; larger ones are floors and roofs."""
_SLANT = 0.2
"""Smallest horizontal part of the normal of a face that has a direction on the map."""
_NUM_STEPS = 24
"""Number of directions of walls, counted from that of the largest one: faces of one direction are one wall."""
_STEP = 2 * math.pi / _NUM_STEPS


@dataclass(frozen=True, slots=True, eq=False)
class CityFaces:
    """Planar faces of a building on a grid of millimetres."""

    points: Ints
    """[V, 3] millimetres to the east, to the north and up from the origin of the frame."""
    faces: Soup
    """F faces over `points`; their meshes are the instances of the scene."""
    normal: Floats
    """[F, 3] unit normals to the east, to the north and up."""
    area: Floats
    """[F] square metres."""

    def __len__(self) -> int:
        return len(self.faces)

    def select(self, chosen: Flags) -> CityFaces:
        """Faces that are chosen [F]."""
        return CityFaces(self.points, self.faces.where(chosen), self.normal[chosen], self.area[chosen])

    def lowest(self) -> Floats:
        """[F] height of the lowest corner in metres."""
        return -max_rows(-self.points[self.faces.rows, 2] / MILLIMETRES, self.faces.offsets, 0.0)

    def on_the_map(self) -> NDArray[np.object_]:
        """[F] valid polygons in metres to the east and to the north."""
        corners = self.points[self.faces.rows, :2] / MILLIMETRES
        rings = shapely.linearrings(corners, indices=row_of_value(np.diff(self.faces.offsets)))
        polygons = np.asarray(shapely.polygons(np.asarray(rings, dtype=object)), dtype=object)
        # On the grid, the sides of a steep or narrow face may cross by a millimetre.
        crossed = ~shapely.is_valid(polygons)
        polygons[crossed] = shapely.buffer(polygons[crossed], 0.0)
        return polygons


@dataclass(frozen=True, slots=True)
class SurfaceBase:
    """Heights in metres that decide what is ground and what is a roof."""

    ground: float
    """Bottom of the floors: roofs are above it."""
    bottom: float
    """Bottom of the building, at most `ground`: below a plinth."""


def city_faces(scene: Scene, corner: Floats) -> CityFaces:
    """The faces of a scene of one model.

    Faces that are not planar, or have holes, are divided into triangles; those thinner than a millimetre are left out.

    Args:
        scene: I instances.
        corner: [3] where the positions of the scene count from: x, y and z from the frame's origin, in metres.
    """
    meshes = scene.meshes.take(scene.mesh)
    instance = meshes.mesh_of_point()
    placed = apply(scene.frames[scene.frame[instance]], scene.size[instance] * meshes.points)
    x, y, z = (placed + scene.position[instance] + corner).T
    points, row = distinct_points(to_grid(np.column_stack([x, -z, y])))
    soup = Soup.of_faces(meshes, np.arange(meshes.num_faces))
    faces = _divided(points, replace(soup, rows=row[soup.rows]).without_repeats())
    mesh = _as_mesh(points, faces)
    return CityFaces(points, faces, face_normals(mesh), face_areas(mesh))


def surfaces_of(
    faces: CityFaces, scene: Scene, labels: SurfaceLabels, outline: shapely.Polygon, base: SurfaceBase
) -> CityGeometry | None:
    """The faces with their kinds, and the outline as their ground if the model has no floor.

    Args:
        faces: faces of the scene.
        scene: I instances.
        labels: kinds of the I instances.
        outline: outline of the building in metres from the frame's origin.
        base: heights of the building.

    Returns:
        The surfaces; None if there is no face.
    """
    if len(faces) == 0:
        return None
    kind = _kinds(faces, labels, base)
    has_floor = faces.area[kind == GROUND].sum() >= _FLOOR_SHARE * outline.area
    if not has_floor:
        kind[kind == GROUND] = WALL
    kinds, number = _semantic_surfaces(faces, kind, labels.opening[faces.faces.mesh], _directions(faces, scene))
    rows, ends = faces.faces.rows.tolist(), faces.faces.offsets.tolist()
    surfaces = CityGeometry(
        shape="MultiSurface",
        points=faces.points,
        surfaces=[[rows[start:end]] for start, end in pairwise(ends)],
        kinds=kinds,
        kind=number.tolist(),
    )
    return surfaces if has_floor else with_ground(surfaces, outline, base.bottom)


def _divided(points: Ints, faces: Soup) -> Soup:
    """The faces; those that are not planar, or pass a point twice, as triangles; without the thin ones."""
    irregular = _passes_twice(faces) | ~_is_planar(points, faces) | _crosses(points, faces)
    parts = faces.take(np.flatnonzero(irregular))
    triangles, face = triangulate(_as_mesh(points, parts))
    pieces = Soup(
        triangles.ravel(), 3 * np.arange(len(face) + 1), parts.mesh[face], parts.rank[face], parts.tags[face]
    ).without_repeats()
    whole = Soup.concatenate([faces.take(np.flatnonzero(~irregular)), pieces])
    ordered = whole.take(np.argsort(whole.rank, kind="stable"))
    return ordered.where(~_is_thin(points, ordered))


def _passes_twice(faces: Soup) -> Flags:
    """[F] whether a face has a point twice, as at the doubled edge of a hole."""
    face = row_of_value(np.diff(faces.offsets))
    order = np.lexsort((faces.rows, face))
    again = (np.diff(faces.rows[order]) == 0) & (np.diff(face[order]) == 0)
    return np.bincount(face[order][1:][again], minlength=len(faces)) > 0


def _crosses(points: Ints, faces: Soup) -> Flags:
    """[F] whether the outline of a face crosses itself; triangles and rectangles are not looked at."""
    counts = np.diff(faces.offsets)
    many = np.flatnonzero(counts > 4)
    chosen = faces.take(many)
    normal = np.abs(face_normals(_as_mesh(points, chosen)))
    # Seen along the axis that is nearest to the normal.
    axes = np.array([[1, 2], [0, 2], [0, 1]])[np.argmax(normal, axis=1)]
    face = row_of_value(np.diff(chosen.offsets))
    corners = np.take_along_axis(points[chosen.rows], axes[face], axis=1).astype(np.float64)
    rings = np.asarray(shapely.linearrings(corners, indices=face), dtype=object)
    crosses = np.zeros(len(faces), dtype=np.bool_)
    crosses[many] = ~shapely.is_simple(rings)
    return crosses


def _is_planar(points: Ints, faces: Soup) -> Flags:
    """[F] whether all corners are in one plane."""
    face = row_of_value(np.diff(faces.offsets))
    first = points[faces.rows[faces.offsets[:-1]]][face]
    height = np.abs(dot((points[faces.rows] - first) / MILLIMETRES, face_normals(_as_mesh(points, faces))[face]))
    return max_rows(height, faces.offsets, 0.0) <= _FLAT


def _is_thin(points: Ints, faces: Soup) -> Flags:
    """[F] whether faces are narrower than `_NARROW`."""
    meshes = _as_mesh(points, faces)
    longest = max_rows(norm(corner_edges(meshes)), faces.offsets, 0.0)
    return face_areas(meshes) <= _NARROW * longest


def _as_mesh(points: Ints, faces: Soup) -> Meshes:
    """The faces as one mesh in metres, z up."""
    return faces.as_one_mesh(points / MILLIMETRES)


def _kinds(faces: CityFaces, labels: SurfaceLabels, base: SurfaceBase) -> NDArray[np.int8]:
    """[F] kind of each face: that of its instance, else by direction and height."""
    height = faces.points[faces.faces.rows, 2] / MILLIMETRES - base.ground
    mean = sum_rows(height, faces.faces.offsets) / np.diff(faces.faces.offsets)
    up = faces.normal[:, 2]
    is_ground = (up < -STEEP) & (mean < base.bottom - base.ground + _BASE)
    is_roof = (up > STEEP) & (mean > ROOF_HEIGHT)
    label = labels.kind[faces.faces.mesh]
    is_slab = (label >= WINDOW) & (np.abs(up) > _FLAT_LYING) & (faces.area > _LARGEST_SILL)
    return np.where(
        (label == UNLABELLED) | is_slab, np.select([is_ground, is_roof], [GROUND, ROOF], WALL), label
    ).astype(np.int8)


def _directions(faces: CityFaces, scene: Scene) -> Floats:
    """[F] direction of each face on the map in radians; of faces that lie flat, that of the front of their scope."""
    east, north, _ = faces.normal.T
    front = scene.frames[scene.frame[faces.faces.mesh], :, 2]
    lies = np.hypot(east, north) < _SLANT
    return np.arctan2(np.where(lies, -front[:, 2], north), np.where(lies, front[:, 0], east))


def _semantic_surfaces(
    faces: CityFaces, kind: NDArray[np.int8], opening: NDArray[np.int32], direction: Floats
) -> tuple[list[SurfaceKind], Ints]:
    """The different semantic surfaces: ground, roof, walls by direction, openings; and the number of each face [F]."""
    walls = np.flatnonzero(kind == WALL)
    main = direction[walls[np.argmax(faces.area[walls])]] if len(walls) else 0.0
    step = np.rint((direction - main) / _STEP).astype(np.int64) % _NUM_STEPS
    _, which = np.unique(opening, return_inverse=True)
    part = np.select([kind == WALL, kind >= WINDOW], [step, which], 0)
    first, number = distinct_keys(kind * (part.max() + 1) + part)
    parents = _parents(kind[first], faces.normal[_largest(number, faces.area)])
    return [SurfaceKind(*pair) for pair in zip(kind[first].tolist(), parents, strict=True)], number


def _parents(kind: NDArray[np.int8], normal: Floats) -> list[int | None]:
    """[K] the wall or roof of each opening: the one whose normal [K, 3] is nearest; None for all others."""
    carriers = np.flatnonzero((kind == WALL) | (kind == ROOF))
    if len(carriers) == 0:
        return [None] * len(kind)
    nearest = carriers[np.argmax(normal @ normal[carriers].T, axis=1)].tolist()
    return [parent if opens else None for parent, opens in zip(nearest, (kind >= WINDOW).tolist(), strict=True)]


def _largest(group: Ints, area: Floats) -> Ints:
    """[G] the row with the largest area of each group; of equal ones the first."""
    order = np.lexsort((np.arange(len(area)), -area, group))
    return order[np.flatnonzero(np.diff(group[order], prepend=-1))]
