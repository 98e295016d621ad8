"""The plane of a facade in a scan, and coordinates on it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.templates.elements import Floats

_TRIES = 200
_SEEN = 20_000
"""Largest number of points that are examined."""
_NEAR = 0.002
"""Largest distance of the wall's points from the initial plane, as a fraction of the extent of a scan."""
_FLAT = 0.02
"""Largest distance from the final plane, metres."""
_LEVEL = 0.3
"""Largest z component of a normal, since facades are vertical."""
_MOST_PLANES = 4
_LEAST = 0.05
"""Least fraction of the points of a further plane."""


def facades(points: Floats) -> Iterator[Floats]:
    """[P, 3] metres along the facade, up, and out of the wall, of points [P, 3] of a scan with z up.

    The first facade is the vertical plane with the most points (RANSAC with a fixed seed), the next ones are those with
    the most remaining points. The outside of a wall is the side with fewer distant points; the coordinate along it
    starts at its left end, seen from outside.

    Raises:
        FacadeError: If there is no vertical plane.
    """
    if len(points) < 3:
        raise FacadeError(f"Expected a scan of at least 3 points, found {len(points)}.")
    random = np.random.default_rng(0)
    middle = points.mean(axis=0)
    seen = points[random.integers(len(points), size=min(_SEEN, len(points)))] - middle
    near = max(_NEAR * float(np.linalg.norm(np.ptp(seen, axis=0))), _FLAT)
    rest = seen
    for place in range(_MOST_PLANES):
        found = _plane(rest, near, random)
        if found is None and not place:
            raise FacadeError(
                "No vertical plane was found in the scan: its points lie on one line or on the ground (give --up if "
                "another axis is up)."
            )
        if found is None or (place and len(rest) < _LEAST * len(seen)):
            return
        normal, offset = _refined(rest, near, *found)
        yield _along(points - middle, points[:, 2], *_outward(seen, normal, offset))
        rest = rest[np.abs(rest @ normal - offset) > near]


def _plane(points: Floats, near: float, random: np.random.Generator) -> tuple[Floats, float] | None:
    """Normal and offset of the vertical plane with the most points; None if there is none."""
    best, found = 0, None
    if len(points) < 3:
        return None
    for triple in points[random.integers(len(points), size=(_TRIES, 3))]:
        normal = np.cross(triple[1] - triple[0], triple[2] - triple[0])
        length = float(np.linalg.norm(normal))
        if length <= 1e-12 or abs(normal[2]) > _LEVEL * length:
            continue
        normal = np.array([normal[0], normal[1], 0.0]) / np.hypot(normal[0], normal[1])
        offset = float(normal @ triple[0])
        count = int((np.abs(points @ normal - offset) < near).sum())
        if count > best:
            best, found = count, (normal, offset)
    return found


def _refined(points: Floats, near: float, normal: Floats, offset: float) -> tuple[Floats, float]:
    """The least-squares plane of the points near a plane, within a shrinking distance."""
    while True:
        own = points[np.abs(points @ normal - offset) < near][:, :2]
        if len(own) >= 3:
            center = own.mean(axis=0)
            across = np.linalg.eigh(np.cov((own - center).T))[1][:, 0]
            across = across if across @ normal[:2] > 0.0 else -across
            normal, offset = np.array([*across, 0.0]), float(across @ center)
        if near <= _FLAT:
            return normal, offset
        near = max(near / 2.0, _FLAT)


def _outward(seen: Floats, normal: Floats, offset: float) -> tuple[Floats, float]:
    """Direction out of the wall: parts behind it, such as rooms behind windows, extend farther than parts in front.

    If both sides extend equally far, the coordinate that changes most along the wall grows to the right.
    """
    depth = seen @ normal - offset
    farther = float(depth.max() + depth.min())
    if abs(farther) < _FLAT:
        farther = float(normal[1] if abs(normal[1]) > abs(normal[0]) else -normal[0])
    return (-normal, -offset) if farther > 0.0 else (normal, offset)


def _along(moved: Floats, up: Floats, normal: Floats, offset: float) -> Floats:
    depth = moved @ normal - offset
    along = moved @ np.array([-normal[1], normal[0], 0.0])
    wall = np.abs(depth) < _FLAT
    return np.stack([along - along[wall if wall.any() else slice(None)].min(), up, depth], axis=1)
