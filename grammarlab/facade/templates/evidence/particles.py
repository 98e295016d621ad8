"""Posterior samples of the sizes of each element, by tempered sequential Monte Carlo.

Integrated over are the place of the element, the half-plane that hides a part of it and the noise. What is cut off is
"at least so large" all by itself: once a side lies behind the half-plane, its place no longer changes the density.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp

from grammarlab.facade.templates.evidence.density import Array, log_likelihood
from grammarlab.facade.templates.outline import outline

TEMPERATURES = 10
MOVES = 2
"""At each temperature."""
LAST_MOVES = 6
"""At the posterior itself; the samples after each of them are kept."""
NEAREST, FARTHEST = -0.3, 2.0
"""Of the half-plane from the middle of an element, in parts of its half extent; beyond 1 nothing is hidden."""


class Task(NamedTuple):
    """One element, in metres from the middle of its box."""

    points: Array
    """[P, 2]"""
    weight: Array
    """[P] 0 for padding."""
    area: Array
    """Of the box."""
    reach: Array
    """[2, 2] lowest and highest coordinates of its points, without the outermost ones."""


class Bounds(NamedTuple):
    """Between which values all parameters are equally likely beforehand."""

    low: Array
    """[D] of width, height and further parameters."""
    high: Array
    """[D]"""
    limits: Array
    """[C, 1 + D] what is never below 0, as a template has it."""
    noise: Array
    """[2] metres."""


class Samples(NamedTuple):
    """Equally weighted samples of one element."""

    parameters: Array
    """[Q, D]"""
    corner: Array
    """[Q, 2] lower left corner, metres from the middle of the box."""
    plane: Array
    """[Q, 2] angle and distance of what hides."""
    noise: Array
    """[Q] metres."""
    evidence: Array
    """Logarithm of the marginal likelihood."""


def _parameters(state: Array, size: int) -> Array:
    """[D] width, height and further parameters of a state: sides (4), further (D - 2), angle, cut, log noise."""
    return jnp.concatenate([jnp.stack([state[1] - state[0], state[3] - state[2]]), state[4 : 4 + size - 2]])


def _log_prior(state: Array, bounds: Bounds) -> Array:
    size = len(bounds.low)
    parameters = _parameters(state, size)
    angle, cut, log_noise = state[-3], state[-2], state[-1]
    across, up = jnp.cos(angle), jnp.sin(angle)
    half = 0.5 * (jnp.abs(across) * parameters[0] + jnp.abs(up) * parameters[1])
    middle = 0.5 * (across * (state[0] + state[1]) + up * (state[2] + state[3]))
    place = (cut - middle) / jnp.maximum(half, 1e-6)
    inside = ((parameters >= bounds.low) & (parameters <= bounds.high)).all()
    # Equalities are written as two limits: half a centimetre of play lets samples move between them.
    inside &= (bounds.limits[:, 0] + bounds.limits[:, 1:] @ parameters >= -0.005).all()
    inside &= (place > NEAREST) & (place < FARTHEST)
    inside &= (log_noise > jnp.log(bounds.noise[0])) & (log_noise < jnp.log(bounds.noise[1]))
    return jnp.where(inside, -jnp.log(jnp.maximum(half, 1e-6)), -jnp.inf)


def _start(key: Array, task: Task, bounds: Bounds) -> Array:
    """A state near what is seen, with sides farther out half of the time."""
    keys = jax.random.split(key, 5)
    spread = 0.1 * (task.reach[1] - task.reach[0]) + 1e-3
    near = jax.random.normal(keys[0], (2, 2)) * spread
    room = jnp.maximum(bounds.high[:2] - (task.reach[1] - task.reach[0]), 0.0)
    far = jax.random.uniform(keys[1], (2, 2)) * room * jnp.array([[-1.0], [1.0]])
    hidden = jax.random.bernoulli(keys[2], 0.25, (2, 2))
    sides = task.reach + jnp.where(hidden, far, near)
    low, high = jnp.minimum(sides[0], sides[1]), jnp.maximum(sides[0], sides[1])
    size = jnp.clip(high - low, bounds.low[:2] * 1.001, bounds.high[:2] * 0.999)
    low, high = (low + high - size) / 2, (low + high + size) / 2
    part = jax.random.uniform(keys[3], (len(bounds.low) + 1,))
    further = bounds.low[2:] + part[3:] * (bounds.high[2:] - bounds.low[2:])
    angle = 2.0 * jnp.pi * part[0]
    normal = jnp.stack([jnp.cos(angle), jnp.sin(angle)])
    place = NEAREST + part[1] * (FARTHEST - NEAREST)
    cut = normal @ (low + high) / 2 + place * 0.5 * (jnp.abs(normal) @ size)
    log_noise = jnp.log(bounds.noise[0]) + part[2] * jnp.log(bounds.noise[1] / bounds.noise[0])
    sides = jnp.stack([low[0], high[0], low[1], high[1]])
    return jnp.concatenate([sides, further, jnp.stack([angle, cut, log_noise])])


def _resample(key: Array, log_weight: Array) -> Array:
    """[Q] which particles go on, systematically."""
    number = len(log_weight)
    edges = jnp.cumsum(jax.nn.softmax(log_weight))
    places = (jnp.arange(number) + jax.random.uniform(key)) / number
    return jnp.clip(jnp.searchsorted(edges, places), 0, number - 1)


def _sample(key: Array, task: Task, bounds: Bounds, wires: Array, number: int) -> Samples:
    size = len(bounds.low)

    def log_prior(state: Array) -> Array:
        return _log_prior(state, bounds)

    def log_like(state: Array) -> Array:
        corner = jnp.stack([state[0], state[2]])
        segments = outline(wires, _parameters(state, size)) + corner
        return log_likelihood(
            segments, state[-3], state[-2], jnp.exp(state[-1]), task.points, task.weight, task.area
        )

    prior, like = jax.vmap(log_prior), jax.vmap(log_like)

    def move(
        key: Array, states: Array, priors: Array, likes: Array, temperature: Array
    ) -> tuple[Array, Array, Array]:
        """One Metropolis step along differences of other particles, in a random part of the coordinates."""
        keys = jax.random.split(key, 6)
        others = jax.random.randint(keys[0], (2, number), 0, number)
        part = jax.random.choice(keys[1], jnp.array([0.25, 0.5, 1.0]), (number, 1))
        chosen = jax.random.uniform(keys[2], states.shape) < part
        chosen = chosen.at[jnp.arange(number), jax.random.randint(keys[5], (number,), 0, states.shape[1])].set(True)
        count = chosen.sum(axis=1, keepdims=True)
        step = 2.38 / jnp.sqrt(2.0 * count) * (states[others[0]] - states[others[1]])
        step += 1e-4 * jax.random.normal(keys[3], states.shape)
        proposed = states + jnp.where(chosen, step, 0.0)
        new_priors = prior(proposed)
        new_likes = like(proposed)
        ratio = new_priors - priors + temperature * (new_likes - likes)
        taken = jnp.log(jax.random.uniform(keys[4], (number,))) < ratio
        return (
            jnp.where(taken[:, None], proposed, states),
            jnp.where(taken, new_priors, priors),
            jnp.where(taken, new_likes, likes),
        )

    def cool(carry: tuple, place: Array) -> tuple[tuple, None]:
        key, states, priors, likes, evidence = carry
        key, pick, *moving = jax.random.split(key, 2 + MOVES)
        before, after = (place / TEMPERATURES) ** 3, ((place + 1) / TEMPERATURES) ** 3
        log_weight = (after - before) * likes
        evidence += jax.nn.logsumexp(log_weight) - jnp.log(number)
        chosen = _resample(pick, log_weight)
        states, priors, likes = states[chosen], priors[chosen], likes[chosen]
        for each in moving:
            states, priors, likes = move(each, states, priors, likes, after)
        return (key, states, priors, likes, evidence), None

    def last(carry: tuple, _: None) -> tuple[tuple, Array]:
        key, states, priors, likes = carry
        key, each = jax.random.split(key)
        states, priors, likes = move(each, states, priors, likes, jnp.ones(()))
        return (key, states, priors, likes), states

    key, begin = jax.random.split(key)
    states = jax.vmap(lambda each: _start(each, task, bounds))(jax.random.split(begin, number))
    priors = prior(states)
    carry = (key, states, priors, jnp.where(jnp.isfinite(priors), like(states), -1e9), jnp.zeros(()))
    (key, states, priors, likes, evidence), _ = jax.lax.scan(cool, carry, jnp.arange(TEMPERATURES))
    _, kept = jax.lax.scan(last, (key, states, priors, likes), None, LAST_MOVES)
    kept = kept.reshape(-1, states.shape[1])
    parameters = jax.vmap(lambda state: _parameters(state, size))(kept)
    return Samples(parameters, kept[:, jnp.array([0, 2])], kept[:, -3:-1], jnp.exp(kept[:, -1]), evidence)


@partial(jax.jit, static_argnames="number")
def sample(keys: Array, tasks: Task, bounds: Bounds, wires: Array, number: int) -> Samples:
    """Samples of N elements, one after the other, so that memory does not grow with N.

    Args:
        keys: [N] random keys.
        tasks: N elements.
        bounds: of the template's parameters, the same for all.
        wires: [S, 7, 1 + D] of the template, see `outline`.
        number: particles of each element; `LAST_MOVES` times as many samples come out.
    """
    return jax.lax.map(lambda each: _sample(each[0], each[1], bounds, wires, number), (keys, tasks))
