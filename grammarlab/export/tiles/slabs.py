"""Models as stacks of slabs: closed massing for what has too many walls.

The cross-section of a model at several heights is described by its support function: how far it reaches in each of a
few directions. Where the reach is about constant or linear in the height, the levels are one slab, with a polygon below
and one above. A spire is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, index_in_row
from grammarlab.export.tiles.plane_outlines import Outlines
from grammarlab.geometry.meshes.measure import area_vectors
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.ragged import next_in_row

_NUM_LEVELS = 20
"""Heights at which models are cut."""
_MIN_GAIN = 0.02
"""Smallest error that a further slab must avoid, as a share of the largest reach."""
_CLOSER = 0.95
"""Largest ratio of the sizes of sections for which directions along a wall are better than the axes."""
_SPIRE, _DROP = 0.1, 0.2
"""Largest area of the sections of a spire, as a share of the largest section and of the section below it."""
_OTHERS = 1e-6
"""Weight in colours of walls of what is level, and of roofs of what is upright, where there is nothing else."""
_SMALLEST = 0.05
"""Smallest area of a side in square metres."""


@dataclass(frozen=True, slots=True)
class _Cuts:
    """C points of cross-sections."""

    points: Floats
    """[C, 2] x and z in metres."""
    owner: Ints
    """[C] number of the model among those that have polygons."""
    level: Ints
    """[C]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sections:
    """Cross-sections of M models at L levels."""

    model: Ints
    """[M] ascending."""
    low: Floats
    """[M] lowest height in metres."""
    box: tuple[Floats, Floats]
    """Lowest and highest x and z [M, 2] of each model."""
    step: Floats
    """[M] metres between levels; the first is half a step above the lowest height."""
    top: Ints
    """[M] highest level; those above have the same section."""
    angle: Floats
    """[M, K] directions in radians, from x towards z."""
    reach: Floats
    """[M, L, K] metres from the origin of the model along the directions."""

    @property
    def num_directions(self) -> int:
        return self.angle.shape[1]


def slabs(polygons: Outlines, num_directions: int, most_slabs: int) -> Outlines:
    """The models of some polygons as stacks of slabs.

    Args:
        polygons: walls and roofs of models, in any order.
        num_directions: corners of slabs, at least 4.
        most_slabs: largest number of slabs of a model; each has at most ``3 * num_directions - 2`` triangles.
    """
    if not len(polygons):
        return polygons
    polygons = polygons.take(np.argsort(polygons.model, kind="stable"))
    vectors = area_vectors(Meshes.from_polygons(polygons.points, np.diff(polygons.offsets)))
    sections = _sections(polygons, vectors, num_directions)
    is_start = _starts(sections.reach, most_slabs)
    owner, first = np.nonzero(is_start)
    spans, is_straight = _spans(is_start), _errors(sections.reach, is_start)[1]
    last = spans[1][owner, first]
    bottom = _rings(sections, owner, first)
    top = np.where(is_straight[owner, first][:, None, None], bottom, _rings(sections, owner, last))
    heights = (
        sections.low[owner] + sections.step[owner] * level
        for level in (first, np.minimum(last, sections.top[owner]) + 1)
    )
    rings = [_at(ring, height) for ring, height in zip((bottom, top), heights, strict=True)]
    walls, roofs = _colors(polygons, vectors, sections, is_start)
    sides = np.stack((rings[1], np.roll(rings[1], -1, 1), np.roll(rings[0], -1, 1), rings[0]), axis=2)
    number = sections.num_directions
    model = sections.model[owner]
    parts = (
        _quads(sides.reshape(-1, 4, 3), model.repeat(number), walls.repeat(number, axis=0)),
        _quads(rings[1][:, ::-1], model, roofs),
    )
    return parts[0].joined(parts[1])


def _sections(polygons: Outlines, vectors: Floats, num_directions: int) -> _Sections:
    models, first = np.unique(polygons.model, return_index=True)
    starts, y, flat = polygons.offsets[first], polygons.points[:, 1], polygons.points[:, [0, 2]]
    low, high = np.minimum.reduceat(y, starts), np.maximum.reduceat(y, starts)
    step = np.maximum(high - low, 1e-6) / _NUM_LEVELS
    cuts = _cuts(polygons, models, low, step)
    facing = _facing(polygons, vectors, models)
    # The axes or the directions of the largest wall, whichever fit more closely.
    turns = 2.0 * np.pi * np.arange(num_directions) / num_directions
    along_axes, along_wall = (_reach(cuts, angle[:, None] + turns) for angle in (np.zeros(len(models)), facing))
    is_turned = _sizes(along_wall).sum(axis=1) < _CLOSER * _sizes(along_axes).sum(axis=1)
    reach = np.where(is_turned[:, None, None], along_wall, along_axes)
    top = _tops(_sizes(reach))
    level = np.minimum(np.arange(_NUM_LEVELS), top[:, None])
    return _Sections(
        model=models.astype(np.int64),
        low=low,
        box=(np.minimum.reduceat(flat, starts), np.maximum.reduceat(flat, starts)),
        step=step,
        top=top,
        angle=np.where(is_turned, facing, 0.0)[:, None] + turns,
        reach=np.take_along_axis(reach, level[:, :, None], axis=1),
    )


