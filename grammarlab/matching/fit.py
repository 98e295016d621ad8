"""Robust fits of all templates to all elements, each with a covariance and an occluding half-plane.

A wire of a template is a straight line or an arc. Its start (x, y), end (x, y) and the height of the arc over its
chord, to the right of the direction from start to end, are linear in the parameters: 5 rows of 1 + D coefficients, with
the constant first. An arc is drawn as a chain of chords.

The fits are Gauss-Newton steps with weights that ignore distant points more and more. The distance of a point from its
nearest piece changes with the ends of the piece as with its own foot on it: by the normal, times the shares of both
ends. All is plain NumPy over many pairs of elements and templates: compiling these steps takes longer than the fits of
a hundred elements.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from grammarlab.arrays import Floats, Ints
from grammarlab.matching.elements import Clouds
from grammarlab.matching.template import Stack

OUTLIERS = 0.05
"""e of the density of points: fraction of outliers."""
_NUM_STEPS = 12
"""Number of Gauss-Newton steps."""
_NUM_DIRECTIONS = 12
"""Number of directions of half-planes that are tried."""
_MIN_OCCLUSION_GAIN = 4.0
"""Least gain of an occluding half-plane, nats, since its free position explains some points by chance."""
_MIN_NOISE_M = 0.002
"""Least noise of a fit, metres."""
_MIN_SQUARE = 1e-9
"""Least squared length of a piece, square metres; shorter ones have no points."""
_BATCH_SIZE = 240_000
"""Number of distances between pieces and points of a batch of elements: a megabyte, about the size of a cache."""


@dataclass(frozen=True, eq=False)
class Fits:
    """Fits of T templates to N elements."""

    corner: Floats
    """[N, T, 2] lower left corner, metres from the centre of the box."""
    parameters: Floats
    """[N, T, D] parameters, metres; 1 for templates with fewer parameters."""
    covariance: Floats
    """[N, T, D, D] square metres; 0 for templates with fewer parameters."""
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


@dataclass(frozen=True, eq=False)
class _Wires:
    """R pieces of T templates with D parameters each, one template after the other."""

    stack: Stack
    """The T templates, with D parameters."""
    pieces: Floats
    """[R, 7, 1 + D] pieces without the padding, see `Template.pieces`; their length may be 0."""
    owner: Ints
    """[R] template of each piece, ascending."""
    first: Ints
    """[T] first piece of each template."""
    arcs: Ints
    """Indices of the pieces of arcs."""

    def sums(self, values: Floats) -> Floats:
        """[E, T, ...] sums over the pieces of each template, of [E, R, ...]."""
        return np.add.reduceat(values, self.first, axis=1)


@dataclass(frozen=True, eq=False)
class _Points:
    """P points of each of E elements."""

    xy: Floats
    """[E, P, 2] metres from the centre of the box."""
    weight: Floats
    """[E, P] weights; 0 for padding."""
    area: Floats
    """[E] areas of the boxes, square metres."""
    reach: Floats
    """[E, 2, 2] lowest and highest coordinates, without the outermost points."""

    @property
    def extent(self) -> Floats:
        """[E, 1] longer side of what is visible, metres."""
        return (self.reach[:, 1] - self.reach[:, 0]).max(axis=1, keepdims=True)


@dataclass(frozen=True, eq=False)
class _Residuals:
    """Signed distances of the points of E elements from T templates, and how they change."""

    value: Floats
    """[E, T, P] distances from the nearest piece, metres."""
    slopes: NDArray[np.floating[Any]]
    """[E, T, 2 + D, P] derivatives by corner and parameters."""
    ends: Floats
    """[E, R, 4] x and y of the start, then of the end, of each piece, metres."""


def fit_all(clouds: Clouds, stack: Stack) -> Fits:
    """Fits of all templates to all elements."""
    num, num_templates, size = len(clouds), *stack.usual.shape
    result = Fits(
        corner=np.zeros((num, num_templates, 2)),
        parameters=np.ones((num, num_templates, size)),
        covariance=np.zeros((num, num_templates, size, size)),
        noise=np.zeros((num, num_templates)),
        cost=np.zeros((num, num_templates)),
        inside=np.zeros((num, num_templates)),
        plane=np.zeros((num, num_templates, 2)),
        hidden=np.zeros((num, num_templates)),
        distance=np.zeros((num, num_templates)),
    )
    for indices, wires in _by_parameters(stack):
        used = wires.stack.usual.shape[1]
        step = max(1, _BATCH_SIZE // (len(wires.pieces) * clouds.points.shape[1]))
        for first in range(0, num, step):
            batch = slice(first, min(first + step, num))
            points = _Points(clouds.points[batch], clouds.weight[batch], clouds.area[batch], clouds.reach[batch])
            fits = _fit(points, wires)
            rows = np.ix_(np.arange(num)[batch], indices)
            for field in fields(Fits):
                column = getattr(result, field.name)
                inner = tuple(slice(used) for _ in column.shape[2:]) if column.shape[2:3] == (size,) else ()
                column[(*rows, *inner)] = getattr(fits, field.name)
    return result


def first_guess(reach: Floats, stack: Stack) -> Floats:
    """[E, T, 2 + D] templates of the size of the visible points with usual proportions, or with usual values."""
    guess = stack.guess[:, None]
    size = np.clip((reach[:, 1] - reach[:, 0])[:, None], stack.low[:, :2], stack.high[:, :2])
    growth = size.min(axis=-1, keepdims=True) / stack.usual[:, :2].min(axis=-1, keepdims=True)
    further = np.clip(stack.usual[:, 2:] * np.where(guess > 0.0, growth, 1.0), stack.low[:, 2:], stack.high[:, 2:])
    size = np.where(guess > 0.0, size, stack.usual[:, :2])
    corner = np.where(guess < 0.0, reach[:, None, 1] - size, reach[:, None, 0])
    return np.concatenate([corner, size, further], axis=-1)


def background_cost(clouds: Clouds) -> Floats:
    """[N] negative logarithm of the density of the points without a template, nats."""
    return clouds.weight.sum(axis=1) * np.log(clouds.area)


def _by_parameters(stack: Stack) -> Iterator[tuple[Ints, _Wires]]:
    """Templates with equal numbers of parameters, and their indices."""
    sizes = stack.used.sum(axis=1).astype(np.int64)
    for size in np.unique(sizes).tolist():
        indices = np.flatnonzero(sizes == size)
        some = stack.subset(indices)
        some = replace(
            some,
            pieces=some.pieces[..., : 1 + size],
            usual=some.usual[:, :size],
            low=some.low[:, :size],
            high=some.high[:, :size],
            limits=some.limits[..., : 1 + size],
            used=some.used[:, :size],
        )
        owner, piece = np.nonzero((some.pieces[:, :, :5] != 0.0).any(axis=(2, 3)))
        pieces = some.pieces[owner, piece]
        first = np.searchsorted(owner, np.arange(len(indices)))
        arcs = np.flatnonzero((pieces[:, 4] != 0.0).any(axis=1))
        yield indices, _Wires(some, pieces, owner, first, arcs)


def _fit(points: _Points, wires: _Wires) -> Fits:
    """Fits of T templates to E elements."""
    limits = wires.stack.limits
    extent = points.extent
    begin = state = first_guess(points.reach, wires.stack)
    for iteration in range(_NUM_STEPS):
        scale = extent * max(0.2 * 0.7**iteration, 0.02)
        state = _moved(state, begin, _residuals(points, state, wires), points, wires.stack, scale)
    last = _residuals(points, state, wires)
    near = _robust(points.weight, last.value, 0.05 * extent)
    noise = np.sqrt((near * last.value**2).sum(axis=-1) / np.maximum(near.sum(axis=-1), 1.0))
    noise = np.clip(1.1 * noise, _MIN_NOISE_M, 0.2 * extent)
    close = points.weight[:, None] * (np.abs(last.value) < 4.0 * noise[..., None])
    total = points.weight.sum(axis=1, keepdims=True)
    plane, is_hidden = _hiding(last.ends, points, close, noise, wires)
    length, visible_length, cost = _costs(last.ends, plane, noise, points, wires)
    precision = _weighted(last.slopes, close)[1] / noise[..., None, None] ** 2
    precision += np.eye(state.shape[-1]) / (0.5 * extent[..., None, None]) ** 2
    is_outside = (_margins(limits, state) < -0.02).any(axis=-1)
    away = np.minimum(np.abs(last.value), 0.2 * extent[..., None])
    return Fits(
        corner=state[..., :2],
        parameters=state[..., 2:],
        covariance=np.linalg.inv(precision)[..., 2:, 2:],
        noise=noise,
        cost=np.where(is_outside, 1e6, cost),
        inside=close.sum(axis=-1) / total,
        plane=plane,
        hidden=np.where(is_hidden, 1.0 - visible_length / length, 0.0),
        distance=(points.weight[:, None] * away).sum(axis=-1) / total,
    )


def _moved(state: Floats, begin: Floats, residuals: _Residuals, points: _Points, stack: Stack, scale: Floats) -> Floats:
    """States [E, T, 2 + D] after a Gauss-Newton step; points farther than the scale [E, 1], metres, hardly count."""
    extent = points.extent[..., None]
    weight = _robust(points.weight, residuals.value, scale)
    weighted, matrix = _weighted(residuals.slopes, weight)
    slope = (weighted @ residuals.value[..., None])[..., 0].astype(np.float64)
    normal = np.concatenate([np.zeros((*stack.limits.shape[:2], 2)), stack.limits[..., 1:]], axis=-1)
    broken = np.minimum(_margins(stack.limits, state), 0.0)
    stiff = 100.0 * (broken < 0.0)
    if stiff.any():
        matrix += np.einsum("tck,etc,tcl->etkl", normal, stiff, normal)
        slope += np.einsum("tck,etc->etk", normal, stiff * broken)
    # Weak regularisation towards the initial state fixes parameters that no point determines.
    anchor = 0.05 * (scale[..., None] / (0.3 * extent)) ** 2
    matrix += np.eye(state.shape[-1]) * (anchor + 1e-3)[..., None]
    change = np.linalg.solve(matrix, (slope + anchor * (state - begin))[..., None])[..., 0]
    moved = state - np.clip(change, -0.3 * extent, 0.3 * extent)
    moved[..., 2:] = np.clip(moved[..., 2:], stack.low, stack.high)
    return moved


def _robust(weight: Floats, value: Floats, scale: Floats) -> Floats:
    """[E, T, P] weights of points by their distances, metres, relative to a scale [E, 1]."""
    return (weight[:, None] / (1.0 + (value / scale[..., None].astype(value.dtype)) ** 2) ** 2).astype(value.dtype)


def _weighted(slopes: NDArray[np.floating[Any]], weight: Floats) -> tuple[NDArray[np.floating[Any]], Floats]:
    """Derivatives [E, T, 2 + D, P] times weights, and their products [E, T, 2 + D, 2 + D] over all points."""
    weighted = slopes * weight[:, :, None].astype(slopes.dtype)
    return weighted, (weighted @ slopes.swapaxes(-1, -2)).astype(np.float64)


def _margins(limits: Floats, state: Floats) -> Floats:
    """[E, T, C] values of the limits of each template, at least 0 where they hold."""
    return limits[..., 0] + np.einsum("tcd,etd->etc", limits[..., 1:], state[..., 2:])


def _residuals(points: _Points, state: Floats, wires: _Wires) -> _Residuals:
    """Distances of points from the nearest pieces of templates, with their derivatives.

    Args:
        points: points of E elements.
        state: [E, T, 2 + D] lower left corner, then parameters.
        wires: T templates.
    """
    ends, coefficients = _outline(wires, state)
    num, size, num_points = len(state), state.shape[-1], points.xy.shape[1]
    shape = num, state.shape[1], num_points
    nearest = _nearest(ends, points, wires) + len(wires.pieces) * np.arange(num)[:, None, None]
    x_start, y_start, x_end, y_end = (column.ravel()[nearest] for column in np.moveaxis(ends, -1, 0).astype(np.float32))
    x, y = (points.xy[:, None, :, axis].astype(np.float32) for axis in (0, 1))
    right, up = x_end - x_start, y_end - y_start
    length = np.sqrt(right**2 + up**2 + np.float32(1e-12))
    right, up = right / length, up / length
    along = (x - x_start) * right + (y - y_start) * up
    across = (x - x_start) * up - (y - y_start) * right
    foot = np.clip(along, 0.0, length)
    beyond = along - foot
    # Beyond the end of its piece, the distance of a point is that to the end.
    is_beyond = np.abs(beyond) > 0.0
    signed = np.where(across >= 0.0, 1.0, -1.0).astype(np.float32) * np.sqrt(across**2 + beyond**2 + np.float32(1e-12))
    value = np.where(is_beyond, signed, across)
    x_normal = np.where(is_beyond, (across * up + beyond * right) / signed, up)
    y_normal = np.where(is_beyond, (beyond * up - across * right) / signed, -right)
    share = foot / length
    pulls = (x_normal * (share - 1), y_normal * (share - 1), -x_normal * share, -y_normal * share)
    slopes = np.empty((*shape[:2], size, num_points), dtype=np.float32)
    slopes[:, :, 0], slopes[:, :, 1] = -x_normal, -y_normal
    for parameter in range(size - 2):
        chosen = [column.ravel()[nearest] for column in coefficients[:, parameter]]
        slopes[:, :, 2 + parameter] = sum(pull * column for pull, column in zip(pulls, chosen, strict=True))
    return _Residuals(value, slopes, ends)


def _nearest(ends: Floats, points: _Points, wires: _Wires) -> Ints:
    """[E, T, P] piece of each template that is nearest to a point."""
    step = ends[..., 2:] - ends[..., :2]
    square = (step**2).sum(axis=-1)
    along, across = _along_and_across(ends[..., :2], step, points.xy)
    along -= np.clip(along, 0.0, square[..., None].astype(along.dtype))
    distance = np.square(across, out=across)
    distance += np.square(along, out=along)
    distance *= (1.0 / np.maximum(square, _MIN_SQUARE))[..., None].astype(distance.dtype)
    # No factor does this: a piece of length 0 is at distance 0 from every point here.
    distance[square <= _MIN_SQUARE] = np.inf
    least = np.minimum.reduceat(distance, wires.first, axis=1)
    number = np.arange(len(wires.pieces), dtype=np.int32)[:, None]
    is_least = distance <= least[:, wires.owner]
    candidates = np.where(is_least, number, np.int32(len(wires.pieces) - 1))
    return np.minimum.reduceat(candidates, wires.first, axis=1).astype(np.int64)


def _along_and_across(start: Floats, direction: Floats, points: Floats) -> tuple[Floats, Floats]:
    """[E, R, P] coordinates of points [E, P, 2] from starts [E, R, 2], along directions and to their right.

    As products of matrices, all points of an element at once.
    """
    homogeneous = np.ones((len(points), 3, points.shape[1]), dtype=np.float32)
    homogeneous[:, :2] = points.swapaxes(1, 2)
    rows = np.empty((2, *start.shape[:2], 3), dtype=np.float32)
    right = np.stack([direction[..., 1], -direction[..., 0]], axis=-1)
    for row, normal in zip(rows, (direction, right), strict=True):
        row[..., :2], row[..., 2] = normal, -(start * normal).sum(axis=-1)
    return rows[0] @ homogeneous, rows[1] @ homogeneous


def _outline(wires: _Wires, state: Floats) -> tuple[Floats, NDArray[np.floating[Any]]]:
    """Ends [E, R, 4] of all pieces, metres, and their derivatives [4, D, E, R] by the parameters.

    Args:
        wires: T templates.
        state: [E, T, 2 + D] lower left corner, then parameters.
    """
    forms, arcs = wires.pieces[:, :5], wires.arcs
    parameters = state[:, wires.owner, 2:]
    values = forms[:, :, 0] + (forms[:, :, 1:] @ parameters[..., None])[..., 0]
    ends = values[..., :4].copy()
    straight = np.moveaxis(forms[:, :4, 1:], 0, -1)[:, :, None]
    slopes = np.repeat(straight.astype(np.float32), len(state), axis=2)
    if len(arcs):
        ends[:, arcs], by_value = _arc_pieces(values[:, arcs], wires.pieces[arcs, 5:, 0])
        slopes[..., arcs] = np.moveaxis(by_value @ forms[arcs, :, 1:], (2, 3), (0, 1))
    ends += np.tile(state[:, wires.owner, :2], 2)
    return ends, slopes


def _arc_pieces(values: Floats, parts: Floats) -> tuple[Floats, Floats]:
    """Ends [E, Q, 4] of chords of arcs, and their derivatives [E, Q, 4, 5].

    Args:
        values: [E, Q, 5] start, end, and height of the arc over its chord.
        parts: [Q, 2] fractions of the arc at which the piece begins and ends.
    """
    start, chord, height = values[..., 0:2], values[..., 2:4] - values[..., 0:2], values[..., 4]
    across = np.stack([chord[..., 1], -chord[..., 0]], axis=-1)
    length = np.sqrt((chord**2).sum(axis=-1) + 1e-12)
    half = 2.0 * np.arctan2(2.0 * height, length)
    # Straight lines are arcs of a tiny angle, since the formula below is undefined for angle 0.
    is_tiny, is_straight = np.abs(half) < 1e-3, np.abs(height) < 1e-9
    half = np.where(is_tiny, 1e-3, half)
    by_height = np.where(is_tiny, 0.0, 4.0 / (length**2 + 4.0 * height**2))
    by_end = (-by_height * height / length)[..., None] * chord
    half_slopes = np.concatenate([-by_end, by_end, (by_height * length)[..., None]], axis=-1)
    sine, cosine = np.sin(half), np.cos(half)
    # Chords lie inside of their arc; those of a slightly larger circle have the same mean distance.
    turn = parts[:, 1] - parts[:, 0]
    larger, larger_slope = 1.5 - 0.5 * np.cos(half * turn), 0.5 * turn * np.sin(half * turn)
    ends, slopes = np.empty((*height.shape, 4)), np.zeros((*height.shape, 4, 5))
    for index, part in enumerate(parts.T):
        angle, turned = half * (2.0 * part - 1.0), 2.0 * part - 1.0
        x, y = larger * np.sin(angle), larger * np.cos(angle)
        x_slope = larger_slope * np.sin(angle) + turned * y
        y_slope = larger_slope * np.cos(angle) - turned * x
        along = np.where(is_straight, part, 0.5 + 0.5 * x / sine)
        out = np.where(is_straight, 0.0, 0.5 * (y - cosine) / sine)
        along_slope = np.where(is_straight, 0.0, 0.5 * (x_slope - x * cosine / sine) / sine)
        out_slope = np.where(is_straight, 0.0, 0.5 * (y_slope + sine - (y - cosine) * cosine / sine) / sine)
        both = slice(2 * index, 2 * index + 2)
        ends[..., both] = start + along[..., None] * chord + out[..., None] * across
        by_half = along_slope[..., None] * chord + out_slope[..., None] * across
        block = slopes[..., both, :]
        block += by_half[..., None] * half_slopes[..., None, :]
        for axis, sign in ((0, 1.0), (1, -1.0)):
            block[..., axis, axis] += 1.0 - along
            block[..., axis, 2 + axis] += along
            block[..., axis, 1 - axis] -= sign * out
            block[..., axis, 3 - axis] += sign * out
    return ends, slopes


def _visible(ends: Floats, normal: Floats, cut: Floats) -> tuple[Floats, Floats]:
    """Start and end of the visible part of pieces, in metres from their start; see `point_density.visible`."""
    step = ends[..., 2:] - ends[..., :2]
    length = np.sqrt((step**2).sum(axis=-1))
    slope = (step * normal).sum(axis=-1) / np.maximum(length, 1e-6)
    room = cut - (ends[..., :2] * normal).sum(axis=-1)
    edge = np.clip(room / np.where(np.abs(slope) < 1e-6, 1e-6, slope), 0.0, length)
    start = np.where(slope < -1e-6, edge, 0.0)
    end = np.where(slope > 1e-6, edge, length)
    return start, np.where((np.abs(slope) > 1e-6) | (room >= 0.0), np.maximum(end, start), start)


def _hiding(ends: Floats, points: _Points, close: Floats, noise: Floats, wires: _Wires) -> tuple[Floats, NDArray[Any]]:
    """Half-planes that hide the most outline without points, and whether they are accepted.

    A half-plane in a direction is just beyond the outermost point: nearer ones hide points, farther ones less outline.

    Returns:
        [E, T, 2] angle, and distance from the centre of the box, inf for none; and [E, T] whether one is accepted.
    """
    angles = 2.0 * np.pi * np.arange(_NUM_DIRECTIONS) / _NUM_DIRECTIONS
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    heights = points.xy @ normals.T
    cuts = np.where(close[..., None] > 0.0, heights[:, None], -np.inf).max(axis=2) + 0.5 * noise[..., None]
    start, end = _visible(ends[:, :, None], normals, cuts[:, wires.owner])
    length = wires.sums(np.sqrt(((ends[..., 2:] - ends[..., :2]) ** 2).sum(axis=-1)))
    gains = -close.sum(axis=-1)[..., None] * np.log(np.maximum(wires.sums(end - start), 1e-3) / length[..., None])
    best = gains.argmax(axis=-1)
    is_hidden = np.take_along_axis(gains, best[..., None], axis=-1)[..., 0] > _MIN_OCCLUSION_GAIN
    cut = np.where(is_hidden, np.take_along_axis(cuts, best[..., None], axis=-1)[..., 0], np.inf)
    return np.stack([angles[best], cut], axis=-1), is_hidden


def _costs(ends: Floats, plane: Floats, noise: Floats, points: _Points, wires: _Wires) -> tuple[Floats, Floats, Floats]:
    """Lengths of templates and of their visible parts, metres, and costs of the points, nats; each [E, T].

    The density is that of `point_density.log_likelihood`.
    """
    normal = np.stack([np.cos(plane[..., 0]), np.sin(plane[..., 0])], axis=-1)
    start, end = _visible(ends, normal[:, wires.owner], plane[:, wires.owner, 1])
    step = ends[..., 2:] - ends[..., :2]
    length = np.sqrt((step**2).sum(axis=-1))
    along, across = _along_and_across(ends[..., :2], step / np.maximum(length, 1e-6)[..., None], points.xy)
    scale = (0.70710678 / noise)[:, wires.owner, None].astype(np.float32)
    begin, finish = (values[..., None].astype(np.float32) for values in (start, end))
    near = erf((along - begin) * scale) - erf((along - finish) * scale)
    near *= np.exp(-((across * scale) ** 2))
    visible_length = wires.sums(end - start)
    density = wires.sums(near) * (0.5 * 0.3989423 / noise / np.maximum(visible_length, 1e-6))[..., None]
    outliers = OUTLIERS / points.area[:, None, None]
    value = (points.weight[:, None] * np.log((1.0 - OUTLIERS) * density + outliers)).sum(axis=-1)
    return wires.sums(length), visible_length, -np.where(visible_length > 1e-3, value, -1e9)
