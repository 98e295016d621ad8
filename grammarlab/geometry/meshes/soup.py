"""Faces moved between meshes, over one table of points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import index_in_row, offsets_from_counts, take_rows
from grammarlab.geometry.meshes.mesh import Floats, Indices, Meshes
from grammarlab.geometry.meshes.ragged import next_in_row, sum_rows


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
        """Selected faces of meshes over the points of those meshes, each in its mesh and in the same order."""
        where, offsets = take_rows(meshes.face_offsets, chosen)
        return cls(meshes.corner_points()[where], offsets, meshes.mesh_of_face()[chosen], chosen, meshes.tags[chosen])

    @classmethod
    def together(cls, parts: Sequence[Soup]) -> Soup:
        """Faces of several parts over one table of points."""
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
        """Selected faces."""
        where, offsets = take_rows(self.offsets, chosen)
        return Soup(self.rows[where], offsets, self.mesh[chosen], self.place[chosen], self.tags[chosen])

    def begun_earlier(self, chosen: NDArray[np.bool_]) -> Soup:
        """The faces; chosen ones begin one corner earlier."""
        where, offsets = take_rows(self.offsets, np.flatnonzero(chosen))
        before = np.empty(len(where), np.int64)
        before[next_in_row(offsets)] = self.rows.take(where)
        rows = self.rows.copy()
        rows[where] = before
        return replace(self, rows=rows)

    def without_repeats(self) -> Soup:
        """The faces without repeated corners, and without faces of fewer than three corners."""
        differs = self.rows != self.rows.take(next_in_row(self.offsets))
        counts = sum_rows(differs, self.offsets)
        clean = replace(self, rows=self.rows[differs], offsets=offsets_from_counts(counts))
        return clean.where(counts >= 3)

    def where(self, chosen: NDArray[np.bool_]) -> Soup:
        """The faces that are chosen."""
        return self if bool(chosen.all()) else self.take(np.flatnonzero(chosen))

    def as_one_mesh(self, points: Floats) -> Meshes:
        """All faces as a single mesh over the table of points, for measuring them."""
        ends = np.array([0, len(self)]), np.array([0, len(points)])
        return Meshes(points, self.rows, self.offsets, *ends, self.tags)

    def meshes(self, points: Floats, mesh_of_point: Indices, num_meshes: int) -> Meshes:
        """Meshes of these faces, without the points that no face uses.

        Args:
            points: [P, 3] the table of points in metres.
            mesh_of_point: [P] the mesh of each point.
            num_meshes: number of meshes; some may be empty.
        """
        faces = self._sorted()
        is_used = np.zeros(len(points), bool)
        is_used[faces.rows] = True
        used = np.flatnonzero(is_used)
        owner = mesh_of_point.take(used)
        if not bool((owner[1:] >= owner[:-1]).all()):
            used = used.take(np.argsort(owner, kind="stable"))
        per_mesh = np.bincount(owner, minlength=num_meshes)
        mesh_points = offsets_from_counts(per_mesh)
        local = np.empty(len(points), np.int64)
        local[used] = index_in_row(per_mesh)
        mesh_faces = offsets_from_counts(np.bincount(faces.mesh, minlength=num_meshes))
        corners = local.take(faces.rows)
        return Meshes(points.take(used, axis=0), corners, faces.offsets, mesh_faces, mesh_points, faces.tags)

    def _sorted(self) -> Soup:
        """The faces sorted by mesh and place; equal ones keep their order."""
        lowest = int(self.place.min(initial=0))
        key = self.mesh * (int(self.place.max(initial=0)) - lowest + 1) + (self.place - lowest)
        if bool((key[1:] >= key[:-1]).all()):
            return self
        # The parts of a soup are runs in order, which a stable sort merges in almost no time.
        return self.take(np.argsort(key, kind="stable"))
