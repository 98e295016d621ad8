"""Bounding boxes of the instances and of the models of a scene, without placing their points."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.scene.instances import Scene


def instance_bounds(scene: Scene) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates [I, 3] of each instance from the origin of its model, in metres.

    They are those of the box of its mesh, so larger than the instance where a round mesh is turned.
    """
    mesh_low, mesh_high = scene.meshes.bounds()
    middle = ((mesh_low + mesh_high) / 2.0)[scene.mesh] * scene.size
    half = ((mesh_high - mesh_low) / 2.0)[scene.mesh] * scene.size
    centre, reach = scene.position.copy(), np.zeros_like(half)
    columns = np.ascontiguousarray(scene.frames.T)
    for axis in range(3):
        turned = columns[axis].T[scene.frame]
        centre += turned * middle[:, axis, None]
        reach += np.abs(turned) * half[:, axis, None]
    return centre - reach, centre + reach


def scene_bounds(scene: Scene) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates [num_models, 3] of each model from its origin; zeros for empty models."""
    low, high = np.zeros((scene.num_models, 3)), np.zeros((scene.num_models, 3))
    if len(scene):
        starts = np.flatnonzero(np.diff(scene.model, prepend=-1))
        instance_low, instance_high = instance_bounds(scene)
        low[scene.model[starts]] = np.minimum.reduceat(instance_low, starts, axis=0)
        high[scene.model[starts]] = np.maximum.reduceat(instance_high, starts, axis=0)
    return low, high
