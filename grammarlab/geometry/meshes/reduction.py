"""Meshes with fewer points and nearly the same surface: CGA's ``reduceGeometry``.

Edges collapse to one of their ends, those first that move the surface least: by the sum of squared distances from the
planes of the faces around (Garland and Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997).
A plane at right angles to the surface holds each edge of one face or between two materials in place.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import ROUNDING, Floats, offsets_from_counts
from grammarlab.geometry.meshes.cleanup import SAME_POINT, merged_points
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.mesh import UNTAGGED, Indices, Meshes, Soup
from grammarlab.geometry.meshes.triangulate import triangulate
from grammarlab.geometry.meshes.vectors import cross, dot, norm, unit

MOST_TRIANGLES = 100_000
"""Budget: larger meshes stay as they are, since a collapse takes about 0.4 ms."""
_LEAST_COSINE = 0.1
"""Tolerance: cosine of the largest angle, 84 degrees, by which a triangle turns in one collapse. From 90 degrees on the
surface folds over; the margin leaves out triangles that stand on edge, whose next collapse would fold them."""
_QUAD = 4
"""Corners of a face that stays whole if it is alone, as rectangles do that no rule reads tags of."""
_FLAT = 1e-18
"""Tolerance: cost below which a collapse moves nothing in a mesh of size 1, the fourth power of a length."""

_Quadric = tuple[float, float, float, float, float, float, float, float, float, float]
"""Upper half of the symmetric 4 x 4 matrix of a sum of squared distances, row by row."""
_Vector = tuple[float, float, float]


def reduced(mesh: Meshes, share: float) -> Meshes:
    """A mesh with a smaller number of points; faces around a point that is gone are triangles.

    Tags and normals are gone. Texture coordinates are those of the remaining end of an edge, and materials stay.

    Args:
        mesh: a single mesh of at most `MOST_TRIANGLES` triangles, points in metres.
        share: 0..1, the share of its points that goes; fewer, if no more can go without folds.
    """
    extent = float(np.ptp(mesh.points, axis=0).max(initial=0.0))
    if extent == 0.0 or (mesh.num_faces == 1 and len(mesh.corners) == _QUAD):
        return _plain(mesh)
    # A power of two, so that a scaled mesh is rounded as the mesh is.
    points = np.ldexp(mesh.points, -int(np.frexp(extent)[1]))
    faces = Soup.of_faces(mesh, np.arange(mesh.num_faces))
    faces = replace(faces, rows=merged_points(points, SAME_POINT / max(1.0, extent))[faces.rows]).without_repeats()
    count = _num_removed(len(np.unique(faces.rows)), share)
    if count == 0:
        return _plain(mesh)
    corners, face = _triangles(faces, points)
    collapse = _Collapse.of(faces, points, corners, face)
    collapse.run(count)
    return _rebuilt(faces, collapse, face).meshes(mesh.points, np.zeros(len(mesh.points), np.int64), 1)


def _plain(mesh: Meshes) -> Meshes:
    """The same mesh without tags and normals; the mesh itself if it has none."""
    has_normals = mesh.data is not None and not np.isnan(mesh.data.values[:, :3]).all()
    if not has_normals and (mesh.tags == UNTAGGED).all():
        return mesh
    data = mesh.data and mesh.data.without_normals()
    return replace(mesh, tags=np.full_like(mesh.tags, UNTAGGED), data=data)


def _num_removed(num_points: int, share: float) -> int:
    """Number of points that go: those beyond the whole number that may stay; none for less than half a point."""
    if num_points * share < 0.5:
        return 0
    return num_points - int(num_points * (1.0 - min(share, 1.0)) + ROUNDING)


def _triangles(faces: Soup, points: Floats) -> tuple[Indices, Indices]:
    """Corners [T, 3] of the triangles of faces, and the face [T] of each."""
    count = len(faces.rows)
    own = replace(faces.as_one_mesh(points[faces.rows]), corners=np.arange(count), mesh_points=np.array([0, count]))
    return triangulate(own)


@dataclass(slots=True)
class _Collapse:
    """Triangles whose edges collapse."""

    points: list[_Vector]
    triangles: list[list[int]]
    """Points of each triangle; empty for one that is gone."""
    values: list[list[int]]
    """Number of the corner whose values each corner has."""
    same: list[int]
    """The first corner of equal values, for every corner."""
    around: dict[int, set[int]]
    """The triangles at each point."""
    quadrics: dict[int, _Quadric]
    touched: set[int] = field(default_factory=set[int])
    """Triangles that are not as they were."""

    @classmethod
    def of(cls, faces: Soup, points: Floats, corners: Indices, face: Indices) -> _Collapse:
        """Triangles with given corners before the first collapse; points are in a mesh of size 1."""
        rows = faces.rows[corners]
        triangles: list[list[int]] = rows.tolist()
        around: dict[int, set[int]] = {}
        for number, triangle in enumerate(triangles):
            for point in triangle:
                around.setdefault(point, set()).add(number)
        slots = np.zeros(len(faces), np.int32) if faces.data is None else faces.data.slots
        return cls(
            points=[(x, y, z) for x, y, z in points.tolist()],
            triangles=triangles,
            values=corners.tolist(),
            same=_equal_values(faces),
            around=around,
            quadrics=_quadrics(rows, points, slots[face]),
        )

    def run(self, count: int) -> None:
        """Collapse edges, the cheapest first, until this number of points is gone or no edge can collapse."""
        queue = [entry for edge in self._edges() for entry in self._entries(edge)]
        heapq.heapify(queue)
        while queue and count > 0:
            cost, length, gone, stays = heapq.heappop(queue)
            if gone not in self.around or stays not in self.around:
                continue
            if (cost, length) != self._cost(gone, stays) or not self._may(gone, stays):
                continue
            self._apply(gone, stays)
            count -= 1
            near = {point for number in self.around[stays] for point in self.triangles[number]} - {stays}
            for point in near:
                for entry in self._entries((stays, point)):
                    heapq.heappush(queue, entry)

    def _edges(self) -> set[tuple[int, int]]:
        pairs = (pair for triangle in self.triangles for pair in zip(triangle, _turned(triangle), strict=True))
        return {(min(pair), max(pair)) for pair in pairs}

    def _entries(self, edge: tuple[int, int]) -> Iterator[tuple[float, float, int, int]]:
        """Both directions in which an edge may collapse: cost, length, the point that goes and the one that stays."""
        for gone, stays in (edge, edge[::-1]):
            yield (*self._cost(gone, stays), gone, stays)

    def _cost(self, gone: int, stays: int) -> tuple[float, float]:
        place = self.points[stays]
        cost = _distance(self.quadrics[gone], place) + _distance(self.quadrics[stays], place)
        edge = _difference(self.points[gone], place)
        return cost if cost > _FLAT else 0.0, _product(edge, edge)

    def _may(self, gone: int, stays: int) -> bool:
        """Whether the surface stays as connected as it is, and no triangle turns over."""
        around, dying = self.around[gone], self.around[gone] & self.around[stays]
        if not dying or len(dying) > 2 or dying == around:
            return False
        of_gone, of_stays = (
            {point for number in self.around[end] for point in self.triangles[number]} for end in (gone, stays)
        )
        if len(of_gone & of_stays) - 2 != len(dying):
            return False
        if len(dying) == 2 and self._is_border(gone):
            return False
        return not any(self._turns(self.triangles[number], gone, stays) for number in around - dying)

    def _is_border(self, point: int) -> bool:
        counts: dict[int, int] = {}
        for number in self.around[point]:
            for other in self.triangles[number]:
                counts[other] = counts.get(other, 0) + 1
        return any(count == 1 for count in counts.values())

    def _turns(self, triangle: list[int], gone: int, stays: int) -> bool:
        old = _normal(*(self.points[point] for point in triangle))
        new = _normal(*(self.points[stays if point == gone else point] for point in triangle))
        lengths = (_product(old, old) * _product(new, new)) ** 0.5
        return not _product(old, new) > _LEAST_COSINE * lengths

    def _apply(self, gone: int, stays: int) -> None:
        dying = self.around[gone] & self.around[stays]
        successors: dict[int, int] = {}
        for number in sorted(dying):
            triangle, values = self.triangles[number], self.values[number]
            leaving, reached = values[triangle.index(gone)], values[triangle.index(stays)]
            successors.setdefault(self.same[leaving], reached)
        default = next(iter(successors.values()))
        for number in self.around.pop(gone):
            self.touched.add(number)
            triangle = self.triangles[number]
            if number in dying:
                for point in triangle:
                    self.around.get(point, set()).discard(number)
                self.triangles[number] = []
                continue
            corner = triangle.index(gone)
            self.values[number][corner] = successors.get(self.same[self.values[number][corner]], default)
            triangle[corner] = stays
            self.around[stays].add(number)
        a, b = self.quadrics.pop(gone), self.quadrics[stays]
        self.quadrics[stays] = _sum(a, b)


def _rebuilt(faces: Soup, collapse: _Collapse, face: Indices) -> Soup:
    """Untouched faces as they were, and the triangles of the others."""
    touched = np.zeros(len(faces), bool)
    touched[face[sorted(collapse.touched)]] = True
    rest = [k for k in np.flatnonzero(touched[face]).tolist() if collapse.triangles[k]]
    rows = np.array([point for k in rest for point in collapse.triangles[k]], dtype=np.int64)
    corners = np.array([corner for k in rest for corner in collapse.values[k]], dtype=np.int64)
    source = face[np.array(rest, dtype=np.int64)]
    data = None if faces.data is None else CornerData(faces.data.values[corners], faces.data.slots[source])
    new = Soup(
        rows,
        offsets_from_counts(np.full(len(rest), 3)),
        faces.mesh[source],
        faces.rank[source],
        faces.tags[source],
        data,
    )
    whole = Soup.concatenate([faces.where(~touched), new])
    tags = np.full(len(whole), UNTAGGED, whole.tags.dtype)
    return replace(whole, tags=tags, data=whole.data and whole.data.without_normals())


def _equal_values(faces: Soup) -> list[int]:
    """[C] the first corner with the same texture coordinates."""
    if faces.data is None:
        return [0] * len(faces.rows)
    values = np.nan_to_num(faces.data.values[:, 3:], nan=np.inf)
    _, first, number = np.unique(values, axis=0, return_index=True, return_inverse=True)
    return first[number.ravel()].tolist()


def _quadrics(rows: Indices, points: Floats, slots: NDArray[np.int32]) -> dict[int, _Quadric]:
    """For each point the squared distances from the planes of its triangles and of its open edges, by their areas."""
    a, b, c = (points[rows[:, corner]] for corner in range(3))
    normals = cross(b - a, c - a)
    matrices = np.zeros((len(points), 10))
    planes = _plane_quadrics(unit(normals), a, norm(normals))
    start, end = rows.ravel(), np.roll(rows, -1, axis=1).ravel()
    is_open = _is_open(start, end, np.repeat(slots, 3))
    along = points[end] - points[start]
    walls = _plane_quadrics(unit(cross(np.repeat(normals, 3, axis=0), along)), points[start], dot(along, along))
    np.add.at(matrices, start, np.repeat(planes, 3, axis=0))
    for point in (start, end):
        np.add.at(matrices, point[is_open], walls[is_open])
    return {int(point): _quadric(matrices[point].tolist()) for point in np.unique(rows)}


def _is_open(start: Indices, end: Indices, slots: NDArray[np.int32]) -> NDArray[np.bool_]:
    """[E] whether an edge has no second triangle, or one of another material."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, number, counts = np.unique(np.column_stack((low, high, slots)), axis=0, return_inverse=True, return_counts=True)
    return counts[number.ravel()] == 1


