"""Posterior samples of the sizes of each element, by tempered sequential Monte Carlo.

The position of the element, the occluding half-plane and the noise are integrated out. For a cut element, the result is
a lower bound of the size without further rules: the position of a side behind the half-plane does not affect the
density.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp

from grammarlab.matching.point_density import Array, log_likelihood, outline

Column: TypeAlias = Any
"""An array of JAX during sampling, of NumPy afterwards."""

TEMPERATURES = 10
MOVES = 3
"""Moves at each temperature."""
LAST_MOVES = 6
"""Moves at the posterior itself; the samples after each of them are kept."""
COLDEST = 0.02
"""Initial inverse temperature."""
STEPS = TEMPERATURES * MOVES + LAST_MOVES
NEAREST, FARTHEST = -0.3, 2.0
"""Range of the half-plane's distance from the centre of an element, in half extents; beyond 1 nothing is hidden."""

_SIDE_MOVE_SHARE = 0.3
"""Fraction of moves of one side by up to the largest size: other samples do not help where a side is hidden."""
_NUM_OUTERMOST = 4
"""Number of outermost points in a direction at which a half-plane may begin; points beyond it are outliers."""


class CenteredElement(NamedTuple):
    """One element, in metres from the centre of its box."""

    points: Array
    """[P, 2] points."""
    weight: Array
    """[P] weights; 0 for padding."""
    area: Array
    """Area of the box."""
    reach: Array
    """[2, 2] lowest and highest coordinates of its points, without the outermost ones."""


class Bounds(NamedTuple):
    """Bounds of the uniform prior of all parameters."""

    low: Array
    """[D] least width, height and further parameters."""
    high: Array
    """[D] largest values."""
    limits: Array
    """[C, 1 + D] linear forms that are at least 0, from the template."""
    noise: Array
    """[2] least and largest noise, metres."""


class ParticleSamples(NamedTuple):
    """Equally weighted samples of one element."""

    parameters: Column
    """[Q, D] parameters."""
    corner: Column
    """[Q, 2] lower left corner, metres from the centre of the box."""
    plane: Column
    """[Q, 2] angle and distance of the occluding half-plane."""
    noise: Column
    """[Q] noise, metres."""
    evidence: Column
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
    relative_cut = (cut - middle) / jnp.maximum(half, 1e-6)
    inside = ((parameters >= bounds.low) & (parameters <= bounds.high)).all()
    # Equalities are two limits: a tolerance of half a centimetre lets samples move between them.
    inside &= (bounds.limits[:, 0] + bounds.limits[:, 1:] @ parameters >= -0.005).all()
    inside &= (relative_cut > NEAREST) & (relative_cut < FARTHEST)
    inside &= (log_noise > jnp.log(bounds.noise[0])) & (log_noise < jnp.log(bounds.noise[1]))
    return jnp.where(inside, -jnp.log(jnp.maximum(half, 1e-6)), -jnp.inf)


class ParticleDraws(NamedTuple):
    """All random numbers of one element, as an argument of the sampler."""

    begin: Array
    """[Q, 10 + D] uniform in 0 to 1."""
    resampling: Array
    """[STEPS] uniform in 0 to 1."""
    moves: Array
    """[STEPS, Q, 8 + 2 (5 + D)] uniform in 0 to 1: partners, fraction of the coordinates, one of them, acceptance,
    whether one side moves, which one and how far; then for all coordinates which ones, and jitter."""


def num_draws(size: int) -> tuple[int, int]:
    """Last axes of `ParticleDraws.begin` and `ParticleDraws.moves` for D parameters."""
    return 10 + size, 8 + 2 * (5 + size)


