"""Walls and roofs of models: facets that lie in about one plane and beside each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, offsets_from_counts, take_rows
from grammarlab.export.tiles.facets import Facets
from grammarlab.geometry.meshes.ragged import next_in_row
from grammarlab.geometry.meshes.vectors import cross

_STEPS_OF_NORMAL = 40.0
"""Steps of each coordinate of a normal: facets that turn by less than about 1.5 degrees are parallel."""
_DEPTH_GAP, _MAX_DEPTH = 600, 1500
"""Millimetres between parallel planes that are one wall, so with its windows and sills, and its largest depth."""
_GAP = 1000
"""Millimetres between facets in a plane that belong to one wall."""
_MILLIMETRES = 1000.0
_UPWARDS = np.array([0.31, 0.87, 0.38])
"""Direction of the front of planes; walls and roofs of most models are not along it."""


@dataclass(frozen=True, slots=True)
class Planes:
    """W walls and roofs, ordered by their model, with their facets."""

    facets: Facets
    """F facets, ordered by their wall."""
    wall_facets: Ints
    """[W + 1] into the facets."""
    area: Floats
    """[F] square metres of each facet."""
    model: Ints
    """[W] ascending."""
    axes: Floats
    """[W, 3, 3] rows: u and v in the plane, and its normal; a right-handed rotation."""
    depth: Floats
    """[W] metres of the plane along its normal: that of the largest facet."""
    covered: Floats
    """[W] sum of the areas of the facets of one side in square metres: of the side with the larger sum."""
    local: Floats
    """[P, 2] u and v of the corners of the facets."""

    def __len__(self) -> int:
        return len(self.model)

    def of_facets(self, values: Floats) -> Floats:
        """[W] sums of numbers of the facets [F]."""
        return np.bincount(self.wall_of_facet(), values, len(self)).astype(np.float64)

    def wall_of_facet(self) -> Ints:
        """[F] wall of each facet."""
        return np.repeat(np.arange(len(self)), np.diff(self.wall_facets))

    def wall_points(self) -> Ints:
        """[W + 1] offsets of the corners of walls."""
        return self.facets.offsets[self.wall_facets]

    def take(self, walls: Ints) -> Planes:
        """These walls [K], ascending."""
        rows, wall_facets = take_rows(self.wall_facets, walls)
        points, _ = take_rows(self.facets.offsets, rows)
        return Planes(
            facets=self.facets.take(rows),
            wall_facets=wall_facets,
            area=self.area[rows],
            model=self.model[walls],
            axes=self.axes[walls],
            depth=self.depth[walls],
            covered=self.covered[walls],
            local=self.local[points],
        )


def planes(facets: Facets) -> Planes:
    """Walls and roofs of all models; each has at least one facet."""
    area = np.sqrt(np.einsum("ij,ij->i", facets.vector, facets.vector))
    normal = facets.vector / area[:, None]
    side = np.where(normal @ _UPWARDS < 0.0, -1.0, 1.0)
    steps = np.rint(normal * side[:, None] * _STEPS_OF_NORMAL).astype(np.int64)
    parallel = _numbered(facets.model, *steps.T)
    largest = _largest(parallel, area)
    axes = _axes(facets, largest, (normal * side[:, None])[largest])

    corner_axes = axes[parallel.repeat(np.diff(facets.offsets))]
    local = np.einsum("nij,nj->ni", corner_axes, facets.points)
    starts = facets.offsets[:-1]
    middle = np.add.reduceat(local[:, 2], starts) / np.diff(facets.offsets)
    low, high = (np.rint(bound.reduceat(local, starts, axis=0) * _MILLIMETRES) for bound in (np.minimum, np.maximum))
    depth = np.rint(middle * _MILLIMETRES).astype(np.int64)
    wall = split_by_gaps(parallel, depth, depth, _DEPTH_GAP)
    first = np.full(int(wall.max(initial=-1)) + 1, np.iinfo(np.int64).max)
    np.minimum.at(first, wall, depth)
    wall = _numbered(wall, (depth - first[wall]) // _MAX_DEPTH)
    for axis in range(2):
        wall = split_by_gaps(wall, low[:, axis].astype(np.int64), high[:, axis].astype(np.int64), _GAP)

    order = np.argsort(wall, kind="stable")
    points, _ = take_rows(facets.offsets, order)
    wall_facets = offsets_from_counts(np.bincount(wall))
    largest = _largest(wall, area)
    sums = [np.bincount(wall, np.where(side * sign > 0.0, area, 0.0)) for sign in (1.0, -1.0)]
    return Planes(
        facets=facets.take(order),
        wall_facets=wall_facets,
        area=area[order],
        model=facets.model[largest],
        axes=axes[parallel[largest]],
        depth=middle[largest],
        covered=np.maximum(*sums),
        local=local[points, :2],
    )


def split_by_gaps(group: Ints, low: Ints, high: Ints, gap: int) -> Ints:
    """Numbers [n] of the runs of intervals of each group that have no gap between them, in the order of groups.

    >>> ends = np.array([0, 9, 2]), np.array([1, 10, 5])
    >>> split_by_gaps(np.array([0, 0, 0]), *ends, 2).tolist()
    [0, 1, 0]
    """
    if not len(group):
        return group
    order = np.lexsort((low, group))
    group, low, high = group[order], low[order], high[order]
    # All intervals of a group lie before those of the next one.
    shift = group * (int(high.max()) - int(low.min()) + gap + 2)
    reach = np.maximum.accumulate(high + shift)
    is_first = np.ones(len(order), dtype=bool)
    is_first[1:] = (group[1:] != group[:-1]) | (low[1:] + shift[1:] > reach[:-1] + gap)
    number = np.empty_like(order)
    number[order] = np.cumsum(is_first) - 1
    return number


def _numbered(*columns: NDArray[np.integer]) -> Ints:
    """[n] number of each row of columns among the different ones, in their order."""
    key = np.zeros(len(columns[0]), dtype=np.int64)
    for column in columns:
        low = int(column.min(initial=0))
        key = key * (int(column.max(initial=0)) - low + 1) + (column - low)
    return np.unique(key, return_inverse=True)[1].astype(np.int64)


def _largest(group: Ints, area: Floats) -> Ints:
    """[G] the first row of the largest area of each group."""
    order = np.lexsort((-area, group))
    return order[np.flatnonzero(np.diff(group[order], prepend=-1))]


def _axes(facets: Facets, rows: Ints, normals: Floats) -> Floats:
    """[G, 3, 3] for facets at these rows: axes along the longest edge of each, across it, and along its normal."""
    points, offsets = take_rows(facets.offsets, rows)
    corners = facets.points[points]
    edges = corners[next_in_row(offsets)] - corners
    length = np.einsum("ij,ij->i", edges, edges)
    facet = np.repeat(np.arange(len(rows)), np.diff(offsets))
    along: Floats = edges[_largest(facet, length)]
    along -= np.einsum("ij,ij->i", along, normals)[:, None] * normals
    along /= np.sqrt(np.einsum("ij,ij->i", along, along))[:, None]
    return np.stack((along, cross(normals, along), normals), axis=1)
