"""Walls of a building: upright planes that contain much of the visible surface of one side.

Depth map of a building seen from one side: depth and triangle at each pixel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import ndimage

from grammarlab.synthesis.mesh.surface import Bools, Floats, Ints, Surface
from grammarlab.synthesis.mesh.views import seen_from

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


PIXELS = 250_000
"""Number of pixels of the depth map of each side."""
FACING = 0.9
"""Least component towards the viewer of the normal of a triangle in a wall."""
_BIN = 0.05
"""Bin width of depths, metres."""
BEHIND, BEFORE = 1.0, 2.0
"""Largest depth of recesses, and of balconies, that belong to a wall, metres."""
_LEAST_PART, _LEAST_SIDE = 0.04, 1.5
"""Least wall: share of the visible area of its side, and width and height, metres."""
_NARROW = 3
"""Least width of a visible gap, pixels."""
_NOISY, _CRACK = 0.001, 8.0
"""Noise from which cracks are possible, metres, and largest ratio of the width of a crack to the noise."""
_DEVIATION = 1.4826
"""Ratio of the standard deviation to the median deviation of normal noise; robust against windows near the plane."""
_UNDER = 0.5
"""Least share of the width of a wall that its ground floor covers."""
_TILTED = 0.1
"""Largest change of depth of a wall from end to end, metres."""
_MOST = 6
"""Largest number of walls of one side."""


@dataclass(frozen=True, eq=False)
class Wall:
    """A wall, in the coordinates of the view from its side."""

    side: int
    depth: float
    """Depth of its plane, metres."""
    low: Floats
    """[2] lower left corner, metres."""
    high: Floats
    """[2] upper right corner, metres."""
    map: DepthMap
    seen: Bools
    """[H, W] whether each pixel of the map belongs to it."""
    noise: float
    """Deviation of points in its plane from it, metres."""

    def tilt(self) -> float:
        """Rotation about the vertical axis that makes it square to the view, radians; 0 if it has no effect."""
        flat = self.seen & (np.abs(self.map.depth - self.depth) <= _TILTED)
        x = np.nonzero(flat)[1] * self.map.step
        depth = self.map.depth[flat]
        x = x - x.mean()
        slope = float((x * (depth - depth.mean())).sum() / max((x**2).sum(), 1e-12))
        return -float(np.arctan(slope)) if abs(slope) * (self.high[0] - self.low[0]) > _TILTED else 0.0


def walls_of(surface: Surface, side: int, num_pixels: int = PIXELS) -> list[Wall]:
    """The walls of one side, the largest first, from a map of this many pixels."""
    corners = seen_from(side, surface.points)[surface.triangles]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(facing, axis=1)
    map_ = depth_map(corners, num_pixels)
    upright = np.append(np.abs(facing[:, 2]) >= FACING * length, False)[map_.triangle] & (map_.triangle >= 0)
    left = upright.copy()
    walls: list[Wall] = []
    while left.any() and len(walls) < _MOST:
        plane = _plane(map_.depth[left])
        plane = float(np.median(map_.depth[left & (np.abs(map_.depth - plane) <= 1.5 * _BIN)]))
        flat = left & (np.abs(map_.depth - plane) <= _BIN)
        if not flat.any():
            break
        plane = float(np.median(map_.depth[flat]))
        near = (map_.depth >= plane - BEHIND) & (map_.depth <= plane + BEFORE)
        # Pieces of wall between windows belong together, and so do windows, which may be holes; narrow gaps are none.
        bridged: Any = ndimage.binary_closing(near, structure=np.ones((_NARROW, _NARROW)))
        found: Any = ndimage.label(near | bridged, structure=np.ones((3, 3)))
        pieces, num = found
        if not num:
            break
        sizes = np.bincount(pieces[flat], minlength=num + 1)
        sizes[0] = 0
        own = pieces == int(sizes.argmax())
        own_flat = own & flat
        rows, columns = np.flatnonzero(own_flat.any(axis=1)), np.flatnonzero(own_flat.any(axis=0))
        if len(rows):
            # A ground floor in front of or behind the plane belongs to the wall.
            under = own[: rows[0], columns[0] : columns[-1] + 1].mean(axis=1) >= _UNDER
            rows[0] = np.flatnonzero(~np.append(False, under))[-1]
        left &= ~own
        if not own_flat.any():
            continue
        low = map_.low + np.array([columns[0], rows[0]]) * map_.step
        high = map_.low + np.array([columns[-1] + 1, rows[-1] + 1]) * map_.step
        if own_flat.sum() < _LEAST_PART * upright.sum() or (high - low).min() < _LEAST_SIDE:
            continue
        within = np.zeros_like(own)
        within[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1] = True
        noise = _DEVIATION * float(np.median(np.abs(map_.depth[own_flat] - plane)))
        seen = within & (_filled(own, rows[0]) | (map_.triangle < 0))
        walls.append(
            Wall(side=side, depth=plane, low=low, high=high, map=_without_cracks(map_, noise), seen=seen, noise=noise)
        )
    return sorted(walls, key=lambda wall: -float((wall.high - wall.low).prod()))


def _filled(own: Bools, lowest: int) -> Bools:
    """[H, W] the wall with its holes; doors are closed by the ground below."""
    ground = np.ones((1, own.shape[1]), dtype=bool)
    filled = own.copy()
    above: Any = ndimage.binary_fill_holes(np.concatenate([ground, own[lowest:]]))
    filled[lowest:] = above[1:]
    return filled


def _without_cracks(map_: DepthMap, noise: float) -> DepthMap:
    """The map with narrow gaps closed.

    Cracks are visible only in places, and would divide a wall with noise into pieces that only touch.
    """
    pixels = _NARROW + int(np.ceil(_CRACK * noise / map_.step)) * (noise > _NOISY)
    return replace(map_, depth=ndimage.grey_closing(map_.depth, (pixels, pixels)))


def _plane(depth: Floats) -> float:
    """The most frequent depth, to `_BIN`."""
    low = float(depth.min())
    count = np.bincount(((depth - low) / _BIN).astype(np.int64), minlength=3)
    return low + (int(np.convolve(count, [1, 2, 1], mode="same").argmax()) + 0.5) * _BIN
