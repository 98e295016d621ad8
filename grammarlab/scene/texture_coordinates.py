"""Texture coordinates of triangles: from their maps, or projected along the world's axes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.scene.triangles import TriangleBatch

FARTHEST = 1e9
"""Largest coordinate; larger ones are clipped so that they fit 32 bits, since no image is visible there."""
MANY_REPEATS = 1024.0
"""Largest number of repeats of an image; beyond it, whole repeats are removed to keep the fraction in 32 bits."""


def texture_coordinates(batch: TriangleBatch, triangles: slice) -> NDArray[np.float32]:
    """U and v of the corners of selected triangles [T] of a batch: from their maps, or in metres without a map.

    Returns:
        [T, 3, 2] with v downwards, as in glTF; up to `MANY_REPEATS` whole repeats are kept.
    """
    corners, chosen = batch.vertices[batch.triangles[triangles]], batch.texture_map[triangles]
    found = planar_coordinates(corners).astype(np.float64)
    mapped = np.flatnonzero(chosen >= 0)
    if len(mapped):
        rows = batch.texture_maps[chosen[mapped]]
        values = np.einsum("tij,tcj->tci", rows[:, :, :3], corners[mapped]) + rows[:, None, :, 3]
        found[mapped] = np.clip(np.nan_to_num(values), -FARTHEST, FARTHEST) * (1.0, -1.0)
    first = found.min(axis=1, keepdims=True)
    return (found - np.where(np.abs(first) > MANY_REPEATS, np.floor(first), 0.0)).astype(np.float32)


def planar_coordinates(corners: NDArray[np.floating]) -> NDArray[np.float32]:
    """Texture coordinates in metres, projected along the axis that each triangle faces most.

    Read from outside, u runs to the right and v down a wall, so that no image is mirrored or upside down.

    Args:
        corners: [T, 3, 3] the corners of each triangle.

    Returns:
        [T, 3, 2] with v downwards, as in glTF.
    """
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(axis=1)
    outward = np.where(np.take_along_axis(normal, axis[:, None], axis=1) < 0, -1.0, 1.0)
    x, y, z = corners[..., 0], corners[..., 1], corners[..., 2]
    along_x, along_y = (axis == 0)[:, None], (axis == 1)[:, None]
    u = np.where(along_x, -outward * z, np.where(along_y, x, outward * x))
    v = np.where(along_y, outward * z, -y)
    return np.stack([u, v], axis=-1).astype(np.float32)
