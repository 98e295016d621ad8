"""Plots as columns, and straight cuts through all of them at once.

A plot is a simple polygon without holes whose edges know whether they are on a street. A cut joins two points of its
outline along a line; both parts have these points in common, to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints, index_in_row, offsets_from_counts, row_of_value, take_rows
from grammarlab.city.street_chords import DECIMALS


@dataclass(frozen=True, slots=True, eq=False)
class Plots:
    """N simple polygons as a ragged list of corners."""

    corners: Floats
    """[P, 2] corners in metres, counter-clockwise, those of the first plot first."""
    on_street: Flags
    """[P] whether the edge that leaves each corner is on a street."""
    offsets: Ints
    """[N + 1] into the corners."""

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @property
    def row(self) -> Ints:
        """[P] plot of each corner."""
        return row_of_value(np.diff(self.offsets))

    @property
    def following(self) -> Ints:
        """[P] index of the next corner of the same plot."""
        following = np.arange(1, len(self.corners) + 1)
        following[self.offsets[1:] - 1] = self.offsets[:-1]
        return following

    @property
    def area(self) -> Floats:
        """[N] square metres."""
        local = self.corners - self.corners[self.offsets[:-1]][self.row]
        after = local[self.following]
        return self.sums(local[:, 0] * after[:, 1] - after[:, 0] * local[:, 1]) / 2

    @property
    def frontage(self) -> Floats:
        """[N] metres along streets."""
        length = np.hypot(*(self.corners[self.following] - self.corners).T)
        return self.sums(np.where(self.on_street, length, 0.0))

    @property
    def outline(self) -> NDArray[np.object_]:
        """[N] polygons of shapely."""
        counts = np.diff(self.offsets)
        closed, offsets = take_rows(self.offsets, np.arange(len(self)))
        position = np.arange(len(closed)) + row_of_value(counts)
        points = np.empty((len(closed) + len(self), 2))
        points[position] = self.corners
        points[offsets[1:] + np.arange(len(self))] = self.corners[self.offsets[:-1]]
        rings = shapely.linearrings(points, indices=np.repeat(np.arange(len(self)), counts + 1))
        return np.asarray(shapely.polygons(rings))

    def sums(self, values: Floats) -> Floats:
        """[N] sums of values [P] at the corners of each plot."""
        return np.add.reduceat(values, self.offsets[:-1]) if len(self) else np.empty(0)

    def extent(self, axis: Floats) -> tuple[Floats, Floats]:
        """[N] lowest and highest position of the corners along an axis [N, 2] of each plot."""
        along = (self.corners * axis[self.row]).sum(axis=1)
        if not len(self):
            return np.empty(0), np.empty(0)
        return np.minimum.reduceat(along, self.offsets[:-1]), np.maximum.reduceat(along, self.offsets[:-1])

    def take(self, rows: NDArray[np.integer]) -> Plots:
        """The plots at these indices."""
        where, offsets = take_rows(self.offsets, rows)
        return Plots(self.corners[where], self.on_street[where], offsets)

    @classmethod
    def concatenate(cls, parts: list[Plots]) -> Plots:
        """The plots of several columns, in their order."""
        counts = np.concatenate([np.diff(part.offsets) for part in parts])
        return cls(
            np.concatenate([part.corners for part in parts]),
            np.concatenate([part.on_street for part in parts]),
            offsets_from_counts(counts),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """Smallest boxes around N polygons."""

    axis: Floats
    """[N, 2] unit vectors along the longer sides, towards the east."""
    length: Floats
    """[N] longer sides in metres."""
    breadth: Floats
    """[N] shorter sides in metres."""

    @property
    def aspect(self) -> Floats:
        """[N] longer side by shorter side, at least 1."""
        return self.length / np.maximum(self.breadth, 1e-9)


def smallest_boxes(polygons: NDArray[np.object_]) -> Boxes:
    """The boxes of least area around polygons [N] of non-zero area."""
    corners = shapely.get_coordinates(shapely.oriented_envelope(polygons)).reshape(-1, 5, 2)
    sides = corners[:, 1:3] - corners[:, :2]
    lengths = np.linalg.norm(sides, axis=2)
    longer = lengths.argmax(axis=1)
    rows = np.arange(len(sides))
    length = lengths[rows, longer]
    axis = sides[rows, longer] / length[:, None]
    westward = (axis[:, 0] < 0) | ((axis[:, 0] == 0) & (axis[:, 1] < 0))
    axis[westward] *= -1.0
    return Boxes(axis, length, lengths[rows, 1 - longer])


@dataclass(frozen=True, slots=True, eq=False)
class Cuts:
    """K straight cuts through different plots."""

    row: Ints
    """[K] plots that are cut."""
    edge: Ints
    """[K, 2] corners that the edges at both ends leave."""
    end: Floats
    """[K, 2, 2] ends, on these edges, in metres, rounded."""

    def take(self, rows: NDArray[np.integer]) -> Cuts:
        """The cuts at these indices."""
        return Cuts(self.row[rows], self.edge[rows], self.end[rows])


def cuts_along(plots: Plots, origin: Floats, direction: Floats) -> Cuts:
    """Cuts of plots along lines: each along the longest part of its line inside.

    Args:
        plots: N plots.
        origin: [N, 2] a point on each line.
        direction: [N, 2] unit vectors along the lines.
    """
    row, following = plots.row, plots.following
    offset = plots.corners - origin[row]
    step = direction[row]
    side = step[:, 0] * offset[:, 1] - step[:, 1] * offset[:, 0]
    after = side[following]
    edge = np.flatnonzero((side >= 0) != (after >= 0))
    share = side[edge] / (side[edge] - after[edge])
    hit = plots.corners[edge] + share[:, None] * (plots.corners[following[edge]] - plots.corners[edge])
    along = ((hit - origin[row[edge]]) * step[edge]).sum(axis=1)
    order = np.lexsort((along, row[edge]))
    pairs = edge[order].reshape(-1, 2)  # a line enters and leaves a ring in turn
    length = np.diff(along[order].reshape(-1, 2), axis=1)[:, 0]
    longest_first = np.lexsort((-length, row[pairs[:, 0]]))
    cut, position = np.unique(row[pairs[:, 0]][longest_first], return_index=True)
    chosen = longest_first[position]
    ends = np.round(hit[order].reshape(-1, 2, 2)[chosen], DECIMALS)
    return Cuts(cut, pairs[chosen], ends)


def parts_of(plots: Plots, cuts: Cuts) -> tuple[Plots, Plots]:
    """[K] the parts of cut plots on the right and on the left of the way from the first end to the second."""
    (first, last), (start, end) = cuts.edge.T, cuts.end.transpose(1, 0, 2)
    return _part(plots, cuts.row, first, last, start, end), _part(plots, cuts.row, last, first, end, start)


def _part(plots: Plots, cut: Ints, first: Ints, last: Ints, start: Floats, end: Floats) -> Plots:
    """The parts from points on edges `first` [K] counter-clockwise to points on edges `last`, closed by the cuts."""
    base = plots.offsets[cut]
    num = plots.offsets[cut + 1] - base
    steps = (last - first) % num
    counts = steps + 2
    row, position = row_of_value(counts), index_in_row(counts)
    ring = base[row] + ((first - base)[row] + position) % num[row]
    corners = plots.corners[ring]
    on_street = plots.on_street[ring]
    is_end = position == steps[row] + 1
    corners[position == 0] = start
    corners[is_end] = end
    on_street[is_end] = False
    return _without_repeats(Plots(corners, on_street, offsets_from_counts(counts)))


def _without_repeats(plots: Plots) -> Plots:
    """Plots without edges of length 0."""
    differs = (plots.corners != plots.corners[plots.following]).any(axis=1)
    if differs.all():
        return plots
    row = plots.row
    differs[plots.offsets[:-1][np.bincount(row[differs], minlength=len(plots)) == 0]] = True
    counts = np.bincount(row[differs], minlength=len(plots))
    return Plots(plots.corners[differs], plots.on_street[differs], offsets_from_counts(counts))
