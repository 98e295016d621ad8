"""Shadows from a depth map seen from the sun."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.rendering.camera import Camera

Floats = NDArray[np.floating]

SIDE = 1024
"""Samples along each side of the map."""
LIFT = np.float32(4.0 / SIDE)
"""Offset above a surface for shadow tests, in model units: two samples."""
BIAS = np.float32(2.0 / SIDE)
"""Largest distance behind the depth of the map at which a point is not in shadow."""
BLUR = 1.5
"""Radius of look-ups in the map, in samples: softness of shadows."""


@dataclass(frozen=True, slots=True)
class ShadowMap:
    """Depth map of a model in the unit sphere, seen from the sun."""

    camera: Camera
    depth: Floats
    """[SIDE, SIDE] distance from the plane of the camera, 0 for nothing."""

    def visibility(self, points: Floats, normals: Floats, spot: Floats) -> Floats:
        """[N] 1 if the sun is visible from a point, otherwise 0.

        Args:
            points: [N, 3].
            normals: [N, 3] unit vectors.
            spot: [N] in 0..1: offset of the look-up of each point.
        """
        right, up, back = self.camera.axes.astype(np.float32)
        at = points + LIFT * normals
        angle = spot * np.float32(8 * np.pi)
        row = (1 - at @ up) * np.float32(SIDE / 2) + BLUR * np.sin(angle)
        column = (1 + at @ right) * np.float32(SIDE / 2) + BLUR * np.cos(angle)
        inside = (row >= 0) & (row < SIDE) & (column >= 0) & (column < SIDE)
        seen = self.depth[np.where(inside, row, 0).astype(int), np.where(inside, column, 0).astype(int)]
        distance = np.float32(self.camera.position @ self.camera.axes[2]) - at @ back
        blocked = inside & (seen > 0) & (seen < distance - BIAS)
        return ((normals @ back > 0) & ~blocked).astype(np.float32)


def sun_camera(sun: Floats) -> Camera:
    """A parallel camera in the direction of the sun [3] that sees the unit sphere."""
    back = sun.astype(np.float64) / np.linalg.norm(sun)
    right = np.cross((0.0, 1.0, 0.0) if abs(back[1]) < 0.99 else (1.0, 0.0, 0.0), back)
    right /= np.linalg.norm(right)
    return Camera(3.0 * back, np.stack([right, np.cross(back, right), back]), 1.0, parallel=True)
