"""Bounding boxes of the instances and of the models of a scene, without placing all of their points."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, row_of_value, take_rows
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.instances import Scene

_TURNED = 1e-9
"""Smallest part of an axis along another one that counts as a turn."""


def instance_bounds(scene: Scene) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates [I, 3] of each instance from the origin of its model, in metres.

    Those that reach a side of the box of their model are exact. Others are those of the box of a mesh, so larger than
    the instance where a round mesh is turned.
    """
    mesh_low, mesh_high = scene.meshes.bounds()
    middle = ((mesh_low + mesh_high) / 2.0)[scene.mesh] * scene.size
    half = ((mesh_high - mesh_low) / 2.0)[scene.mesh] * scene.size
    centre, reach = scene.position.copy(), np.zeros_like(half)
    for axis in range(3):
        turned = np.ascontiguousarray(scene.frames[:, :, axis])[scene.frame]
        centre += turned * middle[:, axis, None]
        reach += np.abs(turned) * half[:, axis, None]
    low, high = centre - reach, centre + reach
    rows = _inexact(scene, low, high)
    low[rows], high[rows] = _bounds_of(scene, rows)
    return low, high


def scene_bounds(scene: Scene) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates [num_models, 3] of each model from its origin; zeros for empty models."""
    low, high = np.zeros((scene.num_models, 3)), np.zeros((scene.num_models, 3))
    if len(scene):
        starts = np.flatnonzero(np.diff(scene.model, prepend=-1))
        instance_low, instance_high = instance_bounds(scene)
        low[scene.model[starts]] = np.minimum.reduceat(instance_low, starts, axis=0)
        high[scene.model[starts]] = np.maximum.reduceat(instance_high, starts, axis=0)
    return low, high


def _inexact(scene: Scene, low: Floats, high: Floats) -> Ints:
    """Instances in boxes larger than they are, which reach beyond all others of their model."""
    turned = ((np.abs(scene.frames) > _TURNED).sum(axis=(1, 2)) > 3)[scene.frame]
    is_inexact = turned & ~_is_box(scene.meshes)[scene.mesh]
    if not is_inexact.any():
        return np.zeros(0, dtype=np.int64)
    starts = np.flatnonzero(np.diff(scene.model, prepend=-1))
    spans = np.diff(np.append(starts, len(scene)))
    matters = np.zeros(len(scene), dtype=bool)
    for reach in (-low, high):
        exact = np.maximum.reduceat(np.where(is_inexact[:, None], -np.inf, reach), starts, axis=0)
        matters |= (reach > exact.repeat(spans, axis=0)).any(axis=1)
    return np.flatnonzero(matters & is_inexact)


def _bounds_of(scene: Scene, rows: Ints) -> tuple[Floats, Floats]:
    """Exact lowest and highest coordinates [n, 3] of instances at some rows."""
    point, ends = take_rows(scene.meshes.mesh_points, scene.mesh[rows])
    row = rows[row_of_value(np.diff(ends))]
    scaled = scene.meshes.points[point] * scene.size[row]
    points = scene.position[row] + np.einsum("pij,pj->pi", scene.frames[scene.frame[row]], scaled)
    if not len(rows):
        return np.zeros((0, 3)), np.zeros((0, 3))
    return np.minimum.reduceat(points, ends[:-1], axis=0), np.maximum.reduceat(points, ends[:-1], axis=0)


def _is_box(meshes: Meshes) -> Flags:
    """[M] whether the points of a mesh are the corners of its box."""
    low, high = meshes.bounds()
    owner = meshes.mesh_of_point()
    is_high = meshes.points == high[owner]
    is_corner = (is_high | (meshes.points == low[owner])).all(axis=1)
    code = owner * 8 + is_high @ (1, 2, 4)
    num_corners = np.bincount(np.unique(code) // 8, minlength=len(meshes))
    needed = 2 ** np.count_nonzero(high > low, axis=1)
    all_corners = np.bincount(owner, ~is_corner, len(meshes)) == 0
    return all_corners & (num_corners == needed)
