"""Closed meshes as solids: whether geometry lies inside them, overlaps or touches them; distances of boxes.

Distances up to 1 mm count as contact. Solids are those of manifold3d.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from manifold3d import CrossSection, Error, FillRule, Manifold, Mesh64
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.measure import areas, face_normals
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.triangulate import triangulate

CONTACT = 1e-3
"""Metres up to which faces touch, and solids do not overlap yet."""


def solid_of(mesh: Meshes) -> Manifold | None:
    """The solid of one mesh; None if its surface is not closed, has no volume, or its faces look inwards.

    Args:
        mesh: one mesh, points in metres; faces are counter-clockwise seen from outside.
    """
    triangles, _ = triangulate(mesh)
    if len(triangles) < 4:
        return None
    surface = Mesh64(vert_properties=np.ascontiguousarray(mesh.points), tri_verts=triangles.astype(np.uint64))
    surface.merge()
    solid = Manifold(surface)
    if solid.status() != Error.NoError or solid.is_empty() or not solid.volume() > 0.0:
        return None
    return solid


class Body:
    """One mesh, perhaps closed, that is compared with solids."""

    def __init__(self, mesh: Meshes) -> None:
        """Compare a mesh.

        Args:
            mesh: one mesh, points in metres in the axes of all other bodies.
        """
        self.mesh = mesh
        points = mesh.points if len(mesh.points) else np.zeros((1, 3))
        self.low: Floats = points.min(axis=0)
        """[3] lowest corner of its bounding box."""
        self.high: Floats = points.max(axis=0)
        """[3] highest corner of its bounding box."""

    @cached_property
    def solid(self) -> Manifold | None:
        """Its solid, if it is closed."""
        return solid_of(self.mesh)

    @cached_property
    def area(self) -> float:
        """Area of its faces in square metres."""
        return float(areas(self.mesh)[0])

    def is_inside(self, other: Body) -> bool:
        """Whether all of it lies in a solid or on its surface."""
        if other.solid is None or not self._boxes_meet(other):
            return False
        if self.solid is not None:
            return (self.solid - other.solid).volume() <= _skin(self.area)
        return all((face.section - (face.above(other) + face.below(other))).area() <= face.skin for face in self._faces)

    def overlaps(self, other: Body) -> bool:
        """Whether a part of it lies within a solid, not only on its surface."""
        if other.solid is None or not self._boxes_meet(other):
            return False
        if self.solid is not None:
            common = np.minimum(self.high, other.high) - np.maximum(self.low, other.low)
            if (common <= CONTACT).any():
                return False
            return (self.solid ^ other.solid).volume() > _skin(min(self.area, other.area))
        return any((face.section ^ face.above(other) ^ face.below(other)).area() > face.skin for face in self._faces)

    def touches(self, other: Body) -> bool:
        """Whether it overlaps a solid, or a part of one of its faces lies on the solid's surface."""
        if other.solid is None or not self._boxes_meet(other):
            return False
        if self.overlaps(other):
            return True
        return any(
            (face.section ^ face.above(other)).area() > face.skin
            or (self.solid is None and (face.section ^ face.below(other)).area() > face.skin)
            for face in self._faces
        )

    def _boxes_meet(self, other: Body) -> bool:
        gap = np.maximum(self.low - other.high, other.low - self.high)
        return bool((gap <= CONTACT).all())

    @cached_property
    def _faces(self) -> list[_Face]:
        normals = face_normals(self.mesh)
        corners = self.mesh.points[self.mesh.corner_points()]
        offsets = self.mesh.face_offsets.tolist()
        return [
            _Face(corners[first:end], normal)
            for first, end, normal in zip(offsets[:-1], offsets[1:], normals, strict=True)
            if normal.any()
        ]


class _Face:
    """A face in its own plane."""

    def __init__(self, corners: Floats, normal: Floats) -> None:
        least = np.eye(3)[np.abs(normal).argmin()]
        u = np.cross(normal, least)
        u /= np.linalg.norm(u)
        self.axes = np.stack([u, np.cross(normal, u), normal])
        local = corners @ self.axes.T
        self.level = float(local[:, 2].mean())
        outline = np.array(local[:, :2], dtype=np.float64)
        self.section = CrossSection([outline], FillRule.NonZero)
        """The face as an area of its plane."""
        self.skin = CONTACT * float(np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).sum())
        """Area that counts as none: a seam along its outline, in square metres."""

    def above(self, other: Body) -> CrossSection:
        """Section of a solid just above the face."""
        return self._cut(other, self.level + CONTACT)

    def below(self, other: Body) -> CrossSection:
        """Section of a solid just below the face."""
        return self._cut(other, self.level - CONTACT)

    def _cut(self, other: Body, level: float) -> CrossSection:
        if other.solid is None:
            return CrossSection()
        placement = np.zeros((3, 4))
        placement[:, :3] = self.axes
        turned = other.solid.transform(placement)  # ty: ignore[invalid-argument-type]  # pyright: ignore[reportArgumentType]
        return turned.slice(level)


