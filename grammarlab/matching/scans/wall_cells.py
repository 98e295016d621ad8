"""The wall of a facade as cells: where points are missing, or lie in front of or behind their surroundings.

Points of a scan are on coordinates of the vertical planes of its facades.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.errors import FacadeError

DEEP = 0.04
"""Least distance from the wall of a point that is not part of it, metres."""
_NUM_TRIALS = 200
"""Number of random planes."""
_MAX_SAMPLES = 20_000
"""Largest number of points that are examined."""
_NEAR_RATIO = 0.002
"""Largest distance of the wall's points from the initial plane, as a fraction of the extent of a scan."""
_MAX_DISTANCE_M = 0.02
"""Largest distance from the final plane, metres."""
_MAX_VERTICAL = 0.3
"""Largest z component of a normal, since facades are vertical."""
_MAX_PLANES = 4
"""Largest number of facades of a scan."""
_MIN_SHARE = 0.05
"""Least fraction of the points of a further plane."""
_MIN_RELIEF_M = 0.006
"""Least relief of a part of the wall, metres."""
_NUM_SDS = 3.0
"""Least relief and least lack of points, in standard deviations of the mean and of the number of points."""
_MAX_DENSITY_RATIO = 0.5
"""Largest density of the points of a sparse part, relative to its surroundings."""
_BLOCK_M, _NUM_BLOCKS = 0.5, 7
"""Side of a block, metres, and blocks along a side of the surroundings; elements cover less than half of these."""
_MAX_CELLS = 4_000_000
"""Largest number of cells of a wall."""


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
    empty: Flags
    """[W, H] cells without points; single ones between others do not count."""
    relief: Floats
    """[W, H] mean distance from the surroundings, metres, out of the wall."""
    smooth: Floats
    """[W, H] the same over 3 x 3 cells."""
    lack: Floats
    """[W, H] lack of points in 3 x 3 cells: 0 for the density of the surroundings, 1 for none."""
    raised: Flags
    """[W, H] cells with significant relief, out of the wall or into it."""
    sparse: Flags
    """[W, H] cells with significant lack of points."""

    @property
    def high(self) -> Floats:
        """[2] upper right corner, metres."""
        return self.low + self.side * np.array(self.empty.shape)

    def indices(self, points: Floats) -> tuple[Ints, Ints]:
        """Column [P] and row [P] of the cells of points [P, 2]; of the nearest cells for points outside."""
        return _indices(points, self.low, self.side, self.empty.shape)


def cells_of(points: Floats) -> Cells:
    """The wall of a facade with points [P, 3]: along it, up, and out of the wall, metres."""
    flat, low = points[:, :2], points[:, :2].min(axis=0)
    on_wall = np.abs(points[:, 2]) < DEEP
    side = max(_side(flat[on_wall]), float(np.sqrt(np.ptp(flat, axis=0).prod() / _MAX_CELLS)))
    width, height = (np.ceil((flat.max(axis=0) - low) / side).astype(np.int64) + 1).tolist()
    index = np.ravel_multi_index(_indices(flat[on_wall], low, side, (width, height)), (width, height))
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
    raised = np.abs(smooth) > np.maximum(_MIN_RELIEF_M, _NUM_SDS * noise / np.sqrt(np.maximum(number, 1.0)))
    sparse = number < np.minimum(_MAX_DENSITY_RATIO * usual, usual - _NUM_SDS * np.sqrt(np.maximum(usual, 0.0)))
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


def facades(points: Floats) -> Iterator[Floats]:
    """[P, 3] metres along the facade, up, and out of the wall, of points [P, 3] of a scan with z up.

    The first facade is the vertical plane with the most points (RANSAC with a fixed seed), the next ones are those with
    the most remaining points. The outside of a wall is the side with fewer distant points; the coordinate along it
    starts at its left end, seen from outside.

    Raises:
        FacadeError: If there is no vertical plane.
    """
    if len(points) < 3:
        raise FacadeError(f"Expected a scan of at least 3 points, found {len(points)}.")
    random = np.random.default_rng(0)
    middle = points.mean(axis=0)
    sample = points[random.integers(len(points), size=min(_MAX_SAMPLES, len(points)))] - middle
    near = max(_NEAR_RATIO * float(np.linalg.norm(np.ptp(sample, axis=0))), _MAX_DISTANCE_M)
    remaining = sample
    for index in range(_MAX_PLANES):
        plane = _plane(remaining, near, random)
        if plane is None and not index:
            raise FacadeError(
                "No vertical plane was found in the scan: its points lie on one line or on the ground (give `up=` if "
                "another axis is up)."
            )
        if plane is None or (index and len(remaining) < _MIN_SHARE * len(sample)):
            return
        normal, offset = _refined(remaining, near, *plane)
        yield _along(points - middle, points[:, 2], *_outward(sample, normal, offset))
        remaining = remaining[np.abs(remaining @ normal - offset) > near]


