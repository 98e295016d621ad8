"""Faces on their way from one mesh to another, over one table of points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts, take_rows
from grammarlab.geometry.mesh import Floats, Indices, Meshes
from grammarlab.geometry.ragged import next_in_row, sum_rows


@dataclass(frozen=True, slots=True)
class Soup:
    """F faces in any order."""

    rows: Indices
    """[C] row of the table of points at each corner."""
    offsets: Indices
    """[F + 1] into `rows`."""
    mesh: Indices
    """[F] the mesh that each face goes to."""
    place: Indices
    """[F] faces of one mesh are sorted by this."""
    tags: NDArray[np.int8]
    """[F] as in `Meshes`."""

    def __len__(self) -> int:
        return len(self.mesh)

    @classmethod
    def of_faces(cls, meshes: Meshes, chosen: Indices) -> Soup:
        """Some faces of meshes over the points of those meshes, each in its mesh and in their order."""
        where, offsets = take_rows(meshes.face_offsets, chosen)
        return cls(meshes.corner_points()[where], offsets, meshes.mesh_of_face()[chosen], chosen, meshes.tags[chosen])

    @classmethod
    def together(cls, parts: Sequence[Soup]) -> Soup:
        """The faces of several parts over one table of points."""
        parts = [part for part in parts if len(part)] or list(parts[:1])
        if len(parts) == 1:
            return parts[0]
        counts = np.concatenate([np.diff(part.offsets) for part in parts])
        return cls(
            np.concatenate([part.rows for part in parts]),
            offsets_from_counts(counts),
            np.concatenate([part.mesh for part in parts]),
            np.concatenate([part.place for part in parts]),
            np.concatenate([part.tags for part in parts]),
        )

    def take(self, chosen: Indices) -> Soup:
        """Some of the faces."""
        where, offsets = take_rows(self.offsets, chosen)
        return Soup(self.rows[where], offsets, self.mesh[chosen], self.place[chosen], self.tags[chosen])

    def without_repeats(self) -> Soup:
        """The faces without corners that repeat the one before, and without those that have fewer than three left."""
        differs = self.rows != self.rows[next_in_row(self.offsets)]
        counts = sum_rows(differs.astype(np.int64), self.offsets)
        clean = replace(self, rows=self.rows[differs], offsets=offsets_from_counts(counts))
        return clean.take(np.flatnonzero(counts >= 3))

    def as_one_mesh(self, points: Floats) -> Meshes:
        """All faces as a single mesh over the table of points, for measuring them."""
        ends = np.array([0, len(self)]), np.array([0, len(points)])
        return Meshes(points, self.rows, self.offsets, *ends, self.tags)

    def meshes(self, points: Floats, mesh_of_point: Indices, num_meshes: int) -> tuple[Meshes, Indices]:
        """Meshes of these faces without the points that no face uses, and the rows of the points that remain.

        Args:
            points: [P, 3] the table of points in metres.
            mesh_of_point: [P] the mesh of each point.
            num_meshes: how many meshes to make; some may be empty.
        """
        rows, offsets, mesh, tags = self.rows, self.offsets, self.mesh, self.tags
        if not _is_sorted(mesh, self.place):
            order = np.lexsort((self.place, mesh))
            where, offsets = take_rows(offsets, order)
            rows, mesh, tags = rows[where], mesh[order], tags[order]
        is_used = np.zeros(len(points), bool)
        is_used[rows] = True
        used = np.flatnonzero(is_used)
        used = used[np.argsort(mesh_of_point[used], kind="stable")]
        mesh_points = offsets_from_counts(np.bincount(mesh_of_point[used], minlength=num_meshes))
        local = np.empty(len(points), np.int64)
        local[used] = np.arange(len(used)) - np.repeat(mesh_points[:-1], np.diff(mesh_points))
        mesh_faces = offsets_from_counts(np.bincount(mesh, minlength=num_meshes))
        return Meshes(points[used], local[rows], offsets, mesh_faces, mesh_points, tags), used


def _is_sorted(mesh: Indices, place: Indices) -> bool:
    step = np.diff(mesh)
    return bool(((step > 0) | ((step == 0) & (np.diff(place) >= 0))).all())
