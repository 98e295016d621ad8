"""The loop of the paper: deform, find a common space, label, find similarities; until labels are stable.

Templates are deformed to all elements with coupled parameters (paper 001, Equations 5.1 and 5.4). The data term of a
label is the distance of the points of every element from the deformed template placed on it. The deformations by all
templates give a common low-dimensional space of elements (section 5.4.2): Dong, Frossard, Vandergheynst and Nefedov,
"Clustering on multi-layer graphs via subspace analysis on Grassmann manifolds": L_mod = sum_j L_j - alpha sum_j U_j
U_j^T, whose lowest eigenvectors are near to all U_j.
"""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
import optax

from grammarlab.arrays import Floats, Ints
from grammarlab.extras import require
from grammarlab.matching.elements import Clouds, Elements, clouds_of, too_poor
from grammarlab.matching.fit import Fits, fit_all
from grammarlab.matching.match import Clock, Match
from grammarlab.matching.match_assembly import couplings, replicas, similarity_threshold
from grammarlab.matching.paper_labelling import Field, label
from grammarlab.matching.plain import description, fitting, from_labels, unfit
from grammarlab.matching.point_density import Array, along_and_across, outline
from grammarlab.matching.template import Stack, Template, stack

_SIMILARITY_WEIGHT = 10.0
"""w_sim of Equation 5.1: weight of E_sim."""
_ALPHA = 0.5
"""alpha of L_mod: weight of the common space of all templates."""
_MOST_DIMENSIONS = 10
"""Largest number of dimensions of the common space."""
_MOST_ITERATIONS = 12
"""Largest number of iterations of the loop."""
_TEMPLATES_PER_ELEMENT = 3
"""Number of best templates whose deformations become labels, for each element."""
_SMOOTHNESS_WEIGHT = 0.1
"""w_s of Equation 5.3: weight of the smoothness term."""
_NUM_STEPS = 60
"""Number of steps of Adam."""
_STEP_RATIO = 0.02
"""Initial step size of Adam, as a multiple of the scale."""
_ANCHORS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.5]])
"""Anchors, corners and centre: one of them stays at its position in the element's own fit."""
_LABEL_COST = 0.2
"""Cost of a template, as a fraction of the mean data cost."""
_SPACE_RATIO = 4.0
"""Unit of Equation 5.2, which the paper does not give, as a multiple of the similarity threshold."""


def match_as_paper(elements: Elements, templates: Sequence[Template]) -> Match:
    """Kinds of elements by the paper's loop, with its weights."""
    require("ortools")
    clock = Clock()
    reasons = too_poor(elements)
    indices = np.array([element for element in range(len(elements)) if element not in reasons], dtype=np.int64)
    stacked = stack(templates)
    clouds = clouds_of(elements, indices)
    fits = fit_all(clouds, stacked)
    fine = fitting(clouds, templates, fits)
    reasons |= unfit(clouds, templates, ~fine)
    indices = indices[fine]
    clouds = clouds_of(elements, indices)
    fits = fits.subset(fine)
    clock.lap("fitting")
    threshold = similarity_threshold(elements)
    state = np.concatenate([fits.corner, fits.parameters], axis=2)
    owner, values, corner = np.zeros(len(indices), dtype=np.int64), state[:, 0, 2:], state[:, 0, :2]
    previous: tuple[Ints, Ints] | None = None
    iterations = 0
    while len(indices) and iterations < _MOST_ITERATIONS:
        iterations += 1
        field, label_values, label_corner = _field(clouds, templates, stacked, fits, state, threshold)
        clock.lap("subspace")
        labels, _ = label(field)
        clock.lap("labelling")
        owner, values = field.owner[labels], label_values[labels]
        corner = label_corner[labels, np.arange(len(indices))]
        groups = replicas(owner, values, threshold)
        if previous is not None and (previous[0] == owner).all() and (previous[1] == groups).all():
            break
        previous = owner, groups
        coupled = couplings(owner, values, stacked.used, threshold)
        clock.lap("similarity")
        state = _deformed(clouds, stacked, state, coupled, 10.0 * threshold)
        clock.lap("deformation")
    kind = replicas(owner, values, threshold)
    return from_labels(
        elements, templates, indices, kind, owner, values, corner, fits, reasons, iterations=iterations, clock=clock
    )


