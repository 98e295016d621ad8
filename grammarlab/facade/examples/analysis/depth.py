"""Depth map of a building seen from one side: depth and triangle at each pixel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.mesh.surface import Floats, Ints

_CHUNK = 2_000_000
"""Pixels that are processed together."""
NOTHING = -np.inf
_EDGE = 1e-9
"""Distance from a triangle at which pixels count as inside, pixels."""
_FLAT = 1e-6
"""Twice the least area of a visible triangle, square pixels."""


@dataclass(frozen=True, eq=False)
class DepthMap:
    """H x W pixels, the lowest row first, in orthographic projection."""

    depth: Floats
    """[H, W] metres towards the viewer; `NOTHING` for empty pixels."""
    triangle: Ints
    """[H, W] visible triangle, -1 for none."""
    low: Floats
    """[2] lower left corner, metres."""
    step: float
    """Metres per pixel."""

    def rows(self, low: float, high: float) -> slice:
        """Pixel rows with centres between two heights."""
        return self._between(1, low, high)

    def columns(self, low: float, high: float) -> slice:
        """Pixel columns with centres between two positions."""
        return self._between(0, low, high)

    def _between(self, axis: int, low: float, high: float) -> slice:
        ends = (np.array([low, high]) - self.low[axis]) / self.step - 0.5
        first = max(int(np.ceil(ends[0])), 0)
        return slice(first, max(int(np.floor(ends[1])) + 1, first))


def depth_map(corners: Floats, num_pixels: int) -> DepthMap:
    """The nearest triangle at each pixel.

    Args:
        corners: [T, 3, 3] corners of triangles in the coordinates of a view.
        num_pixels: approximate number of pixels of the map.
    """
    low, high = corners.reshape(-1, 3).min(axis=0)[:2], corners.reshape(-1, 3).max(axis=0)[:2]
    size = np.maximum(high - low, 1e-9)
    step = float(np.sqrt(size.prod() / num_pixels))
    step = max(step, float(size.max()) / num_pixels)
    width, height = (int(each) for each in np.maximum(np.ceil(size / step), 1))
    depth = np.full(width * height, NOTHING)
    triangle = np.full(width * height, -1, dtype=np.int64)
    for rows, pixel, value in _covered(corners, low, step, width, height):
        np.maximum.at(depth, pixel, value)
        nearest = value == depth[pixel]
        triangle[pixel[nearest]] = rows[nearest]
    return DepthMap(depth.reshape(height, width), triangle.reshape(height, width), low, step)


def _covered(corners: Floats, low: Floats, step: float, width: int, height: int) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Triangles, the pixels with centres inside them and depths there, in chunks of triangles, by row of pixels."""
    flat = (corners[:, :, :2] - low) / step - 0.5
    (ax, ay), (bx, by), (cx, cy) = flat.transpose(1, 2, 0)
    double = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    lowest, highest = np.minimum(np.minimum(ay, by), cy) - _EDGE, np.maximum(np.maximum(ay, by), cy) + _EDGE
    left, right = np.minimum(np.minimum(ax, bx), cx) - _EDGE, np.maximum(np.maximum(ax, bx), cx) + _EDGE
    first = np.maximum(np.ceil(lowest), 0.0).astype(np.int64)
    last = np.minimum(np.floor(highest), height - 1).astype(np.int64)
    wide = np.floor(right) - np.ceil(left) + 1.0
    count = np.where((wide > 0.0) & (np.abs(double) > _FLAT), np.maximum(last - first + 1, 0), 0)
    safe = np.where(double == 0.0, 1.0, double)
    up, over = (corners[:, k, 2] - corners[:, 0, 2] for k in (1, 2))
    along_x = ((cy - ay) * up - (by - ay) * over) / safe
    along_y = ((bx - ax) * over - (cx - ax) * up) / safe
    rows = np.flatnonzero(count)
    for group in np.split(
        rows, np.flatnonzero(np.diff(np.cumsum((count * np.maximum(wide, 0.0))[rows]) // _CHUNK)) + 1
    ):
        if not group.size:
            continue
        row = np.repeat(group, count[group])
        y = first[row] + _within(count[group])
        start, end = _span(flat, row, y)
        start = np.maximum(np.ceil(start - _EDGE), 0.0).astype(np.int64)
        number = np.maximum(np.minimum(np.floor(end + _EDGE), width - 1).astype(np.int64) - start + 1, 0)
        at_start = corners[row, 0, 2] + along_x[row] * (start - ax[row]) + along_y[row] * (y - ay[row])
        place = _within(number)
        value: Floats = np.repeat(at_start, number) + np.repeat(along_x[row], number) * place.astype(np.float64)
        yield np.repeat(row, number), np.repeat(y * width + start, number) + place, value


def _span(flat: Floats, row: Ints, y: Ints) -> tuple[Floats, Floats]:
    """Start and end of a line of constant y inside a triangle."""
    start, end = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for one, other in ((0, 1), (1, 2), (2, 0)):
        (x, low), (to, high) = flat[row, one].T, flat[row, other].T
        rise = high - low
        part = np.clip((y - low) / np.where(rise == 0.0, 1.0, rise), 0.0, 1.0)
        crosses = (np.minimum(low, high) <= y + _EDGE) & (np.maximum(low, high) >= y - _EDGE)
        at = x + part * (to - x)
        start = np.where(crosses, np.minimum(start, at), start)
        end = np.where(crosses, np.maximum(end, at), end)
    return start, end


def _within(count: Ints) -> Ints:
    """0, 1, ... for each of several counts, concatenated."""
    return np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