def _skin(area: float) -> float:
    """Volume that counts as none: a layer on a surface of this area, in cubic metres."""
    return 0.5 * CONTACT * area


def distances_to_boxes(box: tuple[Floats, Floats, Floats], others: tuple[Floats, Floats, Floats]) -> Floats:
    """[K] distances in metres of one box to other boxes of any orientation; 0 where they meet.

    Args:
        box: position [3], size [3] and axes [3, 3] (columns) of the box.
        others: the same of the other boxes: [K, 3], [K, 3], [K, 3, 3].
    """
    position, size, axes = others
    centers, halves = position + np.einsum("kij,kj->ki", axes, 0.5 * size), 0.5 * size
    center, half = box[0] + box[2] @ (0.5 * box[1]), 0.5 * box[1]
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    corners = center + (signs * half) @ box[2].T
    other_corners = centers[:, None] + np.einsum("kij,kcj->kci", axes, signs * halves[:, None])
    into_others = np.einsum("kij,kci->kcj", axes, corners - centers[:, None])
    from_corners = np.linalg.norm(np.maximum(np.abs(into_others) - halves[:, None], 0.0), axis=2).min(axis=1)
    into_box = (other_corners - center) @ box[2]
    to_corners = np.linalg.norm(np.maximum(np.abs(into_box) - half, 0.0), axis=2).min(axis=1)
    ends = [(i, j) for i in range(8) for j in range(i + 1, 8) if (signs[i] != signs[j]).sum() == 1]
    first, last = np.array(ends).T
    between = _between_segments(
        corners[first][None, :, None],
        (corners[last] - corners[first])[None, :, None],
        other_corners[:, None, first],
        (other_corners[:, last] - other_corners[:, first])[:, None],
    ).min(axis=(1, 2))
    distance = np.minimum(np.minimum(from_corners, to_corners), between)
    return np.where(_boxes_meet(centers - center, half, box[2], halves, axes), 0.0, distance)


def _between_segments(p: Floats, u: Floats, q: Floats, v: Floats) -> Floats:
    """Distances of segments from p along u and from q along v; arrays of any shapes that broadcast, [..., 3]."""
    w = p - q
    a, b, c = (u * u).sum(-1), (u * v).sum(-1), (v * v).sum(-1)
    d, e = (u * w).sum(-1), (v * w).sum(-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.clip(np.nan_to_num((b * e - c * d) / (a * c - b * b), nan=0.0, posinf=0.0, neginf=0.0), 0.0, 1.0)
        t = np.clip(np.nan_to_num((b * s + e) / c, nan=0.0, posinf=0.0, neginf=0.0), 0.0, 1.0)
        s = np.clip(np.nan_to_num((b * t - d) / a, nan=0.0, posinf=0.0, neginf=0.0), 0.0, 1.0)
    return np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=-1)


def _boxes_meet(offset: Floats, half: Floats, axes: Floats, halves: Floats, others: Floats) -> NDArray[np.bool_]:
    """[K] whether a box meets others, by their separating axes.

    Args:
        offset: [K, 3] from its center to those of the others.
        half: [3] half its size.
        axes: [3, 3] its axes, as columns.
        halves: [K, 3] half the sizes of the others.
        others: [K, 3, 3] their axes, as columns.
    """
    count = len(offset)
    normals = [np.broadcast_to(axes.T, (count, 3, 3)), others.swapaxes(1, 2)]
    normals += [np.cross(axes[:, i], others.swapaxes(1, 2)) for i in range(3)]
    normal = np.concatenate(normals, axis=1)
    reach = np.abs(normal @ axes) @ half + np.einsum("kni,ki->kn", np.abs(normal @ others), halves)
    return (np.abs(np.einsum("kni,ki->kn", normal, offset)) <= reach + 1e-12).all(axis=1)
