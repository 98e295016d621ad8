"""Trim planes: planes through the edges that faces shared before ``comp(f)`` took them apart.

A shape refers to the face that it is or comes from by an id, and the planes are computed when an inserted mesh or
``trim`` needs them. A plane halves the angle between two faces, so that what is inserted on one of them ends there. It
stays where it is when shapes move. Planes of edges at less than 40 degrees to the xz plane of the face's axes are
horizontal and apply only after ``set(trim.horizontal, true)``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import (
    Flags,
    Floats,
    distinct,
    distinct_counts,
    distinct_hashes,
    distinct_lists,
    distinct_pairs,
    distinct_rows,
    hashed,
    offsets_from_counts,
    row_lengths,
    row_of_value,
    take_rows,
)
from grammarlab.derivation.frames import FrameTable
from grammarlab.derivation.state.box_orders import is_box
from grammarlab.derivation.state.mesh_table import MeshTable, normalized, scaled
from grammarlab.derivation.state.shapes import EMPTY, Ids, Shapes
from grammarlab.geometry.meshes.clip import trimmed
from grammarlab.geometry.meshes.shared_planes import SharedPlanes, shared_planes

FaceIds = NDArray[np.int64]

TRIM = "trim planes"
"""Name in `Shapes.state` of the ids of faces; no attribute can have it."""
NONE = -1
"""Id of shapes without trim planes; as long as it is that of all shapes of a column, a constant."""
_SLACK = 1e-9
"""Metres by which scopes may reach beyond planes."""
_STEEP = float(np.sin(np.radians(40.0)))
"""Height of the direction of an edge above which its plane is vertical."""


@dataclass(frozen=True, slots=True)
class _Faces:
    """Faces of one ``comp(f)``."""

    first: int
    """Id of the first one."""
    whole: Shapes
    """[N] the shapes that were divided."""
    row: NDArray[np.int64]
    """[K] the shape that each face belongs to, ascending."""
    face: NDArray[np.int64]
    """[K] its number there."""
    frame: Ids
    """[K] its axes."""
    position: Floats
    """[K, 3] its first corner."""
    size: Floats
    """[K, 3] its size along its axes."""


class _BoxFaces(NamedTuple):
    """K faces as far as their planes are known without computing them."""

    axes: Ids
    """[K] their axes, -1 for those of no box."""
    corner: Floats
    """[K, 3] their first corners."""
    width: Floats
    """[K] metres."""


class TrimPlanes:
    """Faces whose shared edges give planes, in one derivation."""

    def __init__(self, stay_off: bool) -> None:
        """No faces yet; ``stay_off``: whether planes that are switched off are never switched on again."""
        self._stay_off = stay_off
        self._batches: list[_Faces] = []
        self._used = 0
        self._box_faces: list[_BoxFaces] = []

    def add(self, whole: Shapes, row: NDArray[np.int64], face: NDArray[np.int64], parts: Shapes) -> FaceIds | int:
        """Ids of faces [K] of shapes, which are parts in their own axes; `NONE` if no planes will ever apply."""
        if self._stay_off and _vertical(parts) is False and _horizontal(parts) is False:
            return NONE
        self._batches.append(
            _Faces(
                first=self._used,
                whole=whole,
                row=row,
                face=face,
                frame=parts.frame,
                position=parts.position,
                size=parts.size,
            )
        )
        self._used += len(row)
        axes = np.where(is_box(whole.mesh[row]), parts.frame, np.int32(-1))
        self._box_faces.append(_BoxFaces(axes, parts.position, parts.size[:, 0]))
        return np.arange(self._used - len(row), self._used)

    def holds(self, ids: FaceIds, shapes: Shapes, frames: FrameTable) -> Flags:
        """[N] whether scopes of shapes surely lie within the vertical planes of faces [N] of boxes.

        It compares scopes that have the axes of the face, as most parts of a wall have, without computing planes.
        """
        if len(self._box_faces) > 1:
            self._box_faces = [_BoxFaces._make(np.concatenate(column) for column in zip(*self._box_faces, strict=True))]
        axes, corner, width = self._box_faces[0]
        away = shapes.position - corner.take(ids, axis=0)
        x = np.einsum("ij,ij->i", frames.axis(shapes.frame, 0), away)
        z = np.einsum("ij,ij->i", frames.axis(shapes.frame, 2), away)
        room = np.minimum(x, width.take(ids) - x - shapes.size[:, 0]) + z
        return (axes.take(ids) == shapes.frame) & (room >= -_SLACK) & (shapes.size[:, 2] >= 0.0)

    def planes(self, ids: FaceIds, meshes: MeshTable, frames: FrameTable) -> tuple[SharedPlanes, Flags]:
        """Planes of faces [K], none of them `NONE`, in world axes, sorted by face; and whether each is vertical."""
        starts = [batch.first for batch in self._batches]
        of_batch = np.searchsorted(starts, ids, side="right") - 1
        parts, steep = [], []
        for number in distinct(of_batch, len(starts)).tolist():
            rows = np.flatnonzero(of_batch == number)
            batch = self._batches[number]
            index = ids[rows] - batch.first
            boxes = is_box(batch.whole.mesh[batch.row[index]])
            if boxes.any():
                planes, is_vertical = _of_box_faces(batch, index[boxes], frames)
                parts.append(planes.of_rows(rows[boxes]))
                steep.append(is_vertical)
            rows, index = rows[~boxes], index[~boxes]
            if len(rows) == 0:
                continue
            used, mesh = np.unique(batch.row[index], return_inverse=True)
            whole = batch.whole.take(used)
            local = scaled(meshes.take(whole.mesh), whole.size)
            turned = frames.to_world(whole.frame[local.mesh_of_point()], local.points)
            placed = local.with_points(turned + whole.position[local.mesh_of_point()])
            planes = shared_planes(placed, placed.mesh_faces[mesh.ravel()] + batch.face[index])
            up = frames.axis(batch.frame[index], 1)[planes.row]
            steep.append(np.abs(np.einsum("pk,pk->p", planes.direction, up)) >= _STEEP)
            parts.append(planes.of_rows(rows))
        joined = SharedPlanes.concatenate(parts)
        order = np.argsort(joined.row, kind="stable")
        return joined.take(order), np.concatenate(steep)[order]


def _of_box_faces(batch: _Faces, index: NDArray[np.int64], frames: FrameTable) -> tuple[SharedPlanes, Flags]:
    """Planes of faces [K] of boxes, four for each: left, right, below and above."""
    axes = frames.rotations(batch.frame[index])
    x, y, z = axes[:, :, 0], axes[:, :, 1], axes[:, :, 2]
    near = batch.position[index]
    far = near + x * batch.size[index, :1] + y * batch.size[index, 1:2]
    normal = np.stack((-x - z, x - z, -y - z, y - z), axis=1) * np.sqrt(0.5)
    level = np.einsum("kpj,kpj->kp", normal, np.stack((near, far, near, far), axis=1))
    direction = np.stack((y, y, x, x), axis=1)
    row = np.repeat(np.arange(len(index)), 4)
    planes = SharedPlanes(row, normal.reshape(-1, 3), level.ravel(), direction.reshape(-1, 3))
    return planes, np.tile([True, True, False, False], len(index))


def with_trim_ids(shapes: Shapes, ids: FaceIds | int) -> Shapes:
    """The same shapes with other planes [N], or without planes."""
    return shapes._replace(state={**shapes.state, TRIM: ids})  # ty: ignore[invalid-argument-type]


def trim(shapes: Shapes, planes: TrimPlanes, meshes: MeshTable, frames: FrameTable) -> Shapes:
    """Shapes without what lies beyond their planes, their scopes fitted; cuts are not closed, as in CityEngine."""
    if not isinstance(shapes.state.get(TRIM), np.ndarray):
        return shapes
    ids = cast("FaceIds", shapes.state[TRIM])
    rows = np.flatnonzero((ids != NONE) & (shapes.mesh != EMPTY) & (_vertical(shapes) | _horizontal(shapes)))
    if len(rows) == 0:
        return shapes
    if _horizontal(shapes) is False:
        held = planes.holds(ids[rows], shapes if len(rows) == shapes.num else shapes.take(rows), frames)
        rows = rows[~held]
        if len(rows) == 0:
            return shapes
    cuts = _cuts(shapes, ids, rows, planes, meshes, frames)
    used, counts = distinct_counts(cuts.row, shapes.num)
    if len(used) == 0:
        return shapes
    chosen = shapes.take(used)
    _, kind = distinct_lists(np.column_stack((cuts.normal, cuts.level)), counts)
    first, number = distinct_rows(chosen.mesh, chosen.size, kind)
    plane, offsets = take_rows(offsets_from_counts(counts), first)
    whole = scaled(meshes.take(chosen.mesh[first]), chosen.size[first])
    unit, low, size = normalized(
        trimmed(whole, row_of_value(row_lengths(offsets)), cuts.normal.take(plane, axis=0), cuts.level.take(plane))
    )
    position, sizes, mesh = shapes.position.copy(), shapes.size.copy(), shapes.mesh.copy()
    position[used] = chosen.position + frames.to_world(chosen.frame, low[number])
    sizes[used], mesh[used] = size[number], meshes.add(unit)[number]
    return shapes.rescoped(position, sizes, shapes.frame, mesh)


class _Cuts(NamedTuple):
    """P planes that shapes reach beyond."""

    row: NDArray[np.int64]
    """[P] the shape, ascending."""
    normal: Floats
    """[P, 3] unit vectors in the axes of its scope."""
    level: Floats
    """[P] metres from the scope's origin along the normal."""


