"""Outlines of walls and roofs: polygons that stand for all their facets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints, offsets_from_counts, take_rows
from grammarlab.export.tiles.planes import Planes
from grammarlab.geometry.meshes.ragged import next_in_row

_NUM_DIRECTIONS = 16
"""Directions in which an outline keeps its farthest corner, so its largest number of corners."""
MAX_CORNERS = 12
"""Most corners of a facet that keeps its outline; others are replaced by their hulls."""
_SAME = 0.01
"""Metres between corners that are one."""
_FILLED, _STEEP_FILLED = 0.85, 0.5
"""Smallest share of a hull that its facets cover; walls and steep roofs may have openings. Others are several outlines:
a flat roof around a court."""
_SMALL, _SMALL_SHARE = 1.0, 0.005
"""Smallest area of an outline in square metres, 16 pixels at 234 m, or as a share of all outlines if that is less."""
_LEVEL = 0.95
"""Smallest upward part of the normal of a flat roof."""


@dataclass(frozen=True, slots=True)
class Outlines:
    """N flat polygons."""

    points: Floats
    """[P, 3] corners in metres from the origin of the model."""
    offsets: Ints
    """[N + 1] into `points`."""
    model: Ints
    """[N]."""
    color: Floats
    """[N, 3] linear light in 0..1."""
    area: Floats
    """[N] square metres."""

    def __len__(self) -> int:
        return len(self.model)

    @property
    def num_triangles(self) -> Ints:
        """[N] triangles of each polygon."""
        return np.diff(self.offsets) - 2

    def take(self, rows: NDArray[np.integer]) -> Outlines:
        """These polygons [K], in any order."""
        points, offsets = take_rows(self.offsets, rows)
        return Outlines(self.points[points], offsets, self.model[rows], self.color[rows], self.area[rows])

    def joined(self, other: Outlines) -> Outlines:
        """These polygons, then the others."""
        return Outlines(
            np.concatenate((self.points, other.points)),
            np.concatenate((self.offsets, self.offsets[-1] + other.offsets[1:])),
            *(np.concatenate((getattr(self, name), getattr(other, name))) for name in ("model", "color", "area")),
        )


def outlines(planes: Planes, light: Floats) -> Outlines:
    """The outlines of walls and roofs: the convex hull of each, or the outlines of its facets if these leave much open.

    Args:
        planes: W walls and roofs.
        light: [K, 3] linear colours of the materials.
    """
    local, offsets = _hulls(planes)
    hull_area = _areas(local, offsets)
    num_facets, num_corners = np.diff(planes.wall_facets), np.diff(planes.facets.offsets)
    is_level = np.abs(planes.axes[:, 2, 1]) > _LEVEL
    first_corners = num_corners[planes.wall_facets[:-1]]
    is_exact = (num_facets == 1) & (first_corners <= MAX_CORNERS)
    is_open = planes.covered < np.where(is_level, _FILLED, _STEEP_FILLED) * hull_area
    separate = is_exact | (is_open & (num_facets > 1))

    shade = light[planes.facets.material]
    weighted = [planes.of_facets(planes.area * shade[:, channel]) for channel in range(3)]
    color = np.column_stack(weighted) / planes.of_facets(planes.area)[:, None]
    wall = np.repeat(np.arange(len(planes)), np.diff(offsets))
    world = local[:, :1] * planes.axes[wall, 0] + local[:, 1:] * planes.axes[wall, 1]
    world += (planes.depth[:, None] * planes.axes[:, 2])[wall]
    hulls = Outlines(world, offsets, planes.model, color, hull_area)
    facet_wall = planes.wall_of_facet()
    facet_rows = np.flatnonzero(separate[facet_wall] & (num_corners <= MAX_CORNERS))
    facets = planes.facets.take(facet_rows)
    alone = Outlines(facets.points, facets.offsets, facets.model, shade[facet_rows], planes.area[facet_rows])
    return hulls.take(np.flatnonzero(~separate & (np.diff(offsets) > 2))).joined(alone)


def significant(polygons: Outlines, num_models: int) -> Outlines:
    """The polygons that are not small."""
    total_area = np.bincount(polygons.model, polygons.area, num_models)[polygons.model]
    return polygons.take(np.flatnonzero(polygons.area >= np.minimum(_SMALL, _SMALL_SHARE * total_area)))


def within_budget(polygons: Outlines, most_triangles: int, num_models: int) -> Outlines:
    """The largest polygons of each model that have at most so many triangles in all."""
    order = np.lexsort((-polygons.area, polygons.model))
    counts, model = polygons.num_triangles[order], polygons.model[order]
    total = np.cumsum(counts)
    starts = np.searchsorted(model, np.arange(num_models))
    before = np.concatenate(([0], total))[starts]
    return polygons.take(order[total - before[model] <= most_triangles])


def _hulls(planes: Planes) -> tuple[Floats, Ints]:
    """Convex outlines of walls: u and v of their corners [C, 2], and offsets [W + 1] into these."""
    ends = planes.wall_points()
    num_walls = len(planes)
    if not num_walls:
        return np.zeros((0, 2)), np.zeros(1, dtype=np.int64)
    starts, wall = ends[:-1], np.repeat(np.arange(num_walls), np.diff(ends))
    corner = np.empty((num_walls, _NUM_DIRECTIONS), dtype=np.int64)
    u, v = planes.local.T
    for index in range(_NUM_DIRECTIONS):
        # Not along the axes, where all corners of one side of a rectangle are equally far.
        angle = 2.0 * np.pi * (index + 0.5) / _NUM_DIRECTIONS
        reach = u * np.cos(angle) + v * np.sin(angle)
        is_farthest = reach == np.maximum.reduceat(reach, starts)[wall]
        rows = np.flatnonzero(is_farthest)
        corner[:, index] = rows[np.flatnonzero(np.diff(wall[rows], prepend=-1))]
    local = planes.local[corner]
    keep = _is_apart(local)
    return local[keep], offsets_from_counts(np.count_nonzero(keep, axis=1))


def _is_apart(corners: Floats) -> Flags:
    """[W, K] whether each corner of polygons [W, K, 2] differs from the one before it."""
    step = corners - np.roll(corners, 1, axis=1)
    return np.einsum("wki,wki->wk", step, step) > _SAME * _SAME


def _areas(local: Floats, offsets: Ints) -> Floats:
    """[W] areas of polygons of corners [C, 2], in square metres."""
    following = next_in_row(offsets)
    u, v = local.T
    twice = u * v[following] - u[following] * v
    row = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    return np.bincount(row, twice, len(offsets) - 1) / 2.0
