"""Scenes of polygons of one colour each: what simplified models are."""

from __future__ import annotations

import numpy as np

from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.instances import Scene


def polygon_scene(meshes: Meshes, model: np.ndarray, color: np.ndarray, num_models: int) -> Scene:
    """A scene of polygons.

    Args:
        meshes: N meshes of one face each.
        model: [N] model of each polygon, ascending.
        color: [N, 3] sRGB in 0..1.
        num_models: number of models.
    """
    different, material = np.unique(color, axis=0, return_inverse=True)
    channels = np.tile(list(CHANNELS.values()), (len(different), 1))
    channels[:, :3] = different
    num = len(meshes)
    return Scene(
        num_models=num_models,
        meshes=meshes,
        materials=Materials(channels, ("",) * len(different)),
        model=model.astype(np.int32),
        mesh=np.arange(num, dtype=np.int32),
        material=material.ravel().astype(np.int32),
        position=np.zeros((num, 3)),
        size=np.ones((num, 3)),
        frame=np.zeros(num, dtype=np.int32),
        frames=np.eye(3)[None],
        texture_map=np.full(num, -1, dtype=np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=np.zeros((num_models, 3)),
    )
