"""Walls of a building: where much of what is seen from one side lies in one upright plane."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import ndimage

from grammarlab.facade.examples.analysis.depth import DepthMap, depth_map
from grammarlab.facade.examples.mesh.surface import Bools, Floats, Surface
from grammarlab.facade.examples.mesh.views import seen_from

PIXELS = 250_000
"""Of the depth map of each side."""
FACING = 0.9
"""Part of a normal towards the viewer from which a triangle may lie in a wall."""
_BIN = 0.05
"""Metres of depth that are counted together."""
BEHIND, BEFORE = 1.0, 2.0
"""Metres behind and before the plane of a wall that belong to it: recesses, and balconies."""
_LEAST_PART, _LEAST_SIDE = 0.04, 1.5
"""Of a wall: part of what is seen from its side, and metres of width and height."""
_NARROW = 3
"""Pixels of a gap that is surely seen."""
_NOISY, _CRACK = 0.001, 8.0
"""Metres of noise from which there may be cracks, and how many times as wide these may be."""
_DEVIATION = 1.4826
"""Standard deviation of normal noise, for a median deviation of 1: windows that lie nearly in the wall are no noise."""
_UNDER = 0.5
"""Part of the width of a wall that what lies under its plane has, at least, to be its ground floor."""
_TILTED = 0.1
"""Metres of depth that a wall may lose from end to end."""
_MOST = 6
"""Walls of one side."""


@dataclass(frozen=True, eq=False)
class Wall:
    """A wall, in the coordinates of the view from its side."""

    side: int
    depth: float
    """Metres, of its plane."""
    low: Floats
    """[2] metres, lower left corner."""
    high: Floats
    """[2] metres, upper right corner."""
    map: DepthMap
    seen: Bools
    """[H, W] pixels of the map that belong to it."""
    noise: float
    """Metres by which what lies in its plane deviates from it."""

    def tilt(self) -> float:
        """Radians about the upright axis that make it square to the view; 0 where that makes no difference."""
        flat = self.seen & (np.abs(self.map.depth - self.depth) <= _TILTED)
        x = np.nonzero(flat)[1] * self.map.step
        depth = self.map.depth[flat]
        x = x - x.mean()
        slope = float((x * (depth - depth.mean())).sum() / max((x**2).sum(), 1e-12))
        return -float(np.arctan(slope)) if abs(slope) * (self.high[0] - self.low[0]) > _TILTED else 0.0


def walls_of(surface: Surface, side: int, num_pixels: int = PIXELS) -> list[Wall]:
    """The walls of one side, the largest first, as a map of so many pixels shows them."""
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
        # Pieces of wall between windows belong together, and so do windows: they may be holes.
        found: Any = ndimage.label(near, structure=np.ones((3, 3)))
        pieces, num = found
        if not num:
            break
        sizes = np.bincount(pieces[flat], minlength=num + 1)
        sizes[0] = 0
        own = pieces == int(sizes.argmax())
        own_flat = own & flat
        rows, columns = np.flatnonzero(own_flat.any(axis=1)), np.flatnonzero(own_flat.any(axis=0))
        if len(rows):
            # A ground floor that stands before or behind the plane belongs to the wall.
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
    """[H, W] the wall with its holes, whatever is seen through them; doors are closed by the ground below."""
    ground = np.ones((1, own.shape[1]), dtype=bool)
    filled = own.copy()
    above: Any = ndimage.binary_fill_holes(np.concatenate([ground, own[lowest:]]))
    filled[lowest:] = above[1:]
    return filled


def _without_cracks(map_: DepthMap, noise: float) -> DepthMap:
    """The map with narrow gaps closed.

    It does not show them everywhere, and pieces of a wall that only touch each other come apart where points are off.
    """
    pixels = _NARROW + int(np.ceil(_CRACK * noise / map_.step)) * (noise > _NOISY)
    return replace(map_, depth=ndimage.grey_closing(map_.depth, (pixels, pixels)))


def _plane(depth: Floats) -> float:
    """The depth that most pixels have, to `_BIN`."""
    low = float(depth.min())
    count = np.bincount(((depth - low) / _BIN).astype(np.int64), minlength=3)
    return low + (int(np.convolve(count, [1, 2, 1], mode="same").argmax()) + 0.5) * _BIN
