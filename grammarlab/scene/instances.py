"""A scene: which mesh stands where in which material, for one model or a whole batch."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest
from grammarlab.derivation.materials import Materials
from grammarlab.geometry.mesh import Meshes

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Scene:
    """I instances of meshes over `num_models` models, world y up, metres, right-handed."""

    num_models: int
    meshes: Meshes
    materials: Materials
    model: NDArray[np.int32]
    """[I] model of each instance, ascending."""
    mesh: NDArray[np.int32]
    """[I] index into `meshes`."""
    material: NDArray[np.int32]
    """[I] index into `materials`."""
    position: Floats
    """[I, 3] an instance's points are ``position + rotation @ (size * point)``."""
    size: Floats
    """[I, 3] >= 0."""
    rotation: Floats
    """[I, 3, 3] proper rotations."""

    def __len__(self) -> int:
        return len(self.model)


def realize(forest: Forest) -> Scene:
    """The scene of a forest: its leaves, ordered by model."""
    model = forest.nodes.model[forest.leaves.node]
    order = np.argsort(model, kind="stable")
    leaves = forest.leaves
    return Scene(
        forest.num_models,
        forest.meshes,
        forest.materials,
        model[order],
        leaves.mesh[order],
        leaves.material[order],
        leaves.position[order],
        leaves.size[order],
        forest.frames[leaves.frame[order]],
    )


def only(scene: Scene, model: int) -> Scene:
    """One model of a batch, as a scene of its own with the same tables."""
    alone = chosen(scene, slice(*np.searchsorted(scene.model, [model, model + 1])))
    return replace(alone, num_models=1, model=np.zeros(len(alone), np.int32))


def chosen(scene: Scene, rows: slice | NDArray[np.integer] | NDArray[np.bool_]) -> Scene:
    """Some of the instances, in their order, in as many models with the same tables."""
    return Scene(
        scene.num_models,
        scene.meshes,
        scene.materials,
        scene.model[rows],
        scene.mesh[rows],
        scene.material[rows],
        scene.position[rows],
        scene.size[rows],
        scene.rotation[rows],
    )
