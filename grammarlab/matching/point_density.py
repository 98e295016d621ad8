"""Density of the points of an element around its visible outline.

The visible outline V of an element is its template cut by a half-plane. Points are uniform on V with normal noise s in
both coordinates, and a fraction e of them is uniform in the box:
p(x) = (1 - e) / |V| integral_V N(x; u, s^2) du + e / |box|, in closed form for each segment.
"""

from __future__ import annotations

from typing import TypeAlias

import jax
import jax.numpy as jnp

from grammarlab.matching.fit import OUTLIERS

Array: TypeAlias = jax.Array
_NUM_UNROLLED = 4
"""Number of pieces whose densities are added in one loop over the points."""
_EPSILON = 1e-6
"""Least slope of a segment along a normal, and least visible length, metres: avoids divisions by 0."""


def outline(pieces: Array, parameters: Array) -> Array:
    """[S, 2, 2] start and end of each piece, relative to the template's origin.

    Args:
        pieces: [S, 7, 1 + D] as in `Template.pieces`: 5 rows of `fit`, then the fractions of the arc at which the piece
            begins and ends, in the first column.
        parameters: [D] parameters.
    """
    values = pieces[:, :5, 0] + pieces[:, :5, 1:] @ parameters
    start, end, height = values[:, 0:2], values[:, 2:4], values[:, 4]
    chord = end - start
    length = jnp.sqrt((chord**2).sum(-1) + 1e-12)
    half = 2.0 * jnp.arctan2(2.0 * height, length)
    # Straight lines are arcs of a tiny angle, since the formula below is undefined for angle 0.
    half = jnp.where(jnp.abs(half) < 1e-3, 1e-3, half)
    across = jnp.stack([chord[:, 1], -chord[:, 0]], axis=1)
    straight = jnp.abs(height) < 1e-9
    # Chords lie inside of their arc; those of a slightly larger circle have the same mean distance.
    larger = 1.5 - 0.5 * jnp.cos(half * (pieces[:, 6, 0] - pieces[:, 5, 0]))

    def points_at(part: Array) -> Array:
        angle = half * (2.0 * part - 1.0)
        along = 0.5 + 0.5 * larger * jnp.sin(angle) / jnp.sin(half)
        out = 0.5 * (larger * jnp.cos(angle) - jnp.cos(half)) / jnp.sin(half)
        along = jnp.where(straight, part, along)
        out = jnp.where(straight, 0.0, out)
        return start + along[:, None] * chord + out[:, None] * across

    return jnp.stack([points_at(pieces[:, 5, 0]), points_at(pieces[:, 6, 0])], axis=1)


def log_likelihood(
    segments: Array, angle: Array, cut: Array, noise: Array, points: Array, weight: Array, area: Array
) -> Array:
    """Log-density of the points of one element.

    Args:
        segments: [S, 2, 2] outline; segments of length 0 are ignored.
        angle: direction of the normal of the occluding half-plane, radians.
        cut: distance of the half-plane from the origin along that normal, metres.
        noise: s, metres.
        points: [P, 2] points.
        weight: [P] weight of each point; 0 for padding.
        area: area of the box, square metres.
    """
    start, end = visible(segments, angle, cut)
    scale = 0.70710678 / noise

    def add(near: Array, piece: tuple[Array, Array, Array]) -> tuple[Array, None]:
        segment, begin, finish = piece
        step = segment[1] - segment[0]
        direction = step / jnp.sqrt((step**2).sum() + 1e-12)
        along, across = along_and_across(segment[0], direction, points)
        inside = jax.lax.erf((along - begin) * scale) - jax.lax.erf((along - finish) * scale)
        return near + jnp.exp(-((across * scale) ** 2)) * inside, None

    # One piece after the other, and products instead of sums: loops of sums are not vectorised, and take twice as long.
    near, _ = jax.lax.scan(
        add, jnp.zeros(len(points), dtype=points.dtype), (segments, start, end), unroll=_NUM_UNROLLED
    )
    total = (end - start).sum()
    density = near * (0.5 * 0.3989423 / noise) / jnp.maximum(total, _EPSILON)
    value = weight @ jnp.log((1.0 - OUTLIERS) * density + OUTLIERS / area)
    return jnp.where(total > 1e-3, value, -1e9)


def along_and_across(start: Array, direction: Array, points: Array) -> tuple[Array, Array]:
    """[P] coordinates of points [P, 2] from a start [2], along a direction [2] and to its right."""
    right, up = points[:, 0] - start[0], points[:, 1] - start[1]
    return right * direction[0] + up * direction[1], right * direction[1] - up * direction[0]


def visible(segments: Array, angle: Array, cut: Array) -> tuple[Array, Array]:
    """Start and end [S] of the visible part of each segment, in metres from its start.

    Args:
        segments: [S, 2, 2] start and end of each segment.
        angle: direction of the normal of the occluding half-plane, radians.
        cut: distance of the half-plane from the origin along that normal; points beyond it are hidden.
    """
    normal = jnp.stack([jnp.cos(angle), jnp.sin(angle)])
    step = segments[:, 1] - segments[:, 0]
    length = jnp.sqrt((step**2).sum(-1))
    slope = (step @ normal) / jnp.maximum(length, _EPSILON)
    room = cut - segments[:, 0] @ normal
    edge = room / jnp.where(jnp.abs(slope) < _EPSILON, _EPSILON, slope)
    start = jnp.where(slope < -_EPSILON, jnp.clip(edge, 0.0, length), 0.0)
    end = jnp.where(slope > _EPSILON, jnp.clip(edge, 0.0, length), length)
    is_visible = (jnp.abs(slope) > _EPSILON) | (room >= 0.0)
    return start, jnp.where(is_visible, jnp.maximum(end, start), start)
