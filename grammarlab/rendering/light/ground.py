"""Ground below a model: the region that the model can darken, and by how much."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats, Flags
from grammarlab.rendering.light.lighting import OPENNESS_REACH, Exposure, sun_spread
from grammarlab.rendering.light.look import Look

SLACK = 1e-3
"""Margin of the areas in model units, against rounding."""


@dataclass(frozen=True, slots=True)
class Ground:
    """The level ground below a model, in model units, and the parts of it that the model can darken."""

    height: float
    low: AnyFloats
    """[2] smallest x and z of the model."""
    high: AnyFloats
    """[2] largest x and z."""
    shadow_sides: AnyFloats
    """[F, 3] lines (a, b, c) around all shadow: inside is a x + b z + c <= 0. One that nothing fulfils without sun."""

    def meet(self, origins: AnyFloats, directions: AnyFloats) -> tuple[NDArray[np.int64], AnyFloats]:
        """Rays [N, 3] that meet the ground where the model can darken it: their rows [K], and the points [K, 3]."""
        rows = np.flatnonzero(directions[:, 1] < -1e-6)
        distance = (np.float32(self.height) - origins[rows, 1]) / directions[rows, 1]
        x = origins[rows, 0] + distance * directions[rows, 0]
        z = origins[rows, 2] + distance * directions[rows, 2]
        dark = np.flatnonzero((distance > 0) & (self.is_near(x, z) | self._may_be_in_shadow(x, z)))
        points = np.stack([x[dark], np.full(len(dark), self.height, np.float32), z[dark]], axis=1)
        return rows[dark], points.astype(np.float32)

    def is_near(self, x: AnyFloats, z: AnyFloats) -> Flags:
        """[N] whether the model can hide a part of the sky from these places."""
        reach = OPENNESS_REACH + SLACK
        (low_x, low_z), (high_x, high_z) = self.low - reach, self.high + reach
        return (x > low_x) & (x < high_x) & (z > low_z) & (z < high_z)

    def _may_be_in_shadow(self, x: AnyFloats, z: AnyFloats) -> Flags:
        inside = np.ones(len(x), bool)
        for a, b, c in self.shadow_sides.astype(np.float32):
            inside &= a * x + b * z + c <= 0
        return inside


def ground_below(low: AnyFloats, high: AnyFloats, height: float, sun: AnyFloats, look: Look) -> Ground:
    """The ground below a box that holds a model.

    Args:
        low: [3] smallest coordinates, in model units.
        high: [3] largest ones.
        height: height of the ground, at most that of the box.
        sun: [3] direction of the middle of the sun.
        look: the light, with the size of the sun.
    """
    flat = np.array([0, 2])
    return Ground(height, low[flat], high[flat], _shadow_sides(low - SLACK, high + SLACK, height, sun, look))


def ground_light(look: Look, exposure: Exposure) -> AnyFloats:
    """[K, 3] factor of the paper by the model's shadow and ambient occlusion."""
    shadow, contact = np.array(look.shadow, np.float32), np.array(look.contact, np.float32)
    in_shadow = 1.0 - (1.0 - exposure.sun)[:, None] * (1.0 - shadow)
    return in_shadow * (1.0 - (1.0 - exposure.free)[:, None] * (1.0 - contact))


def _shadow_sides(low: AnyFloats, high: AnyFloats, height: float, sun: AnyFloats, look: Look) -> AnyFloats:
    """[F, 3] the sides of a convex area on the ground that holds every shadow of a box."""
    directions = sun_spread(sun, look)
    if directions[:, 1].min() <= 1e-3:
        return np.array([[0.0, 0.0, 1.0]]) if sun[1] <= 0 else np.zeros((0, 3))
    corners = np.where(np.indices((2, 2, 2)).reshape(3, -1).T, high, low)
    way = (corners[:, None, 1] - height) / directions[None, :, 1]
    points = corners[:, None, [0, 2]] - way[..., None] * directions[None][..., [0, 2]]
    return _hull_sides(points.reshape(-1, 2))


def _hull_sides(points: AnyFloats) -> AnyFloats:
    """[F, 3] the sides of the convex hull of points [N, 2] that are not on one line; inside is a x + b z + c <= 0.

    By the monotone chain of Andrew (1979). SciPy has this, but takes longer to load than a picture to be drawn.
    """
    ordered = sorted({(x, z) for x, z in points.astype(np.float64).tolist()})
    hull: list[tuple[float, float]] = []
    for way in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for point in way:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], point) <= 0.0:
                chain.pop()
            chain.append(point)
        hull += chain[:-1]
    corners = np.array(hull)
    along = np.roll(corners, -1, axis=0) - corners
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(along[:, 0], along[:, 1])[:, None]
    return np.column_stack([normal, -(normal * corners).sum(axis=1)])


def _turn(first: tuple[float, float], middle: tuple[float, float], last: tuple[float, float]) -> float:
    """Twice the area of a triangle, positive if it turns left."""
    (ax, az), (bx, bz), (cx, cz) = first, middle, last
    return (bx - ax) * (cz - az) - (bz - az) * (cx - ax)
