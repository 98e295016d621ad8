"""Planes through the edges that faces share, halfway between the two faces: CGA's trim planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Flags, Floats, index_in_row, row_of_value, take_rows
from grammarlab.geometry.meshes.edges import edges
from grammarlab.geometry.meshes.measure import face_normals
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.ragged import any_rows
from grammarlab.geometry.meshes.vectors import cross, dot, has_length, unit

_SLACK = 1e-7
"""Largest distance, as a share of coordinates, up to which a corner lies on a plane."""


@dataclass(frozen=True, slots=True)
class SharedPlanes:
    """P planes. A face lies where ``normal @ point <= level``."""

    row: Indices
    """[P] the face of each, by its place among those asked for."""
    normal: Floats
    """[P, 3] unit vectors, out of the face."""
    level: Floats
    """[P] metres."""
    direction: Floats
    """[P, 3] unit vectors along the shared edges."""

    def of_rows(self, rows: Indices) -> SharedPlanes:
        """The same planes of faces with other numbers."""
        return replace(self, row=rows[self.row])

    @classmethod
    def concatenate(cls, parts: Sequence[SharedPlanes]) -> SharedPlanes:
        """The planes of several parts, in order."""
        return cls(
            np.concatenate([part.row for part in parts]),
            np.concatenate([part.normal for part in parts]),
            np.concatenate([part.level for part in parts]),
            np.concatenate([part.direction for part in parts]),
        )

    def take(self, planes: Indices) -> SharedPlanes:
        """Selected planes."""
        return SharedPlanes(self.row[planes], self.normal[planes], self.level[planes], self.direction[planes])


def shared_planes(meshes: Meshes, faces: Indices) -> SharedPlanes:
    """Planes through the edges that faces [K] share with others, halfway between the two normals.

    Planes that would cut the face itself are left out.
    """
    table = edges(meshes)
    shared = np.flatnonzero(table.faces[:, 1] >= 0)
    start = meshes.points[table.start[shared]]
    along = unit(meshes.points[table.end[shared]] - start)
    normals = face_normals(meshes)
    first, second = table.faces[shared].T
    middle = normals[first] + normals[second]
    across = unit(cross(along, middle))
    face = np.concatenate((first, second))
    # The second face runs along the edge the other way.
    outwards = np.concatenate((cross(along, normals[first]), cross(-along, normals[second])))
    both = np.concatenate((across, across))
    sign = np.where(dot(both, outwards) < 0.0, -1.0, 1.0)
    normal = both * sign[:, None]
    start, along = np.concatenate((start, start)), np.concatenate((along, along))
    usable = np.flatnonzero(has_length(both)[:, 0] & ~_cuts_face(meshes, face, normal, dot(normal, start)))
    order = usable[np.argsort(face[usable], kind="stable")]
    begin, end = (np.searchsorted(face[order], faces, side=side) for side in ("left", "right"))
    row = np.repeat(np.arange(len(faces)), end - begin)
    chosen = order[np.repeat(begin, end - begin) + index_in_row(end - begin)]
    return SharedPlanes(row, normal[chosen], dot(normal[chosen], start[chosen]), along[chosen])


def _cuts_face(meshes: Meshes, face: Indices, normal: Floats, level: Floats) -> Flags:
    """[P] whether planes cut their own faces, as beside a concave corner."""
    corners, offsets = take_rows(meshes.face_offsets, face)
    plane = row_of_value(np.diff(offsets))
    points = meshes.points[meshes.corner_points()[corners]]
    beyond = dot(normal[plane], points) - level[plane]
    size = np.abs(points).max(axis=1, initial=0.0)
    return any_rows(beyond > _SLACK * (1.0 + size), offsets)
