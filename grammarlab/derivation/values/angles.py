"""Rotations by three angles, and the angles of rotations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def euler(x: float | Floats, y: float | Floats, z: float | Floats) -> Floats:
    """Rotations Rz Ry Rx, about x first, by angles in degrees: [3, 3] from numbers, [N, 3, 3] with columns [N]."""
    x, y, z = np.broadcast_arrays(*np.radians(np.broadcast_arrays(x, y, z)))
    (cx, cy, cz), (sx, sy, sz) = (np.cos(a) for a in (x, y, z)), (np.sin(a) for a in (x, y, z))
    rows = [
        [cy * cz, sx * sy * cz - cx * sz, cx * sy * cz + sx * sz],
        [cy * sz, sx * sy * sz + cx * cz, cx * sy * sz - sx * cz],
        [-sy, sx * cy, cx * cy],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def euler_angles(rotations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles [N, 3] in degrees about x, y, z whose rotations Rz Ry Rx, about x first, give the matrices [N, 3, 3]."""
    y = np.arcsin(np.clip(-rotations[:, 2, 0], -1.0, 1.0))
    x = np.arctan2(rotations[:, 2, 1], rotations[:, 2, 2])
    z = np.arctan2(rotations[:, 1, 0], rotations[:, 0, 0])
    return np.degrees(np.stack([x, y, z], axis=1))
