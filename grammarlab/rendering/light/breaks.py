"""Breaks between neighbouring samples of different surfaces: drawn edges, and limits for smoothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import AnyFloats, Flags
from grammarlab.rendering.light.surfaces import dot

CREASE_COSINE = 0.82
"""Cosine of the smallest angle of normals at a crease (35 degrees)."""
JUMP = 4.0
"""Largest distance from the surface, in spacings, of a neighbour on the same surface."""
SILHOUETTE_STRENGTH, JUMP_STRENGTH, CREASE_STRENGTH = np.float32(1.0), np.float32(0.9), np.float32(0.55)
PERIOD_WEIGHTS = (1.0, 0.5)
"""Weights of neighbours one and two samples away: with the sample's own 1, a window of four samples in all."""


@dataclass(frozen=True, slots=True)
class Breaks:
    """Between each sample and the next along one axis of a picture [H, W]."""

    axis: int
    silhouette: Flags
    """[H - 1, W] or [H, W - 1] whether only one of both shows the model."""
    jump: Flags
    """Both show the model, one behind the other."""
    crease: Flags
    """Both show the model, meeting at an angle."""

    @property
    def together(self) -> Flags:
        """Whether both samples show the same surface."""
        return ~(self.silhouette | self.jump | self.crease)


def find_breaks(shows: Flags, points: AnyFloats, normals: AnyFloats, spacing: float) -> tuple[Breaks, Breaks]:
    """Breaks along the rows and along the columns.

    Args:
        shows: [H, W] whether a sample shows the model.
        points: [H, W, 3] points of the surfaces.
        normals: [H, W, 3] unit vectors.
        spacing: distance between the points of neighbouring samples on a surface that faces the eye.
    """
    return _breaks(0, shows, points, normals, spacing), _breaks(1, shows, points, normals, spacing)


def _breaks(axis: int, shows: Flags, points: AnyFloats, normals: AnyFloats, spacing: float) -> Breaks:
    first, second = _neighbours(axis)
    step = points[second] - points[first]
    off_plane = np.minimum(np.abs(dot(step, normals[first])), np.abs(dot(step, normals[second])))
    shows_both = shows[first] & shows[second]
    jump = shows_both & (off_plane > JUMP * spacing)
    crease = shows_both & ~jump & (dot(normals[first], normals[second]) < CREASE_COSINE)
    return Breaks(axis, shows[first] != shows[second], jump, crease)


def edge_strength(shows: Flags, breaks: tuple[Breaks, Breaks]) -> AnyFloats:
    """[H, W] how strongly each sample of the model is an edge, 0..1."""
    strength = np.zeros(shows.shape, np.float32)
    for along_axis in breaks:
        drawn = np.where(along_axis.jump, JUMP_STRENGTH, np.where(along_axis.crease, CREASE_STRENGTH, np.float32(0)))
        drawn = np.where(along_axis.silhouette, SILHOUETTE_STRENGTH, drawn)
        for side in _neighbours(along_axis.axis):
            np.maximum(strength[side], drawn, out=strength[side])
    strength[~shows] = 0
    return strength


def smooth(values: AnyFloats, breaks: tuple[Breaks, Breaks]) -> AnyFloats:
    """Means [H, W] over windows of 4 x 4 samples that stay on one surface.

    A pattern with a period of four samples, such as that of the rays, becomes constant.
    """
    for along_axis in breaks:
        values = _smooth_along(values, along_axis.axis, along_axis.together)
    return values


def _smooth_along(values: AnyFloats, axis: int, together: Flags) -> AnyFloats:
    total, weight = values.copy(), np.ones_like(values)
    linked = together
    for distance, share in enumerate(PERIOD_WEIGHTS, start=1):
        if distance > 1:
            linked = linked[_shifted(axis, 0, 1)] & together[_shifted(axis, distance - 1)]
        first, second = _shifted(axis, 0, distance), _shifted(axis, distance)
        amount = linked * np.float32(share)
        total[first] += amount * values[second]
        total[second] += amount * values[first]
        weight[first] += amount
        weight[second] += amount
    return total / weight


def _neighbours(axis: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Index of all samples but the last along an axis, and of all but the first."""
    return _shifted(axis, 0, 1), _shifted(axis, 1)


def _shifted(axis: int, start: int, drop: int = 0) -> tuple[slice, ...]:
    """Index without the first `start` and the last `drop` along an axis."""
    return tuple(slice(start, -drop or None) if a == axis else slice(None) for a in (0, 1))
