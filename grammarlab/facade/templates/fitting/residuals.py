"""Distances from points to a template, and the energy E_fit of a fit (paper 001, Equation 5.1)."""

from __future__ import annotations

from typing import TypeAlias

import jax
import jax.numpy as jnp

from grammarlab.facade.templates.outline import outline

Array: TypeAlias = jax.Array


def nearest_piece(segments: Array, points: Array) -> Array:
    """[P] index of the segment [S, 2, 2] nearest to each point [P, 2]; segments of length 0 are ignored."""
    start, step = segments[:, 0], segments[:, 1] - segments[:, 0]
    square = (step**2).sum(-1)
    away = points[:, None] - start
    part = jnp.clip((away * step).sum(-1) / jnp.maximum(square, 1e-9), 0.0, 1.0)
    distance = ((away - part[..., None] * step) ** 2).sum(-1)
    return jnp.argmin(jnp.where(square > 1e-9, distance, jnp.inf), axis=1)


def residuals(state: Array, pieces: Array, points: Array) -> Array:
    """[P] signed distances, metres, from points to a template.

    Args:
        state: [2 + D] lower left corner, then parameters.
        pieces: [S, 7, 1 + D] pieces of the template.
        points: [P, 2] points.
    """
    segments = outline(pieces, state[2:]) + state[:2]
    chosen = jax.lax.stop_gradient(nearest_piece(segments, points))
    start, end = segments[chosen, 0], segments[chosen, 1]
    step = end - start
    length = jnp.sqrt((step**2).sum(-1) + 1e-12)
    away = points - start
    along = (away * step).sum(-1) / length
    across = (away[:, 0] * step[:, 1] - away[:, 1] * step[:, 0]) / length
    beyond = along - jnp.clip(along, 0.0, length)
    sign = jnp.where(across >= 0.0, 1.0, -1.0)
    # Beyond the end of its piece, the distance of a point is that to the end.
    return jnp.where(jnp.abs(beyond) < 1e-9, across, sign * jnp.sqrt(across**2 + beyond**2 + 1e-12))


def energy(state: Array, pieces: Array, points: Array, weight: Array, scale: Array) -> Array:
    """E_fit: mean robust squared distance, square metres; outliers count at most `scale` squared (Geman-McClure)."""
    square = residuals(state, pieces, points) ** 2
    return (weight * square / (1.0 + square / scale**2)).sum() / weight.sum()