def _cuts(polygons: Outlines, models: Ints, low: Floats, step: Floats) -> _Cuts:
    """Points where the edges of polygons cross the levels of their models."""
    start, end = polygons.points, polygons.points[next_in_row(polygons.offsets)]
    owner = np.repeat(np.searchsorted(models, polygons.model), np.diff(polygons.offsets))
    heights = [(points[:, 1] - low[owner]) / step[owner] - 0.5 for points in (start, end)]
    lowest = np.maximum(np.ceil(np.minimum(*heights)), 0.0)
    highest = np.minimum(np.floor(np.maximum(*heights)), _NUM_LEVELS - 1)
    counts = np.maximum(highest - lowest + 1.0, 0.0).astype(np.int64)
    edge = np.repeat(np.arange(len(counts)), counts)
    level = lowest[edge].astype(np.int64) + index_in_row(counts)
    rise = heights[1][edge] - heights[0][edge]
    share = np.where(rise != 0.0, (level - heights[0][edge]) / np.where(rise != 0.0, rise, 1.0), 0.0)
    points = start[edge] + share[:, None] * (end - start)[edge]
    return _Cuts(points[:, [0, 2]], owner[edge], level)


def _reach(cuts: _Cuts, angle: Floats) -> Floats:
    """[M, L, K] how far the sections of models reach in directions [M, K]."""
    num_models, num_directions = angle.shape
    reach = np.full((num_directions, num_models, _NUM_LEVELS), -np.inf)
    x, z = cuts.points.T
    for along, turn in zip(reach, angle.T, strict=True):
        values = x * np.cos(turn)[cuts.owner] + z * np.sin(turn)[cuts.owner]
        np.maximum.at(along, (cuts.owner, cuts.level), values)
    return _filled(np.moveaxis(reach, 0, 2))


def _sizes(reach: Floats) -> Floats:
    """[M, L] areas of boxes of sections along the first and the second axis, in square metres."""
    across = reach.shape[2] // 4
    widths = [reach[:, :, axis] + reach[:, :, axis + 2 * across] for axis in (0, across)]
    return widths[0] * widths[1]


def _tops(sizes: Floats) -> Ints:
    """[M] the highest level below a spire: where sections of areas [M, L] become small at once, and stay so."""
    is_spire = np.maximum.accumulate(sizes[:, ::-1], axis=1)[:, ::-1] < _SPIRE * sizes.max(axis=1, keepdims=True)
    drops = np.append(sizes[:, 1:] < _DROP * sizes[:, :-1], np.zeros((len(sizes), 1), dtype=bool), axis=1)
    is_below = drops & np.append(is_spire[:, 1:], np.zeros((len(sizes), 1), dtype=bool), axis=1)
    return np.where(is_below.any(axis=1), is_below.argmax(axis=1), _NUM_LEVELS - 1)


def _facing(polygons: Outlines, vectors: Floats, models: Ints) -> Floats:
    """[M] direction of the largest wall of each model."""
    across = np.hypot(vectors[:, 0], vectors[:, 2])
    order = np.lexsort((-across, polygons.model))
    largest = order[np.searchsorted(polygons.model[order], models)]
    return np.where(across[largest] > 0.0, np.arctan2(vectors[largest, 2], vectors[largest, 0]), 0.0)


def _filled(reach: Floats) -> Floats:
    """Sections with those of the level below for levels where there is nothing, or of the first above."""
    is_empty = np.isneginf(reach[:, :, 0])
    level = np.where(is_empty, -1, np.arange(_NUM_LEVELS))
    first = np.argmax(~is_empty, axis=1)
    source = np.maximum.accumulate(level, axis=1)
    source = np.where(source < 0, first[:, None], source)
    result = np.take_along_axis(reach, source[:, :, None], axis=1)
    return np.where(np.isneginf(result), 0.0, result)


def _starts(reach: Floats, most_slabs: int) -> Flags:
    """[M, L] the first levels of slabs; each next slab is where it avoids the largest error."""
    is_start = np.zeros(reach.shape[:2], dtype=bool)
    is_start[:, 0] = True
    extent = np.maximum(reach.max(axis=(1, 2)) - reach.min(axis=(1, 2)), 1.0)
    error = _errors(reach, is_start)[0]
    for _ in range(most_slabs - 1):
        candidates = np.repeat(is_start[:, None], _NUM_LEVELS - 1, axis=1)
        levels = np.arange(1, _NUM_LEVELS)
        candidates[:, levels - 1, levels] = True
        errors = _errors(reach.repeat(len(levels), axis=0), candidates.reshape(-1, _NUM_LEVELS))[0]
        errors = errors.reshape(len(reach), -1)
        best = errors.argmin(axis=1)
        lowest = errors[np.arange(len(errors)), best]
        gains = error - lowest > _MIN_GAIN * extent
        if not gains.any():
            break
        rows = np.flatnonzero(gains)
        is_start[rows, best[rows] + 1] = True
        error = np.where(gains, lowest, error)
    return is_start