def similarity(basis: Floats) -> Floats:
    """[N, N] similarity of elements from 0 to 1, by their Euclidean distance in a space [N, K]; 0 on the diagonal."""
    rows = basis / np.maximum(np.linalg.norm(basis, axis=1, keepdims=True), 1e-12)
    distance = np.linalg.norm(rows[:, None] - rows[None], axis=-1)
    near = np.exp(-((distance / 0.5) ** 2))
    np.fill_diagonal(near, 0.0)
    return near


def merged(weights: Floats, dimensions: int) -> Floats:
    """[N, dimensions] common basis of the graphs [J, N, N]."""
    laplacians = [laplacian(layer) for layer in weights]
    modified = np.sum(laplacians, axis=0)
    for matrix in laplacians:
        basis = lowest(matrix, dimensions)
        modified -= _ALPHA * basis @ basis.T
    return lowest(modified, dimensions)


def laplacian(weights: Floats) -> Floats:
    """[N, N] normalised Laplacian of a graph of symmetric weights [N, N] >= 0."""
    degree = 1.0 / np.sqrt(np.maximum(weights.sum(axis=1), 1e-12))
    return np.eye(len(weights)) - degree[:, None] * weights * degree


def lowest(matrix: Floats, dimensions: int) -> Floats:
    """[N, dimensions] eigenvectors of the smallest eigenvalues of a symmetric matrix."""
    return np.linalg.eigh(matrix)[1][:, :dimensions]


def energy(state: Array, pieces: Array, points: Array, weight: Array, scale: Array) -> Array:
    """E_fit: mean robust squared distance, square metres; outliers count at most `scale` squared (Geman-McClure)."""
    square = residuals(state, pieces, points) ** 2
    return (weight * square / (1.0 + square / scale**2)).sum() / weight.sum()


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


def similarity_energy(parameters: Array, coupled: Array) -> Array:
    """E_sim: sum over pairs of c^T (d_i - d_k)^2 (Equation 5.4).

    Args:
        parameters: [N, T, D] parameters.
        coupled: [T, D, N, N] c: 1 if a parameter of two elements is coupled, symmetric, 0 on the diagonal.
    """
    moved = jnp.moveaxis(parameters, 0, -1)
    away = moved[..., :, None] - moved[..., None, :]
    return 0.5 * (coupled * away**2).sum()


def _nearest_piece(segments: Array, points: Array) -> Array:
    """[P] index of the segment [S, 2, 2] nearest to each point [P, 2]; segments of length 0 are ignored."""
    start, step = segments[:, 0], segments[:, 1] - segments[:, 0]
    square = (step**2).sum(-1)
    along, across = jax.vmap(along_and_across, in_axes=(0, 0, None))(start, step, points)
    square = jnp.maximum(square, 1e-9)[:, None]
    beyond = along - jnp.clip(along, 0.0, square)
    distance = (across**2 + beyond**2) / square
    return jnp.argmin(jnp.where(square > 1e-9, distance, jnp.inf), axis=0)


def _field(
    clouds: Clouds, templates: Sequence[Template], stacked: Stack, fits: Fits, state: Floats, threshold: float
) -> tuple[Field, Floats, Floats]:
    """The field of Equation 5.3, the parameters [L, D] of its labels and their corners [L, N, 2] on each element."""
    misfit = fits.noise.min(axis=1, keepdims=True) * _misfit(clouds, templates, fits)
    best = np.argsort(misfit, axis=1)[:, :_TEMPLATES_PER_ELEMENT]
    element = np.repeat(np.arange(len(best)), best.shape[1])
    owner = best.reshape(-1).astype(np.int64)
    values = state[element, owner, 2:]
    data, corner = _place_labels(clouds, stacked, state, owner, values, 10.0 * threshold)
    data += np.minimum(misfit, 10.0 * threshold)[:, owner]
    away = np.linalg.norm(values[:, None] - values[None], axis=2)
    other = max(float(away.max(initial=0.0)) / 2.0, 1e-3)
    same = owner[:, None] == owner[None]
    # A metric: the distance of labels of different templates is half of the largest distance within one.
    distance = np.where(same, np.minimum(away, 2.0 * other), other)
    weights = _weights_of(state[:, np.unique(owner), 2:], _SPACE_RATIO * threshold)
    near = similarity(merged(weights, min(_dimensions_of(weights), len(best))))
    cost = np.full(len(stacked.usual), _LABEL_COST * float(data.min(axis=1).mean()))
    return Field(data, _SMOOTHNESS_WEIGHT * near, distance, owner, cost), values, corner