def _indices(points: Floats, low: Floats, side: float, shape: tuple[int, ...]) -> tuple[Ints, Ints]:
    index = np.clip(((points - low) / side).astype(np.int64), 0, np.array(shape) - 1)
    return index[:, 0], index[:, 1]


def _side(flat: Floats) -> float:
    """Side of cells such that a wall has some points in every cell, metres."""
    extent = np.maximum(np.ptp(flat, axis=0), 1e-6)
    dense = float(np.sqrt(extent.prod() / max(len(flat), 1)))
    return max(2.2 * dense, 0.02, float(np.sqrt(extent.prod() / _MAX_CELLS)))


def _ratio(over: Floats, under: Floats) -> Floats:
    return over / np.where(under > 1e-9, under, np.inf)


def _surroundings(values: Floats, side: float) -> Floats:
    """[W, H] median of the values [W, H] of blocks around each cell, between blocks by interpolation."""
    size = max(1, round(_BLOCK_M / side))
    filled = np.pad(values, [(0, -length % size) for length in values.shape], mode="edge")
    blocks = filled.reshape(filled.shape[0] // size, size, filled.shape[1] // size, size).mean(axis=(1, 3))
    middle = ndimage.median_filter(blocks, _NUM_BLOCKS, mode="reflect")
    coordinates = [np.clip((np.arange(length) + 0.5) / size - 0.5, 0.0, None) for length in values.shape]
    return ndimage.map_coordinates(middle, np.meshgrid(*coordinates, indexing="ij"), order=1, mode="nearest")


def _plane(points: Floats, near: float, random: np.random.Generator) -> tuple[Floats, float] | None:
    """Normal and offset of the vertical plane with the most points; None if there is none."""
    best, best_plane = 0, None
    if len(points) < 3:
        return None
    for triple in points[random.integers(len(points), size=(_NUM_TRIALS, 3))]:
        normal = np.cross(triple[1] - triple[0], triple[2] - triple[0])
        length = float(np.linalg.norm(normal))
        if length <= 1e-12 or abs(normal[2]) > _MAX_VERTICAL * length:
            continue
        normal = np.array([normal[0], normal[1], 0.0]) / np.hypot(normal[0], normal[1])
        offset = float(normal @ triple[0])
        count = int((np.abs(points @ normal - offset) < near).sum())
        if count > best:
            best, best_plane = count, (normal, offset)
    return best_plane


def _refined(points: Floats, near: float, normal: Floats, offset: float) -> tuple[Floats, float]:
    """The least-squares plane of the points near a plane, within a shrinking distance."""
    while True:
        near_points = points[np.abs(points @ normal - offset) < near][:, :2]
        if len(near_points) >= 3:
            center = near_points.mean(axis=0)
            across = np.linalg.eigh(np.cov((near_points - center).T))[1][:, 0]
            across = across if across @ normal[:2] > 0.0 else -across
            normal, offset = np.array([*across, 0.0]), float(across @ center)
        if near <= _MAX_DISTANCE_M:
            return normal, offset
        near = max(near / 2.0, _MAX_DISTANCE_M)


def _along(moved: Floats, up: Floats, normal: Floats, offset: float) -> Floats:
    depth = moved @ normal - offset
    along = moved @ np.array([-normal[1], normal[0], 0.0])
    wall = np.abs(depth) < _MAX_DISTANCE_M
    return np.stack([along - along[wall if wall.any() else slice(None)].min(), up, depth], axis=1)


def _outward(points: Floats, normal: Floats, offset: float) -> tuple[Floats, float]:
    """Direction out of the wall: parts behind it, such as rooms behind windows, extend farther than parts in front.

    If both sides extend equally far, the coordinate that changes most along the wall grows to the right.
    """
    depth = points @ normal - offset
    farther = float(depth.max() + depth.min())
    if abs(farther) < _MAX_DISTANCE_M:
        farther = float(normal[1] if abs(normal[1]) > abs(normal[0]) else -normal[0])
    return (-normal, -offset) if farther > 0.0 else (normal, offset)