def _spans(is_start: Flags) -> tuple[Ints, Ints]:
    """First and last level [M, L] of the slab of each level."""
    level = np.broadcast_to(np.arange(_NUM_LEVELS), is_start.shape)
    first = np.maximum.accumulate(np.where(is_start, level, 0), axis=1)
    is_end = np.append(is_start[:, 1:], np.ones((len(is_start), 1), dtype=bool), axis=1)
    last = np.minimum.accumulate(np.where(is_end, level, _NUM_LEVELS)[:, ::-1], axis=1)[:, ::-1]
    return first, last


def _errors(reach: Floats, is_start: Flags) -> tuple[Floats, Flags]:
    """[M] mean distance of sections from slabs, summed over levels, and [M, L] whether slabs are straight."""
    first, last = _spans(is_start)
    share = (np.arange(_NUM_LEVELS) - first) / np.maximum(last - first, 1)
    low, high = (np.take_along_axis(reach, ends[:, :, None], axis=1) for ends in (first, last))
    straight = np.abs(reach - low).mean(axis=2)
    slanted = np.abs(reach - low - share[:, :, None] * (high - low)).mean(axis=2)
    difference = np.append(np.zeros((len(reach), 1)), np.cumsum(straight - slanted, axis=1), axis=1)
    in_slab = np.take_along_axis(difference, last + 1, axis=1) - np.take_along_axis(difference, first, axis=1)
    is_straight = in_slab < 0.0
    return np.where(is_straight, straight, slanted).sum(axis=1), is_straight


def _rings(sections: _Sections, owner: Ints, level: Ints) -> Floats:
    """[S, K, 2] x and z of the polygons of sections: corner k is where sides k - 1 and k meet."""
    reach, angle = sections.reach[owner, level], sections.angle[owner]
    before, turn = np.roll(reach, 1, axis=1), 2.0 * np.pi / sections.num_directions
    # Along the normal of side k and along the side.
    along = (reach * np.cos(turn) - before) / np.sin(turn)
    x = reach * np.cos(angle) - along * np.sin(angle)
    z = reach * np.sin(angle) + along * np.cos(angle)
    # Corners of a turned rectangle may stick out of the box of what it contains.
    low, high = (box[owner][:, None] for box in sections.box)
    return np.clip(np.stack((x, z), axis=2), low, high)


def _at(ring: Floats, height: Floats) -> Floats:
    """[S, K, 3] corners of rings [S, K, 2] at heights [S]."""
    return np.stack((ring[:, :, 0], np.broadcast_to(height[:, None], ring.shape[:2]), ring[:, :, 1]), axis=2)


def _colors(polygons: Outlines, vectors: Floats, sections: _Sections, is_start: Flags) -> tuple[Floats, Floats]:
    """[S, 3] colours of the sides and of the tops of slabs: those of walls and roofs at their heights."""
    owner = np.searchsorted(sections.model, polygons.model)
    middle = np.add.reduceat(polygons.points[:, 1], polygons.offsets[:-1]) / np.diff(polygons.offsets)
    level = np.floor((middle - sections.low[owner]) / sections.step[owner]).astype(np.int64)
    number = np.cumsum(is_start.ravel()).reshape(is_start.shape) - 1
    slab = number[owner, np.clip(level, 0, _NUM_LEVELS - 1)]
    num_slabs = int(number[-1, -1]) + 1
    owner_of_slab = np.nonzero(is_start)[0]
    results = []
    for part in (np.hypot(vectors[:, 0], vectors[:, 2]), np.abs(vectors[:, 1])):
        weight = part + _OTHERS * (polygons.area + _SMALLEST)
        here = _mean_color(slab, weight, polygons.color, num_slabs)
        anywhere = _mean_color(owner, weight, polygons.color, len(sections.model))
        results.append(np.where(np.isnan(here), anywhere[owner_of_slab], here))
    return results[0], results[1]


def _mean_color(group: Ints, weight: Floats, color: Floats, num_groups: int) -> Floats:
    """[G, 3] weighted means of colours [N, 3]; NaN for empty groups."""
    total = np.bincount(group, weight, num_groups)
    sums = np.stack([np.bincount(group, weight * channel, num_groups) for channel in color.T], axis=1)
    return np.where(total[:, None] > 0.0, sums / np.where(total > 0.0, total, 1.0)[:, None], np.nan)


def _quads(corners: Floats, model: Ints, color: Floats) -> Outlines:
    """Polygons of equally many corners [N, k, 3] as outlines, without corners that coincide and small ones."""
    step = corners - np.roll(corners, 1, axis=1)
    apart = np.einsum("nki,nki->nk", step, step) > 1e-6
    vectors = area_vectors(Meshes.from_polygons(corners.reshape(-1, 3), np.full(len(corners), corners.shape[1])))
    area = np.sqrt(np.einsum("ni,ni->n", vectors, vectors))
    counts = np.count_nonzero(apart, axis=1)
    keep = (counts > 2) & (area > _SMALLEST)
    offsets = np.concatenate(([0], np.cumsum(counts[keep])))
    return Outlines(corners[keep][apart[keep]], offsets, model[keep], color[keep], area[keep])
