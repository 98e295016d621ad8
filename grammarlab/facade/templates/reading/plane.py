"""The plane of a facade in a scan, and coordinates on it."""

from __future__ import annotations

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.templates.elements import Floats

_TRIES = 200
_SEEN = 20_000
"""Points that are looked at."""
_NEAR = 0.002
"""Part of the extent of a scan that points of the wall lie from its plane at most."""
_LEVEL = 0.3
"""Of the z of a normal: a facade stands upright, up is z."""


def on_facade(points: Floats) -> Floats:
    """[P, 3] metres along the facade, up, and out of the wall, of points [P, 3] of a scan whose z goes up.

    The plane is that of most points (RANSAC with a fixed seed); out of the wall is the side that has fewer of them far
    away, and along it the right of who looks at it from there.

    Raises:
        FacadeError: when there is no upright plane.
    """
    if len(points) < 3:
        raise FacadeError(f"A scan of a facade has at least 3 points, found {len(points)}.")
    random = np.random.default_rng(0)
    middle = points.mean(axis=0)
    seen = points[random.integers(len(points), size=min(_SEEN, len(points)))] - middle
    near = _NEAR * float(np.linalg.norm(np.ptp(seen, axis=0)))
    best, found = 0, (np.zeros(3), 0.0)
    for triple in seen[random.integers(len(seen), size=(_TRIES, 3))]:
        normal = np.cross(triple[1] - triple[0], triple[2] - triple[0])
        length = float(np.linalg.norm(normal))
        if length <= 1e-12 or abs(normal[2]) > _LEVEL * length:
            continue
        normal = normal / length
        offset = float(normal @ triple[0])
        count = int((np.abs(seen @ normal - offset) < near).sum())
        if count > best:
            best, found = count, (normal, offset)
    if not best:
        raise FacadeError(
            "No upright plane was found in the scan: its points lie on one line or on the ground (z is up)."
        )
    normal, offset = found
    normal = np.array([normal[0], normal[1], 0.0]) / np.hypot(normal[0], normal[1])
    # What is behind the wall, such as rooms seen through windows, reaches farther than what juts out of it.
    depth = seen @ normal - np.median(seen @ normal)
    if depth.max() > -depth.min():
        normal, offset = -normal, -offset
    along = np.array([-normal[1], normal[0], 0.0])
    moved = points - middle
    depth = moved @ normal
    wall = np.median(depth[np.abs(depth - offset) < 4 * near]) if (np.abs(depth - offset) < 4 * near).any() else offset
    return np.stack([moved @ along, points[:, 2], depth - wall], axis=1)
