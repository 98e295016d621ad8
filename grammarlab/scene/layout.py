"""Layout of several models in one file."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.derivation.lots import NEAR, origins_of
from grammarlab.scene.triangles import TriangleBatch

GAP = 0.25
"""Gap between neighbours, as a share of the larger of the widest and the deepest model."""


_NANOMETRES = 9
"""Decimals of metres; differences of large numbers have rounding errors below."""


def model_bounds(batch: TriangleBatch) -> tuple[Floats, Floats]:
    """Smallest and largest coordinates [num_models, 3] of each model from its origin; zeros without triangles."""
    low, high = np.zeros((batch.num_models, 3)), np.zeros((batch.num_models, 3))
    ends = batch.group_vertices[batch.model_groups]
    filled = np.diff(ends) > 0
    if filled.any():
        low[filled] = np.minimum.reduceat(batch.vertices, ends[:-1][filled], axis=0)
        high[filled] = np.maximum.reduceat(batch.vertices, ends[:-1][filled], axis=0)
    return low, high


@dataclass(frozen=True, slots=True)
class SceneLayout:
    """Positions of the models of one file."""

    origin: Floats
    """[3] origin of the file in the world, in metres."""
    offsets: Floats
    """[num_models, 3] origin of the coordinates of each model, in metres from the origin of the file."""

    @property
    def is_wide(self) -> bool:
        """Whether models are so far apart that 32-bit coordinates are inaccurate."""
        return bool(np.abs(self.offsets).max(initial=0.0) > NEAR)


def around(origin: Floats, origins: Floats) -> SceneLayout:
    """Models at their places in the world, relative to an origin.

    Args:
        origin: [3] origin of the file in the world.
        origins: [num_models, 3] origins of the models in the world.
    """
    return SceneLayout(origin, np.round(origins - origin, _NANOMETRES) + 0.0)


def in_place(low: Floats, high: Floats, origins: Floats) -> SceneLayout:
    """Models at their places in the world, relative to the origin of their bounding box.

    Args:
        low: [num_models, 3] smallest coordinates of each model from its origin; at least one model.
        high: [num_models, 3] largest coordinates.
        origins: [num_models, 3] origins in the world.
    """
    if len(origins) == 1:
        return SceneLayout(origins[0], np.zeros((1, 3)))
    box = (low + origins).min(axis=0), (high + origins).max(axis=0)
    (origin,) = origins_of(box[0][None], box[1][None])
    return SceneLayout(origin, origins - origin)


def grid(low: Floats, high: Floats, origins: Floats, columns: int | None = None) -> SceneLayout:
    """Models on a grid without touching.

    Models are placed from left (-x) to right and from back (-z) to front, centred on their cells, and keep their
    heights. A single model does not move.

    Args:
        low: [num_models, 3] smallest coordinates of each model from its origin.
        high: [num_models, 3] largest coordinates.
        origins: [num_models, 3] origins in the world.
        columns: number of columns, at least 1; by default the grid is about square.
    """
    if len(origins) == 1:
        return in_place(low, high, origins)
    if len(origins) == 0:
        return SceneLayout(np.zeros(3), origins)
    extent = (high - low).max(axis=0)
    gap = GAP * max(extent[0], extent[2])
    across = columns or math.ceil(math.sqrt(len(origins)))
    index = np.arange(len(origins))
    cell = np.stack([index % across, np.zeros_like(index), index // across], axis=1)
    offsets = cell * (extent + gap) - (low + high) / 2
    offsets[:, 1] = origins[:, 1]
    return SceneLayout(np.zeros(3), offsets)
