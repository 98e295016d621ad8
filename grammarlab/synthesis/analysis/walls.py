"""Walls of a building: upright planes that contain much of the visible surface of one side.

The visible surface is a depth map: depth and triangle at each pixel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import ndimage

from grammarlab.arrays import Flags, Floats, Ints, index_in_row
from grammarlab.synthesis.mesh.surface import Surface
from grammarlab.synthesis.mesh.views import seen_from

PIXELS = 250_000
"""Number of pixels of the depth map of each side."""
FACING = 0.9
"""Least component towards the viewer of the normal of a triangle in a wall."""
BEHIND, BEFORE = 1.0, 2.0
"""Largest depth of recesses, and of balconies, that belong to a wall, metres."""
_CHUNK_PIXELS = 2_000_000
"""Pixels that are processed together."""
_EDGE_TOLERANCE = 1e-9
"""Distance from a triangle at which pixels count as inside, pixels."""
_MIN_DOUBLE_AREA = 1e-6
"""Twice the least area of a visible triangle, square pixels."""
_BIN_M = 0.05
"""Bin width of depths, metres."""
_MIN_AREA_SHARE, _MIN_SIDE_M = 0.04, 1.5
"""Least wall: share of the visible area of its side, and width and height, metres."""
_MIN_GAP_PIXELS = 3
"""Least width of a visible gap, pixels."""
_MIN_CRACK_NOISE_M, _MAX_CRACK_RATIO = 0.001, 8.0
"""Noise from which cracks are possible, metres, and largest ratio of the width of a crack to the noise."""
_SD_PER_MEDIAN_DEVIATION = 1.4826
"""Ratio of the standard deviation to the median deviation of normal noise; robust against windows near the plane."""
_MIN_GROUND_SHARE = 0.5
"""Least share of the width of a wall that its ground floor covers."""
MAX_TILT_M = 0.1
"""Largest change of depth of a wall from end to end, metres."""
_MIN_TILT_M = 0.001
"""Least change of depth of a wall from end to end that counts, metres."""
_MAX_WALLS = 6
"""Largest number of walls of one side."""


@dataclass(frozen=True, eq=False)
class DepthMap:
    """H x W pixels, the lowest row first, in orthographic projection."""

    depth: Floats
    """[H, W] metres towards the viewer; -inf for empty pixels."""
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
    mask: Flags
    """[H, W] whether each pixel of the map belongs to it."""
    noise: float
    """Deviation of points in its plane from it, metres."""
    slope: float = 0.0
    """Change of its depth per metre to the right: 0 if it is square to the view."""

    def tilt(self, least: float = MAX_TILT_M) -> float:
        """Rotation about the vertical axis that makes it square to the view, radians; 0 if it has no effect.

        Args:
            least: change of its depth from end to end up to which it is square, metres.
        """
        return -float(np.arctan(self.slope)) if abs(self.slope) * (self.high - self.low)[0] > least else 0.0

    def squared(self, corners: Floats) -> tuple[Wall, Floats]:
        """The wall with depths relative to its own plane instead of one square to the view, and corners of triangles.

        Args:
            corners: [T, 3, 3] of all triangles of the building, in the coordinates of the view.
        """
        if self.slope == 0.0:
            return self, corners
        middle = float((self.low + self.high)[0]) / 2.0
        x = self.map.low[0] + (np.arange(self.map.depth.shape[1]) + 0.5) * self.map.step
        map_ = replace(self.map, depth=self.map.depth - self.slope * (x - middle))
        moved = corners.copy()
        moved[..., 2] -= self.slope * (corners[..., 0] - middle)
        return replace(self, map=map_, slope=0.0), moved


def walls_of(surface: Surface, side: int, num_pixels: int = PIXELS) -> list[Wall]:
    """The walls of one side, the largest first, from a map of this many pixels."""
    corners = seen_from(side, surface.points)[surface.triangles]
    facing = normals_of(corners)
    length = np.sqrt((facing * facing).sum(axis=0))
    view = depth_map(corners, num_pixels)
    upright = np.append(np.abs(facing[2]) >= FACING * length, False)[view.triangle] & (view.triangle >= 0)
    remaining = upright.copy()
    walls: list[Wall] = []
    while remaining.any() and len(walls) < _MAX_WALLS:
        plane = _plane(view.depth[remaining])
        plane = float(np.median(view.depth[remaining & (np.abs(view.depth - plane) <= 1.5 * _BIN_M)]))
        flat = remaining & (np.abs(view.depth - plane) <= _BIN_M)
        if not flat.any():
            break
        plane = float(np.median(view.depth[flat]))
        near = (view.depth >= plane - BEHIND) & (view.depth <= plane + BEFORE)
        # Pieces of wall between windows belong together, and so do windows, which may be holes; narrow gaps are none.
        bridged: Any = ndimage.binary_closing(near, structure=np.ones((_MIN_GAP_PIXELS, _MIN_GAP_PIXELS)))
        labelled: Any = ndimage.label(near | bridged, structure=np.ones((3, 3)))
        pieces, num = labelled
        if not num:
            break
        sizes = np.bincount(pieces[flat], minlength=num + 1)
        sizes[0] = 0
        piece = pieces == int(sizes.argmax())
        piece_flat = piece & flat
        rows, columns = np.flatnonzero(piece_flat.any(axis=1)), np.flatnonzero(piece_flat.any(axis=0))
        if len(rows):
            # A ground floor in front of or behind the plane belongs to the wall.
            under = piece[: rows[0], columns[0] : columns[-1] + 1].mean(axis=1) >= _MIN_GROUND_SHARE
            rows[0] = np.flatnonzero(~np.append(False, under))[-1]
        remaining &= ~piece
        if not piece_flat.any():
            continue
        low = view.low + np.array([columns[0], rows[0]]) * view.step
        high = view.low + np.array([columns[-1] + 1, rows[-1] + 1]) * view.step
        if piece_flat.sum() < _MIN_AREA_SHARE * upright.sum() or (high - low).min() < _MIN_SIDE_M:
            continue
        within = np.zeros_like(piece)
        within[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1] = True
        depth, slope, deviation = _own_plane(view, facing, piece_flat, float((low + high)[0]) / 2.0)
        noise = _SD_PER_MEDIAN_DEVIATION * deviation
        mask = within & (_filled(piece, rows[0]) | (view.triangle < 0))
        walls.append(
            Wall(
                side=side,
                depth=depth,
                low=low,
                high=high,
                map=_without_cracks(view, noise),
                mask=mask,
                noise=noise,
                slope=slope,
            )
        )
    return sorted(walls, key=lambda wall: -float((wall.high - wall.low).prod()))


def normals_of(corners: Floats) -> Floats:
    """[3, T] normals of triangles [T, 3, 3], each twice as long as its triangle is large, by coordinate."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners.transpose(1, 2, 0)
    bx, by, bz, cx, cy, cz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
    return np.stack([by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx])


