"""Edges that are nearly parallel to an axis made parallel to it: ``rectify``."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Flags, Floats, connected
from grammarlab.geometry.meshes.edges import edges
from grammarlab.geometry.meshes.measure import area_vectors
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.planar import sums_by_row


def rectified(meshes: Meshes, angles: Floats) -> Meshes:
    """Meshes whose edges are parallel to an axis, in the view along the axis that their faces look along most, if near.

    Corners that such edges join get one place across them: the mean of the middles of the edges, weighted by length.

    Args:
        meshes: [M] meshes.
        angles: [M] degrees; an edge that deviates less from an axis becomes parallel to it.
    """
    table, owner = edges(meshes), meshes.mesh_of_face()
    depth = np.argmax(sums_by_row(owner, len(meshes), np.abs(area_vectors(meshes))), axis=1)[table.mesh]
    points = meshes.points.copy()
    vectors = meshes.points[table.end] - meshes.points[table.start]
    limit = np.tan(np.radians(np.minimum(angles, 45.0)))[table.mesh]
    for axis in range(3):
        # Edges along the third of the three axes, in the plane of this axis and the one along which the shape is seen.
        along = 3 - axis - depth
        chosen = np.flatnonzero((depth != axis) & _is_less(vectors, axis, along, limit))
        _level(points, meshes.points, axis, table.start[chosen], table.end[chosen], np.abs(vectors[chosen]))
    return meshes.with_points(points)


def _is_less(vectors: Floats, axis: int, along: Indices, limit: Floats) -> Flags:
    """[E] whether the share of vectors along one axis is less than a multiple [E] of that along another axis [E]."""
    rows = np.arange(len(vectors))
    return np.abs(vectors[:, axis]) < limit * np.abs(vectors[rows, along % 3])


def _level(points: Floats, before: Floats, axis: int, start: Indices, end: Indices, extent: Floats) -> None:
    """One coordinate of points changed so that edges between them are level: `points` [P, 3] is written.

    Args:
        points: [P, 3] the result.
        before: [P, 3] where the points were.
        axis: the coordinate.
        start: [E] point at the beginning of each edge.
        end: [E] point at its end.
        extent: [E, 3] sizes of the edges.
    """
    group = connected(len(points), start, end)
    weight = extent.sum(axis=1)
    middle = (before[start, axis] + before[end, axis]) / 2.0
    sums = sums_by_row(group[start], len(points), np.column_stack((weight, weight * middle)))
    is_level = sums[group, 0] > 0.0
    points[is_level, axis] = sums[group[is_level], 1] / sums[group[is_level], 0]