def _start(draw: Array, task: CenteredElement, bounds: Bounds) -> tuple[Array, Array]:
    """A state near the visible points, and the logarithm of its proposal density.

    A side is exactly or roughly at the outermost points, or anywhere farther out; the half-plane is anywhere, or just
    beyond one of the outermost points in its direction.
    """
    extent = task.reach[1] - task.reach[0]
    scale = jnp.sqrt(bounds.noise[0] * bounds.noise[1])
    widths = jnp.stack([jnp.full(2, 2.0 * scale), 0.06 * extent])
    room = jnp.maximum(bounds.high[:2] - extent, 0.05 * extent)
    outward = jnp.array([[-1.0], [1.0]])
    component = jnp.floor(3.0 * draw[0:4]).reshape(2, 2)
    part = draw[4:8].reshape(2, 2)
    normal = jax.scipy.special.ndtri(jnp.clip(part, 1e-4, 1.0 - 1e-4))
    away = jnp.where(component == 0, normal * widths[0], jnp.where(component == 1, normal * widths[1], part * room))
    sides = task.reach + outward * away
    near = jnp.exp(-0.5 * (away[None] / widths[:, None]) ** 2) / (2.5066283 * widths[:, None])
    far = jnp.where((away >= 0.0) & (away <= room), 1.0 / room, 0.0)
    density = jnp.log((near.sum(axis=0) + far) / 3.0).sum()
    further = bounds.low[2:] + draw[12 : 10 + len(bounds.low)] * (bounds.high[2:] - bounds.low[2:])
    angle = 2.0 * jnp.pi * draw[8]
    direction = jnp.stack([jnp.cos(angle), jnp.sin(angle)])
    half = 0.5 * (jnp.abs(direction) @ jnp.abs(sides[1] - sides[0])) + 1e-6
    middle = direction @ (sides[0] + sides[1]) / 2
    outermost = jax.lax.top_k(jnp.where(task.weight > 0.0, task.points @ direction, -jnp.inf), _NUM_OUTERMOST)[0]
    choice = draw[9] * 2.0 * _NUM_OUTERMOST
    beyond = outermost[jnp.minimum(choice.astype(jnp.int32), _NUM_OUTERMOST - 1)]
    beyond += 2.0 * scale * jax.scipy.special.ndtri(jnp.clip(draw[10], 1e-4, 1.0 - 1e-4))
    cut = jnp.where(choice < _NUM_OUTERMOST, beyond, middle + (NEAREST + draw[10] * (FARTHEST - NEAREST)) * half)
    close = jnp.exp(-0.5 * ((cut - outermost) / (2.0 * scale)) ** 2).mean() / (2.5066283 * 2.0 * scale)
    relative_cut = (cut - middle) / half
    wide = jnp.where((relative_cut > NEAREST) & (relative_cut < FARTHEST), 1.0 / (half * (FARTHEST - NEAREST)), 0.0)
    density += jnp.log(0.5 * close + 0.5 * wide + 1e-30)
    log_noise = jnp.log(bounds.noise[0]) + draw[11] * jnp.log(bounds.noise[1] / bounds.noise[0])
    flat = jnp.stack([sides[0, 0], sides[1, 0], sides[0, 1], sides[1, 1]])
    return jnp.concatenate([flat, further, jnp.stack([angle, cut, log_noise])]), density


def _resampled(offset: Array, log_weight: Array) -> Array:
    """[Q] indices of the particles after systematic resampling; each of them once for equal weights."""
    number = len(log_weight)
    edges = jnp.cumsum(jax.nn.softmax(log_weight))
    positions = (jnp.arange(number) + 0.05 + 0.9 * offset) / number
    return jnp.clip(jnp.searchsorted(edges, positions), 0, number - 1)


