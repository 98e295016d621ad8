"""Robust fits of all templates to all elements in one call, each with a covariance and an occluding half-plane.

A wire of a template is a straight line or an arc. Its start (x, y), end (x, y) and the height of the arc over its
chord, to the right of the direction from start to end, are linear in the parameters: 5 rows of 1 + D coefficients, with
the constant first. An arc is drawn as a chain of chords. Every template is one array, so that one call draws all of
them. The energy E_fit of a fit is that of paper 001, Equation 5.1.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.matching.elements import Clouds
from grammarlab.matching.point_density import Array, along_and_across, log_likelihood, visible
from grammarlab.matching.template import Stack

_NUM_STEPS = 12
"""Number of Gauss-Newton steps."""
_NUM_DIRECTIONS = 12
"""Number of directions of half-planes that are tried."""
_MIN_OCCLUSION_GAIN = 4.0
"""Least gain of an occluding half-plane, nats, since its free position explains some points by chance."""
_MIN_NOISE_M = 0.002
"""Least noise of a fit, metres."""
_BATCH_SIZE = 8
"""Number of elements of a batch."""
_MIN_TEMPLATES = 16
"""Number of templates from which those with few pieces are fitted separately."""
_CLASS_ENDS = (24,)
"""Bounds of the classes of numbers of pieces: each is compiled, which takes as long as 100 elements."""


@dataclass(frozen=True, eq=False)
class Fits:
    """Fits of T templates to N elements."""

    corner: Floats
    """[N, T, 2] lower left corner, metres from the centre of the box."""
    parameters: Floats
    """[N, T, D] parameters, metres; 1 for templates with fewer parameters."""
    covariance: Floats
    """[N, T, D, D] square metres."""
    noise: Floats
    """[N, T] noise of the inliers, metres."""
    cost: Floats
    """[N, T] negative logarithm of the density of the points, nats."""
    inside: Floats
    """[N, T] fraction of inliers."""
    plane: Floats
    """[N, T, 2] angle of the occluding half-plane, and its distance from the centre of the box; inf for none."""
    hidden: Floats
    """[N, T] hidden fraction of the outline."""
    distance: Floats
    """[N, T] mean distance of the points, metres: the data term of Equation 5.3."""

    def subset(self, selection: NDArray[Any]) -> Fits:
        """The fits of some elements."""
        return Fits(**{field.name: getattr(self, field.name)[selection] for field in fields(self)})


def fit_all(clouds: Clouds, stack: Stack) -> Fits:
    """Fits of all templates to all elements; templates with few pieces are fitted separately, for speed."""
    number = len(clouds)
    # Whole batches of one size, so that one is compiled whatever the number of elements.
    batches = np.split(
        np.arange(-(-number // _BATCH_SIZE) * _BATCH_SIZE) % max(number, 1), range(_BATCH_SIZE, number, _BATCH_SIZE)
    )
    groups = _by_size(stack.num_pieces)
    results = []
    for most, indices in groups:
        columns = (stack.pieces[:, :most], stack.usual, stack.low, stack.high, stack.limits, stack.used, stack.guess)
        templates = tuple(jnp.asarray(column[indices], jnp.float32) for column in columns)
        fits = [_fit(_elements(clouds, batch), templates) for batch in batches]
        results.append([np.concatenate(column, dtype=np.float64) for column in zip(*fits, strict=True)])
    order = np.argsort(np.concatenate([indices for _, indices in groups]))
    stacked = (np.concatenate(column, axis=1) for column in zip(*results, strict=True))
    return Fits(**{field.name: column[:number, order] for field, column in zip(fields(Fits), stacked, strict=True)})


def residuals(state: Array, pieces: Array, points: Array) -> Array:
    """[P] signed distances, metres, from points to a template.

    Args:
        state: [2 + D] lower left corner, then parameters.
        pieces: [S, 7, 1 + D] pieces of the template.
        points: [P, 2] points.
    """
    segments = outline(pieces, state[2:]) + state[:2]
    chosen = jax.lax.stop_gradient(_nearest_piece(segments, points))
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

    def points_at(part: Array) -> Array:
        angle = half * (2.0 * part - 1.0)
        along = 0.5 + 0.5 * larger * jnp.sin(angle) / jnp.sin(half)
        out = 0.5 * (larger * jnp.cos(angle) - jnp.cos(half)) / jnp.sin(half)
        along = jnp.where(straight, part, along)
        out = jnp.where(straight, 0.0, out)
        return start + along[:, None] * chord + out[:, None] * across

    return jnp.stack([points_at(pieces[:, 5, 0]), points_at(pieces[:, 6, 0])], axis=1)


def background_cost(clouds: Clouds) -> Floats:
    """[N] negative logarithm of the density of the points without a template, nats."""
    return clouds.weight.sum(axis=1) * np.log(clouds.area)


def energy(state: Array, pieces: Array, points: Array, weight: Array, scale: Array) -> Array:
    """E_fit: mean robust squared distance, square metres; outliers count at most `scale` squared (Geman-McClure)."""
    square = residuals(state, pieces, points) ** 2
    return (weight * square / (1.0 + square / scale**2)).sum() / weight.sum()


def _by_size(count: Ints) -> list[tuple[int, Ints]]:
    """Numbers of pieces and their templates; a few templates do not justify separate compilations."""
    ends = (
        [int(count.max())]
        if len(count) < _MIN_TEMPLATES
        else [*(end for end in _CLASS_ENDS if end < count.max()), int(count.max())]
    )
    group = np.searchsorted(ends, count)
    return [(end, np.flatnonzero(group == index)) for index, end in enumerate(ends) if (group == index).any()]


@jax.jit
def _fit(clouds: tuple[Array, ...], templates: tuple[Array, ...]) -> tuple[Array, ...]:
    fit_templates = jax.vmap(_fit_one, in_axes=(*(None,) * len(clouds), *(0,) * len(templates)))
    return jax.lax.map(lambda cloud: fit_templates(*cloud, *templates), clouds)


def _fit_one(
    points: Array,
    weight: Array,
    area: Array,
    reach: Array,
    pieces: Array,
    usual: Array,
    low: Array,
    high: Array,
    limits: Array,
    used: Array,
    guess: Array,
) -> tuple[Array, ...]:
    begin = first_guess(reach, usual, low, high, guess)
    extent = (reach[1] - reach[0]).max()
    free = jnp.concatenate([jnp.ones(2), used])
    # Weak regularisation towards the initial state fixes parameters that no point determines.
    pull = 1.0 / (0.3 * extent) ** 2

    def linear(state: Array) -> tuple[Array, Array]:
        """Residuals [P] and their derivatives [P, 2 + D]."""

        def twice(state: Array) -> tuple[Array, Array]:
            value = residuals(state, pieces, points)
            return value, value

        slope, value = jax.jacfwd(twice, has_aux=True)(state)
        return value, slope

    def robust(value: Array, scale: Array) -> Array:
        return weight / (1.0 + (value / scale) ** 2) ** 2

    def step(carry: tuple[Array, Array, Array], iteration: Array) -> tuple[tuple[Array, Array, Array], None]:
        """The next state, with residuals and derivatives at the state before it; the last step does not move."""
        state = carry[0]
        scale = extent * jnp.maximum(0.2 * 0.7**iteration, 0.02)
        value, slopes = linear(state)
        weighted = slopes * robust(value, scale)[:, None]
        matrix, slope = weighted.T @ slopes, weighted.T @ value
        broken = jnp.minimum(limits[:, 0] + limits[:, 1:] @ state[2:], 0.0)
        normal = jnp.concatenate([jnp.zeros((len(limits), 2)), limits[:, 1:]], axis=1)
        stiff = 100.0 * (broken < 0.0)
        matrix += (normal * stiff[:, None]).T @ normal
        slope += normal.T @ (stiff * broken)
        anchor = pull * scale**2 * 0.05
        matrix += jnp.diag(anchor + 1e-3 + 1e6 * (1.0 - free))
        change = _inverse(matrix) @ (slope + anchor * (state - begin))
        moved = state - jnp.clip(change, -0.3 * extent, 0.3 * extent) * free
        moved = moved.at[2:].set(jnp.clip(moved[2:], low, high))
        return (jnp.where(iteration < _NUM_STEPS, moved, state), value, slopes), None

    # Residuals are compiled once, in the steps, since compilation takes longer than the fits of 100 elements.
    before = (begin, jnp.zeros(len(points)), jnp.zeros((len(points), len(begin))))
    (state, value, slopes), _ = jax.lax.scan(step, before, jnp.arange(_NUM_STEPS + 1))
    near = robust(value, 0.05 * extent)
    noise = jnp.sqrt((near * value**2).sum() / jnp.maximum(near.sum(), 1.0))
    noise = jnp.clip(1.1 * noise, _MIN_NOISE_M, 0.2 * extent)
    close = weight * (jnp.abs(value) < 4.0 * noise)
    inside = close.sum() / weight.sum()
    segments = outline(pieces, state[2:]) + state[:2]
    angle, cut, gain = _hiding(segments, points, close, noise)
    cost = -log_likelihood(segments, angle, cut, noise, points, weight, area)
    start, end = visible(segments, angle, cut)
    length = jnp.sqrt(((segments[:, 1] - segments[:, 0]) ** 2).sum(-1) + 1e-12)
    hidden = jnp.where(gain, 1.0 - (end - start).sum() / length.sum(), 0.0)
    full = (slopes * close[:, None]).T @ slopes / noise**2 + jnp.diag(1.0 / (0.5 * extent) ** 2 + 1e6 * (1.0 - free))
    covariance = _inverse(full)[2:, 2:]
    outside = (limits[:, 0] + limits[:, 1:] @ state[2:] < -0.02).any()
    cost = jnp.where(outside, 1e6, cost)
    distance = (weight * jnp.minimum(jnp.abs(value), 0.2 * extent)).sum() / weight.sum()
    return state[:2], state[2:], covariance, noise, cost, inside, jnp.stack([angle, cut]), hidden, distance


def first_guess(reach: Array, usual: Array, low: Array, high: Array, guess: Array) -> Array:
    """[2 + D] a template of the size of the visible points with usual proportions, or with usual values."""
    size = jnp.clip(reach[1] - reach[0], low[:2], high[:2])
    growth = jnp.where(guess > 0.0, size.min() / usual[:2].min(), 1.0)
    further = jnp.clip(usual[2:] * growth, low[2:], high[2:])
    size = jnp.where(guess > 0.0, size, usual[:2])
    corner = jnp.where(guess < 0.0, reach[1] - size, reach[0])
    return jnp.concatenate([corner, size, further])


def _nearest_piece(segments: Array, points: Array) -> Array:
    """[P] index of the segment [S, 2, 2] nearest to each point [P, 2]; segments of length 0 are ignored."""
    start, step = segments[:, 0], segments[:, 1] - segments[:, 0]
    square = (step**2).sum(-1)
    along, across = along_and_across(start, step, points)
    square = jnp.maximum(square, 1e-9)[:, None]
    beyond = along - jnp.clip(along, 0.0, square)
    distance = (across**2 + beyond**2) / square
    return jnp.argmin(jnp.where(square > 1e-9, distance, jnp.inf), axis=0)


def _inverse(matrix: Array) -> Array:
    """Inverse of a small positive definite matrix, by Gauss-Jordan elimination, which compiles faster than LAPACK."""

    def eliminate(index: Array, matrix: Array) -> Array:
        pivot = matrix[index, index]
        row = (matrix[index] / pivot).at[index].set(1.0 / pivot)
        column = matrix[:, index].at[index].set(0.0)
        return (matrix - jnp.outer(column, row)).at[:, index].set(-column / pivot).at[index].set(row)

    return jax.lax.fori_loop(0, len(matrix), eliminate, matrix)


def _hiding(segments: Array, points: Array, close: Array, noise: Array) -> tuple[Array, Array, Array]:
    """Angle and distance of the half-plane that hides the most outline without points, and whether it is accepted.

    A half-plane in a direction is just beyond the outermost point: nearer ones hide points, farther ones less outline.
    """
    angles = 2.0 * jnp.pi * jnp.arange(_NUM_DIRECTIONS) / _NUM_DIRECTIONS
    normals = jnp.stack([jnp.cos(angles), jnp.sin(angles)], axis=1)
    cuts = jnp.where(close[:, None] > 0.0, points @ normals.T, -jnp.inf).max(axis=0) + 0.5 * noise
    start, end = jax.vmap(visible, in_axes=(None, 0, 0))(segments, angles, cuts)
    length = jnp.sqrt(((segments[:, 1] - segments[:, 0]) ** 2).sum(-1) + 1e-12).sum()
    gains = -close.sum() * jnp.log(jnp.maximum((end - start).sum(axis=1), 1e-3) / length)
    best = jnp.argmax(gains)
    worth = gains[best] > _MIN_OCCLUSION_GAIN
    return angles[best], jnp.where(worth, cuts[best], jnp.inf), worth


def _elements(clouds: Clouds, batch: Ints) -> tuple[Array, ...]:
    columns = (clouds.points, clouds.weight, clouds.area, clouds.reach)
    return tuple(jnp.asarray(column[batch], jnp.float32) for column in columns)
