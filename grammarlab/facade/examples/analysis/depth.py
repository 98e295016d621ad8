"""What is seen of a building from one side: depth and triangle at each pixel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.mesh.surface import Floats, Ints

_CHUNK = 2_000_000
"""Pixels that are looked at together."""
NOTHING = -np.inf


@dataclass(frozen=True, eq=False)
class DepthMap:
    """H x W pixels, the lowest row first, seen without perspective."""

    depth: Floats
    """[H, W] metres towards the viewer; `NOTHING` where there is nothing."""
    triangle: Ints
    """[H, W] triangle that is seen, -1 for none."""
    low: Floats
    """[2] metres of the lower left corner."""
    step: float
    """Metres per pixel."""

    def rows(self, low: float, high: float) -> slice:
        """Pixel rows whose middles lie between two heights."""
        return self._between(1, low, high)

    def columns(self, low: float, high: float) -> slice:
        """Pixel columns whose middles lie between two places."""
        return self._between(0, low, high)

    def _between(self, axis: int, low: float, high: float) -> slice:
        ends = (np.array([low, high]) - self.low[axis]) / self.step - 0.5
        first = max(int(np.ceil(ends[0])), 0)
        return slice(first, max(int(np.floor(ends[1])) + 1, first))


def depth_map(corners: Floats, num_pixels: int) -> DepthMap:
    """The nearest triangle at each pixel.

    Args:
        corners: [T, 3, 3] of triangles in the coordinates of a view.
        num_pixels: of the map, about.
    """
    low, high = corners.reshape(-1, 3).min(axis=0)[:2], corners.reshape(-1, 3).max(axis=0)[:2]
    size = np.maximum(high - low, 1e-9)
    step = float(np.sqrt(size.prod() / num_pixels))
    step = max(step, float(size.max()) / num_pixels)
    width, height = (int(each) for each in np.maximum(np.ceil(size / step), 1))
    depth = np.full(width * height, NOTHING)
    triangle = np.full(width * height, -1, dtype=np.int64)
    for rows, pixel, value in _covered(corners, low, step, width, height):
        order = np.lexsort((value, pixel))
        last = np.append(np.diff(pixel[order]) != 0, True)
        best = order[last]
        nearer = value[best] > depth[pixel[best]]
        best = best[nearer]
        depth[pixel[best]] = value[best]
        triangle[pixel[best]] = rows[best]
    return DepthMap(depth.reshape(height, width), triangle.reshape(height, width), low, step)


def _covered(corners: Floats, low: Floats, step: float, width: int, height: int) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Triangles, pixels whose middles they cover and depths there, in chunks."""
    flat = (corners[:, :, :2] - low) / step - 0.5
    a, b, c = flat[:, 0], flat[:, 1], flat[:, 2]
    double = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    first = np.maximum(np.ceil(np.minimum(np.minimum(a, b), c)), 0).astype(np.int64)
    last = np.minimum(np.floor(np.maximum(np.maximum(a, b), c)), [width - 1, height - 1]).astype(np.int64)
    extent = np.maximum(last - first + 1, 0)
    rows = np.flatnonzero((extent[:, 0] > 0) & (extent[:, 1] > 0) & (np.abs(double) > 1e-12))
    num = extent[rows, 0] * extent[rows, 1]
    for group in np.split(rows, np.flatnonzero(np.diff(np.cumsum(num) // _CHUNK)) + 1):
        if not group.size:
            continue
        count = extent[group, 0] * extent[group, 1]
        row = np.repeat(group, count)
        place = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
        x = first[row, 0] + place % extent[row, 0]
        y = first[row, 1] + place // extent[row, 0]
        dx, dy = x - a[row, 0], y - a[row, 1]
        v = (dx * (c[row, 1] - a[row, 1]) - dy * (c[row, 0] - a[row, 0])) / double[row]
        w = (dy * (b[row, 0] - a[row, 0]) - dx * (b[row, 1] - a[row, 1])) / double[row]
        inside = (v >= -1e-9) & (w >= -1e-9) & (v + w <= 1.0 + 1e-9)
        row, v, w = row[inside], v[inside], w[inside]
        z = corners[row, :, 2]
        yield row, y[inside] * width + x[inside], z[:, 0] + v * (z[:, 1] - z[:, 0]) + w * (z[:, 2] - z[:, 0])