def _misfit(clouds: Clouds, templates: Sequence[Template], fits: Fits) -> Floats:
    """[N, T] nats per point that each template describes an element worse by than the best one."""
    costs = description(clouds, templates, fits)[:, :-1]
    return (costs - costs.min(axis=1, keepdims=True)) / clouds.weight.sum(axis=1, keepdims=True)


def _place_labels(
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
    fits = state[:, owner]  # [N, L, 2 + D]
    room = fits[:, :, None, 2:4] - values[None, :, None, :2]
    corners = fits[:, :, None, :2] + room * _ANCHORS
    distances = _distances(
        *(jnp.asarray(array, jnp.float32) for array in (clouds.points, clouds.weight, corners)),
        jnp.asarray(stack.pieces[owner], jnp.float32),
        jnp.asarray(values, jnp.float32),
        jnp.asarray(scale, jnp.float32),
    )
    distance = np.asarray(distances, dtype=np.float64)
    best = distance.argmin(axis=2)
    picked = np.take_along_axis(corners, best[:, :, None, None], axis=2)[:, :, 0]
    return distance.min(axis=2), np.moveaxis(picked, 1, 0)


@jax.jit
def _distances(points: Array, weight: Array, corners: Array, pieces: Array, values: Array, scale: Array) -> Array:
    def distance_at(corner: Array, pieces: Array, values: Array, points: Array, weight: Array) -> Array:
        away = jnp.abs(residuals(jnp.concatenate([corner, values]), pieces, points))
        return (weight * jnp.minimum(away, scale)).sum() / weight.sum()

    anchors = jax.vmap(distance_at, in_axes=(0, None, None, None, None))
    labels = jax.vmap(anchors, in_axes=(0, 0, 0, None, None))
    return jax.lax.map(
        lambda element: labels(element[2], pieces, values, element[0], element[1]), (points, weight, corners)
    )


def _weights_of(parameters: Floats, scale: float) -> Floats:
    """[T, N, N] weights exp(-|d_i - d_k|^2) of deformations [N, T, D], in units of a length (Equation 5.2)."""
    away = (parameters[:, None] - parameters[None]) / scale
    return np.moveaxis(np.exp(-(away**2).sum(axis=-1)), -1, 0)


def _dimensions_of(weights: Floats) -> int:
    """Number of eigenvectors to keep: up to the largest gap between the mean eigenvalues of all graphs [T, N, N]."""
    values = np.mean([np.linalg.eigvalsh(laplacian(layer)) for layer in weights], axis=0)
    # The value after the last one is that of another, distant element: so a few elements may all be separate.
    return 1 + int(np.argmax(np.diff(np.append(values, 1.0)[: _MOST_DIMENSIONS + 2])))


def _deformed(clouds: Clouds, stack: Stack, state: Floats, coupled: Floats, scale: float) -> Floats:
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
    return np.asarray(_deform(*(jnp.asarray(values, jnp.float32) for values in numbers), scale), dtype=np.float64)


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
        return fit + _SIMILARITY_WEIGHT * similarity_energy(state[:, :, 2:], coupled)

    rate = optax.cosine_decay_schedule(_STEP_RATIO * scale, _NUM_STEPS)
    optimizer = optax.adam(rate)
    free = jnp.concatenate([jnp.ones((*used.shape[:-1], 2)), used], axis=-1)

    def step(carry: tuple, _: None) -> tuple[tuple, None]:
        state, memory = carry
        change, memory = optimizer.update(jax.grad(total)(state), memory)
        moved = state + jnp.asarray(change) * free
        return (moved.at[..., 2:].set(jnp.clip(moved[..., 2:], low, high)), memory), None

    (state, _), _ = jax.lax.scan(step, (state, optimizer.init(state)), None, _NUM_STEPS)
    return state
