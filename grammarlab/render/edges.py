"""Drawn edges: creases, silhouettes and jumps in depth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

CREASE_COSINE = 0.82
"""Normals that turn by more (35 degrees) meet in a drawn crease."""


def edge_strength(hit: NDArray[np.bool_], points: Floats, normals: Floats, spacing: float) -> Floats:
    """How strongly each sample is an edge, 0..1.

    Args:
        hit: [H, W] whether the sample shows the model.
        points: [H, W, 3] where it does.
        normals: [H, W, 3] unit vectors.
        spacing: distance between the surface points of neighbouring samples that face the eye.
    """
    strength = np.zeros(hit.shape, np.float32)
    for axis in (0, 1):
        first = tuple(slice(None, -1) if a == axis else slice(None) for a in (0, 1))
        second = tuple(slice(1, None) if a == axis else slice(None) for a in (0, 1))
        found = _between(hit[first], hit[second], points[first], points[second], normals[first], normals[second], spacing)
        np.maximum(strength[first], np.where(hit[first], found, 0), out=strength[first])
        np.maximum(strength[second], np.where(hit[second], found, 0), out=strength[second])
    return strength


def _between(
    hit: NDArray[np.bool_],
    other_hit: NDArray[np.bool_],
    point: Floats,
    other_point: Floats,
    normal: Floats,
    other_normal: Floats,
    spacing: float,
) -> Floats:
    """Strength of the edge between samples and their neighbours."""
    step = other_point - point
    off_plane = np.minimum(
        np.abs(np.einsum("...i,...i->...", step, normal)), np.abs(np.einsum("...i,...i->...", step, other_normal))
    )
    jump = off_plane > 4.0 * spacing
    crease = np.einsum("...i,...i->...", normal, other_normal) < CREASE_COSINE
    both = hit & other_hit
    strength = np.where(both & jump, np.float32(0.9), np.where(both & crease, np.float32(0.55), np.float32(0)))
    return np.where(hit != other_hit, np.float32(1), strength)