def _sample(draws: ParticleDraws, task: CenteredElement, bounds: Bounds, pieces: Array) -> ParticleSamples:
    size = len(bounds.low)
    number = len(draws.begin)
    dimension = 5 + size
    largest = jnp.concatenate([jnp.repeat(bounds.high[:2], 2), jnp.zeros(dimension - 4)])

    def log_likelihood_of(state: Array) -> Array:
        corner = jnp.stack([state[0], state[2]])
        segments = outline(pieces, _parameters(state, size)) + corner
        return log_likelihood(segments, state[-3], state[-2], jnp.exp(state[-1]), task.points, task.weight, task.area)

    def measure(states: Array) -> tuple[Array, Array]:
        log_priors = jax.vmap(lambda state: _log_prior(state, bounds))(states)
        return log_priors, jnp.where(jnp.isfinite(log_priors), jax.vmap(log_likelihood_of)(states), -1e9)

    def step(carry: tuple, inputs: tuple) -> tuple[tuple, Array]:
        """Weights, resampling, and one Metropolis step along differences of other samples or of one side."""
        states, log_priors, log_likelihoods, evidence = carry
        offset, draw, before, after, first = inputs
        log_weight = (after - before) * log_likelihoods + first
        evidence += jax.nn.logsumexp(log_weight) - jnp.log(number)
        chosen = _resampled(offset, log_weight)
        states, log_priors, log_likelihoods = states[chosen], log_priors[chosen], log_likelihoods[chosen]
        partner = (draw[:, 0:2] * number).astype(jnp.int32)
        part = 2.0 ** -jnp.floor(3.0 * draw[:, 2:3])
        is_certain = jnp.floor(draw[:, 3:4] * dimension) == jnp.arange(dimension)
        moved = (draw[:, 8 : 8 + dimension] < part) | is_certain
        count = moved.sum(axis=1, keepdims=True)
        away = 2.38 / jnp.sqrt(2.0 * count) * (states[partner[:, 0]] - states[partner[:, 1]])
        away += 4e-4 * (draw[:, 8 + dimension :] - 0.5)
        side_move = largest * (jnp.floor(4.0 * draw[:, 6:7]) == jnp.arange(dimension)) * (2.0 * draw[:, 7:8] - 1.0) ** 3
        proposed = states + jnp.where(draw[:, 5:6] < _SIDE_MOVE_SHARE, side_move, jnp.where(moved, away, 0.0))
        new_log_priors, new_log_likelihoods = measure(proposed)
        log_ratio = new_log_priors - log_priors + after * (new_log_likelihoods - log_likelihoods)
        is_accepted = jnp.log(draw[:, 4]) < log_ratio
        states = jnp.where(is_accepted[:, None], proposed, states)
        log_priors, log_likelihoods = (
            jnp.where(is_accepted, new_log_priors, log_priors),
            jnp.where(is_accepted, new_log_likelihoods, log_likelihoods),
        )
        return (states, log_priors, log_likelihoods, evidence), states

    states, density = jax.vmap(lambda draw: _start(draw, task, bounds))(draws.begin)
    log_priors, log_likelihoods = measure(states)
    heat = jnp.minimum(jnp.arange(STEPS + 1 + MOVES) // MOVES / TEMPERATURES, 1.0) ** 2
    heat = COLDEST + (1.0 - COLDEST) * heat
    # The first weights are the ratio of the first tempered posterior and the proposal density.
    log_ratio = jnp.maximum(log_priors - density + COLDEST * log_likelihoods, -1e9)
    first = jnp.zeros((STEPS, len(states))).at[0].set(log_ratio)
    # The first move at each temperature has weights; the others have the same temperature before and after.
    before, after = heat[MOVES - 1 : STEPS + MOVES - 1], heat[MOVES : STEPS + MOVES]
    carry, samples = jax.lax.scan(
        step,
        (states, log_priors, log_likelihoods, jnp.zeros(())),
        (draws.resampling, draws.moves, before, after, first),
    )
    samples = samples[-LAST_MOVES:].reshape(-1, dimension)
    parameters = jax.vmap(lambda state: _parameters(state, size))(samples)
    return ParticleSamples(
        parameters, samples[:, jnp.array([0, 2])], samples[:, -3:-1], jnp.exp(samples[:, -1]), carry[-1]
    )


@jax.jit
def sample(draws: ParticleDraws, tasks: CenteredElement, bounds: Bounds, pieces: Array) -> ParticleSamples:
    """Samples of N elements, one after the other, so that memory does not depend on N.

    Args:
        draws: draws of N elements with Q particles each; the result has `LAST_MOVES` times as many samples.
        tasks: the N elements.
        bounds: bounds of the template's parameters, the same for all.
        pieces: [S, 7, 1 + D] pieces of the template, see `outline`.
    """
    return jax.lax.map(lambda pair: _sample(pair[0], pair[1], bounds, pieces), (draws, tasks))
