"""The initial shapes of lots: a scope for each footprint, along its first edge, and its polygon as a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts, row_of_value
from grammarlab.derivation.lots import Footprints, Lots
from grammarlab.derivation.origins import brought_near
from grammarlab.derivation.state.meshes import MeshTable, normalized
from grammarlab.derivation.state.shapes import FOOTPRINT, Floats, Ids, Shapes
from grammarlab.derivation.values.frames import FrameTable
from grammarlab.geometry.meshes.mesh import UNTAGGED, Meshes
from grammarlab.geometry.solids.primitives import quad
from grammarlab.randomness import root_keys

_UP = np.array([0.0, 1.0, 0.0])


def initial_shapes(lots: Lots, frames: FrameTable, meshes: MeshTable) -> Shapes:
    """[N] initial shapes of models, without any state.

    Node and model ids start at 0; positions are relative to `Lots.origins`.
    """
    rows = np.arange(len(lots), dtype=np.int32)
    _, corners = brought_near(lots.footprints.points, lots.footprints.offsets)
    position, size, frame, mesh = _scopes(Footprints(corners, lots.footprints.offsets), frames, meshes)
    on, frame = lots.footprint, frame[lots.footprint]
    keys, material = root_keys(lots.seed, lots.model), np.zeros(len(lots), dtype=np.int32)
    return Shapes(
        node=rows,
        model=rows,
        key=keys,
        position=position[on],
        size=size[on],
        frame=frame,
        pivot=frame,
        mesh=mesh[on],
        material=material,
        state={},
        locals=(),
    )


def _scopes(footprints: Footprints, frames: FrameTable, meshes: MeshTable) -> tuple[Floats, Floats, Ids, Ids]:
    """Position, size, frame and mesh [F] of the initial shapes on different footprints."""
    rotation = _rotations(footprints)
    local = _times(footprints, rotation)
    unit, low, size = normalized(_polygons(local, footprints))
    skew = ~np.isclose(rotation, np.eye(3), atol=1e-12).all(axis=(1, 2))
    frame = np.zeros(len(footprints), dtype=np.int32)
    frame[skew] = frames.add(rotation[skew])
    mesh = np.full(len(footprints), FOOTPRINT, dtype=np.int32)
    others = np.flatnonzero(~_is_rectangle(unit))
    if len(others):
        mesh[others] = meshes.add(unit.take(others))
    return (rotation @ low[:, :, None])[:, :, 0], size, frame, mesh


def _rotations(footprints: Footprints) -> Floats:
    """[F, 3, 3] rotations whose x axis runs along the first edge."""
    first = footprints.offsets[:-1]
    x = footprints.points[first + 1] - footprints.points[first]
    x = x / np.sqrt(np.vecdot(x, x))[:, None]
    return np.stack([x, np.broadcast_to(_UP, x.shape), np.cross(x, _UP)], axis=2)


def _times(footprints: Footprints, rotation: Floats) -> Floats:
    """[P, 3] corners times the rotation [F, 3, 3] of their footprint.

    There is one product per footprint, as for a single footprint, so that the last bits are the same.
    """
    counts = np.diff(footprints.offsets)
    result = np.empty_like(footprints.points)
    for count in np.unique(counts).tolist():
        alike = np.flatnonzero(counts == count)
        corners = footprints.offsets[alike][:, None] + np.arange(count)
        result[corners] = footprints.points[corners] @ rotation[alike]
    return result


def _polygons(points: Floats, footprints: Footprints) -> Meshes:
    """[F] meshes of one face; bridges to its holes are passed in both directions over the same points."""
    counts = np.diff(footprints.offsets)
    row = row_of_value(counts)
    visited, corners = _first_visits(np.column_stack([row.astype(np.float64), footprints.points]))
    per_mesh = np.bincount(row[visited], minlength=len(counts))
    mesh_points = offsets_from_counts(per_mesh)
    return Meshes(
        points[visited],
        corners - mesh_points[row],
        footprints.offsets,
        np.arange(len(counts) + 1),
        mesh_points,
        np.full(len(counts), UNTAGGED, dtype=np.int8),
    )


def _first_visits(points: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices of the first occurrences of points [P, K], ascending, and the number of each point among them."""
    order = np.lexsort(points.T)
    ordered = points[order]
    begins = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1)) if len(points) else np.zeros(0, dtype=bool)
    first = order[begins]  # the sort is stable, so that the first of equal ones comes first
    visited = np.sort(first)
    numbers = np.empty(len(points), dtype=np.int64)
    numbers[order] = np.searchsorted(visited, first)[np.cumsum(begins) - 1]
    return visited, numbers


def _is_rectangle(unit: Meshes) -> NDArray[np.bool_]:
    """[F] whether meshes in the unit cube are the whole rectangle y = 0 seen from above."""
    found = np.diff(unit.mesh_points) == 4
    four = np.flatnonzero(found & (np.diff(unit.face_offsets) == 4))
    corners = unit.points[unit.mesh_points[:-1][four][:, None] + np.arange(4)]
    found[:] = False
    found[four] = np.isclose(corners, quad().points, atol=1e-9).all(axis=(1, 2))
    return found
