"""A wall from the front, in orthographic projection."""

from __future__ import annotations

import numpy as np
from PIL import Image

from grammarlab.facade.examples.analysis.depth import depth_map
from grammarlab.facade.examples.analysis.example import Example, Region
from grammarlab.facade.examples.mesh.views import seen_from

_PIXELS = 400_000
_SKY = (236, 239, 242)
_DEEP = 0.35
"""Depth behind the plane of the wall at which brightness is halved, metres."""


def wall_picture(example: Example, region: Region) -> Image.Image:
    """The wall between its lower left and upper right corner, in the colors of its materials; depth is dark."""
    corners = seen_from(region.side, example.surface.points)[example.surface.triangles]
    low, high = region.wall
    low_seen, high_seen = corners.min(axis=1), corners.max(axis=1)
    near = (high_seen[:, :2] > low).all(axis=1) & (low_seen[:, :2] < high).all(axis=1)
    near &= (high_seen[:, 2] >= region.back) & (low_seen[:, 2] <= region.front)
    rows = np.flatnonzero(near)
    map_ = depth_map(corners[rows], _PIXELS)
    part = map_.rows(low[1], high[1]), map_.columns(low[0], high[0])
    triangle, depth = map_.triangle[part], map_.depth[part]
    colors = np.array(example.mesh.colors)[:, :3] * 255.0
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat = np.abs(facing[:, 2]) / np.maximum(np.linalg.norm(facing, axis=1), 1e-12)
    chosen = rows[np.maximum(triangle, 0)]
    behind = np.clip(region.plane - np.where(triangle >= 0, depth, region.plane), 0.0, 2.0)
    light = (0.55 + 0.45 * flat[chosen]) / (1.0 + behind / _DEEP * 0.5)
    shaded = colors[example.surface.material[chosen]] * light[..., None]
    shaded[triangle < 0] = _SKY
    return Image.fromarray(np.clip(shaded[::-1], 0, 255).astype(np.uint8))
