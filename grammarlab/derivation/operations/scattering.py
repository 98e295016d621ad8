"""``scatter``: points scattered over a surface or a scope, each a shape without extent."""

from __future__ import annotations

from typing import cast

import numpy as np

from grammarlab.arrays import Floats, index_in_row
from grammarlab.derivation.calls.calls import BlockOperation, BoundCall, BoundPart, Head
from grammarlab.derivation.functions.shape_measures import local_meshes
from grammarlab.derivation.state.mesh_table import upright
from grammarlab.derivation.state.shapes import EMPTY, Ids, number_column, part_keys
from grammarlab.geometry.meshes.measure import areas, face_normals
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.surface_points import nearest_on, points_on
from grammarlab.randomness import Keys, uniforms

_ENDS = {"left": (0, 0.0), "right": (0, 1.0), "bottom": (1, 0.0), "top": (1, 1.0), "back": (2, 0.0), "front": (2, 1.0)}
"""Axis of the scope, and the position along it of the middle of a side."""
_SPREAD = 0.16
"""Default standard deviation, as a share of the scope's size."""
_MAX_DRAWS = 32
"""Largest number of draws from a normal distribution until one is on a flat surface."""
_TOLERANCE = 1e-6
"""Largest distance of a point on a surface, as a share of the scope's size."""


def scatter(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
    """``scatter(surface|scope, n, uniform)``, ``scatter(surface|scope, n, gaussian, mean, deviation) { … }``.

    Scatters n points, rounded to a whole number. On a surface their y axes are its normals, by the smallest rotation of
    the scopes. In a scope they keep its axes. The default mean is the center and the default deviation ``'0.16``.

    Normally distributed points are drawn within the scope, along each axis independently. On a surface that is flat
    along an axis of the scope they are drawn up to 32 times until they lie on it; after that, and on every other
    surface, they are replaced by the closest point of the surface.

    Positions are not recorded draws: no tree depends on them.
    """
    call = call._replace(shapes=upright(call.shapes, call.workspace.meshes, call.workspace.frames))
    shapes, words = call.shapes, call.words
    on_surface = words[0] == "surface"
    counts = np.maximum(np.rint(call.column(call.values[0])), 0.0)
    call.workspace.expanded(int(counts.sum()), shapes.num, call.location)
    meshes = local_meshes(shapes, call.workspace)
    if on_surface:
        counts = np.where(areas(meshes) > 0.0, counts, 0.0)
    number = index_in_row(counts.astype(np.int64))
    rows = np.repeat(np.arange(shapes.num), counts.astype(np.int64))
    key = cast("Keys", part_keys(shapes.random_key().take(rows), heads[0].block, number))
    frame = shapes.frame.take(rows)
    if "gaussian" in words:
        local, face = _normal(call, meshes, rows, key, on_surface)
    elif on_surface:
        local, face = points_on(meshes, rows, _draws(key, 0))
    else:
        local, face = _draws(key, 0) * shapes.size[rows], rows
    position = shapes.position[rows] + call.workspace.frames.to_world(frame, local)
    if on_surface:
        frame = _standing(call, meshes, frame, face)
    mesh = np.full(len(rows), EMPTY, dtype=np.int32)
    return [BoundPart(shapes.parts(rows, position, np.zeros((len(rows), 3)), frame, mesh), number)]


def _draws(key: Keys, attempt: int) -> Floats:
    """[K, 3] three uniform draws for each point."""
    return np.stack([uniforms(key, 3 * attempt + axis) for axis in range(3)], axis=1)


def _normal(call: BoundCall, meshes: Meshes, rows: Indices, key: Keys, on_surface: bool) -> tuple[Floats, Indices]:
    """Normally distributed points [K, 3], and the faces [K] they lie on."""
    shapes = call.shapes
    size, mean, deviation = shapes.size[rows], _mean(call)[rows], _deviation(call)[rows]
    points = _truncated(_draws(key, 0), size, mean, deviation)
    if not on_surface:
        return points, rows
    nearest, face = nearest_on(meshes, rows, points)
    reach = _TOLERANCE * np.maximum(size.max(axis=1, initial=0.0), 1e-9)
    rejected = np.flatnonzero((size <= 0.0).any(axis=1) & (_distances(nearest, points) > reach))
    for attempt in range(1, _MAX_DRAWS):
        if len(rejected) == 0:
            break
        points[rejected] = _truncated(
            _draws(key[rejected], attempt), size[rejected], mean[rejected], deviation[rejected]
        )
        nearest[rejected], face[rejected] = nearest_on(meshes, rows[rejected], points[rejected])
        rejected = rejected[_distances(nearest[rejected], points[rejected]) > reach[rejected]]
    return nearest, face


def _distances(first: Floats, second: Floats) -> Floats:
    return np.abs(first - second).max(axis=1, initial=0.0)


def _truncated(draws: Floats, size: Floats, mean: Floats, deviation: Floats) -> Floats:
    """[K, 3] normally distributed numbers from 0 to the sizes, from uniform draws."""
    scale = np.where(deviation > 0.0, deviation, 1.0)
    from scipy.special import ndtr, ndtri  # noqa: PLC0415  # a tenth of the time that a small run takes to start

    low, high = ndtr(-mean / scale), ndtr((size - mean) / scale)
    drawn = mean + scale * ndtri(low + (high - low) * draws)
    return np.clip(np.where(deviation > 0.0, drawn, mean), 0.0, size)


def _mean(call: BoundCall) -> Floats:
    """[N, 3] the middle of the scope, or of one of its sides."""
    mean = 0.5 * call.shapes.size
    for word in call.words[2:3]:
        if word in _ENDS:
            axis, share = _ENDS[word]
            mean[:, axis] = share * call.shapes.size[:, axis]
    return mean


def _deviation(call: BoundCall) -> Floats:
    """[N, 3] standard deviation along each axis in metres."""
    size = call.shapes.size
    if len(call.values) < 2:
        return _SPREAD * size
    argument = call.values[1]
    deviation = number_column(call.number(argument), call.shapes.num)
    if (deviation < 0.0).any():
        raise call.error(f"scatter expects a deviation of at least 0, found {deviation.min():g}")
    return deviation[:, None] * (size if argument.relative else np.ones(3))


def _standing(call: BoundCall, meshes: Meshes, frame: Ids, face: Indices) -> Ids:
    """Frames of points [K], by the smallest rotations that turn their y axes to the normals of their faces."""
    if len(face) == 0:
        return frame
    faces, first, inverse = np.unique(face, return_index=True, return_inverse=True)
    x, y, z = face_normals(meshes)[faces].T
    share = 1.0 / np.maximum(1.0 + y, 1e-12)
    turn = np.stack([1.0 - x * x * share, x, -x * z * share, -x, y, -z, -x * z * share, z, 1.0 - z * z * share], axis=1)
    turn = turn.reshape(-1, 3, 3)
    turn[y < -1.0 + 1e-9] = np.diag([1.0, -1.0, -1.0])
    return call.workspace.frames.rotated(frame[first], turn)[inverse]


BLOCKS: dict[str, BlockOperation] = {
    "scatter": BlockOperation(scatter, frozenset({"surface", "scope", "uniform", "gaussian", "center", *_ENDS}), (3, 5))
}
