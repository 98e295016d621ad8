"""Meshes of one derivation, in the unit cube of their scopes, by id."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, distinct, distinct_hashes, ranked, row_lengths
from grammarlab.derivation.frames import FrameTable
from grammarlab.derivation.state.box_orders import BoxOrders
from grammarlab.derivation.state.shapes import EMPTY, FACE, FOOTPRINT, Ids, Shapes
from grammarlab.geometry.meshes.mesh import UNTAGGED, Meshes
from grammarlab.geometry.meshes.primitives import box, quad

_NOTHING = Meshes.single(np.zeros((0, 3)), [])
_FACE_POINTS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
_FACE = Meshes.single(_FACE_POINTS, [[0, 1, 2, 3]])


_UP = np.array([0.0, 1.0, 0.0])

_MOST_SMALL_BATCHES = 32
"""Number of batches up to which none are joined."""
_ROUNDING = 1e-9
"""Tolerance of the corners of a rectangle, as a share of the scope's size."""


class MeshTable:
    """Meshes in the order they were made; the first four are `EMPTY`, `BOX`, `FOOTPRINT` and `FACE`.

    A mesh that equals one that was added before to the last bit is that mesh: so shapes of equal geometry share one id.
    """

    def __init__(self) -> None:
        self._batches = [_predefined()]
        self._starts = [0]
        self._used = 4
        self._by_fingerprint: dict[int, int] = {}
        self._named: dict[str, int] = {}
        self._mirrored: dict[tuple[int, int], int] = {}
        self.has_data = False
        """Whether a mesh has normals, texture coordinates or materials from a file."""
        self.boxes = BoxOrders()
        """Orders of the faces of boxes."""

    def __len__(self) -> int:
        return self._used

    def add(self, meshes: Meshes) -> Ids:
        """Ids [N] of meshes whose points lie in the unit cube; a mesh without faces is `EMPTY`."""
        ids = np.full(len(meshes), EMPTY, dtype=np.int32)
        rows = np.flatnonzero(row_lengths(meshes.mesh_faces) > 0)
        if len(rows):
            ids[rows] = self._interned(meshes if len(rows) == len(meshes) else meshes.take(rows))
        return ids

    def _interned(self, meshes: Meshes) -> Ids:
        """Ids [N] of meshes with faces: those of equal meshes, or new ones."""
        fingerprints = meshes.fingerprints()
        first, number = distinct_hashes(fingerprints)
        keys = fingerprints.take(first)
        stored = np.array([self._by_fingerprint.get(key, -1) for key in keys.tolist()], dtype=np.int32)
        if not self._are_equal(meshes, first, number, stored):
            # Two meshes with one fingerprint are possible in principle: then none counts as equal to another.
            return self._appended(meshes)
        new = np.flatnonzero(stored < 0)
        if len(new):
            stored[new] = self._appended(meshes if len(new) == len(meshes) else meshes.take(first[new]))
            self._by_fingerprint.update(zip(keys[new].tolist(), stored[new].tolist(), strict=True))
        return stored[number]

    def _are_equal(self, meshes: Meshes, first: Ints, number: Ints, stored: Ids) -> bool:
        """Whether meshes [N] with one fingerprint [K] equal the first of them, and the stored mesh of it."""
        if len(first) < len(meshes) and not meshes.same_as(meshes.take(first[number])):
            return False
        known = np.flatnonzero(stored >= 0)
        return not len(known) or meshes.take(first[known]).same_as(self.take(stored[known]))

    def _appended(self, meshes: Meshes) -> Ids:
        """New ids [N] of meshes."""
        ids = np.arange(self._used, self._used + len(meshes), dtype=np.int32)
        self.has_data |= meshes.data is not None
        self._used += len(meshes)
        start = int(ids[0])
        # Batches are joined as digits are carried: so there are few of them, and few meshes are copied often.
        while len(self._batches) > _MOST_SMALL_BATCHES and len(self._batches[-1].points) <= len(meshes.points):
            meshes, start = Meshes.concatenate([self._batches.pop(), meshes]), self._starts.pop()
        self._batches.append(meshes)
        self._starts.append(start)
        return ids

    def named(self, name: str, make: Callable[[], Meshes]) -> int:
        """The id of one shared mesh in the unit cube, made when the name is new, whatever other meshes equal it."""
        index = self._named.get(name)
        if index is None:
            index = self._named[name] = int(self._appended(make())[0])
        return index

    def mirrored(self, ids: NDArray[np.integer], axis: int) -> Ids:
        """Ids [N] of meshes with points mirrored along an axis and the same faces, which then point inwards.

        Scaled by a negative size they coincide with the given meshes: so scopes of negative height keep their
        geometry. Mirroring twice gives the original mesh.
        """
        different, inverse = different_ids(ids)
        new = np.array([mesh for mesh in different.tolist() if (axis, mesh) not in self._mirrored], dtype=np.int32)
        if len(new):
            unit = self.take(new)
            points = unit.points.copy()
            points[:, axis] = 1.0 - points[:, axis]
            signs = np.broadcast_to(np.where(np.arange(3) == axis, -1.0, 1.0), (len(new), 3))
            turned = self.add(unit.with_points(points, stretch=signs)).tolist()
            for mesh, mirror in zip(new.tolist(), turned, strict=True):
                self._mirrored[axis, mesh] = mirror
                self._mirrored.setdefault((axis, mirror), mesh)
        return np.array([self._mirrored[axis, mesh] for mesh in different.tolist()], dtype=np.int32)[inverse]

    def take(self, ids: NDArray[np.integer]) -> Meshes:
        """The meshes [N] with these ids, in the unit cube."""
        if len(ids) and ids.min() < 0:
            ids = self._with_boxes(ids)
        batch = np.searchsorted(self._starts, ids, side="right") - 1
        touched = distinct(batch, len(self._batches))
        if len(touched) <= 1:
            return self._from_batch(int(touched[0]) if len(touched) else 0, ids)
        rows = [np.flatnonzero(batch == b) for b in touched]
        parts = [self._from_batch(int(b), ids[r]) for b, r in zip(touched, rows, strict=True)]
        return Meshes.concatenate(parts).take(np.argsort(np.concatenate(rows)))

    def has_coordinates(self, ids: NDArray[np.integer], uv_set: int) -> NDArray[np.bool_]:
        """[N] whether corners of meshes have coordinates in a set."""
        if not self.has_data or not len(ids):
            return np.zeros(len(ids), dtype=bool)
        different, inverse = different_ids(ids)
        meshes = self.take(different)
        if meshes.data is None:
            return np.zeros(len(ids), dtype=bool)
        known = meshes.mesh_of_corner()[~np.isnan(meshes.data.coordinates(uv_set)[:, 0])]
        return (np.bincount(known, minlength=len(different)) > 0)[inverse]

    def freeze(self) -> Meshes:
        """All meshes, in the order of their ids, without the names of faces, whose numbers hold here only."""
        whole = Meshes.concatenate(self._batches)
        return whole if whole.tags.dtype == np.int8 else replace(whole, tags=whole.roles.astype(np.int8))

    def _with_boxes(self, ids: NDArray[np.integer]) -> NDArray[np.integer]:
        """Ids [N] in which boxes with orders of their own are stored meshes."""
        different, inverse = different_ids(ids)
        stored = [
            id_ if id_ >= 0 else self.named(f"box:{-id_}", partial(self.boxes.mesh, -id_)) for id_ in different.tolist()
        ]
        return np.array(stored)[inverse]

    def _from_batch(self, batch: int, ids: NDArray[np.integer]) -> Meshes:
        return self._batches[batch].take(ids - self._starts[batch])


