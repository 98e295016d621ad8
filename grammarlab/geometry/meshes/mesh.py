"""Many polygon meshes as one value: the geometry of a whole batch of shapes.

`Meshes` is a ragged list of meshes, each a ragged list of faces, each a ragged list of corners. Faces are simple planar
polygons of any number of corners, counter-clockwise seen from outside; a hole is joined to the outline by a
doubled edge (keyhole). Axes are right-handed with y up; units are metres.

`Soup` has faces that move between meshes, over one table of points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import (
    Floats,
    hashed,
    index_in_row,
    offsets_from_counts,
    row_lengths,
    row_of_value,
    same_bits,
    take_rows,
)
from grammarlab.geometry.meshes.corner_data import CornerData, join_data
from grammarlab.geometry.meshes.ragged import next_in_row, sum_rows

Indices = NDArray[np.int64]

UNTAGGED, INSIDE, BORDER, BOTTOM, TOP, OUTER_WALL, INNER_WALL, NUM_ROLES = range(8)
"""Roles of faces, and their number: those that ``offset`` gives, for the selectors ``inside`` and ``border`` of
``comp``, and those of the faces of a solid, where they are asked for."""

_STRIDE = 64
"""Distance of the positions of consecutive rows in a hash: at least the number of columns of most tables."""


@dataclass(frozen=True, slots=True)
class Meshes:
    """M polygon meshes.

    >>> square = Meshes.from_polygons(np.array([[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0.0]]), np.array([4]))
    >>> len(square), square.num_faces, square.bounds()[1].tolist()
    (1, 1, [[1.0, 0.0, 1.0]])
    """

    points: Floats
    """[P, 3] coordinates in metres."""
    corners: Indices
    """[C] point of each face corner, counted from the first point of its own mesh."""
    face_offsets: Indices
    """[F + 1] into `corners`."""
    mesh_faces: Indices
    """[M + 1] into faces."""
    mesh_points: Indices
    """[M + 1] into `points`."""
    tags: NDArray[np.int8 | np.int32]
    """[F] role of each face, such as `UNTAGGED`, plus `NUM_ROLES` times the number of its set of names (a derivation's
    `TagTable`); 0 is no name."""
    data: CornerData | None = None
    """Normals, texture coordinates and materials of the corners and faces, if a file gave some."""

    def __len__(self) -> int:
        return len(self.mesh_faces) - 1

    @property
    def num_faces(self) -> int:
        return len(self.face_offsets) - 1

    @property
    def roles(self) -> NDArray[np.integer]:
        """[F] role of each face."""
        return self.tags % NUM_ROLES

    @classmethod
    def from_polygons(
        cls, points: Floats, counts: NDArray[np.integer], faces_per_mesh: NDArray[np.integer] | None = None
    ) -> Self:
        """Meshes whose faces share no points.

        Args:
            points: [P, 3] corners of the first face, then of the second, and so on.
            counts: [F] corners of each face; they sum to P.
            faces_per_mesh: [M] faces of each mesh; one each when left out.
        """
        face_offsets = offsets_from_counts(counts)
        per_mesh = np.ones(len(counts), np.int64) if faces_per_mesh is None else faces_per_mesh
        mesh_faces = offsets_from_counts(per_mesh)
        mesh_points = face_offsets[mesh_faces]
        corners = np.arange(len(points), dtype=np.int64) - np.repeat(mesh_points[:-1], row_lengths(mesh_points))
        return cls(points, corners, face_offsets, mesh_faces, mesh_points, np.zeros(len(counts), np.int8))

    @classmethod
    def single(cls, points: Floats, faces: Sequence[Sequence[int]], tags: Sequence[int] | None = None) -> Self:
        """One mesh from points [P, 3] and faces given as lists of point indices."""
        corners = np.array([index for face in faces for index in face], dtype=np.int64)
        face_offsets = offsets_from_counts(np.array([len(face) for face in faces], dtype=np.int64))
        tag_column = np.zeros(len(faces), np.int8) if tags is None else np.array(tags, dtype=np.int8)
        ends = np.array([0, len(faces)]), np.array([0, len(points)])
        return cls(np.asarray(points, dtype=np.float64), corners, face_offsets, *ends, tag_column)

    @classmethod
    def united(cls, parts: Sequence[Meshes]) -> Meshes:
        """All faces of some meshes as a single mesh; without any, a mesh without faces."""
        if not parts:
            return cls.single(np.zeros((0, 3)), [])
        whole = cls.concatenate(list(parts))
        return cls(
            points=whole.points,
            corners=whole.corner_points(),
            face_offsets=whole.face_offsets,
            mesh_faces=np.array([0, whole.num_faces]),
            mesh_points=np.array([0, len(whole.points)]),
            tags=whole.tags,
            data=whole.data,
        )

    @classmethod
    def concatenate(cls, batches: Sequence[Meshes]) -> Meshes:
        """All meshes of several batches, in order."""
        if len(batches) == 1:
            return batches[0]
        return cls(
            np.concatenate([batch.points for batch in batches]),
            np.concatenate([batch.corners for batch in batches]),
            _chain([batch.face_offsets for batch in batches]),
            _chain([batch.mesh_faces for batch in batches]),
            _chain([batch.mesh_points for batch in batches]),
            np.concatenate([batch.tags for batch in batches]),
            join_data([(batch.data, len(batch.corners), batch.num_faces) for batch in batches]),
        )

    def take(self, meshes: NDArray[np.integer]) -> Meshes:
        """The meshes [K] with these indices, in any order, repeats allowed; all of them in order share their arrays."""
        if len(meshes) == len(self) and (meshes == np.arange(len(self))).all():
            return self
        faces, mesh_faces = take_rows(self.mesh_faces, meshes)
        corner_index, face_offsets = take_rows(self.face_offsets, faces)
        point_index, mesh_points = take_rows(self.mesh_points, meshes)
        return Meshes(
            points=self.points.take(point_index, axis=0),
            corners=self.corners[corner_index],
            face_offsets=face_offsets,
            mesh_faces=mesh_faces,
            mesh_points=mesh_points,
            tags=self.tags[faces],
            data=None if self.data is None else self.data.take(corner_index, faces),
        )

    def with_points(self, points: Floats, turn: Floats | None = None, stretch: Floats | None = None) -> Meshes:
        """The same faces over other points [P, 3].

        Args:
            points: the new points.
            turn: [M, 3, 3] matrices by which the points of each mesh were turned, for the normals of corners.
            stretch: [M, 3] factors, not 0, by which the points of each mesh were stretched or mirrored.
        """
        data = self.data
        if data is not None and (turn is not None or stretch is not None):
            mesh = self.mesh_of_corner()
            normals = data.normals
            if turn is not None:
                normals = np.einsum("cij,cj->ci", turn[mesh], normals)
            if stretch is not None:
                normals = normals / stretch[mesh]
            data = data.with_normals(normals)
        return Meshes(
            points=points,
            corners=self.corners,
            face_offsets=self.face_offsets,
            mesh_faces=self.mesh_faces,
            mesh_points=self.mesh_points,
            tags=self.tags,
            data=data,
        )

    def with_data(self, data: CornerData | None) -> Meshes:
        """The same faces with other values of corners."""
        return replace(self, data=data)

    def fingerprints(self) -> NDArray[np.uint64]:
        """[M] hashes of meshes with faces: equal for meshes that are the same (`same_as`), seldom for others."""
        corners = self.face_offsets[self.mesh_faces]
        number, tags = index_in_row(row_lengths(self.mesh_faces)).view(np.uint64), self.tags.astype(np.uint64)
        faces = hashed(hashed(number + np.uint64(1)) + tags)
        if self.data is not None:
            faces = np.where(self.data.slots == 0, faces, hashed(faces + self.data.slots.astype(np.uint64)))
        total = hashed(_row_hashes(self.points, self.mesh_points))
        total += _row_hashes((self.corners.view(np.uint64) + faces[self.face_of_corner()])[:, None], corners)
        return total if self.data is None else total + _row_hashes(self.data.values, corners)

    def same_as(self, other: Meshes) -> bool:
        """Whether the meshes equal those of another batch to the last bit, in the same order.

        Missing values of corners equal no values, and material 0 equals no material.
        """
        columns = ("points", "corners", "face_offsets", "mesh_faces", "mesh_points", "tags")
        if not all(same_bits(getattr(self, name), getattr(other, name)) for name in columns):
            return False
        both = join_data([(meshes.data, len(meshes.corners), meshes.num_faces) for meshes in (self, other)])
        if both is None:
            return True
        values, slots = np.split(both.values, 2), np.split(both.slots, 2)
        return same_bits(*values) and same_bits(*slots)

    def mesh_of_face(self) -> Indices:
        """[F] the mesh that each face belongs to."""
        return row_of_value(row_lengths(self.mesh_faces))

    def mesh_of_point(self) -> Indices:
        """[P] the mesh that each point belongs to."""
        return row_of_value(row_lengths(self.mesh_points))

    def face_of_corner(self) -> Indices:
        """[C] the face that each corner belongs to."""
        return row_of_value(row_lengths(self.face_offsets))

    def mesh_of_corner(self) -> Indices:
        """[C] the mesh that each corner belongs to."""
        return row_of_value(row_lengths(self.face_offsets[self.mesh_faces]))

    def corner_points(self) -> Indices:
        """[C] the row of `points` at each corner."""
        corners_per_mesh = row_lengths(self.face_offsets[self.mesh_faces])
        return self.corners + self.mesh_points[:-1].repeat(corners_per_mesh)

    def bounds(self) -> tuple[Floats, Floats]:
        """Smallest and largest coordinates [M, 3] of each mesh; zeros for a mesh without points."""
        low = np.zeros((len(self), 3))
        high = np.zeros((len(self), 3))
        filled = row_lengths(self.mesh_points) > 0
        if filled.any():
            starts = self.mesh_points[:-1][filled]
            low[filled] = np.minimum.reduceat(self.points, starts, axis=0)
            high[filled] = np.maximum.reduceat(self.points, starts, axis=0)
        return low, high

    def reversed(self, faces: NDArray[np.bool_] | None = None) -> Meshes:
        """The same faces seen from the other side; each keeps its first edge, as CGA's ``reverseNormals`` does.

        Args:
            faces: [F] which faces to turn; all when left out.
        """
        counts = row_lengths(self.face_offsets)
        face = row_of_value(counts)
        starts = self.face_offsets[:-1][face]
        position = np.arange(len(self.corners)) - starts
        mirrored = starts + (1 - position) % counts[face]
        if faces is not None:
            mirrored = np.where(faces[face], mirrored, np.arange(len(self.corners)))
        corners, data = self.corners[mirrored], self.data
        if data is not None:
            sign = -1.0 if faces is None else np.where(faces[face], -1.0, 1.0)[:, None]
            data = data.of_corners(mirrored)
            data = data.with_normals(sign * data.normals)
        return Meshes(
            points=self.points,
            corners=corners,
            face_offsets=self.face_offsets,
            mesh_faces=self.mesh_faces,
            mesh_points=self.mesh_points,
            tags=self.tags,
            data=data,
        )


class SourcedMesh(NamedTuple):
    """One mesh made of parts of the faces of others."""

    mesh: Meshes
    source: Indices
    """[F] number of the mesh that each face comes from."""
    face: Indices
    """[F] its face."""


@dataclass(frozen=True, slots=True)
class Soup:
    """F faces in any order."""

    rows: Indices
    """[C] row of the table of points at each corner."""
    offsets: Indices
    """[F + 1] into `rows`."""
    mesh: Indices
    """[F] the mesh that each face goes to."""
    rank: Indices
    """[F] faces of one mesh are sorted by this."""
    tags: NDArray[np.int8 | np.int32]
    """[F] as in `Meshes`."""
    data: CornerData | None = None
    """As in `Meshes`."""

    def __len__(self) -> int:
        return len(self.mesh)

    @classmethod
    def of_faces(cls, meshes: Meshes, chosen: Indices) -> Soup:
        """Selected faces of meshes over the points of those meshes, each in its mesh and in the same order."""
        where, offsets = take_rows(meshes.face_offsets, chosen)
        data = None if meshes.data is None else meshes.data.take(where, chosen)
        rows, mesh = meshes.corner_points()[where], meshes.mesh_of_face()[chosen]
        return cls(rows, offsets, mesh, chosen, meshes.tags[chosen], data)

    @classmethod
    def concatenate(cls, parts: Sequence[Soup]) -> Soup:
        """Faces of several parts over one table of points."""
        parts = [part for part in parts if len(part)] or list(parts[:1])
        if len(parts) == 1:
            return parts[0]
        counts = np.concatenate([row_lengths(part.offsets) for part in parts])
        return cls(
            np.concatenate([part.rows for part in parts]),
            offsets_from_counts(counts),
            np.concatenate([part.mesh for part in parts]),
            np.concatenate([part.rank for part in parts]),
            np.concatenate([part.tags for part in parts]),
            join_data([(part.data, len(part.rows), len(part)) for part in parts]),
        )

    def take(self, chosen: Indices) -> Soup:
        """Selected faces."""
        where, offsets = take_rows(self.offsets, chosen)
        data = None if self.data is None else self.data.take(where, chosen)
        return Soup(self.rows[where], offsets, self.mesh[chosen], self.rank[chosen], self.tags[chosen], data)

    def begun_earlier(self, chosen: NDArray[np.bool_]) -> Soup:
        """The faces; chosen ones begin one corner earlier."""
        where, offsets = take_rows(self.offsets, np.flatnonzero(chosen))
        corner = np.arange(len(self.rows))
        corner[where[next_in_row(offsets)]] = where
        return replace(self, rows=self.rows.take(corner), data=self.data and self.data.of_corners(corner))

    def without_repeats(self) -> Soup:
        """The faces without repeated corners, and without faces of fewer than three corners."""
        differs = self.rows != self.rows.take(next_in_row(self.offsets))
        counts = sum_rows(differs, self.offsets)
        data = self.data and self.data.of_corners(np.flatnonzero(differs))
        clean = replace(self, rows=self.rows[differs], offsets=offsets_from_counts(counts), data=data)
        return clean.where(counts >= 3)

    def where(self, chosen: NDArray[np.bool_]) -> Soup:
        """The faces that are chosen."""
        return self if bool(chosen.all()) else self.take(np.flatnonzero(chosen))

    def as_one_mesh(self, points: Floats) -> Meshes:
        """All faces as a single mesh over the table of points, for measuring them."""
        return Meshes(
            points=points,
            corners=self.rows,
            face_offsets=self.offsets,
            mesh_faces=np.array([0, len(self)]),
            mesh_points=np.array([0, len(points)]),
            tags=self.tags,
        )

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
        return Meshes(
            points=points.take(used, axis=0),
            corners=corners,
            face_offsets=faces.offsets,
            mesh_faces=mesh_faces,
            mesh_points=mesh_points,
            tags=faces.tags,
            data=faces.data,
        )

    def _sorted(self) -> Soup:
        """The faces sorted by mesh and rank; equal ones keep their order."""
        lowest = int(self.rank.min(initial=0))
        key = self.mesh * (int(self.rank.max(initial=0)) - lowest + 1) + (self.rank - lowest)
        if bool((key[1:] >= key[:-1]).all()):
            return self
        # The parts of a soup are runs in order, which a stable sort merges in almost no time.
        return self.take(np.argsort(key, kind="stable"))


def _row_hashes(values: NDArray, offsets: Indices) -> NDArray[np.uint64]:
    """[N] a hash of each row of a ragged list [V, K] without empty rows, and of the order of its values; NaN adds 0."""
    position = index_in_row(row_lengths(offsets))[:, None] * _STRIDE + np.arange(1, values.shape[1] + 1)
    words = hashed(hashed(values) + position.view(np.uint64))
    if values.dtype.kind == "f":
        words[np.isnan(values)] = 0
    return np.add.reduceat(words.sum(axis=1), offsets[:-1])


def _chain(offsets: Sequence[Indices]) -> Indices:
    """One list of offsets from those of consecutive parts."""
    parts = [offsets[0]]
    end = offsets[0][-1]
    for part in offsets[1:]:
        parts.append(part[1:] + end)
        end = end + part[-1]
    return np.concatenate(parts)