def depth_map(corners: Floats, num_pixels: int) -> DepthMap:
    """The nearest triangle at each pixel.

    Args:
        corners: [T, 3, 3] corners of triangles in the coordinates of a view.
        num_pixels: approximate number of pixels of the map.
    """
    flat = corners[..., 0], corners[..., 1]
    low, high = (np.array([end(values) for values in flat]) for end in (np.min, np.max))
    size = np.maximum(high - low, 1e-9)
    step = float(np.sqrt(size.prod() / num_pixels))
    step = max(step, float(size.max()) / num_pixels)
    width, height = (int(extent) for extent in np.maximum(np.ceil(size / step), 1))
    depth = np.full(width * height, -np.inf)
    triangle = np.full(width * height, -1, dtype=np.int64)
    for rows, pixel, value in covered(corners, low, step, width, height):
        np.maximum.at(depth, pixel, value)
        nearest = value == depth[pixel]
        triangle[pixel[nearest]] = rows[nearest]
    return DepthMap(depth.reshape(height, width), triangle.reshape(height, width), low, step)


def covered(corners: Floats, low: Floats, step: float, width: int, height: int) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Triangles, the pixels with centres inside them and depths there, in chunks of triangles, by row of pixels."""
    flat = (corners[:, :, :2] - low) / step - 0.5
    (ax, ay), (bx, by), (cx, cy) = flat.transpose(1, 2, 0)
    double = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    lowest, highest = (
        np.minimum(np.minimum(ay, by), cy) - _EDGE_TOLERANCE,
        np.maximum(np.maximum(ay, by), cy) + _EDGE_TOLERANCE,
    )
    leftmost, rightmost = (
        np.minimum(np.minimum(ax, bx), cx) - _EDGE_TOLERANCE,
        np.maximum(np.maximum(ax, bx), cx) + _EDGE_TOLERANCE,
    )
    first = np.maximum(np.ceil(lowest), 0.0).astype(np.int64)
    last = np.minimum(np.floor(highest), height - 1).astype(np.int64)
    wide = np.floor(rightmost) - np.ceil(leftmost) + 1.0
    count = np.where((wide > 0.0) & (np.abs(double) > _MIN_DOUBLE_AREA), np.maximum(last - first + 1, 0), 0)
    safe = np.where(double == 0.0, 1.0, double)
    up, over = (corners[:, k, 2] - corners[:, 0, 2] for k in (1, 2))
    along_x = ((cy - ay) * up - (by - ay) * over) / safe
    along_y = ((bx - ax) * over - (cx - ax) * up) / safe
    rows = np.flatnonzero(count)
    for group in np.split(
        rows, np.flatnonzero(np.diff(np.cumsum((count * np.maximum(wide, 0.0))[rows]) // _CHUNK_PIXELS)) + 1
    ):
        if not group.size:
            continue
        row = np.repeat(group, count[group])
        y = first[row] + index_in_row(count[group])
        start, end = _span(flat, row, y)
        start = np.maximum(np.ceil(start - _EDGE_TOLERANCE), 0.0).astype(np.int64)
        number = np.maximum(np.minimum(np.floor(end + _EDGE_TOLERANCE), width - 1).astype(np.int64) - start + 1, 0)
        at_start = corners[row, 0, 2] + along_x[row] * (start - ax[row]) + along_y[row] * (y - ay[row])
        offset = index_in_row(number)
        value: Floats = np.repeat(at_start, number) + np.repeat(along_x[row], number) * offset.astype(np.float64)
        yield np.repeat(row, number), np.repeat(y * width + start, number) + offset, value


def _span(flat: Floats, row: Ints, y: Ints) -> tuple[Floats, Floats]:
    """Start and end of a line of constant y inside a triangle."""
    start, end = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        (x0, y0), (x1, y1) = flat[row, a].T, flat[row, b].T
        rise = y1 - y0
        part = np.clip((y - y0) / np.where(rise == 0.0, 1.0, rise), 0.0, 1.0)
        crosses = (np.minimum(y0, y1) <= y + _EDGE_TOLERANCE) & (np.maximum(y0, y1) >= y - _EDGE_TOLERANCE)
        crossing = x0 + part * (x1 - x0)
        start = np.where(crosses, np.minimum(start, crossing), start)
        end = np.where(crosses, np.maximum(end, crossing), end)
    return start, end


def _plane(depth: Floats) -> float:
    """The most frequent depth, to `_BIN_M`."""
    low = float(depth.min())
    count = np.bincount(((depth - low) / _BIN_M).astype(np.int64), minlength=3)
    return low + (int(np.convolve(count, [1, 2, 1], mode="same").argmax()) + 0.5) * _BIN_M


def _own_plane(view: DepthMap, normals: Floats, flat: Flags, middle: float) -> tuple[float, float, float]:
    """Depth of a wall in its middle, its slope per metre to the right, and median distance of its pixels from both.

    Depth and distance are in metres. The slope is that of most triangles, that of all pixels, or none: whichever fits
    best.

    Args:
        view: the map.
        normals: [3, T] normals of the triangles, of any length.
        flat: [H, W] pixels near the plane of the wall.
        middle: horizontal coordinate of the middle of the wall.
    """
    depth, x = view.depth[flat], view.low[0] + (np.nonzero(flat)[1] + 0.5) * view.step
    across, _, towards = normals[:, view.triangle[flat]]
    centred = x - x.mean()
    fitted = float((centred * (depth - depth.mean())).sum() / max((centred**2).sum(), 1e-12))
    slopes = [0.0]
    for slope in (fitted, float(np.median(-across / towards))):
        if abs(slope) * np.ptp(x) > _MIN_TILT_M:
            slopes.append(slope)
    residuals = [depth - slope * (x - middle) for slope in slopes]
    deviations = [float(np.median(np.abs(residual - np.median(residual)))) for residual in residuals]
    best = int(np.argmin(deviations))
    return float(np.median(residuals[best])), slopes[best], deviations[best]


def _filled(piece: Flags, lowest: int) -> Flags:
    """[H, W] the wall with its holes; doors are closed by the ground below."""
    return np.concatenate([piece[:lowest], filled_above_ground(piece[lowest:])])


def filled_above_ground(mask: Flags) -> Flags:
    """[H, W] a mask with its holes, and with what only the ground below its first row closes.

    A flood from the border, as of `scipy.ndimage.binary_fill_holes`, passes over the picture once for each of its rows.
    """
    if not mask.size:
        return mask
    labelled: Any = ndimage.label(~mask)
    number, num = labelled
    is_outside = np.zeros(num + 1, dtype=bool)
    for border in (number[-1], number[:, 0], number[:, -1]):
        is_outside[border] = True
    return ~is_outside[number] | mask


def _without_cracks(view: DepthMap, noise: float) -> DepthMap:
    """The map with narrow gaps closed.

    Cracks are visible only in places, and would divide a wall with noise into pieces that only touch.
    """
    pixels = _MIN_GAP_PIXELS + int(np.ceil(_MAX_CRACK_RATIO * noise / view.step)) * (noise > _MIN_CRACK_NOISE_M)
    return replace(view, depth=ndimage.grey_closing(view.depth, (pixels, pixels)))