def different_ids(ids: NDArray[np.integer]) -> tuple[Ids, Ints]:
    """The different ids of meshes of a column [N], ascending, and the number [N] of each."""
    low = int(ids.min(initial=0))
    different, number = ranked(ids - low, int(ids.max(initial=0)) - low + 1)
    return (different + low).astype(np.int32), number


@cache
def _predefined() -> Meshes:
    """The meshes that every table begins with."""
    return Meshes.concatenate([_NOTHING, box(), quad(), _FACE])


def scaled(meshes: Meshes, size: Floats) -> Meshes:
    """Meshes with the points of each multiplied by its size [N, 3]."""
    points = meshes.points * np.repeat(size, row_lengths(meshes.mesh_points), axis=0)
    return meshes.with_points(points, stretch=np.where(size == 0.0, 1.0, size))


def upright(shapes: Shapes, table: MeshTable, frames: FrameTable) -> Shapes:
    """The same geometry in scopes without negative heights."""
    if not (shapes.size[:, 1] < 0.0).any():
        return shapes
    return turned_over(shapes, shapes.size[:, 1] < 0.0, table, frames)


def turned_over(shapes: Shapes, chosen: NDArray[np.bool_], table: MeshTable, frames: FrameTable) -> Shapes:
    """The same geometry in scopes that begin at their other end, with the height negated, where chosen [N]."""
    height = np.where(chosen, shapes.size[:, 1], 0.0)
    mesh = shapes.mesh.copy()
    mesh[chosen] = table.mirrored(mesh[chosen], 1)
    position = shapes.position + frames.axis(shapes.frame, 1) * height[:, None]
    return shapes._replace(position=position, size=shapes.size - 2.0 * height[:, None] * _UP, mesh=mesh)


