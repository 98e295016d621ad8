"""Checks of a scene before it becomes a file or a picture."""

from __future__ import annotations

import numpy as np

from grammarlab.errors import DerivationError
from grammarlab.scene.instances import Scene

FARTHEST = 1e9
"""Largest coordinate in metres, far below the overflow of 32-bit arithmetic."""


def require_finite(scene: Scene) -> None:
    """Refuse a scene with coordinates that files and pictures cannot represent.

    Raises:
        DerivationError: If a coordinate is NaN, infinite or beyond `FARTHEST`; it names the first such model.
    """
    _require_within(scene, "position", scene.position)
    _require_within(scene, "size", scene.size)
    if not _within(scene.frames):
        _require_within(scene, "rotation", scene.frames[scene.frame])
    if not np.isfinite(scene.materials.channels).all():
        raise DerivationError(
            "a material has a colour or another number that is not finite", hint="check for divisions by zero"
        )
    points = scene.meshes.points
    if not _within(points):
        raise DerivationError(
            "a mesh has a point that is not a finite number of metres",
            hint="check for divisions by zero and for broken assets",
        )
    if len(scene) and scene.size.min() < 0:
        model = int(scene.model[np.flatnonzero((scene.size < 0).any(axis=1))[0]])
        raise DerivationError(
            f"model {model} has a shape of negative size; a negative size would mirror its geometry",
            hint="keep sizes at or above zero, for example with max(0, size)",
        )


def require_proper(scene: Scene) -> None:
    """Refuse mirrored or sheared orientations, which would be inside out in files.

    Raises:
        DerivationError: If an orientation is not a proper rotation; it names the first such model.
    """
    axes = scene.frames
    handed = np.einsum("ij,ij->i", np.cross(axes[:, :, 0], axes[:, :, 1]), axes[:, :, 2])
    skewed = np.abs(np.einsum("nij,nik->njk", axes, axes) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    wrong = np.flatnonzero(((handed < 0.5) | (skewed > 1e-6))[scene.frame])
    if len(wrong):
        raise DerivationError(
            f"model {int(scene.model[wrong[0]])} has a shape whose axes are not a right-handed rotation",
            hint="mirror the geometry inside its scope, not the scope",
        )


def _within(values: np.ndarray) -> bool:
    """Whether all are finite and within `FARTHEST`; comparisons with NaN are false."""
    return values.size == 0 or bool(values.min() >= -FARTHEST and values.max() <= FARTHEST)


def _require_within(scene: Scene, name: str, values: np.ndarray) -> None:
    if _within(values):
        return
    wrong = np.flatnonzero(~(np.abs(values).reshape(len(values), -1).max(axis=1) <= FARTHEST))[0]
    raise DerivationError(
        f"model {int(scene.model[wrong])} has a shape whose {name} is {values[wrong].tolist()}; "
        f"expected finite numbers within {FARTHEST:g} m",
        hint="check for divisions by zero and for sizes that grow without bound",
    )
