"""Placements of instances, as in nodes of glTF."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import row_of_value
from grammarlab.scene import Scene
from grammarlab.scene.shading import ShadedMeshes

_THINNEST = 1e-6
"""Smallest scale of a node in metres, since readers cannot compute normals at zero."""


@dataclass(frozen=True, slots=True)
class Placements:
    """Translation, rotation and scale of I instances."""

    translation: NDArray[np.float32]
    """[I, 3] metres."""
    rotation: NDArray[np.float32]
    """[I, 4] unit quaternions x, y, z, w."""
    scale: NDArray[np.float32]
    """[I, 3] > 0."""


def placements_of(scene: Scene, shaded: ShadedMeshes, mesh: NDArray[np.integer]) -> Placements:
    """Placements of the instances of a scene.

    Args:
        scene: I instances.
        shaded: their meshes.
        mesh: [I] index of the mesh of each instance in `shaded`.
    """
    # Imported here, since most files do not need it.
    from scipy.spatial.transform import Rotation  # noqa: PLC0415

    extends = np.zeros((len(shaded.mesh_triangles) - 1, 3), dtype=bool)
    np.logical_or.at(extends, row_of_value(np.diff(shaded.mesh_vertices)), shaded.points != 0)
    # A mesh in the plane 0 of an axis is the same at any size along it.
    scale = np.where(~extends[mesh] & (scene.size < _THINNEST), 1.0, np.maximum(scene.size, _THINNEST))
    used, frame = np.unique(scene.frame, return_inverse=True)
    quaternion = Rotation.from_matrix(scene.frames[used]).as_quat() if len(used) else np.zeros((0, 4))
    turned = quaternion.astype(np.float32)[frame]
    return Placements(scene.position.astype(np.float32), turned, scale.astype(np.float32))
