"""Deformation of all templates to all elements, with coupled parameters (paper 001, Equations 5.1 and 5.4)."""

from __future__ import annotations

from typing import TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
import optax

from grammarlab.facade.templates.clouds import Clouds
from grammarlab.facade.templates.elements import Floats
from grammarlab.facade.templates.fitting.residuals import energy
from grammarlab.facade.templates.template import Stack

Array: TypeAlias = jax.Array

W_SIM = 10.0
_STEPS = 60
_RATE = 0.02
"""Initial step size of Adam, as a multiple of the scale."""


def similarity_energy(parameters: Array, coupled: Array) -> Array:
    """E_sim: sum over pairs of c^T (d_i - d_k)^2 (Equation 5.4).

    Args:
        parameters: [N, T, D] parameters.
        coupled: [T, D, N, N] c: 1 if a parameter of two elements is coupled, symmetric, 0 on the diagonal.
    """
    moved = jnp.moveaxis(parameters, 0, -1)
    away = moved[..., :, None] - moved[..., None, :]
    return 0.5 * (coupled * away**2).sum()


def deform(clouds: Clouds, stack: Stack, state: Floats, coupled: Floats, scale: float) -> Floats:
    """States [N, T, 2 + D] that minimise Equation 5.1, from initial ones.

    The pairs of each element are averaged, so that the coupling does not grow with the number of elements.

    Args:
        clouds: the N elements.
        stack: the T templates.
        state: [N, T, 2 + D] initial corner and parameters.
        coupled: [T, D, N, N] as in `similarity_energy`.
        scale: distance from which points are outliers, metres.
    """
    share = coupled / np.maximum(coupled.sum(axis=(1, 3), keepdims=True).max(axis=2, keepdims=True), 1.0)
    numbers = (clouds.points, clouds.weight, stack.pieces, stack.low, stack.high, stack.used, state, share)
    return np.asarray(_deform(*(jnp.asarray(each, jnp.float32) for each in numbers), scale), dtype=np.float64)


@jax.jit
def _deform(
    points: Array,
    weight: Array,
    pieces: Array,
    low: Array,
    high: Array,
    used: Array,
    state: Array,
    coupled: Array,
    scale: Array,
) -> Array:
    over_templates = jax.vmap(energy, in_axes=(0, 0, None, None, None))
    over_elements = jax.vmap(over_templates, in_axes=(0, None, 0, 0, None))

    def total(state: Array) -> Array:
        fit = over_elements(state, pieces, points, weight, scale).sum()
        return fit + W_SIM * similarity_energy(state[:, :, 2:], coupled)

    rate = optax.cosine_decay_schedule(_RATE * scale, _STEPS)
    optimizer = optax.adam(rate)
    free = jnp.concatenate([jnp.ones((*used.shape[:-1], 2)), used], axis=-1)

    def step(carry: tuple, _: None) -> tuple[tuple, None]:
        state, memory = carry
        change, memory = optimizer.update(jax.grad(total)(state), memory)
        moved = state + jnp.asarray(change) * free
        return (moved.at[..., 2:].set(jnp.clip(moved[..., 2:], low, high)), memory), None

    (state, _), _ = jax.lax.scan(step, (state, optimizer.init(state)), None, _STEPS)
    return state
