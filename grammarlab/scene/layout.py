"""Where models stand when several share a file."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from grammarlab.scene.triangles import TriangleBatch

Floats = NDArray[np.float64]

GAP = 0.25
"""Free ground between neighbours, as a share of the larger of the widest and the deepest model."""


def model_bounds(batch: TriangleBatch) -> tuple[Floats, Floats]:
    """Smallest and largest coordinates [num_models, 3] of each model; zeros for a model without triangles."""
    low, high = np.zeros((batch.num_models, 3)), np.zeros((batch.num_models, 3))
    ends = batch.group_vertices[batch.model_groups]
    filled = np.diff(ends) > 0
    if filled.any():
        low[filled] = np.minimum.reduceat(batch.vertices, ends[:-1][filled], axis=0)
        high[filled] = np.maximum.reduceat(batch.vertices, ends[:-1][filled], axis=0)
    return low, high


def grid(batch: TriangleBatch, columns: int | None = None) -> Floats:
    """How far to move each model [num_models, 3] so that all stand on a grid without touching.

    Models go from left (-x) to right and from back (-z) to front, centred on their cells, and keep their heights. A
    batch of one stays where it is.

    Args:
        batch: any number of models.
        columns: models side by side, at least 1; about a square when left out.
    """
    if batch.num_models <= 1:
        return np.zeros((batch.num_models, 3))
    low, high = model_bounds(batch)
    extent = (high - low).max(axis=0)
    gap = GAP * max(extent[0], extent[2])
    across = columns or math.ceil(math.sqrt(batch.num_models))
    index = np.arange(batch.num_models)
    cell = np.stack([index % across, np.zeros_like(index), index // across], axis=1)
    offsets = cell * (extent + gap) - (low + high) / 2
    offsets[:, 1] = 0.0
    return offsets
