"""The data term of labels: distance of the points of every element from every deformed template placed on it."""

from __future__ import annotations

from typing import TypeAlias

import jax
import jax.numpy as jnp
import numpy as np

from grammarlab.facade.templates.clouds import Clouds
from grammarlab.facade.templates.elements import Floats, Ints
from grammarlab.facade.templates.fitting.residuals import residuals
from grammarlab.facade.templates.template import Stack

Array: TypeAlias = jax.Array

_ANCHORS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.5]])
"""Anchors, corners and centre: one of them stays at its position in the element's own fit."""


def place_labels(
    clouds: Clouds, stack: Stack, state: Floats, owner: Ints, values: Floats, scale: float
) -> tuple[Floats, Floats]:
    """Mean distances [N, L] of the points of elements from labels, and the corners [L, N, 2] of the best positions.

    Args:
        clouds: the N elements.
        stack: the T templates.
        state: [N, T, 2 + D] fits of single elements.
        owner: [L] template of each label.
        values: [L, D] parameters of each label.
        scale: largest distance of a point, metres.
    """
    own = state[:, owner]  # [N, L, 2 + D]
    room = own[:, :, None, 2:4] - values[None, :, None, :2]
    corners = own[:, :, None, :2] + room * _ANCHORS
    found = _distances(
        *(jnp.asarray(each, jnp.float32) for each in (clouds.points, clouds.weight, corners)),
        jnp.asarray(stack.pieces[owner], jnp.float32),
        jnp.asarray(values, jnp.float32),
        jnp.asarray(scale, jnp.float32),
    )
    distance = np.asarray(found, dtype=np.float64)
    best = distance.argmin(axis=2)
    picked = np.take_along_axis(corners, best[:, :, None, None], axis=2)[:, :, 0]
    return distance.min(axis=2), np.moveaxis(picked, 1, 0)


@jax.jit
def _distances(points: Array, weight: Array, corners: Array, pieces: Array, values: Array, scale: Array) -> Array:
    def one(corner: Array, pieces: Array, values: Array, points: Array, weight: Array) -> Array:
        away = jnp.abs(residuals(jnp.concatenate([corner, values]), pieces, points))
        return (weight * jnp.minimum(away, scale)).sum() / weight.sum()

    anchors = jax.vmap(one, in_axes=(0, None, None, None, None))
    labels = jax.vmap(anchors, in_axes=(0, 0, 0, None, None))
    return jax.lax.map(lambda each: labels(each[2], pieces, values, each[0], each[1]), (points, weight, corners))
