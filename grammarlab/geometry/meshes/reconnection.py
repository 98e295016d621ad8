"""Faces that touch made neighbours again: near points become one, and corners on edges of others become theirs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grammarlab.arrays import Floats, offsets_from_counts
from grammarlab.geometry.meshes.cleanup import merged_points
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.edges import edges
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.ragged import next_in_row

MOST_EDGES = 10_000
"""Budget: largest number of edges at the boundary of a mesh whose faces are connected."""
_NEAR = 1e-5
"""Metres within which points are one, and lie on edges."""


def reconnected(mesh: Meshes) -> Meshes | None:
    """One mesh in metres whose faces share points and edges wherever they touch; None above `MOST_EDGES`.

    The faces stay as many, in order and in place; some have more corners, on straight lines.
    """
    welded = _welded(mesh)
    table = edges(welded)
    boundary = np.flatnonzero(table.is_boundary)
    if len(boundary) > MOST_EDGES:
        return None
    corner, start, end = table.corner[boundary], table.start[boundary], table.end[boundary]
    candidates = np.unique(np.concatenate((start, end)))
    edge, point, share = _points_on_edges(welded.points, start, end, candidates)
    return _with_corners(welded, corner[edge], point, share) if len(edge) else welded


def _welded(mesh: Meshes) -> Meshes:
    """One mesh whose near points are one: the first of each group."""
    used, number = np.unique(merged_points(mesh.points, _NEAR)[mesh.corners], return_inverse=True)
    ends = np.array([0, len(used)])
    return replace(mesh, points=mesh.points[used], corners=number.ravel(), mesh_points=ends)


def _points_on_edges(
    points: Floats, start: Indices, end: Indices, candidates: Indices
) -> tuple[Indices, Indices, Floats]:
    """Edges [K] with points [K] that lie on them, and the share [K] of the edge before each, ordered by both."""
    found: list[tuple[Indices, Indices, Floats]] = []
    places = points[candidates]
    for number in range(len(start)):
        origin, along = points[start[number]], points[end[number]] - points[start[number]]
        length = float(np.sqrt(along @ along))
        if length <= 2.0 * _NEAR:
            continue
        share = (places - origin) @ along / length**2
        away = np.abs(places - origin - share[:, None] * along).max(axis=1)
        inside = np.flatnonzero((share * length > _NEAR) & ((1.0 - share) * length > _NEAR) & (away < _NEAR))
        if len(inside):
            inside = inside[np.argsort(share[inside], kind="stable")]
            found.append((np.full(len(inside), number), candidates[inside], share[inside]))
    if not found:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
    edge, point, share = (np.concatenate(column) for column in zip(*found, strict=True))
    return edge, point, share


def _with_corners(mesh: Meshes, corner: Indices, point: Indices, share: Floats) -> Meshes:
    """A mesh with more corners [K] after some [K] of the others, at shares [K] of the edges that leave those."""
    place = np.argsort(np.concatenate((np.arange(len(mesh.corners)), corner)), kind="stable")
    corners = np.concatenate((mesh.corners, point))[place]
    face = mesh.face_of_corner()
    counts = np.diff(mesh.face_offsets) + np.bincount(face[corner], minlength=mesh.num_faces)
    data = mesh.data
    if data is not None:
        following = next_in_row(mesh.face_offsets)[corner]
        between = (1.0 - share)[:, None] * data.values[corner] + share[:, None] * data.values[following]
        data = CornerData(np.concatenate((data.values, between))[place], data.slots)
    return replace(mesh, corners=corners, face_offsets=offsets_from_counts(counts), data=data)