def _plane_quadrics(normals: Floats, on_plane: Floats, weights: Floats) -> Floats:
    """[N, 10] weighted squared distances from planes through points [N, 3]."""
    plane = np.column_stack((normals, -dot(normals, on_plane)))
    first, second = np.triu_indices(4)
    return plane[:, first] * plane[:, second] * weights[:, None]


def _quadric(row: Sequence[float]) -> _Quadric:
    xx, xy, xz, xw, yy, yz, yw, zz, zw, ww = row
    return xx, xy, xz, xw, yy, yz, yw, zz, zw, ww


def _sum(a: _Quadric, b: _Quadric) -> _Quadric:
    return _quadric([x + y for x, y in zip(a, b, strict=True)])


def _distance(quadric: _Quadric, point: _Vector) -> float:
    xx, xy, xz, xw, yy, yz, yw, zz, zw, ww = quadric
    x, y, z = point
    square = xx * x * x + yy * y * y + zz * z * z
    return square + ww + 2.0 * (xy * x * y + xz * x * z + yz * y * z + xw * x + yw * y + zw * z)


def _turned(triangle: list[int]) -> list[int]:
    return [*triangle[1:], triangle[0]]


def _difference(a: _Vector, b: _Vector) -> _Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _product(a: _Vector, b: _Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _normal(a: _Vector, b: _Vector, c: _Vector) -> _Vector:
    u, v = _difference(b, a), _difference(c, a)
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
