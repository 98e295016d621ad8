"""Floors and ceilings that roofs hide from view."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, index_in_row
from grammarlab.export.tiles.planes import Planes

_FLAT, _STEEP = 0.95, 0.3
"""Upward parts of normals: at least that of a floor, and at most that of a wall."""
_ABOVE = 0.3
"""Metres from a floor up to a roof that hides it."""
_SHARE = 0.85
"""Smallest share of its box that a roof fills if it hides what is below."""
_SAMPLES = np.stack(np.meshgrid((0.1, 0.5, 0.9), (0.1, 0.5, 0.9)), axis=-1).reshape(-1, 2)
"""[9, 2] places of a floor, as shares of its sides, that are covered if nobody sees it."""
_MOST = 40
"""Most floors and roofs of a model that are compared: the largest."""


def is_covered(planes: Planes, num_models: int) -> Flags:
    """[W] whether a level wall lies below roofs and floors that cover nearly all of it."""
    covered = np.zeros(len(planes), dtype=bool)
    roofs = _largest_roofs(planes)
    if not len(roofs):
        return covered
    low, high = _boxes(planes, num_models)
    low, high = low[roofs], high[roofs]
    model, up = planes.model[roofs], np.abs(planes.axes[roofs, 2, 1])
    area = np.prod(high[:, [0, 2]] - low[:, [0, 2]], axis=1)
    filled = np.minimum(1.0, planes.covered[roofs] * up / np.maximum(area, 1e-9))

    counts = np.bincount(model, minlength=num_models)
    starts = np.cumsum(counts) - counts
    pairs = counts[model]
    below = np.repeat(np.arange(len(roofs)), pairs)
    above = np.repeat(starts[model], pairs) + index_in_row(pairs)
    hides = (up[below] > _FLAT) & (high[above, 1] > high[below, 1] + _ABOVE) & (filled[above] > _SHARE)
    below, above = below[hides], above[hides]
    hidden = np.ones(len(roofs), dtype=bool)
    for shares in _SAMPLES:
        place = low[below][:, [0, 2]] + shares * (high - low)[below][:, [0, 2]]
        inside = (place >= low[above][:, [0, 2]]) & (place <= high[above][:, [0, 2]])
        hidden &= np.bincount(below, inside.all(axis=1), len(roofs)) > 0.0
    covered[roofs] = hidden
    return covered


def _largest_roofs(planes: Planes) -> Ints:
    """Planes that are not walls, ascending: the largest of each model."""
    roofs = np.flatnonzero(np.abs(planes.axes[:, 2, 1]) >= _STEEP)
    order = np.lexsort((-planes.covered[roofs], planes.model[roofs]))
    _, counts = np.unique(planes.model[roofs], return_counts=True)
    return np.sort(roofs[order[index_in_row(counts) < _MOST]])


def _boxes(planes: Planes, num_models: int) -> tuple[Floats, Floats]:
    """Boxes [W, 3] of planes along the longest wall of their model: along it, up, across it."""
    walls = np.flatnonzero(np.abs(planes.axes[:, 2, 1]) < _STEEP)
    order = np.lexsort((-planes.covered[walls], planes.model[walls]))
    largest = walls[order[np.flatnonzero(np.diff(planes.model[walls][order], prepend=-1))]]
    across = np.tile((1.0, 0.0), (num_models, 1))
    across[planes.model[largest]] = planes.axes[largest, 2][:, [0, 2]]
    across /= np.sqrt(np.einsum("ij,ij->i", across, across))[:, None]
    starts = planes.wall_points()[:-1]
    points = planes.facets.points
    cosine, sine = across[planes.model].repeat(np.diff(planes.wall_points()), axis=0).T
    turned = np.column_stack(
        (points[:, 0] * cosine + points[:, 2] * sine, points[:, 1], points[:, 2] * cosine - points[:, 0] * sine)
    )
    return np.minimum.reduceat(turned, starts, axis=0), np.maximum.reduceat(turned, starts, axis=0)