def _cuts(
    shapes: Shapes, ids: FaceIds, rows: NDArray[np.int64], planes: TrimPlanes, meshes: MeshTable, frames: FrameTable
) -> _Cuts:
    """The planes of the faces ``ids`` [N] that the shapes at ``rows`` reach beyond."""
    asked = ids.take(rows)
    different, of_face = distinct_hashes(hashed(asked))
    shared, is_vertical = planes.planes(asked.take(different), meshes, frames)
    may_apply = np.flatnonzero(np.where(is_vertical, np.any(_vertical(shapes)), np.any(_horizontal(shapes))))
    shared, is_vertical = shared.take(may_apply), is_vertical.take(may_apply)
    per_face = np.bincount(shared.row, minlength=len(different))
    plane, offsets = take_rows(offsets_from_counts(per_face), of_face)
    row = rows.repeat(row_lengths(offsets))
    vertical, horizontal = (np.broadcast_to(switch(shapes), shapes.num) for switch in (_vertical, _horizontal))
    applies = np.where(is_vertical.take(plane), vertical.take(row), horizontal.take(row))
    level = shared.level.take(plane)
    reach = np.einsum("pk,pk->p", shared.normal.take(plane, axis=0), shapes.position.take(row, axis=0)) - level
    # Of many shapes few have different axes.
    frame, of_pair, pair = distinct_pairs(shapes.frame.take(row), plane, max(1, len(shared.row)))
    normal = np.einsum("pk,pkj->pj", shared.normal.take(of_pair, axis=0), frames.rotations(frame))
    size = shapes.size.take(row, axis=0)
    farthest = reach + np.maximum(normal.take(pair, axis=0) * size, 0.0).sum(axis=1)
    slack = 1e-9 * (1.0 + np.abs(level) + np.abs(size).max(axis=1))
    chosen = np.flatnonzero(applies & (farthest > slack))
    return _Cuts(row.take(chosen), normal.take(pair.take(chosen), axis=0), -reach.take(chosen))


def _vertical(shapes: Shapes) -> bool | Flags:
    """Whether vertical planes apply, for all shapes or [N]."""
    return cast("bool | Flags", shapes.state.get("trim.vertical", True))


def _horizontal(shapes: Shapes) -> bool | Flags:
    """Whether horizontal planes apply, for all shapes or [N]."""
    return cast("bool | Flags", shapes.state.get("trim.horizontal", False))