def mirrored(shapes: Shapes, chosen: NDArray[np.bool_], table: MeshTable, frames: FrameTable) -> Shapes:
    """Shapes mirrored along the axes [N, 3] where their sizes are negative, in scopes of positive size.

    Geometry that filled the scope from its origin towards one side fills it towards the other, and its faces point
    the opposite way.
    """
    for axis in np.flatnonzero(chosen.any(axis=0)).tolist():
        rows = np.flatnonzero(chosen[:, axis])
        position, size, mesh = shapes.position.copy(), shapes.size.copy(), shapes.mesh.copy()
        position[rows] += frames.axis(shapes.frame[rows], axis) * size[rows, axis, None]
        size[rows, axis] *= -1.0
        mesh[rows] = table.mirrored(mesh[rows], axis)
        shapes = shapes.rescoped(position, size, shapes.frame, mesh)
    return shapes


def right_handed(shapes: Shapes, table: MeshTable, frames: FrameTable) -> Shapes:
    """The same shapes in right-handed scopes: left-handed ones, which ``mirrorScope`` makes, get a reversed x axis."""
    if not frames.has_mirrored:
        return shapes
    rows = np.flatnonzero(frames.are_left_handed(shapes.frame))
    if len(rows) == 0:
        return shapes
    position, frame, mesh = shapes.position.copy(), shapes.frame.copy(), shapes.mesh.copy()
    position[rows] += frames.axis(frame[rows], 0) * shapes.size[rows, :1]
    frame[rows] = frames.rotated(frame[rows], np.diag([-1.0, 1.0, 1.0]))
    different, number = different_ids(mesh[rows])
    meshes = table.take(different)
    points = meshes.points.copy()
    points[:, 0] = 1.0 - points[:, 0]
    # Reversed faces get reversed normals, but a mirrored normal still points outwards.
    mirrored = meshes.with_points(points, stretch=np.broadcast_to([1.0, -1.0, -1.0], (len(meshes), 3)))
    mesh[rows] = table.add(mirrored.reversed())[number]
    return shapes.rescoped(position, shapes.size, frame, mesh)


def replaced(shapes: Shapes, meshes: Meshes, number: NDArray[np.int64], table: MeshTable, frames: FrameTable) -> Shapes:
    """Shapes with other geometry, their scopes fitted to it.

    Args:
        shapes: [N] the shapes.
        meshes: [K] their different new geometries, in metres along their scopes' axes from their scopes' origins.
        number: [N] the new geometry of each shape.
        table: the table of meshes.
        frames: the table of orientations.
    """
    unit, low, size = normalized(meshes)
    position = shapes.position + frames.to_world(shapes.frame, low.take(number, axis=0))
    return shapes._replace(position=position, size=size.take(number, axis=0), mesh=table.add(unit).take(number))


def add_faces(table: MeshTable, meshes: Meshes) -> Ids:
    """Ids [N] of meshes in the unit cube; single untagged rectangles that fill it are `FACE` or `FOOTPRINT`."""
    points_per_mesh = row_lengths(meshes.mesh_points)
    single = (points_per_mesh == 4) & (row_lengths(meshes.mesh_faces) == 1)
    candidates = np.flatnonzero(single)
    first = meshes.mesh_points[:-1][candidates]
    corner = meshes.face_offsets[meshes.mesh_faces[:-1][candidates]]
    corners = meshes.corners[corner[:, None] + np.arange(4)]
    points = meshes.points[first[:, None] + corners]
    plain = meshes.tags[meshes.mesh_faces[:-1][candidates]] == UNTAGGED
    if meshes.data is not None:
        plain &= ~meshes.data.has_values().take(corner)
    ids = np.full(len(meshes), -1, dtype=np.int32)
    for kind, template in ((FACE, _FACE_POINTS), (FOOTPRINT, quad().points)):
        ids[candidates[plain & (np.abs(points - template) < _ROUNDING).all(axis=(1, 2))]] = kind
    other_rows = np.flatnonzero(ids < 0)
    if len(other_rows):
        ids[other_rows] = table.add(meshes.take(other_rows))
    return ids


def normalized(meshes: Meshes) -> tuple[Meshes, Floats, Floats]:
    """Meshes moved and scaled into the unit cube, and their previous low corners and sizes [N, 3]."""
    low, high = meshes.bounds()
    size = high - low
    counts = row_lengths(meshes.mesh_points)
    inverse = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    points = (meshes.points - np.repeat(low, counts, axis=0)) * np.repeat(inverse, counts, axis=0)
    return meshes.with_points(points, stretch=np.where(size > 0.0, inverse, 1.0)), low, size
