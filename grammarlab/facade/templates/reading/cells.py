"""The wall of a facade as cells: where points are missing, or lie in front of or behind their surroundings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from grammarlab.facade.templates.elements import Floats, Ints

Bools = NDArray[np.bool_]

DEEP = 0.04
"""Least distance from the wall of a point that is not part of it, metres."""
_FLATTEST = 0.006
"""Least relief of a part of the wall, metres."""
_NOISES = 3.0
"""Least relief and least lack of points, in standard deviations of the mean and of the number of points."""
_SPARSE = 0.5
"""Largest density of the points of a sparse part, relative to its surroundings."""
_BLOCK, _BLOCKS = 0.5, 7
"""Side of a block, metres, and blocks along a side of the surroundings; elements cover less than half of these."""
_MOST_CELLS = 4_000_000


@dataclass(frozen=True, eq=False)
class Cells:
    """W x H square cells of a wall; all fields count only points of the wall."""

    low: Floats
    """[2] lower left corner, metres."""
    side: float
    """Side of a cell, metres."""
    spacing: float
    """Distance of neighbouring points, metres."""
    noise: float
    """Standard deviation of the distance of a point from the wall, metres."""
    count: Floats
    """[W, H] number of points."""
    empty: Bools
    """[W, H] cells without points; single ones between others do not count."""
    relief: Floats
    """[W, H] mean distance from the surroundings, metres, out of the wall."""
    smooth: Floats
    """[W, H] the same over 3 x 3 cells."""
    lack: Floats
    """[W, H] lack of points in 3 x 3 cells: 0 for the density of the surroundings, 1 for none."""
    raised: Bools
    """[W, H] cells with significant relief, out of the wall or into it."""
    sparse: Bools
    """[W, H] cells with significant lack of points."""

    @property
    def high(self) -> Floats:
        """[2] upper right corner, metres."""
        return self.low + self.side * np.array(self.empty.shape)

    def place(self, points: Floats) -> tuple[Ints, Ints]:
        """Column [P] and row [P] of the cells of points [P, 2]; of the nearest cells for points outside."""
        return _place(points, self.low, self.side, self.empty.shape)


def _place(points: Floats, low: Floats, side: float, shape: tuple[int, ...]) -> tuple[Ints, Ints]:
    place = np.clip(((points - low) / side).astype(np.int64), 0, np.array(shape) - 1)
    return place[:, 0], place[:, 1]


def cells_of(points: Floats) -> Cells:
    """The wall of a facade with points [P, 3]: along it, up, and out of the wall, metres."""
    flat, low = points[:, :2], points[:, :2].min(axis=0)
    on_wall = np.abs(points[:, 2]) < DEEP
    side = max(_side(flat[on_wall]), float(np.sqrt(np.ptp(flat, axis=0).prod() / _MOST_CELLS)))
    width, height = (np.ceil((flat.max(axis=0) - low) / side).astype(np.int64) + 1).tolist()
    index = np.ravel_multi_index(_place(flat[on_wall], low, side, (width, height)), (width, height))
    depth = points[on_wall, 2]
    count, total = (
        np.bincount(index, weights, minlength=width * height).reshape(width, height).astype(np.float64)
        for weights in (None, depth)
    )
    number = 9.0 * ndimage.uniform_filter(count, 3)
    mean = _ratio(9.0 * ndimage.uniform_filter(total, 3), number)
    usual, level = _surroundings(number, side), _surroundings(mean, side)
    noise = 1.4826 * float(np.median(np.abs(depth - np.median(depth)))) if len(depth) else 0.0
    smooth = np.where(number > 0.5, mean - level, 0.0)
    raised = np.abs(smooth) > np.maximum(_FLATTEST, _NOISES * noise / np.sqrt(np.maximum(number, 1.0)))
    sparse = number < np.minimum(_SPARSE * usual, usual - _NOISES * np.sqrt(np.maximum(usual, 0.0)))
    # A hole of one cell is a gap between points.
    empty = np.logical_not(ndimage.binary_closing(count > 0, iterations=1))
    return Cells(
        low=low,
        side=side,
        spacing=side / float(np.sqrt(max(count[~empty].sum() / max((~empty).sum(), 1), 1.0))),
        noise=noise,
        count=count,
        empty=empty,
        relief=np.where(count > 0, _ratio(total, count) - level, 0.0),
        smooth=smooth,
        lack=1.0 - _ratio(number, usual),
        raised=raised,
        sparse=sparse,
    )


def _ratio(over: Floats, under: Floats) -> Floats:
    return over / np.where(under > 1e-9, under, np.inf)


def _side(flat: Floats) -> float:
    """Side of cells such that a wall has some points in every cell, metres."""
    extent = np.maximum(np.ptp(flat, axis=0), 1e-6)
    dense = float(np.sqrt(extent.prod() / max(len(flat), 1)))
    return max(2.2 * dense, 0.02, float(np.sqrt(extent.prod() / _MOST_CELLS)))


def _surroundings(values: Floats, side: float) -> Floats:
    """[W, H] median of the values [W, H] of blocks around each cell, between blocks by interpolation."""
    size = max(1, round(_BLOCK / side))
    filled = np.pad(values, [(0, -length % size) for length in values.shape], mode="edge")
    blocks = filled.reshape(filled.shape[0] // size, size, filled.shape[1] // size, size).mean(axis=(1, 3))
    middle = ndimage.median_filter(blocks, _BLOCKS, mode="reflect")
    places = [np.clip((np.arange(length) + 0.5) / size - 0.5, 0.0, None) for length in values.shape]
    return ndimage.map_coordinates(middle, np.meshgrid(*places, indexing="ij"), order=1, mode="nearest")
