"""Outlines of templates for given parameters: every template is one array, so that one call draws all of them.

A wire of a template is a straight line or an arc. Its start (x, y), end (x, y) and the height of the arc over its
chord, to the right of the direction from start to end, are linear in the parameters: 5 rows of 1 + D coefficients, with
the constant first. An arc is drawn as a chain of chords.
"""

from __future__ import annotations

from typing import TypeAlias

import jax
import jax.numpy as jnp

Array: TypeAlias = jax.Array


def outline(pieces: Array, parameters: Array) -> Array:
    """[S, 2, 2] start and end of each piece, relative to the template's origin.

    Args:
        pieces: [S, 7, 1 + D] as in `Template.pieces`: 5 rows as above, then the fractions of the arc at which the piece
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

    def at(part: Array) -> Array:
        angle = half * (2.0 * part - 1.0)
        along = 0.5 + 0.5 * larger * jnp.sin(angle) / jnp.sin(half)
        out = 0.5 * (larger * jnp.cos(angle) - jnp.cos(half)) / jnp.sin(half)
        along = jnp.where(straight, part, along)
        out = jnp.where(straight, 0.0, out)
        return start + along[:, None] * chord + out[:, None] * across

    return jnp.stack([at(pieces[:, 5, 0]), at(pieces[:, 6, 0])], axis=1)
