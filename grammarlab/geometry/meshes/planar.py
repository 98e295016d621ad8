"""Polygons in their own planes: conversion between space and two coordinates, for a whole batch at once.

Every face of a batch gets a right-handed frame: origin at its first corner, x along its first edge, z along its normal.
In that frame the face is a counter-clockwise polygon starting at (0, 0).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, row_lengths, row_of_value
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.ragged import next_in_row
from grammarlab.geometry.meshes.vectors import any_normal, cross, dot, has_length, unit

RELATIVE_TOLERANCE = 1e-9
"""Largest length that counts as zero, as a share of a polygon's size."""


@dataclass(frozen=True, slots=True)
class Polygons:
    """The F faces of a batch, each in its own plane."""

    points: Floats
    """[C, 3] corners in space, face after face, in metres."""
    xy: Floats
    """[C, 2] the same corners in the frame of their face, in metres."""
    offsets: Indices
    """[F + 1] into the corners."""
    origin: Floats
    """[F, 3] first corner of each face."""
    axes: Floats
    """[F, 3, 3] unit vectors along x, y and z (the normal) of each frame, one per row."""

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @property
    def counts(self) -> Indices:
        """[F] corners of each face."""
        return row_lengths(self.offsets)

    def face_of_corner(self) -> Indices:
        """[C] the face of each corner."""
        return row_of_value(self.counts)

    def next_corner(self) -> Indices:
        """[C] the corner that follows each corner around its face."""
        return next_in_row(self.offsets)

    def extents(self) -> Floats:
        """[F] largest coordinate in the frame of each face: its size, up to a factor."""
        largest = np.zeros(len(self))
        np.maximum.at(largest, self.face_of_corner(), np.abs(self.xy).max(axis=1, initial=0.0))
        return largest

    def lift(self, faces: NDArray[np.integer], xy: Floats, height: Floats) -> Floats:
        """Points in space [K, N, 3] from coordinates [K, N, 2] and heights [K, N] over the planes of ``faces`` [K]."""
        x, y, z = (self.axes[faces, None, i] for i in range(3))
        return self.origin[faces, None] + x * xy[..., :1] + y * xy[..., 1:] + z * height[..., None]


def lay_flat(meshes: Meshes) -> Polygons:
    """The faces of a batch, each in its own plane.

    A face that is not quite planar is projected along its (Newell) normal. A face without area gets an arbitrary frame
    and coordinates without NaN.
    """
    points = meshes.points[meshes.corner_points()]
    counts = row_lengths(meshes.face_offsets)
    face = row_of_value(counts)
    filled = counts > 0
    origin = np.zeros((len(counts), 3))
    origin[filled] = points[meshes.face_offsets[:-1][filled]]
    relative = points - origin[face]
    following = next_in_row(meshes.face_offsets)
    edges = relative[following] - relative
    normal = unit(sums_by_row(face, len(counts), cross(relative, relative[following])))
    axes = _frames(normal, _first_direction(edges, face, len(counts)))
    xy = np.stack([dot(relative, axes[face, 0]), dot(relative, axes[face, 1])], axis=1)
    return Polygons(points, xy, meshes.face_offsets, origin, axes)


def signed_areas(polygons: Polygons) -> Floats:
    """[F] area of each face in its own plane; at least 0 up to rounding, since the normal follows the corners."""
    following = polygons.next_corner()
    a, b = polygons.xy, polygons.xy[following]
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return 0.5 * sums_by_row(polygons.face_of_corner(), len(polygons), twice[:, None])[:, 0]


def rectangle_sizes(polygons: Polygons) -> tuple[NDArray[np.bool_], Floats]:
    """Whether faces [F] are rectangles, and the lengths of their first and second edges [F, 2] (zeros for others)."""
    four = np.flatnonzero(polygons.counts == 4)
    corners = polygons.offsets[four][:, None] + np.arange(4)
    xy = polygons.xy[corners]
    size = xy[:, 2]
    tolerance = RELATIVE_TOLERANCE * np.maximum(np.abs(size).max(axis=1), 1e-300)
    expected = np.zeros_like(xy)
    expected[:, 1, 0] = expected[:, 2, 0] = size[:, 0]
    expected[:, 2, 1] = expected[:, 3, 1] = size[:, 1]
    deviation = np.abs(xy - expected).max(axis=(1, 2))
    offset = polygons.points[corners] - polygons.origin[four][:, None]
    height = np.abs(dot(offset, polygons.axes[four, 2][:, None])).max(axis=1)
    fits = (np.maximum(deviation, height) <= tolerance) & (size > tolerance[:, None]).all(axis=1)
    rectangular = np.zeros(len(polygons), np.bool_)
    rectangular[four] = fits
    sizes = np.zeros((len(polygons), 2))
    sizes[four[fits]] = size[fits]
    return rectangular, sizes


def regroup(meshes: Meshes, offsets: Indices) -> Meshes:
    """Fewer meshes, each made of consecutive ones.

    Args:
        meshes: the meshes to join.
        offsets: [M + 1] new mesh i is made of the meshes ``offsets[i]`` to ``offsets[i + 1]``.
    """
    if np.array_equal(offsets, np.arange(len(meshes) + 1)):
        return meshes
    corners_per_mesh = row_lengths(meshes.face_offsets[meshes.mesh_faces])
    base = meshes.mesh_points[offsets]
    shift = meshes.mesh_points[:-1] - np.repeat(base[:-1], row_lengths(offsets))
    corners = meshes.corners + np.repeat(shift, corners_per_mesh)
    return Meshes(
        points=meshes.points,
        corners=corners,
        face_offsets=meshes.face_offsets,
        mesh_faces=meshes.mesh_faces[offsets],
        mesh_points=base,
        tags=meshes.tags,
        data=meshes.data,
    )


def sums_by_row(row: NDArray[np.integer], num_rows: int, values: Floats) -> Floats:
    """Sums [R, D] of the values [N, D] of each row [N], added in order, so that they are equal in every batch."""
    sums = np.zeros((num_rows, values.shape[1]))
    for i in range(values.shape[1]):
        sums[:, i] = np.bincount(row, values[:, i], num_rows)
    return sums


def _first_direction(edges: Floats, face: Indices, num_faces: int) -> Floats:
    """[F, 3] the first edge of each face that is not degenerate relative to its longest edge."""
    length = np.sqrt(dot(edges, edges))
    longest = np.zeros(num_faces)
    np.maximum.at(longest, face, length)
    usable = np.flatnonzero(length > RELATIVE_TOLERANCE * longest[face])
    direction = np.zeros((num_faces, 3))
    first = usable[np.unique(face[usable], return_index=True)[1]]
    direction[face[first]] = edges[first]
    return direction


def _frames(normal: Floats, along: Floats) -> Floats:
    """[F, 3, 3] frames with z along ``normal`` [F, 3] and x as near as possible to ``along`` [F, 3]."""
    across = np.where(has_length(along), any_normal(along), [0.0, 1.0, 0.0])
    z = np.where(has_length(normal), normal, across)
    x = unit(along - z * dot(along, z)[:, None])
    x = np.where(has_length(x), x, any_normal(z))
    return np.stack([x, cross(z, x), z], axis=1)
